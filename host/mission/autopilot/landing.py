"""The landing at the end of a mission: a circle, a straight approach and a go-around with room.

The way of the mission leads from the goal to a circle on the extended centreline, where the
aircraft loses its height. A level leg and the glide to the touch-down follow. On the glide and
on the go-around, the required clearance is half the height above the touch-down where the rules
require more.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.formats.flight_plan import Circling
from pathgene.host.mission.autopilot.room import (
    CORNER_M,
    circle_radius_m,
    climb_slope,
    disc_places,
    disc_radius_m,
    drift_of,
    height_over,
    is_clear,
    is_under_ceiling,
    required_m,
)
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.way import Way, flown, ways_to
from pathgene.host.problem.limits import slope_limits, slope_of_thrust
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain.surface import is_beyond, surface_below


__all__ = ["SHARE_OF_HEIGHT", "Landing", "NoApproachError", "landing"]

Floats = NDArray[np.float64]
Places = tuple[Floats, Floats]
# A climb, from its beginning to its top, and the circle there.
_Climb = tuple[tuple[tuple[float, float, float], ...], Circling]

#: Share of the height above the touch-down that is required as clearance near it.
SHARE_OF_HEIGHT = 0.5

# Slope of the glide, degrees; PX4 refuses more than 5 by default (FW_LND_ANG).
_GLIDE_DEG = 4.0
# Share of the slope at which the aircraft glides without thrust at its cruise speed. The rest is a
# reserve for updrafts, of 0.7 m/s for a small aircraft: an autopilot without it stays above its
# glide. ArduPlane's lower speed on the approach takes a third of it.
_SHARE_OF_IDLE = 0.6
# Heights of the glide's beginning above the touch-down.
_HEIGHTS_M = (40.0, 50.0, 60.0, 75.0, 95.0, 120.0, 150.0, 185.0, 230.0, 290.0, 360.0, 450.0)
# Level way between the circle's disc and the glide, in radii of the circle, beyond the lag.
_LEVEL = (0.0, 2.0, 4.0)
# Half-width of the strip around the glide per metre before the touch-down.
_WIDENING = 0.15
# ArduPlane aims at a point before and above the touch-down, where its flare begins: as high as it
# sinks in this time, but no higher than this (LAND_FLARE_SEC, and twice LAND_FLARE_ALT). From there
# it sinks at the mean of its sink rate and TECS_LAND_SINK (LAND_FLARE_AIM is a half).
_FLARE_S, _HIGHEST_FLARE_M, _TOUCHDOWN_M_S = 2.0, 6.0, 0.25
# Height above the touch-down that a missed approach does not sink below.
_MISSED_M = 10.0
# Heights at which the way from the goal may end, as shares from the lowest to the highest.
_SHARES_OF_REACH = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
# Straight climbs after a missed approach, in radii of the disc.
_CLIMBS = tuple(np.arange(0.5, 16.1, 0.5).tolist())
# Points along a strip are this far apart.
_STEP_M = 10.0
# Acceptance radius of the glide's beginning.
_ACCEPTANCE_M = 10


class NoApproachError(Exception):
    """No approach has room; the message is the reason, the end of a sentence."""


@dataclass(frozen=True)
class Landing:
    """A landing.

    Parameters
    ----------
    way : tuple of RoutePoint
        Waypoints from the goal to the disc of the circle.
    circle : Circling
        The circle on the extended centreline, at the height at which the glide begins.
    glide : RoutePoint
        Beginning of the glide.
    touch_down : (float, float, float)
        Place and altitude of the touch-down.
    go_around : tuple of (float, float, float)
        The climb after a missed approach, at the latest one: its beginning and its top.
    go_around_circle : Circling
        The circle at its top.
    """

    way: tuple[RoutePoint, ...]
    circle: Circling
    glide: RoutePoint
    touch_down: tuple[float, float, float]
    go_around: tuple[tuple[float, float, float], ...]
    go_around_circle: Circling


@dataclass(frozen=True)
class _Runway:
    """The centreline: ``along_m`` counts from the touch-down in the direction of flight.

    ``ground_m_s`` is the speed over ground at the cruise speed.
    """

    problem: Problem
    touch_down: tuple[float, float, float]
    course: tuple[float, float]
    slope: float
    ground_m_s: float

    def at(self, along_m: float) -> tuple[float, float]:
        """Return a place on the centreline."""
        (x, y, _), (east, north) = self.touch_down, self.course
        return x + along_m * east, y + along_m * north

    def beside(self, along_m: Floats, across_m: Floats) -> Places:
        """Return places beside the centreline."""
        (x, y, _), (east, north) = self.touch_down, self.course
        return x + along_m * east - across_m * north, y + along_m * north + across_m * east

    def strip(self, begin_m: float, end_m: float, widths: Floats) -> tuple[Floats, Floats]:
        """Return distances along and beside the centreline; ``widths`` are at both ends."""
        count = max(math.ceil(abs(end_m - begin_m) / _STEP_M) + 1, 2)
        share, across = np.meshgrid(np.linspace(0, 1, count), np.linspace(-1, 1, 7))
        half_m = widths[0] + share * (widths[1] - widths[0])
        return (begin_m + share * (end_m - begin_m)).ravel(), (across * half_m).ravel()

    def is_clear(
        self,
        along_m: Floats,
        across_m: Floats,
        height_m: Floats,
        flown_m: Floats | None = None,
    ) -> bool:
        """Return whether heights above the touch-down keep the clearance near it.

        Parameters
        ----------
        flown_m : ndarray, optional
            Lower heights that must keep the clearance that is required at ``height_m``.
        """
        places = self.beside(along_m, across_m)
        z = self.touch_down[2] + (height_m if flown_m is None else flown_m)
        clearance = np.minimum(required_m(self.problem, places), SHARE_OF_HEIGHT * height_m)
        return is_clear(self.problem, places, z, clearance) and is_under_ceiling(
            self.problem, places, z
        )


def landing(
    problem: Problem,
    heading: tuple[float, float],
    apart_m: float,
    place: tuple[float, float],
    heading_deg: float,
    *,
    home_m: float,
) -> Landing:
    """Return the landing with the shortest approach.

    Parameters
    ----------
    heading : (float, float)
        Unit vector of the track at the goal.
    apart_m : float
        Minimum distance of two waypoints.
    place : (float, float)
        The touch-down.
    heading_deg : float
        Heading there, degrees clockwise from true north.
    home_m : float
        Altitude of home. ArduPlane's height after a missed approach is above it.

    Raises
    ------
    NoApproachError
        If none has room.
    """
    runway = _runway(problem, place, heading_deg)
    climbs = _climbs(runway, home_m)
    reason = "the glide meets ground, a no-fly zone or the ceiling"
    for height_m in _HEIGHTS_M:
        glide_m = height_m / runway.slope
        if not _glides(runway, glide_m):
            continue
        for circle in _circles(runway, glide_m, height_m):
            missed = next((each for each in climbs if _returns(runway, each[1], circle)), None)
            if missed is None:
                reason = "there is no room for a go-around"
                continue
            way = _way(problem, heading, apart_m, circle)
            if way is None:
                reason = "there is no way from the goal to its circle"
                continue
            glide = RoutePoint(*runway.at(-glide_m), circle.z_m, _ACCEPTANCE_M)
            return Landing(way, circle, glide, runway.touch_down, *missed)
        if reason.startswith("the glide"):
            reason = "there is no room for a circle before it"
    raise NoApproachError(reason)


def _runway(problem: Problem, place: tuple[float, float], heading_deg: float) -> _Runway:
    terrain = problem.terrain
    x, y = (np.array([value]) for value in place)
    surface_m = float(surface_below(terrain, x, y)[0])
    if is_beyond(terrain, x, y).any() or not math.isfinite(surface_m):
        raise NoApproachError("it is off the map, or the ground is unknown there")
    angle = math.radians(heading_deg - problem.true_heading_deg(0.0))
    course = math.sin(angle), math.cos(angle)
    steepest = slope_limits(
        problem.limits,
        problem.aircraft.cruise_speed_m_s,
        problem.wind,
        np.array([course[0]]),
        np.array([course[1]]),
    )[1]
    aircraft = problem.aircraft
    idle_rad = -slope_of_thrust(aircraft, 0.0, aircraft.weight_N)[1]
    along_m_s = problem.wind[0] * course[0] + problem.wind[1] * course[1]
    ground_m_s = aircraft.cruise_speed_m_s + along_m_s
    tail = max(1.0, ground_m_s / aircraft.cruise_speed_m_s)
    slope = min(
        math.tan(math.radians(_GLIDE_DEG)),
        float(steepest[0]),
        _SHARE_OF_IDLE * math.tan(idle_rad) / tail,
    )
    if slope <= 0:
        raise NoApproachError("the wind is too strong for it")
    return _Runway(problem, (*place, surface_m), course, slope, ground_m_s)


def _glides(runway: _Runway, glide_m: float) -> bool:
    """Return whether the glide has room, in a strip that narrows towards the touch-down.

    ArduPlane's glide has to have it, which is below the straight line.
    """
    wide_m = min(_WIDENING * glide_m, _corridor_m(runway.problem))
    narrow_m = wide_m / _WIDENING
    for begin_m, end_m, widths in (
        (-glide_m, -narrow_m, (wide_m, wide_m)),
        (-narrow_m, 0.0, (wide_m, 0.0)),
    ):
        along, across = runway.strip(begin_m, end_m, np.array(widths))
        flown = _flown_m(runway, glide_m, -along)
        if not runway.is_clear(along, across, -along * runway.slope, flown):
            return False
    return True


def _flown_m(runway: _Runway, glide_m: float, before_m: Floats) -> Floats:
    """Return ArduPlane's height above the touch-down at distances before it."""
    speed = runway.ground_m_s
    sink = speed * runway.slope
    aim_m = min(_FLARE_S * sink, _HIGHEST_FLARE_M)
    flare_m = min(speed * aim_m / (0.5 * (sink + _TOUCHDOWN_M_S)), 0.5 * glide_m)
    slope = (glide_m * runway.slope - aim_m) / (glide_m - flare_m)
    return np.maximum(before_m * aim_m / flare_m, aim_m + (before_m - flare_m) * slope)


