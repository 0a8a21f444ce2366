"""Parser of the cells of a MAP."""

from math import gcd

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.command.layouts import payload_members
from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.primitives.unit import Given, Unit, Width
from pathgene.hdl.protocol.codes import Status


__all__ = ["CellParser"]


class CellParser(Unit):
    """Writes the cells of a rectangle, row by row, starting at its south-western cell.

    The parser takes ``gcd(8, altitude_bits)`` bits in a cycle, and one more cycle for each cell: 4
    cycles for a cell of 12 bits, 15 times as fast as the line with its shortest divisor. It is done
    when the checker accepts writes again after the last cell; from then on, the map is as
    commanded.

    A cell is held until the next cell is complete, so that the last cell is marked even in a
    request that is too short. A request that is too short or too long is refused.

    Members
    -------
    on, repeated, bytes, ended, done, status
        See :func:`pathgene.hdl.command.layouts.payload_members`.
    rectangle : In(rectangle_layout)
        South-western cell and size; it lies on the map.
    writes : Out(stream of x, y, altitude, last)
        Cells for the checker; registers. After the ``last`` cell, not ready until the checker has
        applied the rectangle.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    rectangle_layout: Given(
        "data.StructLayout", "Fields of a MAP: ``x``, ``y``, ``width`` and ``height``, in cells."
    )

    def interface(self):
        self.cell_layout = cell_layout(self.coordinate_bits, self.altitude_bits)
        return {
            **payload_members(),
            "rectangle": In(self.rectangle_layout),
            "writes": Out(stream.Signature(self.cell_layout)),
        }

    def elaborate(self, platform):
        m = Module()
        coordinate_bits, altitude_bits = self.coordinate_bits, self.altitude_bits
        step = gcd(8, altitude_bits)

        # A byte, and the cell being filled from it.
        byte = Signal(8)
        left = Signal(range(8 // step + 1))  # Steps left in the byte.
        cell = Signal(altitude_bits)
        steps = altitude_bits // step
        missing = Signal(range(steps + 1), init=steps)
        # Position of the next cell in the rectangle.
        column = Signal(coordinate_bits)
        row = Signal(coordinate_bits)
        complete = Signal()  # The last cell of the rectangle is held.
        held = Signal()
        altitude = Signal(altitude_bits)
        x = Signal(coordinate_bits)
        y = Signal(coordinate_bits)

        last_column = Signal.like(column)
        last_row = Signal.like(row)
        full = Signal()
        move = Signal()
        exhausted = Signal()
        due = Signal()  # The cell may be sent in the next cycle.
        leaves = Signal()
        load = Signal()
        offered = Signal()  # Or discarded if the command is repeated.
        settling = Signal()
        m.d.comb += [
            last_column.eq(self.rectangle.width - 1),
            last_row.eq(self.rectangle.height - 1),
            full.eq(missing == 0),
            move.eq((left != 0) & ~full & ~complete),
            exhausted.eq(self.ended & (left == 0) & ~full),
            due.eq(held & (full | (move & (missing == 1)) | complete | exhausted) & ~settling),
            self.writes.p.x.eq(x),
            self.writes.p.y.eq(y),
            self.writes.p.altitude.eq(altitude),
            leaves.eq(offered & (self.repeated | self.writes.ready)),
            load.eq(full & (~held | leaves)),
            self.bytes.ready.eq(~complete & ((left == 0) | ((left == 1) & move))),
        ]

        with m.If(move):
            m.d.sync += [
                cell.eq(Cat(cell[step:], byte[:step])),
                byte.eq(byte >> step),
                left.eq(left - 1),
                missing.eq(missing - 1),
            ]
        with m.If(self.bytes.valid & self.bytes.ready):
            m.d.sync += [byte.eq(self.bytes.payload), left.eq(8 // step)]
        with m.If(due & ~offered):
            m.d.sync += [
                offered.eq(1),
                self.writes.valid.eq(~self.repeated),
                self.writes.p.last.eq(complete | exhausted),
            ]
        with m.If(leaves):
            m.d.sync += [offered.eq(0), self.writes.valid.eq(0)]
        with m.If(load):
            m.d.sync += [
                missing.eq(steps),
                altitude.eq(cell),
                x.eq(self.rectangle.x + column),
                y.eq(self.rectangle.y + row),
                held.eq(1),
                column.eq(column + 1),
            ]
            with m.If(column == last_column):
                m.d.sync += [column.eq(0), row.eq(row + 1)]
                with m.If(row == last_row):
                    m.d.sync += complete.eq(1)
        with m.Elif(leaves):
            m.d.sync += [held.eq(0), settling.eq(1)]
        with m.If(exhausted & ~held):
            m.d.sync += settling.eq(1)
        with m.If(~self.on):
            m.d.sync += [
                left.eq(0),
                missing.eq(steps),
                column.eq(0),
                row.eq(0),
                complete.eq(0),
                held.eq(0),
                offered.eq(0),
                self.writes.valid.eq(0),
                settling.eq(0),
            ]

        # A byte is surplus if none of its bits belong to the rectangle.
        surplus = ~self.ended | (left == 8 // step)
        m.d.comb += [
            self.done.eq(self.on & settling & (self.repeated | self.writes.ready)),
            self.status.eq(Mux(complete & ~surplus, Status.OK, Status.BAD_LENGTH)),
        ]

        return m
