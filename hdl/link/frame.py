"""Frames of ``protocol``: from the bytes of the line to checked bodies, and back."""

import zlib

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.crc.catalog import CRC32_ISO_HDLC
from amaranth.lib.wiring import In, Out

from pathgene.hdl.link.cobs import CobsDecoder, CobsEncoder
from pathgene.hdl.primitives.storage import CommitRing
from pathgene.hdl.primitives.unit import PowerOfTwo, Unit
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, CRC_BYTES, frame_crc


__all__ = ["FrameReceiver", "FrameTransmitter", "body_layout"]

#: One byte of a body.
body_layout = data.StructLayout({"data": 8, "last": 1, "plain": 1})


# XORed with the CRC of every frame except plain ones.
_VERSION_MASK = frame_crc(b"", plain=False) ^ frame_crc(b"", plain=True)


def _residue(*, plain):
    # The CRC over a body and its own CRC is the same for every body, including the empty one.
    return zlib.crc32(frame_crc(b"", plain=plain).to_bytes(CRC_BYTES, "little"))


class FrameReceiver(Unit):
    """Receives frames from the line and passes on the bodies of undamaged frames.

    A body is kept in a ring buffer and can only be read after its CRC has been verified, so the
    user only gets complete, checked bodies. Any other frame is discarded with a pulse for the first
    of these rules that the frame breaks:

    1. ``malformed``: no zero inside a COBS block, and at least 7 bytes of body and CRC;
    2. ``crc_error``: the CRC of the protocol's version, or the plain CRC;
    3. ``overrun``: room in the buffer. A body takes one row more than it has bytes, so bodies that
       have ``receive_buffer`` bytes together with their CRCs always fit.

    An empty frame is ignored and is not an error. After any sequence of bytes and one delimiter,
    the next good frame is received.

    A byte is taken in every cycle. The first byte of a body is offered 6 cycles after the delimiter
    that ends its frame, if no earlier body is waiting; then one byte is offered per cycle.

    The buffer is one block RAM on the target (2048 rows of 9 bits are one DP16KD of an ECP5). The
    rest is about 150 flip-flops, half of them for the CRC and for the bytes that are held because
    they may be the CRC.

    Members
    -------
    bytes : In(stream.Signature(8))
        Bytes from the line. Always ready.
    requests : Out(stream.Signature(body_layout))
        Bodies, without CRC; ``last`` marks the last byte of each, ``plain`` every byte of a body
        from a plain frame.
    malformed, crc_error, overrun : Out(1)
        High for one cycle, 2 cycles after the delimiter of a discarded frame.
    line_busy : Out(1)
        A frame has begun but not ended: bytes have arrived since the last delimiter.
    """

    receive_buffer: PowerOfTwo(8, 1 << 15, "Depth of the buffer.")

    def interface(self):
        return {
            "bytes": In(stream.Signature(8)),
            "requests": Out(stream.Signature(body_layout)),
            "malformed": Out(1),
            "crc_error": Out(1),
            "overrun": Out(1),
            "line_busy": Out(1),
        }

    def elaborate(self, platform):
        m = Module()

        # A row stores a byte of a body; one row before each body says whether the body is plain.
        row_layout = data.StructLayout({"data": 8, "last": 1})
        m.submodules.decoder = decoder = CobsDecoder()
        m.submodules.crc = crc = CRC32_ISO_HDLC().create()
        m.submodules.ring = ring = CommitRing(row_layout, self.receive_buffer)

        wiring.connect(m, wiring.flipped(self.bytes), decoder.encoded)
        m.d.comb += self.line_busy.eq(decoder.inside)

        arrives = Signal()
        ends = Signal()
        m.d.comb += [
            arrives.eq(decoder.decoded.valid & ~decoder.decoded.p.delimiter),
            ends.eq(decoder.decoded.valid & decoder.decoded.p.delimiter),
            crc.data.eq(decoder.decoded.p.data),
            crc.valid.eq(arrives),
            crc.start.eq(ends),
        ]

        # The four newest bytes may be the CRC, and the byte before them the last of the body: this
        # is known when the next byte or the delimiter arrives.
        held = Signal(data.ArrayLayout(8, CRC_BYTES + 1))
        count = Signal(range(BODY_HEADER_BYTES + CRC_BYTES + 1))  # Saturates at the shortest frame.
        with m.If(arrives):
            m.d.sync += held.eq(Cat(decoder.decoded.p.data, held.as_value()[:-8]))
            with m.If(count != BODY_HEADER_BYTES + CRC_BYTES):
                m.d.sync += count.eq(count + 1)
        with m.If(ends):
            m.d.sync += count.eq(0)

        tail = Signal.like(ring.committed, init=1)  # Row for the next byte of the body.
        committed = Signal.like(ring.committed)
        used = Signal.like(ring.committed)
        dropped = Signal()  # There was no room for a byte of the body.
        room = Signal()
        kept = Signal()
        m.d.comb += [
            ring.committed.eq(committed),
            used.eq(tail - ring.fetched),
            room.eq(~used[-1] & ~dropped),
            kept.eq(decoder.decoded.valid & (count > CRC_BYTES)),
        ]
        with m.If(kept):
            with m.If(room):
                m.d.sync += tail.eq(tail + 1)
            with m.Else():
                m.d.sync += dropped.eq(1)

        right = Signal()
        plain = Signal()
        whole = Signal()
        commit = Signal()
        m.d.comb += [
            plain.eq(crc.crc == _residue(plain=True)),
            right.eq(plain | (crc.crc == _residue(plain=False))),
            whole.eq(~decoder.decoded.p.broken & (count == BODY_HEADER_BYTES + CRC_BYTES)),
        ]
        m.d.sync += [
            self.malformed.eq(ends & ~whole),
            self.crc_error.eq(ends & whole & ~right),
            self.overrun.eq(ends & whole & right & ~room),
            commit.eq(ends & whole & right & room),
        ]
        is_plain = Signal()
        ended = Signal()
        m.d.sync += ended.eq(ends)
        with m.If(ends):
            m.d.sync += [
                is_plain.eq(plain),
                dropped.eq(0),
            ]
        # While `ended` is high, no byte of the next frame has arrived yet.
        with m.If(commit):
            m.d.sync += [
                committed.eq(tail),
                tail.eq(tail + 1),
            ]
        with m.Elif(ended):
            m.d.sync += tail.eq(committed + 1)
        m.d.comb += [
            ring.write_enable.eq((kept & room) | commit),
            ring.write_row.eq(Mux(commit, committed, tail)),
            ring.write_data.data.eq(Mux(commit, is_plain, held[CRC_BYTES])),
            ring.write_data.last.eq(ends),
        ]

        opened = Signal()  # The row before the body has been read.
        m.d.comb += [
            self.requests.valid.eq(ring.words.valid & opened),
            self.requests.p.data.eq(ring.words.p.data),
            self.requests.p.last.eq(ring.words.p.last),
            ring.words.ready.eq(self.requests.ready | ~opened),
        ]
        with m.If(ring.words.valid & ring.words.ready):
            with m.If(opened):
                m.d.sync += opened.eq(~ring.words.p.last)
            with m.Else():
                m.d.sync += [
                    opened.eq(1),
                    self.requests.p.plain.eq(ring.words.p.data[0]),
                ]

        return m


