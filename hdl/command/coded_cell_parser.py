"""Parser of the cells of a CODED_MAP."""

from amaranth import *
from amaranth.lib import enum, memory, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.command.layouts import payload_members
from pathgene.hdl.command.rectangle_writer import RectangleWriter
from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.primitives.unit import Given, Unit, Width
from pathgene.hdl.protocol.codes import Status
from pathgene.hdl.protocol.messages import CODED_COLUMNS, ESCAPE_ONES


__all__ = ["CodedCellParser"]


class _Step(enum.Enum, shape=3):
    """Steps of a cell."""

    #: Ones of the quotient, up to a zero.
    QUOTIENT = 0
    REMAINDER = 1
    #: The altitude itself.
    PLAIN = 2
    #: The rise from the cell before, then the altitude, then its transfer.
    RISE = 3
    ALTITUDE = 4
    FULL = 5


class CodedCellParser(Unit):
    """Decodes the cells of a rectangle, and writes them as a MAP writes its cells.

    The rise of a cell over the one before it in its row is predicted to be the rise of the cell to
    the south. The prediction's error is in a Rice code, or the altitude follows an escape: see
    :func:`pathgene.hdl.protocol.messages.coded_map_request`. The parser takes a bit in a cycle, and
    three more cycles for each cell. Whole cells of a request that is too short are written.

    Members
    -------
    on, repeated, bytes, ended, done, status
        See :func:`pathgene.hdl.command.layouts.payload_members`.
    rectangle : In(rectangle_layout)
        South-western cell and size, and ``remainder_bits``; it lies on the map.
    writes : Out(stream of x, y, altitude, last)
        See :class:`pathgene.hdl.command.rectangle_writer.RectangleWriter`.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    rectangle_layout: Given(
        "data.StructLayout",
        "Fields of a CODED_MAP: ``x``, ``y``, ``width``, ``height``, ``remainder_bits``.",
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
        bits = self.altitude_bits
        m.submodules.writer = writer = RectangleWriter(
            self.coordinate_bits, bits, self.rectangle_layout
        )
        connect(m, writer.writes, flipped(self.writes))

        byte = Signal(8)
        left = Signal(range(9))  # Bits left in the byte.
        step = Signal(_Step)
        reads = Signal()  # The step takes bits.
        move = Signal()
        bit = byte[0]
        m.d.comb += [
            reads.eq(step.as_value() < _Step.RISE.value),
            move.eq((left != 0) & reads & ~writer.complete),
            self.bytes.ready.eq(~writer.complete & ((left == 0) | ((left == 1) & move))),
        ]
        with m.If(move):
            m.d.sync += [byte.eq(byte >> 1), left.eq(left - 1)]
        with m.If(self.bytes.valid & self.bytes.ready):
            m.d.sync += [byte.eq(self.bytes.payload), left.eq(8)]

        # The error, with its sign in the lowest bit; a remainder's bit, and one of the quotient.
        ones = Signal(range(ESCAPE_ONES + 1))
        coded = Signal(bits + 1)
        weight = Signal(bits + 1, init=1)
        unit = Signal(bits + 1)
        m.d.sync += unit.eq(1 << self.rectangle.remainder_bits[: bits.bit_length()])
        # The altitude being read, and the number of its bits.
        plain = Signal(bits)
        count = Signal(range(bits))
        is_plain = Signal()

        # The cell's column, and the heights that its rise is counted from.
        column = Signal(range(CODED_COLUMNS))
        is_first_row = Signal(init=1)
        before, south = Signal(bits), Signal(bits)
        m.submodules.rises = rises = memory.Memory(shape=bits, depth=CODED_COLUMNS, init=[])
        write, read = rises.write_port(), rises.read_port(domain="comb")
        rise, altitude = Signal(bits), Signal(bits)
        predicted = Mux(is_first_row | (column == 0), 0, read.data)
        error = (coded >> 1)[:bits] ^ coded[0].replicate(bits)
        m.d.comb += [
            read.addr.eq(column),
            write.addr.eq(column),
            write.data.eq(rise),
            write.en.eq(step == _Step.ALTITUDE),
            writer.on.eq(self.on),
            writer.repeated.eq(self.repeated),
            writer.rectangle.eq(self.rectangle),
            writer.altitudes.valid.eq(step == _Step.FULL),
            writer.altitudes.p.eq(altitude),
            writer.coming.eq(step == _Step.ALTITUDE),
            writer.exhausted.eq(self.ended & (left == 0) & reads),
        ]
        with m.Switch(step):
            with m.Case(_Step.QUOTIENT):
                with m.If(move & bit):
                    m.d.sync += [coded.eq(coded + unit), ones.eq(ones + 1)]
                    with m.If(ones == ESCAPE_ONES - 1):
                        m.d.sync += [step.eq(_Step.PLAIN), is_plain.eq(1)]
                with m.Elif(move):
                    m.d.sync += step.eq(Mux(unit[0], _Step.RISE, _Step.REMAINDER))
            with m.Case(_Step.REMAINDER):
                with m.If(move):
                    m.d.sync += [coded.eq(coded + Mux(bit, weight, 0)), weight.eq(weight << 1)]
                    with m.If((weight << 1)[: len(unit)] == unit):
                        m.d.sync += step.eq(_Step.RISE)
            with m.Case(_Step.PLAIN):
                with m.If(move):
                    m.d.sync += [plain.eq(Cat(plain[1:], bit)), count.eq(count + 1)]
                    with m.If(count == bits - 1):
                        m.d.sync += step.eq(_Step.RISE)
            with m.Case(_Step.RISE):
                m.d.sync += [
                    rise.eq(Mux(is_plain, plain - before, predicted + error)),
                    step.eq(_Step.ALTITUDE),
                ]
            with m.Case(_Step.ALTITUDE):
                m.d.sync += [altitude.eq(before + rise), step.eq(_Step.FULL)]
            with m.Case(_Step.FULL):
                with m.If(writer.altitudes.ready):
                    m.d.sync += [
                        step.eq(_Step.QUOTIENT),
                        ones.eq(0),
                        coded.eq(0),
                        weight.eq(1),
                        count.eq(0),
                        is_plain.eq(0),
                        before.eq(altitude),
                        column.eq(column + 1),
                    ]
                    with m.If(column == 0):
                        m.d.sync += south.eq(altitude)
                    with m.If(column == (self.rectangle.width - 1)[: len(column)]):
                        m.d.sync += [
                            column.eq(0),
                            is_first_row.eq(0),
                            before.eq(Mux(column == 0, altitude, south)),
                        ]
        with m.If(~self.on):
            m.d.sync += [
                left.eq(0),
                step.eq(_Step.QUOTIENT),
                ones.eq(0),
                coded.eq(0),
                weight.eq(1),
                count.eq(0),
                is_plain.eq(0),
                before.eq(0),
                column.eq(0),
                is_first_row.eq(1),
            ]

        # A byte is surplus if none of its bits belong to the rectangle.
        surplus = ~self.ended | (left == 8)
        m.d.comb += [
            self.done.eq(writer.done),
            self.status.eq(Mux(writer.complete & ~surplus, Status.OK, Status.BAD_LENGTH)),
        ]

        return m
