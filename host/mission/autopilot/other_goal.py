"""Another goal for a mission whose end has no room: the nearest one with room for a circle."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pathgene.host.mission.autopilot.loiter import places_near
from pathgene.host.mission.autopilot.room import (
    circle_radius_m,
    climb_slope,
    disc_height_m,
    disc_places,
    disc_radius_m,
    height_over,
    is_clear,
)
from pathgene.host.problem.problem import Problem


__all__ = ["OtherGoal", "other_goal"]

# Maximum distance of the new goal along either axis, in radii of the disc.
_FAR = 30.0
# Distance that counts as much as a metre of height.
_PER_METRE = 20.0
# Share of the climb on the way to a circle that the straight way to the goal may need.
_SHARE_OF_CLIMB = 0.75
# Each how many points of a disc are compared with the surface at first.
_EVERY = 50
# No goal is higher.
_HIGHEST_M = 20_000.0


@dataclass(frozen=True)
class OtherGoal:
    """A goal with room for the circle at the end.

    Parameters
    ----------
    place : (float, float, float)
        x, y and altitude, whole metres unless only the altitude is another one.
    raise_m : int
        Height by which the start must be higher, too, for a straight climb to that goal; 0 or more.
    """

    place: tuple[float, float, float]
    raise_m: int


def other_goal(problem: Problem) -> OtherGoal | None:
    """Return the nearest goal with room for a circle, None if there is none near.

    A metre of height, of the goal or of the start, counts as 20 metres of distance.
    """
    x, y, z = problem.goal
    disc_m = disc_radius_m(circle_radius_m(problem), z)
    near = places_near(problem, _FAR * disc_m, disc_m)
    places = [(x, y), *((float(round(east)), float(round(north))) for east, north in near)]
    best, least_m = None, math.inf
    for at in sorted(places, key=lambda at: math.dist(at, (x, y))):
        if least_m < math.dist(at, (x, y)):
            break
        # A few points of the disc are enough to rule most places out.
        x_m, y_m = disc_places(problem, *at, disc_m)
        some = x_m[::_EVERY], y_m[::_EVERY]
        lowest_m = max(z, height_over(problem, some))
        if _effort_m(problem, at, lowest_m) >= least_m or not is_clear(problem, some, lowest_m):
            continue
        height_m = float(math.ceil(min(disc_height_m(problem, *at, z), _HIGHEST_M)))
        effort_m = _effort_m(problem, at, height_m)
        # Whole metres are a little higher, where the disc is a little wider.
        if (
            effort_m < least_m
            and disc_height_m(problem, *at, height_m) == height_m
            and _is_allowed(problem, at, height_m)
        ):
            best, least_m = OtherGoal((*at, height_m), _raise_m(problem, at, height_m)), effort_m
    return best


def _is_allowed(problem: Problem, at: tuple[float, float], height_m: float) -> bool:
    """Return whether a goal and its start keep the ceilings."""
    x, y, z = problem.start
    start_m = z + _raise_m(problem, at, height_m)
    agl_m = None if problem.rules is None else problem.rules.ceiling_agl_m
    most_m = math.inf if agl_m is None else agl_m
    return start_m <= problem.limits.ceiling_m and all(
        top_m - problem.terrain.ground(*place) <= most_m
        for place, top_m in ((at, height_m), ((x, y), start_m))
    )


def _raise_m(problem: Problem, at: tuple[float, float], height_m: float) -> int:
    """Return by how much the start is too low for a straight climb to a goal."""
    slope = _SHARE_OF_CLIMB * climb_slope(problem)
    reach_m = problem.start[2] + slope * math.dist(problem.start[:2], at)
    return max(0, math.ceil(min(height_m, _HIGHEST_M) - reach_m))


def _effort_m(problem: Problem, at: tuple[float, float], height_m: float) -> float:
    """Return the distance and the heights of another goal and its start as one length."""
    higher_m = height_m - problem.goal[2] + _raise_m(problem, at, height_m)
    return math.dist(at, problem.goal[:2]) + _PER_METRE * higher_m