class FrameTransmitter(Unit):
    """Sends bodies as frames: adds the CRC, COBS and the delimiter.

    A byte of a body is accepted every cycle while the encoder has room, except for 1 cycle after
    each block of 254 bytes without a zero and 6 cycles after each body. A frame of a single COBS
    block is offered from 8 cycles after the last byte of its body is accepted; a longer frame is
    offered block by block, without pauses while bodies arrive faster than ``bytes`` are taken.

    On an ECP5 the transmitter takes one block RAM for the blocks and about 120 flip-flops.

    Members
    -------
    replies : In(stream.Signature(body_layout))
        Bodies of one byte or more; ``last`` marks the last byte of each, with which ``plain`` is
        sampled.
    bytes : Out(stream.Signature(8))
        Bytes for the line.
    """

    def interface(self):
        return {
            "replies": In(stream.Signature(body_layout)),
            "bytes": Out(stream.Signature(8)),
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.crc = crc = CRC32_ISO_HDLC().create()
        m.submodules.encoder = encoder = CobsEncoder()

        wiring.connect(m, encoder.encoded, wiring.flipped(self.bytes))

        left = Signal(range(CRC_BYTES + 1))  # Bytes of the CRC to send; 0 within a body.
        plain = Signal()
        mask = Signal(8 * CRC_BYTES)
        rest = Signal(8 * CRC_BYTES)  # Bytes of the CRC after the first, next byte lowest.
        now = Signal(8 * CRC_BYTES)
        m.d.comb += mask.eq(Mux(plain, 0, _VERSION_MASK))

        with m.If(left == 0):
            m.d.comb += [
                encoder.frames.valid.eq(self.replies.valid),
                encoder.frames.p.data.eq(self.replies.p.data),
                self.replies.ready.eq(encoder.frames.ready),
                crc.data.eq(self.replies.p.data),
                crc.valid.eq(self.replies.valid & self.replies.ready),
            ]
            with m.If(crc.valid & self.replies.p.last):
                m.d.sync += [
                    left.eq(CRC_BYTES),
                    plain.eq(self.replies.p.plain),
                ]
        with m.Else():
            m.d.comb += [
                now.eq(Mux(left == CRC_BYTES, crc.crc ^ mask, rest)),
                encoder.frames.valid.eq(1),
                encoder.frames.p.data.eq(now[:8]),
                encoder.frames.p.last.eq(left == 1),
            ]
            with m.If(encoder.frames.ready):
                m.d.comb += crc.start.eq(left == CRC_BYTES)
                m.d.sync += [
                    left.eq(left - 1),
                    rest.eq(now >> 8),
                ]

        return m
