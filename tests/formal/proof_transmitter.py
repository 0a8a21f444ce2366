"""The frame transmitter sends each body once, followed by its CRC."""

from amaranth import *
from amaranth.hdl import Assert, Cover

from pathgene.hdl.link.frame import FrameTransmitter
from pathgene.hdl.protocol.codec import frame_crc
from tests.formal.parts import Opened, free
from tools.formal import Proof


#: A CRC and an encoder that may do anything.
FREE = (
    (
        "from pathgene.hdl.link.cobs import CobsDecoder, CobsEncoder",
        "from tests.formal.parts import FreeEncoder as CobsEncoder",
    ),
    (
        "from amaranth.lib.crc.catalog import CRC32_ISO_HDLC",
        "from tests.formal.parts import FreeCrc as CRC32_ISO_HDLC",
    ),
)


class Transmitter(Elaboratable):
    """Proved for all time, by induction.

    Bodies have any length and arrive in any cycles; the COBS encoder takes bytes in any cycles, and
    the CRC unit may compute anything.

    - The encoder gets the bytes of a body in the cycles in which they are taken, and immediately
      after them four bytes: the CRC of that body in the form of its version, lowest byte first. The
      fourth is marked as the last of the frame. No byte is lost or invented.
    - The CRC unit gets exactly the bytes of the body, and starts again before the next one.
    """

    def __init__(self, unit):
        self.dut = unit(FrameTransmitter, *FREE)()

    def elaborate(self, platform):
        m = Module()
        replies = self.dut.replies
        m.submodules.dut = dut = Opened(self.dut)
        frames, crc = dut.submodules.encoder.frames, dut.submodules.crc
        free(m, replies.valid, replies.payload, self.dut.bytes.ready)

        mask = frame_crc(b"", plain=False) ^ frame_crc(b"", plain=True)
        body, number = Signal(init=1), Signal(2)
        plain, word = Signal(), Signal(32)
        expected = Signal(32)
        m.d.comb += expected.eq(Mux(number == 0, crc.crc ^ Mux(plain, 0, mask), word))
        sent = frames.valid & frames.ready
        m.d.comb += Assert(crc.start == (sent & ~body & (number == 0)))
        with m.If(body):
            m.d.comb += [
                Assert(frames.valid == replies.valid),
                Assert(replies.ready == frames.ready),
                Assert(frames.p.data == replies.p.data),
                Assert(~frames.p.last),
                Assert(crc.valid == sent),
                Assert(crc.data == replies.p.data),
            ]
            with m.If(sent & replies.p.last):
                m.d.sync += [body.eq(0), number.eq(0), plain.eq(replies.p.plain)]
        with m.Else():
            m.d.comb += [
                Assert(frames.valid),
                Assert(~replies.ready),
                Assert(~crc.valid),
                Assert(frames.p.data == expected.word_select(number, 8)),
                Assert(frames.p.last == (number == 3)),
            ]
            with m.If(sent):
                m.d.sync += [word.eq(expected), number.eq(number + 1), body.eq(number == 3)]

        # Invariants that the induction needs.
        left, rest = dut.signal("left"), dut.signal("rest")
        m.d.comb += Assert(left == Mux(body, 0, 4 - number))
        with m.If(~body):
            m.d.comb += Assert(dut.signal("plain") == plain)
            with m.If(number != 0):
                m.d.comb += Assert(rest == word >> (8 * number))

        bodies = Signal(2)
        m.d.sync += bodies.eq(bodies + (sent & frames.p.last))
        m.d.comb += Cover((bodies == 2) & ~body & (number == 3) & ~plain)
        return m


PROOF = Proof(
    claim=Transmitter,
    depth=2,
    reached=20,
    induction=2,
    faults={
        "three bytes of the CRC": (
            FrameTransmitter,
            ("left.eq(left - 1)", "left.eq(Mux(left == 2, 0, left - 1))"),
        ),
        "the first byte twice": (FrameTransmitter, ("rest.eq(now >> 8)", "rest.eq(now)")),
        "a body starts before its turn": (
            FrameTransmitter,
            ("left.eq(CRC_BYTES),", "left.eq(CRC_BYTES - 1),"),
        ),
        "the CRC of a plain body": (
            FrameTransmitter,
            ("mask.eq(Mux(plain, 0, _VERSION_MASK))", "mask.eq(_VERSION_MASK)"),
        ),
    },
)
