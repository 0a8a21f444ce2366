"""Frames of :mod:`hdl.protocol` in software: one definition for the host and the model.

Pure Python with the COBS codec of the package ``cobs``.
"""

from __future__ import annotations

from cobs import cobs

from hdl.protocol import BODY_HEADER_BYTES, CRC_BYTES, DELIMITER, StickyError, frame_crc


__all__ = ["Frame", "FrameError", "FrameSplitter", "decode_frame", "encode_frame"]

#: A body without its CRC, and whether the CRC was a plain one.
Frame = tuple[bytes, bool]

_DELIMITER = bytes([DELIMITER])


class FrameError(ValueError):
    """A frame that a receiver drops.

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
    """Return body and plainness of what stood between two delimiters.

    Raises
    ------
    FrameError
        If a zero stood inside a block, if body and CRC are too short, or the CRC is wrong.
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
    """Cuts a stream of bytes at its delimiters, whatever the pieces it comes in."""

    def __init__(self) -> None:
        self._begun: list[bytes] = []

    @property
    def inside(self) -> bool:
        """Whether bytes have come since the last delimiter."""
        return bool(self._begun)

    def feed(self, data: bytes) -> list[bytes]:
        """Return what ``data`` completes, without delimiters, leaving out what is empty."""
        *ended, begun = data.split(_DELIMITER)
        if ended:
            ended[0] = b"".join([*self._begun, ended[0]])
            self._begun.clear()
        if begun:
            self._begun.append(begun)
        return [piece for piece in ended if piece]

    def drop(self) -> None:
        """Forget the bytes since the last delimiter."""
        self._begun.clear()
