"""The end of a mission: a circle with room over a disc, at the goal or a climb away from it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.fuel import air_density
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.problem.limits import SEA_LEVEL_DENSITY_KG_M3
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import wholes
from pathgene.host.terrain.surface import is_beyond, surface_below


__all__ = ["Loiter", "loiter"]

Floats = NDArray[np.float64]

# Radius of the disc that is kept clear, in exported radii; ArduPlane flies the radius times the
# squared ratio of true and equivalent airspeed, and 1.35 times that at the entry.
_DISC, _ENTRY = 2.0, 1.35
# Turns after the goal, degrees, and the straight way after them, in radii of the disc.
_TURNS_DEG = (0, *(sign * turn for turn in range(30, 181, 30) for sign in (1, -1)))
_STRAIGHT = tuple(np.arange(0.5, 12.1, 0.5).tolist())
# Share of the aircraft's steepest climb that the way to the circle uses.
_SHARE_OF_CLIMB = 0.7
# Distance beside the way, beyond the corridor, that is kept clear for the corners of its turn.
_CORNER_M = 6.0
# Acceptance radius of the last waypoint before the circle.
_ON_WAY_M = 10
# Points along a way are this far apart, where that is not too many.
_STEP_M = 10.0
# Maximum number of points across a disc or along a way that are compared with the surface.
_MOST_POINTS = 160


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
    shortest way, a turn and a straight climb. If none has room, it is the circle around the goal.

    Parameters
    ----------
    heading : (float, float)
        Unit vector of the track at the goal.
    apart_m : float
        Minimum distance of two waypoints.
    """
    x, y, z = problem.goal
    drift = 1 + math.hypot(*problem.wind) / problem.aircraft.cruise_speed_m_s
    radius_m = math.ceil(problem.aircraft.turn_radius_m * drift**2)
    disc_m = _disc_m(radius_m, z)
    if _is_clear(problem, _disc(problem, x, y, disc_m), z):
        return Loiter(x, y, z, radius_m, disc_m, (), True)
    lead_m = problem.aircraft.height_lag_s * problem.aircraft.cruise_speed_m_s * drift
    ways = (
        _Way(
            problem.goal,
            heading,
            radius_m,
            math.radians(turn),
            lead_m + straight * disc_m,
            apart_m,
        )
        for straight in _STRAIGHT
        for turn in _TURNS_DEG
    )
    for way in sorted(ways, key=lambda way: way.length_m):
        highest_m = z + _climb_slope(problem) * (way.length_m - lead_m)
        centre = way.beyond(_disc_m(radius_m, highest_m))
        around = _disc(problem, *centre, _disc_m(radius_m, highest_m))
        end_m = max(_height_over(problem, around), z)
        if (
            end_m <= min(highest_m, problem.limits.ceiling_m)
            and _is_clear(problem, around, end_m)
            and _is_clear(problem, *_flown(problem, way, lead_m, end_m))
        ):
            points = tuple(way.points(lead_m, end_m))
            return Loiter(*centre, end_m, radius_m, _disc_m(radius_m, end_m), points, True)
    return Loiter(x, y, z, radius_m, disc_m, (), False)


@dataclass(frozen=True)
class _Way:
    """An arc from the goal and a straight way after it.

    Parameters
    ----------
    goal, heading, radius_m, turn_rad : float
        The arc, which turns to the left if ``turn_rad`` is positive.
    straight_m : float
        Length of the straight way.
    apart_m : float
        Minimum distance of two waypoints.
    """

    goal: tuple[float, float, float]
    heading: tuple[float, float]
    radius_m: float
    turn_rad: float
    straight_m: float
    apart_m: float

    @property
    def arc_m(self) -> float:
        """Length of the arc."""
        return self.radius_m * abs(self.turn_rad)

    @property
    def length_m(self) -> float:
        """Length of the whole way."""
        return self.arc_m + self.straight_m

    def at(self, along_m: Floats, outwards: float = 1.0) -> tuple[Floats, Floats, Floats, Floats]:
        """Return places and headings after distances; ``outwards`` multiplies the arc's radius."""
        x, y, _ = self.goal
        east, north = self.heading
        side = math.copysign(self.radius_m, self.turn_rad)
        angle = np.minimum(along_m, self.arc_m) / side
        to_east = east * np.cos(angle) - north * np.sin(angle)
        to_north = north * np.cos(angle) + east * np.sin(angle)
        beyond = np.maximum(along_m - self.arc_m, 0.0)
        centre_x, centre_y = x - side * north, y + side * east
        return (
            centre_x + outwards * side * to_north + beyond * to_east,
            centre_y - outwards * side * to_east + beyond * to_north,
            to_east,
            to_north,
        )

    def beyond(self, distance_m: float) -> tuple[float, float]:
        """Return the place straight ahead of the end."""
        x, y, *_ = self.at(np.array([self.length_m + distance_m]))
        return float(x[0]), float(y[0])

    def points(self, lead_m: float, end_m: float) -> Iterator[RoutePoint]:
        """Yield the waypoints of the way, which asks for its last height ``lead_m`` early."""
        z = self.goal[2]
        asked_m = self.length_m - lead_m
        if self.turn_rad:
            narrowest = 2 * math.atan(self.apart_m / self.radius_m)
            count = max(1, int(abs(self.turn_rad) / narrowest))
            half = 0.5 * abs(self.turn_rad) / count
            along = self.arc_m * (np.arange(count) + 0.5) / count
            x, y, *_ = self.at(along, 1 / math.cos(half))
            for east, north, share in zip(x, y, along / asked_m, strict=True):
                acceptance = math.floor(self.radius_m * math.tan(half))
                yield RoutePoint(float(east), float(north), z + share * (end_m - z), acceptance)
        x, y, *_ = self.at(np.array([asked_m]))
        yield RoutePoint(float(x[0]), float(y[0]), end_m, _ON_WAY_M)


