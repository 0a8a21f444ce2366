"""The track of a planned path, from which every format is written, and the names of its points."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator, SmoothedTrack
from pathgene.host.formats.flight_plan import FlightPlan
from pathgene.host.formats.track import Track
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import wholes


__all__ = ["mark_names", "marked_waypoints", "track_of"]


# A waypoint may miss its via point by the rounding of a file.
_ROUNDING_M = 0.01


def mark_names(way: Sequence[Point]) -> tuple[str, ...]:
    """Return ``Start``, ``Via 1`` and so on, ``Goal`` and, after a return, ``Return``.

    Parameters
    ----------
    way : sequence of (float, float, float)
        All points of a mission in order, two or more. A mission with a return ends where it starts,
        and its goal is the second-last point.
    """
    last = ("Goal", "Return") if len(way) > 2 and way[0] == way[-1] else ("Goal",)
    between = range(1, len(way) - len(last))
    return ("Start", *(f"Via {number}" for number in between), *last)


def marked_waypoints(path: NDArray[np.float64], way: Sequence[Point]) -> dict[int, str]:
    """Return the names of a path's waypoints that are points of its mission, by index.

    A via point that the path misses has no waypoint and therefore no name.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and end included.
    way : sequence of (float, float, float)
        All points of the mission in order.
    """
    first, *between, last = mark_names(way)
    marks, after = {0: first}, 1
    for name, point in zip(between, way[1:-1], strict=True):
        for index in range(after, len(path) - 1):
            if math.dist(path[index], point) <= _ROUNDING_M:
                marks[index], after = name, index + 1
                break
    return {**marks, len(path) - 1: last}


def track_of(
    problem: Problem,
    path: NDArray[np.float64],
    curve: SmoothedTrack | None = None,
    *,
    flight: FlightPlan | None = None,
    page: Callable[[], str] | None = None,
) -> Track:
    """Return the track of a path of a problem.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    curve : SmoothedTrack, optional
        The smoothed path, if it is already computed.
    flight, page
        As for :class:`Track`.
    """
    return Track(
        path,
        Evaluator(problem).track(path) if curve is None else curve,
        problem.terrain,
        tuple(zip(mark_names(problem.way), problem.way, strict=True)),
        marked_waypoints(path, problem.way),
        tuple(zone.shape for zone in wholes(problem.zones)),
        flight,
        page,
    )