def _circles(runway: _Runway, glide_m: float, height_m: float) -> Iterator[Circling]:
    """Yield circles with room, from which a level way leads to the glide."""
    problem = runway.problem
    radius_m, z = circle_radius_m(problem), runway.touch_down[2] + height_m
    if z > problem.limits.ceiling_m:
        return
    disc_m = disc_radius_m(radius_m, z)
    for level in _LEVEL:
        before_m = glide_m + disc_m + _lead_m(problem) + level * radius_m
        centre = runway.at(-before_m)
        widths = np.array([disc_m, _corridor_m(problem)])
        along, across = runway.strip(-before_m, -glide_m, widths)
        places = runway.beside(along, across)
        if is_clear(problem, disc_places(problem, *centre, disc_m), z) and is_clear(
            problem, places, z
        ):
            yield Circling(*centre, z, radius_m, disc_m)


def _climbs(runway: _Runway, home_m: float) -> list[_Climb]:
    """Return the climbs straight ahead with room and a circle at their top, shortest first."""
    problem, (_, _, ground_m) = runway.problem, runway.touch_down
    radius_m, lead_m = circle_radius_m(problem), _lead_m(problem)
    missed_m = _MISSED_M + lead_m * runway.slope
    begin_m, low_m = -missed_m / runway.slope, ground_m + _MISSED_M
    found: list[_Climb] = []
    for climb in _CLIMBS:
        straight_m = lead_m + climb * disc_radius_m(radius_m, low_m)
        highest_m = low_m + climb_slope(problem) * (straight_m - lead_m)
        disc_m = disc_radius_m(radius_m, highest_m)
        centre = runway.at(begin_m + straight_m + disc_m)
        around = disc_places(problem, *centre, disc_m)
        top_m = max(height_over(problem, around), home_m + 1.0)
        if top_m > min(highest_m, problem.limits.ceiling_m):
            continue
        # A late aircraft keeps its height at first.
        wide_m = _corridor_m(problem)
        along, across = runway.strip(begin_m, begin_m + straight_m, np.array([0.0, wide_m]))
        across *= np.minimum(1.0, _WIDENING * (along - begin_m) / max(wide_m, 1.0))
        climbed = np.maximum(along - begin_m - lead_m, 0.0) / (straight_m - lead_m)
        height_m = _MISSED_M + climbed * (top_m - low_m)
        if is_clear(problem, around, top_m) and runway.is_clear(along, across, height_m):
            way = ((*runway.at(begin_m), low_m), (*runway.at(begin_m + straight_m), top_m))
            found.append((way, Circling(*centre, top_m, radius_m, disc_m)))
    return found