def _disc_m(radius_m: float, altitude_m: float) -> float:
    widened = SEA_LEVEL_DENSITY_KG_M3 / air_density(altitude_m)
    return radius_m * max(_DISC, _ENTRY * widened)


def _climb_slope(problem: Problem) -> float:
    """Return the tangent of the slope of the way to the circle, over the ground."""
    climb = max(problem.limits.climb_rad, 0.0)
    drift = 1 + math.hypot(*problem.wind) / problem.aircraft.cruise_speed_m_s
    return _SHARE_OF_CLIMB * math.tan(climb) / drift


def _disc(problem: Problem, x: float, y: float, radius_m: float) -> tuple[Floats, Floats]:
    """Return points of a disc, at most a cell apart where that is not too many."""
    cell_m = min(problem.terrain.dx_m, problem.terrain.dy_m)
    count = min(math.ceil(2 * radius_m / cell_m) + 1, _MOST_POINTS)
    steps = np.linspace(-radius_m, radius_m, max(count, 9))
    dx, dy = np.meshgrid(steps, steps)
    inside = np.hypot(dx, dy) <= radius_m
    return x + dx[inside], y + dy[inside]


def _flown(
    problem: Problem, way: _Way, lead_m: float, end_m: float
) -> tuple[tuple[Floats, Floats], Floats]:
    """Return points along and beside a way, and the heights of a late aircraft there."""
    z = problem.goal[2]
    corridor_m = _CORNER_M + (0.0 if problem.rules is None else problem.rules.corridor_m)
    count = min(math.ceil(way.length_m / _STEP_M) + 1, _MOST_POINTS)
    across = np.linspace(-corridor_m, corridor_m, 7)
    along, side = (
        grid.ravel() for grid in np.meshgrid(np.linspace(0, way.length_m, count), across)
    )
    x, y, east, north = way.at(along)
    climbed = np.maximum(along - lead_m, 0.0) / (way.length_m - lead_m)
    return (x - side * north, y + side * east), z + climbed * (end_m - z)


def _height_over(problem: Problem, places: tuple[Floats, Floats]) -> float:
    """Return the altitude that keeps the clearance over places, infinite off the map."""
    if is_beyond(problem.terrain, *places).any():
        return math.inf
    clearance = np.zeros(len(places[0]))
    if problem.rules is not None:
        clearance = np.maximum(problem.demand.required_m(*places), 0.0)
    return float(np.max(surface_below(problem.terrain, *places) + clearance))


def _is_clear(problem: Problem, places: tuple[Floats, Floats], altitude_m: Floats | float) -> bool:
    """Return whether places keep the clearance at altitudes, and no zone is at them."""
    x, y = places
    if is_beyond(problem.terrain, x, y).any():
        return False
    clearance = np.zeros(len(x))
    margin_m = 0.0
    if problem.rules is not None:
        clearance = np.maximum(problem.demand.required_m(x, y), 0.0)
        margin_m = problem.rules.zone_margin_m
    if not np.all(surface_below(problem.terrain, x, y) + clearance <= altitude_m):
        return False
    lowest, highest = float(np.min(altitude_m)), float(np.max(altitude_m))
    for zone in wholes(problem.zones):
        is_over = zone.upper_m is not None and zone.upper_m < lowest
        is_under = zone.lower_m is not None and zone.lower_m > highest
        if not (is_over or is_under) and (zone.footprint.distance_m(x, y) <= margin_m).any():
            return False
    return True
