"""What surrounds a payload."""

from __future__ import annotations

import zlib


__all__ = ["BODY_HEADER_BYTES", "CRC_BYTES", "DELIMITER", "VERSION", "frame_crc"]

#: Version of the protocol, 1..255; 0 stands for plain frames.
VERSION = 2
#: Ends every frame.
DELIMITER = 0x00
#: Session, sequence, code.
BODY_HEADER_BYTES = 3
CRC_BYTES = 4


def frame_crc(body: bytes, *, plain: bool) -> int:
    """Return the CRC that follows ``body`` in a frame."""
    # In every byte of the CRC: no single damaged byte turns a frame into a plain one.
    return zlib.crc32(body) ^ (0 if plain else VERSION * 0x01010101)
