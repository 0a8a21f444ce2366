"""The COBS encoder sends exactly the code of each frame as defined."""

from amaranth import *
from amaranth.hdl import Assert, Cover

from pathgene.hdl.link.cobs import CobsEncoder
from tests.formal.parts import Opened, any_constant, free
from tools.formal import Proof


class Encoder(Elaboratable):
    """Proved for all time, by induction, for a full block of 4 and a buffer of 16 bytes.

    (For the real sizes, see the proof ``cobs_encoder_full``.) Frames have any length and any bytes,
    which arrive and are taken in any cycles.

    The definition counts places in the encoded frame. A frame starts with the place of a code, and
    each of its bytes takes the next place: as itself if it is not zero, otherwise as a code. A code
    also follows a full block if the frame continues; the delimiter follows the last byte. A code is
    the number of places from it to the next code or the delimiter.

    - Exactly these bytes are sent, in order: none is lost, sent twice or invented. An arbitrary
      place is watched, with the byte that the definition puts there.
    - No byte of an incomplete block is sent.
    - With room in the buffer, it is ready again after at most two cycles. Without room, that is
      with five free rows or fewer, it has bytes of complete blocks to send: if these are taken, the
      wait ends.
    """

    #: Code of a full block, rows of the buffer.
    FULL, DEPTH = 4, 16
    #: Shows that the delimiter of the first of two frames is sent.
    SHOWN = True

    def __init__(self, unit):
        sizes = (("_FULL = 0xFF", f"_FULL = {self.FULL}"), ("DEPTH = 512", f"DEPTH = {self.DEPTH}"))
        self.dut = unit(CobsEncoder, *sizes)()

    def elaborate(self, platform):
        m = Module()
        full, depth, encoder = self.FULL, self.DEPTH, self.dut
        frames, encoded = encoder.frames, encoder.encoded
        m.submodules.dut = dut = Opened(encoder)
        ring = dut.submodules.ring
        inner = dut.open("ring")
        pointer = ring.fetched.shape()
        watched = any_constant(m, pointer, "watched")
        stored = inner.memory(m, "rows", watched[:-1])
        free(m, frames.valid, frames.payload, encoded.ready)

        # Three places: of the current block's code, of the next byte, and of the next byte to be
        # sent. They count modulo a number above their maximum distance.
        block, place, taken = (
            Signal(pointer, init=init, name=name)
            for name, init in (("block", 0), ("place", 1), ("taken", 0))
        )
        expected = Signal(8)

        def put(at, value):
            with m.If(Value.cast(at)[: len(watched)] == watched):
                m.d.sync += expected.eq(value)

        def move(to):
            m.d.sync += [block.eq(to), place.eq(to + 1)]

        zero, length = frames.p.data == 0, Signal(pointer)
        m.d.comb += length.eq(place - block)
        with m.If(frames.valid & frames.ready):
            with m.If(zero):
                put(block, length)
                with m.If(frames.p.last):
                    put(place, 1)
                    put(place + 1, 0)
                    move(place + 2)
                with m.Else():
                    move(place)
            with m.Else():
                put(place, frames.p.data)
                m.d.sync += place.eq(place + 1)
                with m.If(frames.p.last):
                    put(block, length + 1)
                    put(place + 1, 0)
                    move(place + 2)
                with m.Elif(length == full - 1):
                    put(block, full)
                    move(place + 1)

        sent = encoded.valid & encoded.ready
        m.d.sync += taken.eq(taken + sent)
        with m.If(encoded.valid):
            m.d.comb += Assert(taken != block)
            with m.If(taken == watched):
                m.d.comb += Assert(encoded.payload == expected)

        # Invariants that the induction needs: of the states of the encoder, ...
        start, tail, code = (dut.signal(name) for name in ("start", "tail", "code"))
        state, ended, room = (dut.signal(name) for name in ("fsm_state", "ended", "room"))

        complete, used, at = (Signal(pointer, name=name) for name in ("complete", "used", "at"))
        m.d.comb += [
            complete.eq(start - ring.fetched),
            used.eq(tail - ring.fetched),
            at.eq(watched - ring.fetched),
        ]
        m.d.comb += [
            Assert(state <= 2),
            Assert(complete < used),
            Assert(used <= depth),
            # The room is one cycle old; in that cycle a row was added or removed.
            Assert(Mux(room, used <= depth - 4, used >= depth - 5)),
            Assert(code <= full),
            Assert((tail - start)[: len(tail)] == code),
        ]
        fill, close, delimit = range(3)
        with m.If(state == fill):
            m.d.comb += [Assert((block == start) & (place == tail)), Assert(code < full)]
        with m.Else():
            m.d.comb += Assert(place == (block + 1)[: len(place)])
        with m.If((state == close) & ~ended):
            m.d.comb += Assert((block == tail) & (code == full))
        with m.If((state == close) & ended):
            m.d.comb += Assert(block == (tail + 1)[: len(tail)])
        with m.If(state == delimit):
            m.d.comb += [Assert(block == tail), Assert(ended), Assert(code == 1)]

        # ... of the watched place, from when it is known until its byte is fetched, ...
        known = (at < used) & (at != complete)
        with m.If(known):
            m.d.comb += Assert(stored == expected)
        with m.If((watched == start) & (state == close)):
            m.d.comb += Assert(expected == code)
        with m.If((watched == tail) & (state == close) & ended):
            m.d.comb += Assert(expected == 0)
        with m.If((watched == start) & (state == delimit)):
            m.d.comb += Assert(expected == 0)

        # ... and of bytes on their way through the ring.
        loaded = inner.signal("loaded")
        behind = Signal(pointer)
        m.d.comb += [
            behind.eq(ring.fetched - taken),
            Assert(behind == loaded + encoded.valid),
        ]
        with m.If(encoded.valid & (taken == watched)):
            m.d.comb += Assert(encoded.payload == expected)
        with m.If(loaded & (Value.cast(taken + encoded.valid)[: len(taken)] == watched)):
            m.d.comb += Assert(inner.submodules.rows.read_ports[0].data == expected)

        # Cycles without need in which no byte was taken, since the last byte.
        stalled = Signal(2)
        with m.If(frames.ready):
            m.d.sync += stalled.eq(0)
        with m.Elif(room):
            m.d.sync += stalled.eq(stalled + 1)
        with m.Else():
            m.d.comb += Assert(complete != 0)
        m.d.comb += [
            Assert(stalled <= 2),
            Assert((state != close) | (stalled == 0)),
            Assert((state != delimit) | (stalled <= 1)),
        ]

        number = Signal(2)
        m.d.sync += number.eq(number + (frames.valid & frames.ready & frames.p.last))
        if self.SHOWN:
            m.d.comb += Cover((number == 2) & sent & (encoded.payload == 0))
        else:
            m.d.comb += Cover(number == 1)
        return m


