"""The map of a chip: its frames on the link, and smaller maps padded to its size."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.hdl.protocol import BODY_HEADER_BYTES, CRC_BYTES, map_request


__all__ = ["changed_parts", "map_frames", "padded_map"]

#: Maximum cells of the map in one frame.
_FRAME_CELLS = 256
#: Minimum frames of the map that the chip's buffer holds, so that the line never waits for replies.
_FRAMES_IN_FLIGHT = 4


def padded_map(heights: NDArray[np.integer], config: Config) -> NDArray[np.uint16]:
    """Return ``heights`` [y, x] as a whole map; the remaining cells north and east are blocked.

    Parameters
    ----------
    heights : ndarray
        ``(rows, columns)`` integers, altitude steps, row 0 the southernmost; no larger than the
        map.
    config : Config
        The chip's.

    Returns
    -------
    ndarray
        ``(map_size, map_size)`` uint16, altitude steps.
    """
    padded = np.full((config.map_size,) * 2, config.blocked_altitude, dtype=np.uint16)
    padded[: heights.shape[0], : heights.shape[1]] = heights
    return padded


def map_frames(
    config: Config, heights: NDArray[np.integer], x: int, y: int
) -> Iterator[tuple[bytes, tuple[slice, slice]]]:
    """Yield the payload of each MAP frame of a rectangle, with the rows and columns it writes.

    A frame stays within a block of the coarse map where it can, so that the chip rebuilds as few
    blocks as possible.

    Parameters
    ----------
    config : Config
    heights : ndarray
        ``(rows, columns)`` integers, altitude steps, row 0 the southernmost.
    x, y : int
        Cell of ``heights[0, 0]``.

    Raises
    ------
    ValueError
        If ``heights`` is not such an array, or leaves the map.
    """
    heights = np.asarray(heights)
    if heights.ndim != 2 or heights.size == 0 or not np.issubdtype(heights.dtype, np.integer):
        raise ValueError(
            "Heights must be a filled array of two axes of integers, not of shape "
            f"{heights.shape} of {heights.dtype}"
        )
    rows, columns = heights.shape
    edge, top = config.map_size, config.blocked_altitude
    if not (0 <= x <= edge - columns and 0 <= y <= edge - rows):
        raise ValueError(
            f"Heights must lie within 0..{edge - 1}, not {columns} x {rows} cells at ({x}, {y})"
        )
    if heights.min() < 0 or heights.max() > top:
        raise ValueError(f"Heights must be from 0 to {top}, not {heights.min()} to {heights.max()}")

    width, height = _tile(config)
    for south in range(y - y % height, y + rows, height):
        bottom, above = max(south, y), min(south + height, y + rows)
        for west in range(x - x % width, x + columns, width):
            left, right = max(west, x), min(west + width, x + columns)
            header = map_request(config).pack(
                x=left, y=bottom, width=right - left, height=above - bottom
            )
            cells = heights[bottom - y : above - y, left - x : right - x]
            yield header + _packed(config, cells), (slice(bottom, above), slice(left, right))


def changed_parts(config: Config, changed: NDArray[np.bool_]) -> Iterator[tuple[slice, slice]]:
    """Yield rows and columns of rectangles, one per frame of the map, that cover all changes.

    Each rectangle is as small as its changes allow.

    Parameters
    ----------
    config : Config
    changed : ndarray
        ``(map_size, map_size)`` bool, [y, x].
    """
    width, height = _tile(config)
    y, x = np.nonzero(changed)
    tiles = y // height * config.map_size + x // width
    order = np.argsort(tiles, kind="stable")
    y, x = y[order], x[order]
    _, firsts = np.unique(tiles[order], return_index=True)
    for rows, columns in zip(*(np.split(each, firsts[1:]) for each in (y, x)), strict=True):
        if rows.size:
            yield _from_to(rows), _from_to(columns)


def _from_to(places: NDArray[np.intp]) -> slice:
    return slice(int(places.min()), int(places.max()) + 1)


def _tile(config: Config) -> tuple[int, int]:
    """Return the width and height of the largest part of a coarse block that fits into a frame."""
    room = config.receive_buffer // _FRAMES_IN_FLIGHT - BODY_HEADER_BYTES - CRC_BYTES
    cells = (room - map_request(config).size) * 8 // config.altitude_bits
    cells = 1 << min(cells, _FRAME_CELLS).bit_length() - 1
    width = min(config.coarse_factor, cells)
    return width, cells // width


def _packed(config: Config, cells: NDArray[np.integer]) -> bytes:
    """Pack cells as :func:`pathgene.hdl.protocol.pack_cells` does, all at once."""
    bits = cells.reshape(-1, 1).astype(np.uint32) >> np.arange(config.altitude_bits) & 1
    return np.packbits(bits.astype(np.uint8), bitorder="little").tobytes()
