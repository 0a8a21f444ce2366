"""The end of a mission: a circle with room over a disc, at the goal or a climb away from it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from pathgene.host.mission.autopilot.room import (
    circle_radius_m,
    climb_slope,
    disc_places,
    disc_radius_m,
    drift_of,
    height_over,
    is_clear,
    is_under_ceiling,
    keeps_clearance,
)
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.way import STEP_M, Way, flown, ways_to
from pathgene.host.problem.problem import Problem


__all__ = ["Loiter", "loiter", "places_near"]

Floats = NDArray[np.float64]

# Turns after the goal, degrees, and the straight way after them, in radii of the disc.
_TURNS_DEG = (0, *(sign * turn for turn in range(30, 181, 30) for sign in (1, -1)))
_STRAIGHT = tuple(np.arange(0.5, 12.1, 0.5).tolist())
# Heights at which a way may end, as shares from the lowest to the highest.
_SHARES_OF_REACH = (0.0, 0.5, 1.0)
# Distance of other places for the circle, in radii of the disc.
_FAR = 12.0
# Number of places along either axis.
_ACROSS = 24
# A few points at the greatest height exclude most ways.
_FEW_M = 20 * STEP_M


@dataclass(frozen=True)
class Loiter:
    """A circle to wait on.

    Parameters
    ----------
    x_m, y_m, z_m : float
        Centre, and the altitude.
    radius_m : int
        Radius that the autopilot is asked for: the one that the aircraft can fly in a tail wind, in
        whole metres as in ArduPilot.
    disc_m : float
        Radius of the disc that is clear.
    way : tuple of RoutePoint
        Waypoints from the goal to the disc: corners of a turn, and the place before the disc, by
        the aircraft's lag, where its altitude is asked for. Empty if the goal is the centre.
    has_room : bool
        Whether the disc keeps the clearance, and no zone is in it.
    """

    x_m: float
    y_m: float
    z_m: float
    radius_m: int
    disc_m: float
    way: tuple[RoutePoint, ...]
    has_room: bool


def loiter(problem: Problem, heading: tuple[float, float], apart_m: float) -> Loiter:
    """Return the circle at the end of a mission.

    It is the circle around the goal if that has room. Otherwise it is the one at the end of the
    shortest way, a turn and a straight climb; ways to places on a grid follow those that turn by
    multiples of 30 degrees. If none has room, it is the circle around the goal.

    Parameters
    ----------
    heading : (float, float)
        Unit vector of the track at the goal.
    apart_m : float
        Minimum distance of two waypoints.
    """
    x, y, z = problem.goal
    radius_m = circle_radius_m(problem)
    disc_m = disc_radius_m(radius_m, z)
    if is_clear(problem, disc_places(problem, x, y, disc_m), z):
        return Loiter(x, y, z, radius_m, disc_m, (), True)
    speed_m_s = problem.aircraft.cruise_speed_m_s * drift_of(problem)
    lead_m = problem.aircraft.height_lag_s * speed_m_s
    straight_on = (
        Way(
            problem.goal, heading, radius_m, math.radians(turn), lead_m + straight * disc_m, apart_m
        )
        for straight in _STRAIGHT
        for turn in _TURNS_DEG
    )
    aside = (
        way
        for place in places_near(problem, _FAR * disc_m, disc_m)
        for way in ways_to(
            problem.goal, heading, place, radius_m=radius_m, short_m=disc_m, apart_m=apart_m
        )
        if way.straight_m >= lead_m + apart_m
    )
    for way in chain(
        *(sorted(ways, key=lambda way: way.length_m) for ways in (straight_on, aside))
    ):
        found = _at_end(problem, way, lead_m)
        if found is not None:
            return found
    return Loiter(x, y, z, radius_m, disc_m, (), False)


def places_near(problem: Problem, far_m: float, disc_m: float) -> Iterator[tuple[float, float]]:
    """Yield places of a grid around the goal whose discs are on the map.

    Parameters
    ----------
    far_m : float
        Maximum distance from the goal along either axis.
    disc_m : float
        Radius of the disc.
    """
    x, y, _ = problem.goal
    axes = []
    for at, size_m in ((x, problem.terrain.width_m), (y, problem.terrain.height_m)):
        low, high = max(at - far_m, disc_m), min(at + far_m, size_m - disc_m)
        axes.append(np.linspace(low, high, _ACROSS if low <= high else 0).tolist())
    return ((east, north) for east in axes[0] for north in axes[1])


def _at_end(problem: Problem, way: Way, lead_m: float) -> Loiter | None:
    """Return the circle at the end of a way, None if it has no room there."""
    radius_m, z = way.radius_m, problem.goal[2]
    reach_m = z + climb_slope(problem) * (way.length_m - lead_m)
    disc_m = disc_radius_m(radius_m, reach_m)
    centre = way.beyond(disc_m)
    around = disc_places(problem, *centre, disc_m)
    lowest_m, highest_m = (
        max(height_over(problem, around), z),
        min(reach_m, problem.limits.ceiling_m),
    )
    if lowest_m > highest_m:
        return None
    few, heights_m = flown(problem, way, lead_m, highest_m, _FEW_M)
    if not keeps_clearance(problem, few, heights_m):
        return None
    for share in _SHARES_OF_REACH:
        end_m = lowest_m + share * (highest_m - lowest_m)
        on_way = flown(problem, way, lead_m, end_m)
        if (
            is_clear(problem, around, end_m)
            and is_under_ceiling(problem, around, end_m)
            and is_clear(problem, *on_way)
            and is_under_ceiling(problem, *on_way)
        ):
            points = tuple(way.points(lead_m, end_m, is_gusty=any(problem.wind)))
            return Loiter(
                *centre, end_m, round(radius_m), disc_radius_m(radius_m, end_m), points, True
            )
    return None
