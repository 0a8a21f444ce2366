"""The guide of a run: a path that the host knows, on the corners of the chip's map."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.host.planners.chip.problem_record import committed_points
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.problem import Problem


__all__ = ["guide_of"]

Floats = NDArray[np.float64]

# A metre of altitude counts as much as this many metres of distance in the choice of waypoints.
_ALTITUDE_WEIGHT = 0.2


def guide_of(
    config: Config, problem: Problem, grid: CornerMap, path: Floats
) -> list[tuple[int, int, int]]:
    """Return corners and steps of a path's waypoints, as many as the chip's paths may have.

    From a longer path, waypoints without which it changes least are left out, one after another.
    Waypoints before a committed point of an end
    (:func:`pathgene.host.planners.chip.problem_record.committed_points`) are left out, too. The
    steps are above the path. Empty for a path with fewer waypoints than the chip's shortest.

    Parameters
    ----------
    path : (n, 3) float64, metres
        Start and goal included.
    """
    inner = path[1:-1]
    for end, committed in zip(path[[0, -1]], committed_points(problem), strict=True):
        if committed is not None:
            away_m = np.hypot(*(inner[:, :2] - end[:2]).T)
            inner = inner[away_m > math.dist(end[:2], committed[:2])]
    kept = list(np.vstack((path[:1], inner, path[-1:])))
    while len(kept) - 2 > config.max_waypoints:
        misses = [_miss(*kept[i - 1 : i + 2]) for i in range(1, len(kept) - 1)]
        kept.pop(1 + int(np.argmin(misses)))
    if len(kept) - 2 < config.MIN_WAYPOINTS:
        return []
    *_, most = grid.corner_limits
    corners = [grid.nearest_corner((float(x), float(y), float(z))) for x, y, z in kept[1:-1]]
    return [(x, y, min(altitude + 1, most)) for x, y, altitude in corners]


def _miss(before: Floats, point: Floats, after: Floats) -> float:
    """Return how far a straight line from ``before`` to ``after`` misses a point."""
    way, offset = after - before, point - before
    length = float(np.hypot(*way[:2]))
    if length == 0:
        return math.inf
    along = float(np.clip(offset[:2] @ way[:2] / length**2, 0, 1))
    missing = offset - along * way
    return float(np.hypot(*missing[:2])) + _ALTITUDE_WEIGHT * abs(float(missing[2]))
