"""The polish of paths: more waypoints on their straight pieces, and the lowest altitudes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pathgene.host.planners.grid.altitudes import lowest_altitudes
from pathgene.host.planners.grid.astar import DEFAULT_MAX_WAYPOINTS
from pathgene.host.planners.grid.grid_search import Prices
from pathgene.host.planners.grid.polylines import lengthened
from pathgene.host.problem.problem import Problem


__all__ = ["POLISHED_WAYPOINTS", "polished"]

Path = NDArray[np.float64]

#: Waypoints between the ends of a polished path, if its straight pieces have room for them.
POLISHED_WAYPOINTS = DEFAULT_MAX_WAYPOINTS


def polished(problem: Problem, paths: Iterable[Path]) -> list[Path]:
    """Return paths on the same tracks with the lowest altitudes.

    More waypoints on the straight pieces let the altitudes follow the ground. A path whose turns do
    not fit, or for which no altitudes exist, is left out.

    Parameters
    ----------
    paths : iterable of ndarray
        (n, 3) float64 metres each, start and goal included.
    """
    prices = Prices(problem)
    tracks = [
        lengthened(path[:, :2], POLISHED_WAYPOINTS, problem.limits.turn_radius_m) for path in paths
    ]
    lowest = [lowest_altitudes(problem, prices, track) for track in tracks]
    return [path for path in lowest if path is not None]