class FullEncoder(Encoder):
    """Proved for all time, by induction, as there, with a full block of 255 and 512 bytes."""

    FULL, DEPTH = 0xFF, 512
    #: With this many rows, the solver is slow to find an example in which more than one frame is
    #: taken.
    SHOWN = False


ENCODER = Proof(
    claim=Encoder,
    depth=3,
    reached=22,
    induction=3,
    long=("bytes are taken without room",),
    faults={
        "a full block is one byte longer": (
            CobsEncoder,
            ("(code == _FULL - 1)", "(code == _FULL)"),
        ),
        "an empty block after a full one that ends its frame": (
            CobsEncoder,
            ("with m.If(ended):", "with m.If(ended & (code != _FULL)):"),
        ),
        "the code is written over the next byte": (
            CobsEncoder,
            (
                "tail.eq(tail + 1),\n                code.eq(1),",
                "tail.eq(tail),\n                code.eq(1),",
            ),
        ),
        "no delimiter": (CobsEncoder, ("write_data.eq(DELIMITER)", "write_data.eq(code)")),
        "bytes are taken without room": (
            CobsEncoder,
            ("with m.If(self.frames.valid & room):", "with m.If(self.frames.valid):"),
        ),
    },
)

# All remaining faults only show after a full block.
SHOWN = ("the code is written over the next byte", "no delimiter")

PROOFS = {
    "cobs_encoder": ENCODER,
    "cobs_encoder_full": Proof(
        FullEncoder,
        depth=3,
        reached=9,
        long=True,
        induction=3,
        faults={name: ENCODER.faults[name] for name in SHOWN},
    ),
}
