"""Drawer of shapes: blocks the corners in a shape."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.planner.layouts import shape_layout
from pathgene.hdl.primitives.logic import fanout
from pathgene.hdl.primitives.unit import Unit, Width
from pathgene.hdl.protocol.planner import BEND_BITS, EDGE_BITS, EDGES


__all__ = ["ShapeDrawer"]


class ShapeDrawer(Unit):
    """Visits the corners of a shape's box, one per cycle, and writes those in the shape.

    The corners written equal :func:`pathgene.sim.model.run_commands.block`, by rows; every second
    row is drawn backwards, so that the next corner is always a neighbour. In each step, the value
    of an edge gains the edge's fall in that direction; for the first edge, which can bend, the fall
    itself decreases by twice the bend per step. A corner is in the shape unless the value of an
    edge is negative.

    In a box of n corners, corner k, counted from 0, is written k + 2 cycles after its shape is
    offered. The shape is taken with the last corner, n + 1 cycles after it is offered, and the next
    shape may be offered in the following cycle: see
    :attr:`pathgene.hdl.protocol.planner.NoFlyShape.drawing_cycles`.

    Members
    -------
    shapes : In(stream.Signature(shape_layout))
        Steady until it is taken. ``first_x`` is at most ``last_x``, and ``first_y`` ``last_y``.
    cells : Out(stream.Signature(cell_layout))
        Corners with the top altitude; ``last`` is low. Each is offered for one cycle; ``ready``
        must be high.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)

    def interface(self):
        return {
            "shapes": In(stream.Signature(shape_layout(self.coordinate_bits))),
            "cells": Out(stream.Signature(cell_layout(self.coordinate_bits, self.altitude_bits))),
        }

    def elaborate(self, platform):
        m = Module()
        shape, cell = self.shapes.p, self.cells.p

        # The current corner. The next one is above it if it `turns`, otherwise beside it, to the
        # left in rows that go `back`. Control is one cycle ahead, with a register for each edge.
        x, y = (Signal(self.coordinate_bits, name=name, reset_less=True) for name in "xy")
        next_x = Signal.like(x)
        back = Signal()
        next_back = Signal()
        draws_next = Signal()
        turns_next = Signal()
        negates_next = Signal()
        *draws, drawing = fanout(m, *[draws_next] * (EDGES + 1), name="draws")
        *turns, turning = fanout(m, *[turns_next] * (EDGES + 1), name="turns")
        negates = fanout(m, *[negates_next] * (EDGES - 1), name="negates")
        after_first, before_last = (
            Signal(self.coordinate_bits, name=name, reset_less=True)
            for name in ("after_first", "before_last")
        )
        # The next corner is the last of its row, if it is not the first. A register, because the
        # next signals are wired to every edge.
        ends = Signal()
        m.d.sync += [after_first.eq(shape.first_x + 1), before_last.eq(shape.last_x - 1)]
        is_last = Signal()
        begins = self.shapes.valid & ~self.shapes.ready
        m.d.comb += [
            is_last.eq(turning & (y == shape.last_y)),
            draws_next.eq(Mux(drawing, ~is_last, begins)),
            next_back.eq(drawing & (back ^ turning)),
            turns_next.eq(Mux(drawing & ~turning, ends, shape.first_x == shape.last_x)),
            negates_next.eq(next_back & ~turns_next),
        ]
        with m.If(~drawing):
            m.d.comb += next_x.eq(shape.first_x)
            m.d.sync += ends.eq(shape.first_x == (shape.last_x - 1)[: self.coordinate_bits])
        with m.Else():
            m.d.comb += next_x.eq(Mux(turning, x, Mux(back, x - 1, x + 1)))
            m.d.sync += ends.eq(Mux(next_back, next_x == after_first, next_x == before_last))
        m.d.sync += [
            x.eq(next_x),
            y.eq(Mux(drawing, y + turning, shape.first_y)),
            back.eq(next_back),
            self.shapes.ready.eq(drawing & is_last),
        ]

        values = [self._bend(m, draws[0], turns[0])]
        for number in range(1, EDGES):
            negate, turn = negates[number - 1], turns[number]
            east, north = (shape[f"{way}_{number}"].as_unsigned() for way in ("east", "north"))
            gain = Mux(turn, north, east ^ negate.replicate(EDGE_BITS))
            value = Signal(signed(self.coordinate_bits + EDGE_BITS + 2), name=f"value_{number}")
            # The bit below completes the negation.
            total = Cat(Const(1, 1), value).as_signed() + Cat(negate, gain).as_signed()
            m.d.sync += value.eq(Mux(draws[number], total >> 1, shape[f"at_{number}"]))
            values.append(value)

        m.d.sync += [
            self.cells.valid.eq(drawing & ~Cat(value[-1] for value in values).any()),
            cell.x.eq(x),
            cell.y.eq(y),
        ]
        m.d.comb += cell.altitude.eq((1 << self.altitude_bits) - 1)
        return m

    def _bend(self, m, draws, turns):
        """Return the value of the first edge."""
        shape = self.shapes.p
        longest = (1 << self.coordinate_bits) - 1
        most_bend = (1 << BEND_BITS) - 1
        steepest = (1 << EDGE_BITS - 1) + most_bend * 2 * (longest + 1)
        lowest = (2 << self.coordinate_bits + EDGE_BITS) + 2 * most_bend * longest**2
        value = Signal(signed(lowest.bit_length() + 1), name="value_0", reset_less=True)
        # Gains of the value in the next step sideways and upwards. In a row that goes back, the
        # former have the opposite sign, and still decrease by twice the bend in each step.
        beside, above = (
            Signal(signed(steepest.bit_length() + 1), name=name, reset_less=True)
            for name in ("beside", "above")
        )
        falls = [
            Signal(signed(BEND_BITS + 1), name=f"fall_{axis}", reset_less=True) for axis in "xy"
        ]
        m.d.sync += [
            falls[0].eq(-shape.bend_x),
            falls[1].eq(-shape.bend_y),
            value.eq(value + Mux(turns, above, beside)),
            # The lowest bit completes the negation.
            beside.eq(
                (beside.as_unsigned() ^ turns.replicate(len(beside))).as_signed()
                + Cat(turns, falls[0]).as_signed()
            ),
            above.eq(above + Mux(turns, Cat(Const(0, 1), falls[1]).as_signed(), 0)),
        ]
        with m.If(~draws):
            m.d.sync += [
                value.eq(shape.at_0),
                beside.eq(shape.east_0 - shape.bend_x),
                above.eq(shape.north_0 - shape.bend_y),
            ]
        return value
