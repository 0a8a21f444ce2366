"""The terrain on the lattice of corners of a planner on the chip."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from host.problem.chip_map import ChipMap


__all__ = ["CornerMap"]


class CornerMap(ChipMap):
    """A :class:`ChipMap` whose waypoints lie on the corners between cells.

    Corner (i, j) is the corner between the cells i and i + 1 in x, and j and j + 1 in y. A segment
    between corners, rounded to a corner in every step of its longer side, stays in the four cells
    around these corners, so that the highest of the four is all that the chip needs to know.
    """

    @functools.cached_property
    def corners(self) -> NDArray[np.uint16]:
        """Highest of the four cells around each corner, ``(map_size, map_size)`` uint16, [y, x].

        The last row and column, which have no cell beyond them, are blocked.
        """
        cells = self.heights
        rows = np.maximum(cells[:-1], cells[1:])
        corners = np.full_like(cells, self._config.blocked_altitude)
        corners[:-1, :-1] = np.maximum(rows[:, :-1], rows[:, 1:])
        return corners

    @property
    def corner_limits(self) -> tuple[int, int, int]:
        """Highest x and y corner between cells of the terrain, and highest step of a waypoint."""
        x, y, altitude = self.limits
        return max(x - 1, 0), max(y - 1, 0), altitude

    def corners_to_metres(self, corners: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return the (n, 3) metres of (n, 3) integers x, y, altitude step."""
        half = 0.5 * np.array((*self.scale_m, 0.0))
        metres: NDArray[np.float64] = self.to_metres(corners) + half
        return metres
