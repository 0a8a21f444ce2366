"""The map of a chip: its frames on the link, its padding, and the host's copy."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, CRC_BYTES
from pathgene.hdl.protocol.codes import Command
from pathgene.hdl.protocol.messages import map_request
from pathgene.hdl.protocol.planner import NoFlyShape
from pathgene.host.device.orders import Orders


__all__ = ["MapCopy", "changed_parts", "drawn_corners", "map_frames", "padded_map"]


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

    If possible, a frame stays within a block of the coarse map, so that the chip rebuilds as few
    blocks as possible.

    Parameters
    ----------
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


def changed_parts(
    config: Config, before: NDArray[np.int32], after: NDArray[np.integer]
) -> Iterator[tuple[slice, slice]]:
    """Yield rows and columns of rectangles, one per frame of the map, that cover all changes.

    Each rectangle is as small as its changes allow.

    Parameters
    ----------
    before, after : ndarray
        ``(map_size, map_size)`` integers, [y, x].
    """
    # Loads numba, which compiles the kernel.
    from pathgene.host.problem.compiled.changes import find_changes

    width, height = _tile(config)
    boxes = np.zeros((-(-config.map_size // height), -(-config.map_size // width), 4), np.int32)
    boxes[..., ::2] = config.map_size
    if after.dtype != np.uint16:
        # A step outside 32 bits differs all the same, and is refused with its frame.
        limits = np.iinfo(np.int32)
        after = np.clip(after, limits.min, limits.max).astype(np.int32)
    find_changes(before, np.ascontiguousarray(after), (height, width), boxes)
    changed = boxes.reshape(-1, 4)[boxes[..., 1].ravel() > 0]
    for south, north, west, east in changed.tolist():
        yield slice(south, north), slice(west, east)


def _tile(config: Config) -> tuple[int, int]:
    """Return the width and height of the largest part of a coarse block that fits into a frame."""
    room = config.receive_buffer // _FRAMES_IN_FLIGHT - BODY_HEADER_BYTES - CRC_BYTES
    cells = (room - map_request(config).size) * 8 // config.altitude_bits
    cells = 1 << min(cells, _FRAME_CELLS).bit_length() - 1
    width = min(config.coarse_factor, cells)
    return width, cells // width


def _packed(config: Config, cells: NDArray[np.integer]) -> bytes:
    """Pack cells as :func:`pathgene.hdl.protocol.paths.pack_cells` does, all at once."""
    bits = cells.reshape(-1, 1).astype(np.uint32) >> np.arange(config.altitude_bits) & 1
    return np.packbits(bits.astype(np.uint8), bitorder="little").tobytes()


#: Marks a cell whose height on the chip is unknown.
_UNKNOWN = -1
#: Number of map frames between two reports of progress.
_FRAMES_PER_REPORT = 64
#: Payload of a frame, with the rows and columns that it writes.
Frame = tuple[bytes, tuple[slice, slice]]


def drawn_corners(shape: NoFlyShape) -> NDArray[np.bool_]:
    """Return which corners of the box of a shape lie in it, (rows, columns) bool."""
    # Loads numba, which compiles the kernel.
    from pathgene.host.problem.compiled.corners import draw

    drawn = np.empty(
        (shape.last_y - shape.first_y + 1, shape.last_x - shape.first_x + 1), dtype=bool
    )
    edges = np.array(shape.edges, dtype=np.int64).reshape(-1, 3)
    draw(edges, (shape.bend_x, shape.bend_y), drawn)
    return drawn


class MapCopy:
    """The known cells of a chip's map."""

    def __init__(self, config: Config, orders: Orders) -> None:
        self._config, self._orders = config, orders
        self._heights = np.full((config.map_size,) * 2, _UNKNOWN, dtype=np.int32)

    def upload(
        self,
        heights: NDArray[np.integer],
        x: int = 0,
        y: int = 0,
        *,
        progress: Callable[[int, int], object] | None = None,
    ) -> None:
        """Write a rectangle: see :meth:`pathgene.host.device.chip.Chip.upload_map`."""
        heights = np.asarray(heights)
        self._send(list(map_frames(self._config, heights, x, y)), heights, x, y, progress)

    def block(self, shape: NoFlyShape) -> None:
        """Have the chip draw a shape: see :meth:`pathgene.host.device.runs.Runs.block`."""
        cells = slice(shape.first_y, shape.last_y + 1), slice(shape.first_x, shape.last_x + 1)
        blocked = np.where(
            drawn_corners(shape), self._config.blocked_altitude, self._heights[cells]
        )
        self._give([(Command.BLOCK, shape.pack(self._config))], [(cells, blocked)])

    def _send(
        self,
        frames: Sequence[Frame],
        heights: NDArray[np.integer],
        x: int,
        y: int,
        progress: Callable[[int, int], object] | None,
    ) -> None:
        """Send frames of ``heights``, whose first cell is at ``x``, ``y``."""
        written = [(at, heights[_moved(at[0], -y), _moved(at[1], -x)]) for _, at in frames]
        total = sum(values.size for _, values in written)
        done = 0
        for first in range(0, len(frames), _FRAMES_PER_REPORT):
            part = slice(first, first + _FRAMES_PER_REPORT)
            self._give([(Command.MAP, payload) for payload, _ in frames[part]], written[part])
            done += sum(values.size for _, values in written[part])
            if progress:
                progress(done, total)

    def _give(
        self,
        commands: list[tuple[int, bytes]],
        written: Sequence[tuple[tuple[slice, slice], NDArray[np.integer]]],
    ) -> None:
        """Send writes to parts of the map. If they are lost, those parts become unknown."""

        def forget() -> None:
            for cells, _ in written:
                self._heights[cells] = _UNKNOWN

        def note() -> None:
            for cells, values in written:
                self._heights[cells] = values

        forget()
        self._orders.give(commands, lost=forget, then=note)

    def update(
        self, heights: NDArray[np.integer], *, progress: Callable[[int, int], object] | None = None
    ) -> None:
        """Write the changed heights: see :meth:`pathgene.host.device.chip.Chip.update_map`."""
        heights = np.asarray(heights)
        if heights.shape != self._heights.shape:
            raise ValueError(
                f"Heights must be a whole map of {self._heights.shape}, not of {heights.shape}"
            )
        frames = [
            frame
            for rows, columns in changed_parts(self._config, self._heights, heights)
            for frame in map_frames(self._config, heights[rows, columns], columns.start, rows.start)
        ]
        self._send(frames, heights, 0, 0, progress)


def _moved(places: slice, by: int) -> slice:
    return slice(places.start + by, places.stop + by)
