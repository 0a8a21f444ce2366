"""The airspace: the free volume in which a planner may put waypoints, in metres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.problem.problem import Problem


__all__ = ["HEADROOM_M", "NO_FLYABLE_CELL", "Airspace"]

#: Height of the box over the highest ground, metres.
HEADROOM_M = 100.0

#: The sentence on a map that no path can cross.
NO_FLYABLE_CELL = "No flyable cell: reduce the no-fly zones or fill the voids (--fill-voids)."


class Airspace:
    """The box over the map, minus the ground, voids and no-fly zones.

    The box extends from the lowest ground to :data:`HEADROOM_M` above the highest, or to the start
    or the goal if that is higher, but not above the ceiling. Under the rules of safe flight, the
    ground is the raised surface of the search.

    Attributes
    ----------
    low, high : ndarray
        Corners of the box, (3,) float64 metres.
    floor : ndarray
        Lowest free altitude at each node, of the terrain's shape; infinite over voids and zones.
    roof : ndarray or None
        Highest free altitude at each node, if it is below the top of the box anywhere.

    Raises
    ------
    InputError
        If no cell of the map is free.
    """

    def __init__(self, problem: Problem) -> None:
        self.terrain = problem.terrain
        self.start, self.goal = problem.start, problem.goal
        elevation = problem.surface.elevation
        self.floor = np.where(problem.blocked_raster, np.inf, elevation)
        self.roof = problem.roof
        self._free = np.flatnonzero(np.isfinite(self.floor))
        if not len(self._free):
            raise InputError(NO_FLYABLE_CELL)
        rows, columns = elevation.shape
        top = min(float(np.nanmax(elevation)) + HEADROOM_M, problem.limits.ceiling_m)
        top = max(top, self.start[2], self.goal[2])
        self.low = np.array(
            [0.0, 0.0, min(float(np.nanmin(elevation)), self.start[2], self.goal[2])]
        )
        self.high = np.array(
            [(columns - 1) * self.terrain.dx_m, (rows - 1) * self.terrain.dy_m, top]
        )

    def is_free(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which ``points``, (n, 3) float64 metres, are in the box and free: (n,) bool."""
        inside = ((points >= self.low) & (points <= self.high)).all(axis=1)
        nodes = self.terrain.nearest_nodes(points[:, 0], points[:, 1])
        free: NDArray[np.bool_] = inside & (points[:, 2] >= self.floor[nodes])
        if self.roof is not None:
            free &= points[:, 2] <= self.roof[nodes]
        return free

    def draw(self, rng: np.random.Generator, count: int) -> NDArray[np.float64]:
        """Return ``count`` points (count, 3), uniform over the free nodes, then over the height."""
        nodes = self._free[rng.integers(len(self._free), size=count)]
        row, column = np.divmod(nodes, self.floor.shape[1])
        floor, top = self.floor[row, column], self.high[2]
        if self.roof is not None:
            top = np.minimum(top, self.roof[row, column])
        z = floor + (top - floor) * rng.random(count)
        return np.stack((column * self.terrain.dx_m, row * self.terrain.dy_m, z), axis=1)

    def draw_near(
        self, rng: np.random.Generator, point: NDArray[np.float64], share: float, draws: int
    ) -> NDArray[np.float64] | None:
        """Draw a free point in a box around ``point``, whose edges are ``share`` of the airspace's.

        Returns
        -------
        ndarray or None
            The first free point in ``draws`` draws, (3,); None if there is none.
        """
        half = share / 2 * (self.high - self.low)
        low, high = np.maximum(point - half, self.low), np.minimum(point + half, self.high)
        points = rng.uniform(low, high, size=(draws, 3))
        free = np.flatnonzero(self.is_free(points))
        return points[free[0]] if len(free) else None
