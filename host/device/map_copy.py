"""The host's copy of a chip's map, and the upload that brings the chip in line with it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hdl.config import Config
from hdl.protocol import Command
from host.device.link import Link
from host.device.map_frames import map_frames


__all__ = ["MapCopy"]

#: Height of a cell whose value on the chip is unknown.
_UNKNOWN = -1
#: Frames of the map between two reports of progress.
_FRAMES_PER_REPORT = 64


class MapCopy:
    """The cells of a chip's map that the chip has acknowledged.

    Parameters
    ----------
    config : Config
        The chip's.
    link : Link
        Link to the chip.
    """

    def __init__(self, config: Config, link: Link) -> None:
        self._config, self._link = config, link
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
        rows, columns = heights.shape
        written = self._heights.copy()
        written[y : y + rows, x : x + columns] = heights
        # A transfer that fails leaves all cells unknown that the chip has not acknowledged.
        self._heights[y : y + rows, x : x + columns] = _UNKNOWN
        done = 0
        for first in range(0, len(frames), _FRAMES_PER_REPORT):
            part = frames[first : first + _FRAMES_PER_REPORT]
            self._link.transfer([(Command.MAP, payload) for payload, _ in part])
            for _, cells in part:
                self._heights[cells] = written[cells]
                done += self._heights[cells].size
            if progress:
                progress(done, heights.size)

    def forget(self, x: int, y: int, columns: int, rows: int) -> None:
        """Take a rectangle as unknown: a later :meth:`update` sends it again."""
        self._heights[y : y + rows, x : x + columns] = _UNKNOWN

    def update(
        self,
        heights: NDArray[np.integer],
        *,
        progress: Callable[[int, int], object] | None = None,
    ) -> None:
        """Write the rectangle with all changes: see :meth:`host.device.chip.Chip.update_map`."""
        heights = np.asarray(heights)
        if heights.shape != self._heights.shape:
            raise ValueError(
                f"Heights must be a whole map of {self._heights.shape}, not of {heights.shape}"
            )
        rows, columns = np.nonzero(self._heights != heights)
        if len(rows):
            south, west = int(rows.min()), int(columns.min())
            changed = heights[south : rows.max() + 1, west : columns.max() + 1]
            self.upload(changed, west, south, progress=progress)
