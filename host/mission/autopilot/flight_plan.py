"""The flight plan of a path: the items and fences that an autopilot needs to fly it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.formats.flight_plan import (
    LOITER,
    WAYPOINT,
    Fence,
    FenceCircle,
    FencePolygon,
    FlightPlan,
    Item,
)
from pathgene.host.formats.geojson import heights_datum
from pathgene.host.formats.places import check_place, degrees
from pathgene.host.formats.shapes import Ring, wound
from pathgene.host.mission.autopilot.airspeed import with_speeds
from pathgene.host.mission.autopilot.climbs import led
from pathgene.host.mission.autopilot.fence_room import fence_notes
from pathgene.host.mission.autopilot.loiter import Loiter, loiter
from pathgene.host.mission.autopilot.route import RoutePoint, leg_tolerance_m, route
from pathgene.host.mission.autopilot.spacing import accepted, spaced
from pathgene.host.mission.autopilot.timing import timed
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import wholes
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


__all__ = ["fences", "flight_plan", "without_holes"]


_THIN = (
    "In the thin air of the highest legs, the planned airspeed is below 1.2 times the stall speed; "
    "the autopilot is asked for that speed there, and flies faster than planned."
)
# Minimum time between two waypoints.
_APART_S = 1.1
# The track is compared with zones at points this far apart.
_STEP_M = 1.0


def fences(
    zones: tuple[Zone, ...], track: SmoothedTrack, terrain: Terrain
) -> tuple[tuple[Fence, ...], tuple[str, ...]]:
    """Return the fences of zones, and a sentence for each zone that has none.

    A fence forbids the whole column for the whole flight. So a zone whose height or time limits let
    the track pass above, below, before or after it has no fence: the autopilot would abort its own
    mission.

    Parameters
    ----------
    zones : tuple of Zone
        The zones, without margin.
    terrain : Terrain
        Gives the zones their place on Earth.
    """
    samples = track.sample(_STEP_M)
    made: list[Fence] = []
    left_out: list[str] = []
    for number, zone in enumerate(wholes(zones), start=1):
        if zone.limits.keys() - {"name"} and zone.footprint.contains(samples.x, samples.y).any():
            left_out.append(
                f"No fence for {zone.name or f'zone {number}'}: the path crosses it above, below, "
                "before or after its limits, which a fence cannot express."
            )
        else:
            made.append(_fence(zone, terrain))
    # Parts of one zone have one name.
    return tuple(made), tuple(dict.fromkeys(left_out))


def without_holes(ring: Ring, holes: tuple[Ring, ...]) -> Ring:
    """Return one ring that covers ``ring`` less its ``holes``.

    Each hole is joined to the ring by a cut of zero width, traversed in both directions, so that
    the cut covers nothing. Holes wind opposite to the ring, so that the even-odd rule and the
    winding-number rule agree.
    """
    if holes:
        ring = wound(ring, left=True)
    for hole in (wound(hole, left=False) for hole in holes):
        pairs = (
            (math.dist(corner, other), i, j)
            for i, corner in enumerate(ring)
            for j, other in enumerate(hole)
        )
        _, i, j = min(pairs)
        ring = (*ring[: i + 1], *hole[j:], *hole[: j + 1], *ring[i:])
    return ring


def _fence(zone: Zone, terrain: Terrain) -> Fence:
    if zone.footprint.disc is not None:
        x_m, y_m, radius_m = zone.footprint.disc
        ((lat, lon),) = degrees(terrain, np.array([x_m]), np.array([y_m]))
        return FenceCircle(lat, lon, radius_m)
    ring, *holes = zone.footprint.rings
    x, y = np.array(without_holes(ring, tuple(holes))).T
    return FencePolygon(degrees(terrain, x, y))


def flight_plan(
    problem: Problem, track: SmoothedTrack, *, feasible: bool | None = None
) -> FlightPlan:
    """Return the flight plan of a path.

    Parameters
    ----------
    problem : Problem
        The problem; its terrain has a place on Earth.

    Raises
    ------
    InputError
        If the terrain has no place on Earth.
    """
    terrain, aircraft = problem.terrain, problem.aircraft
    check_place(terrain)
    corridor_m = None if problem.rules is None else problem.rules.corridor_m
    points = _flyable(problem, route(track, leg_tolerance_m(corridor_m)))
    end = loiter(problem, _heading(points), _apart_m(problem))
    points += end.way
    x, y = np.array([(point.x_m, point.y_m) for point in points]).T
    places = degrees(terrain, x, y)
    waypoints = tuple(
        Item(WAYPOINT, (0.0, float(point.acceptance_m), 0.0, None), lat, lon, point.z_m)
        for point, (lat, lon) in zip(points, places, strict=True)
    )
    start = waypoints[0]
    ((lat, lon),) = degrees(terrain, np.array([end.x_m]), np.array([end.y_m]))
    # ArduPilot refuses a loiter whose heading is left to the autopilot.
    circle = Item(LOITER, (0.0, 0.0, float(end.radius_m), 0.0), lat, lon, end.z_m)
    fence, left_out = fences(problem.zones, track, terrain)
    # Rally points are relative to home, so with home on the ground, this one is at the altitude of
    # the start.
    ground_m = min(terrain.ground(points[0].x_m, points[0].y_m), start.alt_m)
    datum = heights_datum(terrain)
    items, is_thin = with_speeds((*waypoints, circle), aircraft)
    return FlightPlan(
        (start.lat, start.lon, ground_m),
        items,
        fence,
        ((start.lat, start.lon, start.alt_m - ground_m),),
        aircraft.cruise_speed_m_s,
        (
            *left_out,
            *fence_notes(fence),
            *_loiter_notes(problem, end),
            *([_THIN] if is_thin else []),
        ),
        feasible,
        "" if datum.startswith("AMSL") else datum,
    )


def _flyable(problem: Problem, points: Sequence[RoutePoint]) -> list[RoutePoint]:
    """Return the waypoints that an autopilot flies as planned."""
    aircraft = problem.aircraft
    planned = timed(points, aircraft.cruise_speed_m_s, problem.wind)
    kept = spaced(planned, _apart_m(problem))
    return accepted(led(kept, planned, aircraft.height_lag_s, _APART_S))


def _apart_m(problem: Problem) -> float:
    """Return the minimum distance of two waypoints, in a tail wind."""
    return _APART_S * (problem.aircraft.cruise_speed_m_s + math.hypot(*problem.wind))


def _zone_under(problem: Problem, x: NDArray[np.float64], y: NDArray[np.float64]) -> str:
    """Return the zone below some points that comes nearest to them, in words."""
    zone = min(wholes(problem.zones), key=lambda zone: float(zone.footprint.distance_m(x, y).min()))
    return f"the no-fly zone {zone.name}" if zone.name else "a no-fly zone"


def _heading(points: Sequence[RoutePoint]) -> tuple[float, float]:
    """Return the direction of the last leg, a unit vector."""
    before, last = points[-2:]
    east, north = last.x_m - before.x_m, last.y_m - before.y_m
    length = math.hypot(east, north)
    return (east / length, north / length) if length else (1.0, 0.0)


def _loiter_notes(problem: Problem, end: Loiter) -> tuple[str, ...]:
    """Return a sentence if the circle at the end is not around the goal, or has no room."""
    terrain = problem.terrain
    x, y, z = problem.goal
    if end.has_room:
        if not end.way:
            return ()
        away_m = math.hypot(end.x_m - x, end.y_m - y)
        return (
            f"A circle of {end.radius_m} m around the goal has no room, so the mission ends with "
            f"one {away_m:.0f} m from the goal and {end.z_m - z:.0f} m above it.",
        )
    angles, radii = np.meshgrid(
        np.linspace(0, 2 * np.pi, 128, endpoint=False), np.linspace(0, end.disc_m, 9)
    )
    around = (x + radii * np.cos(angles)).ravel(), (y + radii * np.sin(angles)).ravel()
    lowest_m = z - float(np.nanmax(terrain.ground(*around)))
    blocked = bool(problem.nofly_raster[terrain.nearest_nodes(*around)].any())
    side = "below" if lowest_m >= 0 else "above"
    what = _zone_under(problem, *around) if blocked else f"ground {abs(lowest_m):.0f} m {side} it"
    return (
        f"The mission ends with a circle of {end.radius_m} m around the goal, over {what}; land or "
        "take over before the aircraft gets there.",
    )
