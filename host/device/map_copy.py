"""The host's copy of a chip's map, and the upload that brings the chip in line with it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from hdl.config import Config
from hdl.protocol import Command
from hdl.protocol.planner import NoFlyShape
from host.device.map_frames import map_frames
from host.device.orders import Orders


__all__ = ["MapCopy", "drawn_corners"]

#: Height of a cell whose value on the chip is unknown.
_UNKNOWN = -1
#: Frames of the map between two reports of progress.
_FRAMES_PER_REPORT = 64
#: Changes with as many or more unchanged rows or columns between them are sent as rectangles of
#: their own.
_APART = 16

#: Rows and columns of a rectangle, and what is written there.
Written = tuple[tuple[slice, slice], NDArray[np.integer]]


def drawn_corners(shape: NoFlyShape) -> NDArray[np.bool_]:
    """Return which corners of the box of a shape lie in it, (rows, columns) bool."""
    u = np.arange(shape.last_x - shape.first_x + 1)
    v = np.arange(shape.last_y - shape.first_y + 1)[:, None]
    drawn = np.ones((len(v), len(u)), dtype=bool)
    for number, (at, east, north) in enumerate(shape.edges):
        value = at + east * u + north * v
        if number == 0:
            value = value - shape.bend_x * u**2 - shape.bend_y * v**2
        drawn &= value >= 0
    return drawn


class MapCopy:
    """The cells of a chip's map, as far as they are known.

    Parameters
    ----------
    config : Config
        The chip's.
    orders : Orders
        Commands to the chip.
    """

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
        """Write a rectangle: see :meth:`host.device.chip.Chip.upload_map`."""
        heights = np.asarray(heights)
        frames = list(map_frames(self._config, heights, x, y))
        done = 0
        for first in range(0, len(frames), _FRAMES_PER_REPORT):
            part = frames[first : first + _FRAMES_PER_REPORT]
            written = [
                (cells, heights[_moved(cells[0], -y), _moved(cells[1], -x)]) for _, cells in part
            ]
            self._give([(Command.MAP, payload) for payload, _ in part], written)
            done += sum(values.size for _, values in written)
            if progress:
                progress(done, heights.size)

    def block(self, shape: NoFlyShape) -> None:
        """Have the chip draw a shape: see :meth:`host.device.runs.Runs.block`."""
        cells = slice(shape.first_y, shape.last_y + 1), slice(shape.first_x, shape.last_x + 1)
        blocked = np.where(
            drawn_corners(shape), self._config.blocked_altitude, self._heights[cells]
        )
        self._give([(Command.BLOCK, shape.pack(self._config))], [(cells, blocked)])

    def _give(self, commands: list[tuple[int, bytes]], written: list[Written]) -> None:
        """Send writes to parts of the map. If they are lost, those parts are unknown."""

        def forget() -> None:
            for cells, _ in written:
                self._heights[cells] = _UNKNOWN

        def note() -> None:
            for cells, values in written:
                self._heights[cells] = values

        forget()
        self._orders.give(commands, lost=forget, then=note)

    def update(
        self,
        heights: NDArray[np.integer],
        *,
        progress: Callable[[int, int], object] | None = None,
    ) -> None:
        """Write the rectangles with all changes: see :meth:`host.device.chip.Chip.update_map`."""
        heights = np.asarray(heights)
        if heights.shape != self._heights.shape:
            raise ValueError(
                f"Heights must be a whole map of {self._heights.shape}, not of {heights.shape}"
            )
        parts = list(_rectangles(self._heights != heights))
        total = sum(heights[part].size for part in parts)
        done = 0
        for part in parts:
            south, west = part[0].start, part[1].start
            report = None if progress is None else _shifted(progress, done, total)
            self.upload(heights[part], west, south, progress=report)
            done += heights[part].size


def _rectangles(changed: NDArray[np.bool_]) -> Iterator[tuple[slice, slice]]:
    """Yield rows and columns of rectangles that hold all changed cells."""
    for rows in _bands(np.flatnonzero(changed.any(axis=1))):
        for columns in _bands(np.flatnonzero(changed[rows].any(axis=0))):
            inside = np.flatnonzero(changed[rows, columns].any(axis=1)) + rows.start
            yield slice(int(inside[0]), int(inside[-1]) + 1), columns


def _bands(places: NDArray[np.intp]) -> list[slice]:
    """Return what holds all rows or columns at ``places``, and few of the others."""
    bands = np.split(places, np.flatnonzero(np.diff(places) > _APART) + 1)
    return [slice(int(band[0]), int(band[-1]) + 1) for band in bands if len(band)]


def _shifted(
    progress: Callable[[int, int], object], before: int, total: int
) -> Callable[[int, int], object]:
    """Return a progress of a part that reports the cells of the whole."""
    return lambda done, _: progress(before + done, total)


def _moved(places: slice, by: int) -> slice:
    return slice(places.start + by, places.stop + by)
