"""The host's copy of a chip's map, and the upload that brings the chip in line with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.hdl.protocol import Command
from pathgene.hdl.protocol.planner import NoFlyShape
from pathgene.host.device.map_frames import changed_parts, map_frames
from pathgene.host.device.orders import Orders


__all__ = ["MapCopy", "drawn_corners"]

#: Marks a cell whose height on the chip is unknown.
_UNKNOWN = -1
#: Number of map frames between two reports of progress.
_FRAMES_PER_REPORT = 64
#: Payload of a frame, with the rows and columns that it writes.
Frame = tuple[bytes, tuple[slice, slice]]


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
        Sends the chip commands.
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
        self,
        heights: NDArray[np.integer],
        *,
        progress: Callable[[int, int], object] | None = None,
    ) -> None:
        """Write the changed heights: see :meth:`pathgene.host.device.chip.Chip.update_map`."""
        heights = np.asarray(heights)
        if heights.shape != self._heights.shape:
            raise ValueError(
                f"Heights must be a whole map of {self._heights.shape}, not of {heights.shape}"
            )
        frames = [
            frame
            for rows, columns in changed_parts(self._config, self._heights != heights)
            for frame in map_frames(self._config, heights[rows, columns], columns.start, rows.start)
        ]
        self._send(frames, heights, 0, 0, progress)


def _moved(places: slice, by: int) -> slice:
    return slice(places.start + by, places.stop + by)
