"""Parser of the cells of a MAP."""

from math import gcd

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.command.layouts import payload_members
from pathgene.hdl.command.rectangle_writer import RectangleWriter
from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.primitives.unit import Given, Unit, Width
from pathgene.hdl.protocol.codes import Status


__all__ = ["CellParser"]


class CellParser(Unit):
    """Writes the cells of a rectangle, row by row, starting at its south-western cell.

    The parser takes ``gcd(8, altitude_bits)`` bits in a cycle, and one more cycle for each cell: 4
    cycles for a cell of 12 bits, 15 times as fast as the line with its shortest divisor. It is done
    when the checker accepts writes again after the last cell; from then on, the map is as
    commanded. A request that is too short or too long is refused; whole cells of a short one are
    written.

    Members
    -------
    on, repeated, bytes, ended, done, status
        See :func:`pathgene.hdl.command.layouts.payload_members`.
    rectangle : In(rectangle_layout)
        South-western cell and size; it lies on the map.
    writes : Out(stream of x, y, altitude, last)
        See :class:`pathgene.hdl.command.rectangle_writer.RectangleWriter`.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    rectangle_layout: Given(
        "data.StructLayout", "Fields of a MAP: ``x``, ``y``, ``width`` and ``height``, in cells."
    )

    def interface(self):
        cells = cell_layout(self.coordinate_bits, self.altitude_bits)
        return {
            **payload_members(),
            "rectangle": In(self.rectangle_layout),
            "writes": Out(stream.Signature(cells)),
        }

    def elaborate(self, platform):
        m = Module()
        altitude_bits = self.altitude_bits
        step = gcd(8, altitude_bits)
        m.submodules.writer = writer = RectangleWriter(
            self.coordinate_bits, altitude_bits, self.rectangle_layout
        )
        connect(m, writer.writes, flipped(self.writes))

        # A byte, and the cell being filled from it.
        byte = Signal(8)
        left = Signal(range(8 // step + 1))  # Steps left in the byte.
        cell = Signal(altitude_bits)
        steps = altitude_bits // step
        missing = Signal(range(steps + 1), init=steps)
        full = Signal()
        move = Signal()
        m.d.comb += [
            full.eq(missing == 0),
            move.eq((left != 0) & ~full & ~writer.complete),
            self.bytes.ready.eq(~writer.complete & ((left == 0) | ((left == 1) & move))),
            writer.on.eq(self.on),
            writer.repeated.eq(self.repeated),
            writer.rectangle.eq(self.rectangle),
            writer.altitudes.valid.eq(full),
            writer.altitudes.p.eq(cell),
            writer.coming.eq(move & (missing == 1)),
            writer.exhausted.eq(self.ended & (left == 0) & ~full),
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
        with m.If(full & writer.altitudes.ready):
            m.d.sync += missing.eq(steps)
        with m.If(~self.on):
            m.d.sync += [left.eq(0), missing.eq(steps)]

        # A byte is surplus if none of its bits belong to the rectangle.
        surplus = ~self.ended | (left == 8 // step)
        m.d.comb += [
            self.done.eq(writer.done),
            self.status.eq(Mux(writer.complete & ~surplus, Status.OK, Status.BAD_LENGTH)),
        ]

        return m