def _returns(runway: _Runway, top: Circling, circle: Circling) -> bool:
    """Return whether the way back from a go-around to the circle of the approach has room.

    ArduPlane begins the approach again after a go-around, and changes its height on the way.
    """
    away_m = math.hypot(top.x_m - circle.x_m, top.y_m - circle.y_m)
    count = math.ceil(away_m / _STEP_M) + 1
    shares, across = np.meshgrid(np.linspace(0, 1, count), np.linspace(-1, 1, 9))
    share, side_m = shares.ravel(), across.ravel() * top.radius_m
    east, north = (circle.x_m - top.x_m) / away_m, (circle.y_m - top.y_m) / away_m
    x = top.x_m + share * (circle.x_m - top.x_m) - side_m * north
    y = top.y_m + share * (circle.y_m - top.y_m) + side_m * east
    z = top.z_m + share * (circle.z_m - top.z_m)
    return is_clear(runway.problem, (x, y), z)


def _way(
    problem: Problem, heading: tuple[float, float], apart_m: float, circle: Circling
) -> tuple[RoutePoint, ...] | None:
    """Return waypoints from the goal to the disc of a circle, or None if no way has room."""
    lead_m, z = _lead_m(problem), problem.goal[2]
    for way in ways_to(
        problem.goal,
        heading,
        (circle.x_m, circle.y_m),
        radius_m=circle.radius_m,
        short_m=circle.disc_m,
        apart_m=apart_m,
    ):
        if way.straight_m < lead_m + apart_m:
            continue
        lowest_m = max(z, circle.z_m)
        highest_m = z + climb_slope(problem) * (way.length_m - lead_m)
        for share in _SHARES_OF_REACH:
            end_m = lowest_m + share * (max(highest_m, z) - lowest_m)
            if lowest_m > max(highest_m, z) or end_m > problem.limits.ceiling_m:
                break
            if _has_room(problem, way, end_m, circle):
                return tuple(way.points(lead_m, end_m, is_gusty=any(problem.wind)))
    return None


def _has_room(problem: Problem, way: Way, end_m: float, circle: Circling) -> bool:
    """Return whether a way that ends at a height, and the circle below it, have room."""
    places, z = flown(problem, way, _lead_m(problem), end_m)
    around = disc_places(problem, circle.x_m, circle.y_m, circle.disc_m)
    return (
        is_clear(problem, places, z)
        and is_under_ceiling(problem, places, z)
        and is_clear(problem, around, circle.z_m, up_to_m=end_m)
    )


def _lead_m(problem: Problem) -> float:
    """Return the way that an aircraft flies while its height is late."""
    aircraft = problem.aircraft
    return aircraft.height_lag_s * aircraft.cruise_speed_m_s * drift_of(problem)


def _corridor_m(problem: Problem) -> float:
    """Return half the width of the strip along a way that is kept clear."""
    return CORNER_M + (0.0 if problem.rules is None else problem.rules.corridor_m)
