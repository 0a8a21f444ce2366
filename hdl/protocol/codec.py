"""Frames in software: header, CRC and COBS, for host and model.

It is pure Python with the COBS codec of the package ``cobs``.
"""

from __future__ import annotations

import zlib

from cobs import cobs

from pathgene.hdl.protocol.codes import StickyError


__all__ = [
    "BODY_HEADER_BYTES",
    "CRC_BYTES",
    "DELIMITER",
    "VERSION",
    "Frame",
    "FrameError",
    "FrameSplitter",
    "decode_frame",
    "encode_frame",
    "frame_crc",
]

#: Version of the protocol, 1..255; 0 stands for plain frames.
VERSION = 5
#: Ends every frame.
DELIMITER = 0x00
#: Session, sequence, code.
BODY_HEADER_BYTES = 3
CRC_BYTES = 4

#: A body without its CRC, and whether the frame was plain.
Frame = tuple[bytes, bool]

_DELIMITER = bytes([DELIMITER])


def frame_crc(body: bytes, *, plain: bool) -> int:
    """Return the CRC that follows ``body`` in a frame."""
    # Every byte of the CRC is altered, so that no single damaged byte turns a frame into a plain
    # one.
    return zlib.crc32(body) ^ (0 if plain else VERSION * 0x01010101)


class FrameError(ValueError):
    """A frame that a receiver discards.

    Parameters
    ----------
    kind : StickyError
        ``MALFORMED`` or ``CRC``.
    """

    def __init__(self, kind: StickyError) -> None:
        self.kind = kind
        wrong = "COBS code or length" if kind is StickyError.MALFORMED else "CRC"
        super().__init__(f"Frame must have a right {wrong}")


def encode_frame(body: bytes, *, plain: bool = False) -> bytes:
    """Return the frame of ``body``, with its delimiter.

    Raises
    ------
    ValueError
        If the body is shorter than its header.
    """
    if len(body) < BODY_HEADER_BYTES:
        raise ValueError(f"Body must have {BODY_HEADER_BYTES} bytes or more, not {len(body)}")
    crc = frame_crc(body, plain=plain).to_bytes(CRC_BYTES, "little")
    encoded: bytes = cobs.encode(body + crc)
    return encoded + _DELIMITER


def decode_frame(encoded: bytes) -> Frame:
    """Return the body of the frame ``encoded``, without delimiters, and whether it is plain.

    Raises
    ------
    FrameError
        If a block contains a zero, if body and CRC are too short, or if the CRC is wrong.
    """
    try:
        decoded: bytes = cobs.decode(encoded)
    except cobs.DecodeError:
        raise FrameError(StickyError.MALFORMED) from None
    if len(decoded) < BODY_HEADER_BYTES + CRC_BYTES:
        raise FrameError(StickyError.MALFORMED)
    body = decoded[:-CRC_BYTES]
    crc = int.from_bytes(decoded[-CRC_BYTES:], "little")
    for plain in (False, True):
        if crc == frame_crc(body, plain=plain):
            return body, plain
    raise FrameError(StickyError.CRC)


class FrameSplitter:
    """Splitter of a stream of bytes, in pieces of any size, at its delimiters."""

    def __init__(self) -> None:
        self._begun: list[bytes] = []

    @property
    def inside(self) -> bool:
        """True if bytes have arrived since the last delimiter."""
        return bool(self._begun)

    def feed(self, data: bytes) -> list[bytes]:
        """Return the non-empty frames that ``data`` completes, without their delimiters."""
        *ended, begun = data.split(_DELIMITER)
        if ended:
            ended[0] = b"".join([*self._begun, ended[0]])
            self._begun.clear()
        if begun:
            self._begun.append(begun)
        return [piece for piece in ended if piece]

    def drop(self) -> None:
        """Discard the bytes since the last delimiter."""
        self._begun.clear()
