"""The frame receiver passes on exactly the bodies of good frames, complete and in order."""

import zlib
from types import SimpleNamespace

from amaranth import *
from amaranth.hdl import Assert, Cover

from pathgene.hdl.link.frame import FrameReceiver
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, CRC_BYTES, frame_crc
from tests.formal.parts import Opened, any_constant, free
from tools.formal import Proof


#: A CRC that may compute anything, so that any frame may be found right or wrong.
FREE = (
    "from amaranth.lib.crc.catalog import CRC32_ISO_HDLC",
    "from tests.formal.parts import FreeCrc as CRC32_ISO_HDLC",
)

SHORTEST = BODY_HEADER_BYTES + CRC_BYTES


def residue(*, plain):
    """Return the state of the CRC unit after a body and its correct CRC."""
    return zlib.crc32(frame_crc(b"", plain=plain).to_bytes(CRC_BYTES, "little"))


class Receiver(Elaboratable):
    """Proved for all time, by induction, for a buffer of 8 rows.

    Only the widths of the pointers depend on the depth. Any bytes arrive in any cycles; the user
    takes bytes in any cycles; the CRC unit may compute anything. The COBS decoder and the ring are
    the real ones; the decoding itself is proved for the decoder.

    - The CRC unit gets exactly the bytes of the frame, and starts again with each frame: a frame is
      judged only by its own bytes.
    - A frame is stored if it is not broken, has 7 bytes or more, a correct CRC and room for its
      body. The ring then gets, in this order, a row that says whether the frame is plain, and all
      bytes of the frame except the last four, with the last of them marked. No row is lost, doubled
      or invented, and other frames store none. The proof watches an arbitrary row and its contents.
    - Each other frame causes one pulse: ``malformed``, or ``crc_error``, or ``overrun``, by this
      priority, 2 cycles after its delimiter. There is no other pulse.
    - ``overrun`` only occurs if the bodies, with one more byte for each, do not fit into the
      buffer.
    - Rows of the ring are passed on as bytes of bodies in the cycle in which they are read, with
      ``plain`` from the row before the body, which is not passed on.
    - One cycle after the end of any frame, the receiver is ready for the next one: it neither holds
      nor counts any byte, and only stores bytes of accepted bodies.
    """

    ROWS = 8

    def __init__(self, unit):
        self.dut = unit(FrameReceiver, FREE)(self.ROWS)

    def elaborate(self, platform):
        m = Module()
        receiver, rows = self.dut, self.ROWS
        m.submodules.dut = dut = Opened(receiver)
        decoder, crc, ring = (dut.submodules[name] for name in ("decoder", "crc", "ring"))
        decoding, reading = dut.open("decoder"), dut.open("ring")
        pointer = ring.fetched.shape()
        watched = any_constant(m, pointer, "watched")
        stored = reading.memory(m, "rows", watched[:-1])
        free(m, receiver.bytes.valid, receiver.bytes.payload, receiver.requests.ready)

        # The decoded frame: its bytes, counted up to more than fit.
        arrives, ends = Signal(), Signal()
        n, lost = Signal(range(rows + 9)), Signal()
        m.d.comb += [
            arrives.eq(decoder.decoded.valid & ~decoder.decoded.p.delimiter),
            ends.eq(decoder.decoded.valid & decoder.decoded.p.delimiter),
            Assert(crc.valid == arrives),
            Assert(~arrives | (crc.data == decoder.decoded.p.data)),
            Assert(crc.start == ends),
        ]

        # Its rows: one at `base`, and one for each byte of the body. The oldest held byte is stored
        # when the next byte or the delimiter arrives.
        base, taken = Signal(pointer), Signal(pointer)
        place, unread, waiting, at = (
            Signal(pointer, name=name) for name in ("place", "unread", "waiting", "at")
        )
        fits, stores = Signal(), Signal()
        byte = Signal(8)
        m.d.comb += [
            place.eq(watched - base - 1),
            unread.eq(base - ring.fetched),
            waiting.eq(base - taken),
            at.eq(watched - ring.fetched),
            fits.eq(unread + n < rows + CRC_BYTES),
            stores.eq(decoder.decoded.valid & (n > CRC_BYTES)),
            # Bytes fetched from the ring are not all transferred.
            Assert(~stores | fits | (waiting + n >= rows + CRC_BYTES)),
        ]
        with m.If(arrives):
            with m.If(n != rows + 8):
                m.d.sync += n.eq(n + 1)
            with m.If(n == place):
                m.d.sync += byte.eq(decoder.decoded.p.data)
        with m.If(stores & ~fits):
            m.d.sync += lost.eq(1)
        with m.If(ends):
            m.d.sync += [n.eq(0), lost.eq(0)]

        # The verdict on the frame.
        whole, plain, right, accepts = (
            Signal(name=name) for name in ("whole", "plain", "right", "accepts")
        )
        m.d.comb += [
            whole.eq(~decoder.decoded.p.broken & (n >= SHORTEST)),
            plain.eq(crc.crc == residue(plain=True)),
            right.eq(plain | (crc.crc == residue(plain=False))),
            accepts.eq(ends & whole & right & fits & ~lost),
        ]
        accepted, size = Signal(), Signal(pointer)
        expected = Signal(9)
        m.d.sync += [accepted.eq(accepts), size.eq(n - CRC_BYTES + 1)]
        with m.If(accepts):
            with m.If(watched == base):
                m.d.sync += expected.eq(plain)
            with m.Elif(place < n - CRC_BYTES):
                m.d.sync += expected.eq(Cat(byte, place == n - CRC_BYTES - 1))
        with m.If(accepted):
            m.d.sync += base.eq(base + size)
        for pulse, condition in (
            (receiver.malformed, ends & ~whole),
            (receiver.crc_error, ends & whole & ~right),
            (receiver.overrun, ends & whole & right & (lost | ~fits)),
        ):
            due = Signal(name=f"due_{pulse.name}")
            m.d.sync += due.eq(condition)
            m.d.comb += Assert(pulse == due)

        row = SimpleNamespace(
            watched=watched, stored=stored, expected=expected, byte=byte, place=place, at=at,
            base=base, size=size, unread=unread, n=n, lost=lost, accepted=accepted, taken=taken,
        )  # fmt: skip
        self._check_requests(m, dut, ring, row)

        # Between frames, no state of a frame is left.
        count, tail, commit = (dut.signal(name) for name in ("count", "tail", "commit"))
        dropped, behind, ended = dut.signal("dropped"), Signal(pointer), Signal()
        m.d.sync += ended.eq(ends)
        m.d.comb += [
            behind.eq(tail - base),
            Assert(~(ended & decoder.decoded.valid)),
            Assert(dut.signal("committed", "sync") == base),
        ]
        with m.If(~decoder.inside & ~decoder.decoded.valid):
            m.d.comb += [Assert(count == 0), Assert(~dropped), Assert(ended | (behind == 1))]

        # Invariants that the induction needs: of the decoder, of the frame, ...
        left, zero = decoding.signal("left"), decoding.signal("zero")
        m.d.comb += [
            Assert(decoder.inside | ((left == 0) & ~zero)),
            Assert(~arrives | decoder.inside),
            Assert(~ends | ~decoder.inside),
            Assert((n == 0) | decoder.inside | ends),
            Assert((n <= rows + 8) & (~lost | (n > CRC_BYTES))),
            Assert(~ended | (n == 0)),
            Assert(~accepted | ended),
            Assert(count == Mux(n < SHORTEST, n, SHORTEST)),
            Assert(dropped == lost),
            Assert(commit == accepted),
            Assert(unread <= rows),
        ]
        with m.If(accepted):
            m.d.comb += [
                Assert(behind == size),
                Assert((size > BODY_HEADER_BYTES) & (unread + size <= rows)),
            ]
        with m.Elif(ended | lost):
            m.d.comb += [Assert(behind >= 1), Assert(unread + behind <= rows + 1)]
        with m.Elif(n <= CRC_BYTES + 1):
            m.d.comb += Assert(behind == 1)
        with m.Else():
            m.d.comb += [Assert(behind == n - CRC_BYTES), Assert(unread + behind <= rows)]

        # ... of the watched row and of the ring.
        self._know_row(m, dut, row)
        self._know_ring(m, reading, ring, row)
        self._cover(m, accepts)
        return m

    def _check_requests(self, m, dut, ring, row):
        """Follow the rows as they are read, and check the bytes that are passed on."""
        words, requests = ring.words, self.dut.requests
        transfer, body, is_plain = Signal(), Signal(), Signal()
        m.d.comb += [
            transfer.eq(words.valid & words.ready),
            Assert(words.ready == (requests.ready | ~body)),
            Assert(requests.valid == (words.valid & body)),
        ]
        m.d.sync += row.taken.eq(row.taken + transfer)
        with m.If(transfer):
            m.d.sync += body.eq(~body | ~words.p.last)
        with m.If(transfer & ~body):
            m.d.sync += is_plain.eq(words.p.data[0])
        with m.If(requests.valid):
            m.d.comb += [
                Assert(requests.p.data == words.p.data),
                Assert(requests.p.last == words.p.last),
                Assert(requests.p.plain == is_plain),
            ]
        with m.If(words.valid):
            m.d.comb += Assert(row.taken != row.base)
            with m.If(row.taken == row.watched):
                m.d.comb += Assert(words.payload.as_value() == row.expected)
        m.d.comb += [
            Assert(dut.signal("opened") == body),
            Assert(~body | (requests.p.plain == is_plain)),
        ]

    def _know_row(self, m, dut, row):
        """Assert the invariants of the watched row, from the arrival of its byte."""
        held = Value.cast(dut.signal("held"))
        with m.If(row.at < row.unread):
            m.d.comb += Assert(row.stored == row.expected)
        with m.If(row.accepted):
            with m.If(row.watched == row.base):
                m.d.comb += Assert(dut.signal("is_plain") == row.expected)
            with m.Elif(row.place < row.size - 1):
                m.d.comb += Assert(row.stored == row.expected)
        with m.Elif(~row.lost & (row.place < row.n)):
            age = (row.n - 1 - row.place)[:3]
            with m.If(row.place + CRC_BYTES + 1 < row.n):
                m.d.comb += Assert(row.stored == row.byte)
            with m.Else():
                m.d.comb += Assert(held.word_select(age, 8) == row.byte)

    def _know_ring(self, m, reading, ring, row):
        """Assert the invariants of rows in flight through the ring."""
        loaded = reading.signal("loaded")
        ahead = Signal.like(ring.fetched)
        m.d.comb += [
            ahead.eq(ring.fetched - row.taken),
            Assert(ahead == loaded + ring.words.valid),
        ]
        with m.If(
            loaded & (Value.cast(row.taken + ring.words.valid)[: len(row.taken)] == row.watched)
        ):
            data = Value.cast(reading.submodules.rows.read_ports[0].data)
            m.d.comb += Assert(data == row.expected)

    def _cover(self, m, accepts):
        receiver = self.dut
        requests = receiver.requests
        bodies = Signal(2)
        m.d.sync += bodies.eq(bodies + accepts)
        m.d.comb += [
            Cover((bodies == 2) & requests.valid & requests.p.last & requests.p.plain),
            Cover(receiver.malformed),
            Cover(receiver.crc_error),
            Cover(receiver.overrun),
        ]


PROOF = Proof(
    claim=Receiver,
    depth=2,
    reached=28,
    induction=2,
    long=(
        "reached",
        "the CRC is not looked at",
        "a broken frame passes",
        "bytes of a dropped frame stay",
        "a body without room for all of it passes",
    ),
    faults={
        "a byte of the CRC is passed on": (
            FrameReceiver,
            ("(count > CRC_BYTES)", "(count >= CRC_BYTES)"),
        ),
        "the CRC is not looked at": (
            FrameReceiver,
            ("commit.eq(ends & whole & right & room)", "commit.eq(ends & whole & room)"),
        ),
        "a broken frame passes": (
            FrameReceiver,
            ("whole.eq(~decoder.decoded.p.broken & ", "whole.eq("),
        ),
        "bytes of a dropped frame stay": (
            FrameReceiver,
            ("tail.eq(committed + 1)", "tail.eq(tail)"),
        ),
        "a body without room for all of it passes": (
            FrameReceiver,
            ("commit.eq(ends & whole & right & room)", "commit.eq(ends & whole & right)"),
        ),
    },
)
