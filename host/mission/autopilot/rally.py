"""Rally points: circles with room along a mission, to which an aircraft returns straight."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.mission.autopilot.returns import along, needed_m
from pathgene.host.mission.autopilot.room import disc_height_m
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.problem.problem import Problem


__all__ = ["rally_points"]

Floats = NDArray[np.float64]

# Rally points: their distance along the mission, their maximum number, and the minimum distance of
# two of them.
_APART_M, _MOST, _NEAREST_M = 2500.0, 8, 500.0
# Distance of the places from which returns are judged.
_STEP_M = 200.0
# Places beside the mission that are tried, in turn radii.
_BESIDE = (0.0, 2.0, -2.0, 4.0, -4.0)


def rally_points(problem: Problem, points: Sequence[RoutePoint]) -> tuple[RoutePoint, ...]:
    """Return circles with room, at most 8, spread over a mission.

    Each circle is on the mission, or beside it where the room begins lower. Its
    altitude suits the straight returns from all places of the mission to which it is the nearest;
    if the ceiling is too low for that, it suits the circle.
    """
    way = along(points, _STEP_M)
    flown = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(way[:, :2], axis=0).T))))
    count = int(np.clip(math.ceil(flown[-1] / _APART_M) + 1, 2, _MOST))
    discs: list[Floats] = []
    for number in np.searchsorted(flown, np.linspace(0.0, flown[-1], count)):
        disc = _disc(problem, way, int(number))
        if disc is None or any(math.dist(disc[:2], other[:2]) < _NEAREST_M for other in discs):
            continue
        discs.append(disc)
    if not discs:
        return ()
    places = np.array(discs)
    nearest = np.hypot(*(way[:, None, :2] - places[None, :, :2]).T).argmin(axis=0)
    made = []
    for number, (x, y, z) in enumerate(places.tolist()):
        needed = needed_m(problem, way[nearest == number], (x, y))
        highest_m = float(np.max(needed, initial=z, where=np.isfinite(needed)))
        made.append(RoutePoint(x, y, highest_m if highest_m <= problem.limits.ceiling_m else z, 0))
    return tuple(made)


def _disc(problem: Problem, way: Floats, number: int) -> Floats | None:
    """Return the lowest circle with room at a place of the mission or beside it."""
    x, y, z = way[number]
    before, after = way[max(number - 1, 0)], way[min(number + 1, len(way) - 1)]
    east, north = after[:2] - before[:2]
    length = math.hypot(east, north) or 1.0
    best = math.inf, (x, y)
    for beside in _BESIDE:
        side_m = beside * problem.aircraft.turn_radius_m / length
        at = x - side_m * north, y + side_m * east
        best = min(best, (disc_height_m(problem, *at, z), at))
        if best[0] == z:
            break
    height_m, at = best
    return np.array([*at, height_m]) if math.isfinite(height_m) else None
