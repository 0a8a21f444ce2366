"""The COBS decoder inverts the definition of the code for any bytes."""

from amaranth import *
from amaranth.hdl import Assert, Cover

from pathgene.hdl.link.cobs import CobsDecoder
from tests.formal.parts import Opened, free
from tools.formal import Proof


class Decoder(Elaboratable):
    """Proved for all time, by induction; any bytes arrive in any cycles.

    The definition counts places in a frame: place 0 has a code, and a code c in place p says that
    the next code, or the delimiter, is in place p + c. The places in between are data. A code
    stands for a zero, except for the first code of a frame and the code after a full block (code
    255).

    - Each place is decoded in the cycle after it arrived, to at most one transfer: data to itself,
      a code to the zero that it stands for, a delimiter to the end of its frame, with ``broken``
      exactly if it is not in the place of a code. There are no other transfers: no byte is lost or
      invented.
    - A delimiter right after a delimiter is decoded to nothing.
    - A delimiter restores the state after reset, whatever preceded it.
    - In the cycle after the end of a frame there is no transfer.

    It is also proved for a code with full blocks of 4, so that faults in full blocks show within a
    few cycles.
    """

    FULL = (0xFF, 4)

    def __init__(self, unit):
        self.unit = unit

    def elaborate(self, platform):
        m = Module()
        for full in self.FULL:
            m.submodules[f"full_{full}"] = self._build(full)
        return m

    def _build(self, full_code):
        m = Module()
        decoder = self.unit(CobsDecoder, ("_FULL = 0xFF", f"_FULL = {full_code}"))()
        encoded, decoded = decoder.encoded, decoder.decoded
        m.submodules.dut = dut = Opened(decoder)
        free(m, encoded.valid, encoded.payload)

        # Places count modulo a number that exceeds the distance of any two.
        place, following = Signal(9), Signal(9)
        begun, full = Signal(), Signal()
        transfer, delimits, broken, byte = Signal(), Signal(), Signal(), Signal(8)
        m.d.sync += [transfer.eq(0), delimits.eq(0)]
        with m.If(encoded.valid):
            m.d.sync += [place.eq(place + 1), begun.eq(1)]
            with m.If(encoded.payload == 0):
                m.d.sync += [
                    *(signal.eq(0) for signal in (place, following, begun, full)),
                    transfer.eq(begun),
                    delimits.eq(begun),
                    broken.eq(place != following),
                ]
            with m.Elif(place == following):
                m.d.sync += [
                    following.eq(place + encoded.payload),
                    full.eq(encoded.payload == full_code),
                    transfer.eq(begun & ~full),
                    byte.eq(0),
                ]
            with m.Else():
                m.d.sync += [transfer.eq(1), byte.eq(encoded.payload)]

        ended = Signal()
        m.d.sync += ended.eq(decoded.valid & decoded.p.delimiter)
        m.d.comb += [
            Assert(encoded.ready),
            Assert(decoded.valid == transfer),
            Assert(decoder.inside == begun),
            Assert(~(ended & decoded.valid)),
        ]
        with m.If(transfer):
            m.d.comb += [
                Assert(decoded.p.delimiter == delimits),
                Assert(Mux(delimits, decoded.p.broken == broken, decoded.p.data == byte)),
            ]

        # Invariants that the induction needs.
        left = Signal(9)
        m.d.comb += [
            left.eq(following - place),
            Assert(dut.signal("left") == left),
            Assert(left < 255),
            Assert(dut.signal("zero") == (begun & ~full)),
            Assert(begun | ((place == 0) & (following == 0) & ~full)),
            Assert(~delimits | (transfer & ~begun)),
            Assert(~ended | ~begun | (place == 1)),
        ]

        frames = Signal(2)
        m.d.sync += frames.eq(frames + delimits)
        m.d.comb += [
            Cover((frames == 1) & delimits & ~broken & (byte == 7)),
            Cover((frames == 1) & delimits & broken),
            Cover(transfer & ~delimits & full),
        ]
        return m


PROOF = Proof(
    claim=Decoder,
    depth=2,
    reached=10,
    induction=2,
    faults={
        "a zero after a full block": (
            CobsDecoder,
            ("zero.eq(self.encoded.payload != _FULL)", "zero.eq(1)"),
        ),
        "no zero after a block": (
            CobsDecoder,
            ("self.decoded.valid.eq(zero)", "self.decoded.valid.eq(0)"),
        ),
        "a block one byte short": (
            CobsDecoder,
            ("left.eq(self.encoded.payload - 1)", "left.eq(self.encoded.payload - 2)"),
        ),
        "a block goes on after its frame": (CobsDecoder, ("left.eq(0),", "left.eq(left),")),
        "a frame that breaks off passes": (CobsDecoder, ("broken.eq(left != 0)", "broken.eq(0)")),
    },
)
