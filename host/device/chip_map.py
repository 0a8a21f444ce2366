"""The map of a chip: its frames on the link, its padding, and the host's copy."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, CRC_BYTES
from pathgene.hdl.protocol.codes import Command
from pathgene.hdl.protocol.messages import (
    CODED_COLUMNS,
    ESCAPE_ONES,
    coded_map_request,
    map_request,
)
from pathgene.hdl.protocol.planner import NoFlyShape
from pathgene.host.device.orders import Orders
from pathgene.host.stages import stage


__all__ = [
    "MapCopy",
    "changed_parts",
    "coded_frames",
    "drawn_corners",
    "map_frames",
    "padded_map",
]


#: Minimum cells that are sent as coded cells to a chip with the planner core.
_CODED_CELLS = 2_000
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


def coded_frames(
    config: Config, heights: NDArray[np.integer], x: int, y: int
) -> Iterator[tuple[bytes, tuple[slice, slice]]]:
    """Yield the payload of each CODED_MAP frame of a rectangle, with the cells it writes.

    Parameters
    ----------
    heights, x, y
        As for :func:`map_frames`; the rectangle lies on the map.
    """
    # Loads numba, which compiles the kernels.
    from pathgene.host.problem.compiled.coding import code, count_bits, rows_that_fit

    layout, altitude_bits = coded_map_request(config), config.altitude_bits
    room = 8 * (_room(config) - layout.size)
    # A row fits, even if all of its cells are escapes.
    across = min(CODED_COLUMNS, room // (ESCAPE_ONES + altitude_bits))
    rows, columns = heights.shape
    for west in range(0, columns, across):
        cells = np.ascontiguousarray(heights[:, west : west + across], dtype=np.int32)
        least = min(range(altitude_bits), key=lambda k: count_bits(cells, altitude_bits, k))
        south = 0
        while south < rows:
            count, _ = rows_that_fit(cells[south:], altitude_bits, least, room)
            coded = np.zeros(room // 8 + 1, dtype=np.uint8)
            size = code(cells[south : south + count], altitude_bits, least, coded)
            header = layout.pack(
                x=x + west,
                y=y + south,
                width=cells.shape[1],
                height=count,
                remainder_bits=least,
            )
            yield (
                header + coded[:size].tobytes(),
                (
                    slice(y + south, y + south + count),
                    slice(x + west, x + west + cells.shape[1]),
                ),
            )
            south += count


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
    cells = (_room(config) - map_request(config).size) * 8 // config.altitude_bits
    cells = 1 << min(cells, _FRAME_CELLS).bit_length() - 1
    width = min(config.coarse_factor, cells)
    return width, cells // width


def _room(config: Config) -> int:
    """Return the bytes of the payload of a frame."""
    return config.receive_buffer // _FRAMES_IN_FLIGHT - BODY_HEADER_BYTES - CRC_BYTES


def _packed(config: Config, cells: NDArray[np.integer]) -> bytes:
    """Pack cells as :func:`pathgene.hdl.protocol.paths.pack_cells` does, all at once."""
    bits = cells.reshape(-1, 1).astype(np.uint32) >> np.arange(config.altitude_bits) & 1
    return np.packbits(bits.astype(np.uint8), bitorder="little").tobytes()


#: Marks a cell whose height on the chip is unknown.
_UNKNOWN = -1
#: Number of map frames between two reports of progress.
_FRAMES_PER_REPORT = 64
#: Command and payload of a frame, with the rows and columns that it writes.
Frame = tuple[int, bytes, tuple[slice, slice]]


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
        self._send(list(self._frames(heights, x, y)), heights, x, y, progress)

    def _frames(self, heights: NDArray[np.integer], x: int, y: int) -> Iterator[Frame]:
        """Yield the frames of a rectangle."""
        is_coded = self._config.planner_core and heights.size >= _CODED_CELLS
        # It refuses wrong heights, even if coded frames follow.
        frames = map_frames(self._config, heights, x, y)
        first = next(frames)
        if is_coded:
            for payload, cells in coded_frames(self._config, heights, x, y):
                yield Command.CODED_MAP, payload, cells
            return
        for payload, cells in itertools.chain([first], frames):
            yield Command.MAP, payload, cells

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
        written = [(at, heights[_moved(at[0], -y), _moved(at[1], -x)]) for *_, at in frames]
        total = sum(values.size for _, values in written)
        done = 0
        for first in range(0, len(frames), _FRAMES_PER_REPORT):
            part = slice(first, first + _FRAMES_PER_REPORT)
            commands = [(command, payload) for command, payload, _ in frames[part]]
            self._give(commands, written[part])
            done += sum(values.size for _, values in written[part])
            stage("uploading the map", done / total)
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
        parts = list(changed_parts(self._config, self._heights, heights))
        boxes = np.array([(*_span(rows), *_span(columns)) for rows, columns in parts])
        if len(parts) > 1:
            south, north, west, east = (
                end(places) for end, places in zip((min, max) * 2, boxes.T.tolist(), strict=True)
            )
            areas = (boxes[:, 1] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 2])
            # Coded cells take less than half of the bytes.
            if self._config.planner_core and (north - south) * (east - west) < 2 * areas.sum():
                parts = [(slice(south, north), slice(west, east))]
        frames = [
            frame
            for rows, columns in parts
            for frame in self._frames(heights[rows, columns], columns.start, rows.start)
        ]
        self._send(frames, heights, 0, 0, progress)


def _span(places: slice) -> tuple[int, int]:
    return places.start, places.stop


def _moved(places: slice, by: int) -> slice:
    return slice(places.start + by, places.stop + by)
