"""Writer of the cells of a rectangle: their places, and the mark of the last one."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.primitives.unit import Given, Unit, Width


__all__ = ["RectangleWriter"]


class RectangleWriter(Unit):
    """Writes the cells of a rectangle, row by row, starting at its south-western cell.

    A cell is held until the next one is there, so that the last cell is marked even in a request
    that is too short.

    Members
    -------
    on, repeated : In(1)
        See :func:`pathgene.hdl.command.layouts.payload_members`.
    rectangle : In(rectangle_layout)
        South-western cell and size; it lies on the map.
    altitudes : In(stream.Signature(altitude_bits))
        Altitudes of the cells. None follows a ``complete`` rectangle.
    coming : In(1)
        An altitude will be offered in the next cycle.
    exhausted : In(1)
        No more altitudes follow.
    complete : Out(1)
        The last cell of the rectangle has been taken.
    writes : Out(stream of x, y, altitude, last)
        Cells for the checker; registers. After the ``last`` cell, not ready until the checker has
        applied the rectangle.
    done : Out(1)
        The checker accepts writes again after the last cell.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    rectangle_layout: Given(
        "data.StructLayout", "It has ``x``, ``y``, ``width`` and ``height``, in cells."
    )

    def interface(self):
        self.cell_layout = cell_layout(self.coordinate_bits, self.altitude_bits)
        return {
            "on": In(1),
            "repeated": In(1),
            "rectangle": In(self.rectangle_layout),
            "altitudes": In(stream.Signature(self.altitude_bits)),
            "coming": In(1),
            "exhausted": In(1),
            "complete": Out(1),
            "writes": Out(stream.Signature(self.cell_layout)),
            "done": Out(1),
        }

    def elaborate(self, platform):
        m = Module()
        coordinate_bits = self.coordinate_bits

        # Position of the next cell in the rectangle.
        column = Signal(coordinate_bits)
        row = Signal(coordinate_bits)
        complete = self.complete
        held = Signal()
        altitude = Signal(self.altitude_bits)
        x = Signal(coordinate_bits)
        y = Signal(coordinate_bits)

        last_column = Signal.like(column)
        last_row = Signal.like(row)
        due = Signal()  # The cell may be sent in the next cycle.
        leaves = Signal()
        load = Signal()
        offered = Signal()  # Or discarded if the command is repeated.
        settling = Signal()
        m.d.comb += [
            last_column.eq(self.rectangle.width - 1),
            last_row.eq(self.rectangle.height - 1),
            due.eq(
                held & (self.altitudes.valid | self.coming | complete | self.exhausted) & ~settling
            ),
            self.writes.p.x.eq(x),
            self.writes.p.y.eq(y),
            self.writes.p.altitude.eq(altitude),
            leaves.eq(offered & (self.repeated | self.writes.ready)),
            self.altitudes.ready.eq(~held | leaves),
            load.eq(self.altitudes.valid & self.altitudes.ready),
        ]

        with m.If(due & ~offered):
            m.d.sync += [
                offered.eq(1),
                self.writes.valid.eq(~self.repeated),
                self.writes.p.last.eq(complete | self.exhausted),
            ]
        with m.If(leaves):
            m.d.sync += [offered.eq(0), self.writes.valid.eq(0)]
        with m.If(load):
            m.d.sync += [
                altitude.eq(self.altitudes.p),
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
        with m.If(self.exhausted & ~held):
            m.d.sync += settling.eq(1)
        with m.If(~self.on):
            m.d.sync += [
                column.eq(0),
                row.eq(0),
                complete.eq(0),
                held.eq(0),
                offered.eq(0),
                self.writes.valid.eq(0),
                settling.eq(0),
            ]
        m.d.comb += self.done.eq(self.on & settling & (self.repeated | self.writes.ready))

        return m
