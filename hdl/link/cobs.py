"""Consistent Overhead Byte Stuffing: frames of any bytes, delimited by zeros."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.storage import CommitRing
from pathgene.hdl.primitives.unit import Unit
from pathgene.hdl.protocol.codec import DELIMITER


__all__ = ["CobsDecoder", "CobsEncoder"]

# Code of a full block, which has no zero after it.
_FULL = 0xFF


class CobsDecoder(Unit):
    """Decodes frames, one byte per cycle.

    An encoded byte is decoded 1 cycle later. Empty frames are skipped. Every sequence of bytes can
    be decoded; the first delimiter ends any frame.

    Source: S. Cheshire and M. Baker, "Consistent Overhead Byte Stuffing", IEEE/ACM Transactions on
    Networking 7(2), 1999, section II.

    Members
    -------
    encoded : In(stream.Signature(8))
        Bytes from the line, including delimiters. Always ready.
    decoded : Out(stream.Signature({"data": 8, "delimiter": 1, "broken": 1}, always_ready=True))
        Decoded bytes; after the bytes of each frame, a transfer with ``delimiter`` and no data, in
        which ``broken`` marks a zero inside a block. At least 2 cycles pass between this transfer
        and the first byte of the next frame.
    inside : Out(1)
        A frame has begun but not ended.
    """

    def interface(self):
        self.decoded_layout = data.StructLayout({"data": 8, "delimiter": 1, "broken": 1})
        return {
            "encoded": In(stream.Signature(8)),
            "decoded": Out(stream.Signature(self.decoded_layout, always_ready=True)),
            "inside": Out(1),
        }

    def elaborate(self, platform):
        m = Module()

        left = Signal(8)  # Bytes left in the block.
        zero = Signal()  # A zero follows the block unless the frame ends with it.

        m.d.comb += self.encoded.ready.eq(1)
        m.d.sync += [
            self.decoded.valid.eq(0),
            self.decoded.p.data.eq(0),
            self.decoded.p.delimiter.eq(self.encoded.payload == DELIMITER),
            self.decoded.p.broken.eq(left != 0),
        ]
        with m.If(self.encoded.valid):
            with m.If(self.encoded.payload == DELIMITER):
                m.d.sync += [
                    self.decoded.valid.eq(self.inside),
                    self.inside.eq(0),
                    left.eq(0),
                    zero.eq(0),
                ]
            with m.Elif(left != 0):
                m.d.sync += [
                    self.decoded.valid.eq(1),
                    self.decoded.p.data.eq(self.encoded.payload),
                    left.eq(left - 1),
                ]
            with m.Else():
                m.d.sync += [
                    self.decoded.valid.eq(zero),
                    self.inside.eq(1),
                    left.eq(self.encoded.payload - 1),
                    zero.eq(self.encoded.payload != _FULL),
                ]

        return m


class CobsEncoder(Unit):
    """Encodes frames of any length, each followed by a delimiter.

    The code of a block is its length, so a block can only be sent once it is complete. The buffer
    holds two whole blocks, so that a block is filled while the previous one is sent. The encoding
    is the shortest possible: no empty block follows a full block that ends its frame.

    A byte is accepted every cycle while the buffer has room, except for 1 cycle after each block of
    254 bytes without a zero and 2 cycles after each frame. The first byte of a one-block frame is
    offered 4 cycles after its last byte is accepted.

    Members
    -------
    frames : In(stream.Signature({"data": 8, "last": 1}))
        Bytes of frames, at least one for each; ``last`` marks the last byte of a frame.
    encoded : Out(stream.Signature(8))
        Encoded bytes and delimiters.
    """

    #: Rows of the buffer: a block has at most 255 bytes with its code.
    DEPTH = 512

    def interface(self):
        self.frames_layout = data.StructLayout({"data": 8, "last": 1})
        return {
            "frames": In(stream.Signature(self.frames_layout)),
            "encoded": Out(stream.Signature(8)),
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.ring = ring = CommitRing(8, self.DEPTH)

        # The block being filled: its code goes to `start`, its next byte to `tail`. All rows before
        # `start` may be sent.
        start = Signal.like(ring.committed)
        tail = Signal.like(ring.committed, init=1)
        code = Signal(8, init=1)
        ended = Signal()  # All bytes of the frame have arrived.
        used = Signal.like(ring.committed)
        room = Signal(init=1)

        m.d.comb += [
            used.eq(tail - ring.fetched),
            ring.committed.eq(start),
            self.encoded.valid.eq(ring.words.valid),
            self.encoded.payload.eq(ring.words.payload),
            ring.words.ready.eq(self.encoded.ready),
        ]

        # One cycle old, hence the margin of a few rows: `tail` may have advanced since then.
        m.d.sync += room.eq(~used[-1] & ~used[2:-1].all())

        def close_block():
            m.d.comb += [
                ring.write_enable.eq(1),
                ring.write_row.eq(start),
                ring.write_data.eq(code),
            ]
            m.d.sync += [
                start.eq(tail),
                tail.eq(tail + 1),
                code.eq(1),
            ]

        with m.FSM():
            with m.State("Fill"):
                m.d.comb += self.frames.ready.eq(room)
                with m.If(self.frames.valid & room):
                    m.d.sync += ended.eq(self.frames.p.last)
                    with m.If(self.frames.p.data == 0):
                        close_block()
                    with m.Else():
                        m.d.comb += [
                            ring.write_enable.eq(1),
                            ring.write_row.eq(tail),
                            ring.write_data.eq(self.frames.p.data),
                        ]
                        m.d.sync += [
                            tail.eq(tail + 1),
                            code.eq(code + 1),
                        ]
                    with m.If(self.frames.p.last):
                        m.next = "Close"
                    with m.Elif((self.frames.p.data != 0) & (code == _FULL - 1)):
                        m.next = "Close"
            with m.State("Close"):
                with m.If(room):
                    close_block()
                    m.next = "Fill"
                    with m.If(ended):
                        m.next = "Delimit"
            with m.State("Delimit"):
                with m.If(room):
                    # The delimiter takes the row of the code.
                    m.d.comb += [
                        ring.write_enable.eq(1),
                        ring.write_row.eq(start),
                        ring.write_data.eq(DELIMITER),
                    ]
                    m.d.sync += [
                        start.eq(tail),
                        tail.eq(tail + 1),
                    ]
                    m.next = "Fill"

        return m
