"""The flight plan of a path: the items and fences that an autopilot needs to fly it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.formats.flight_plan import (
    WAYPOINT,
    End,
    FlightPlan,
    Item,
)
from pathgene.host.formats.geojson import heights_datum
from pathgene.host.formats.places import check_place, degrees
from pathgene.host.mission.autopilot.airspeed import with_speeds
from pathgene.host.mission.autopilot.ends import finish, places_of
from pathgene.host.mission.autopilot.fence_room import fence_notes, room_of
from pathgene.host.mission.autopilot.fences import fences
from pathgene.host.mission.autopilot.flyable import apart_m, flyable
from pathgene.host.mission.autopilot.hand_over import USUAL, HandOver
from pathgene.host.mission.autopilot.late import check_climbs
from pathgene.host.mission.autopilot.rally import rally_points
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.problem.problem import Problem


__all__ = ["flight_plan"]


_THIN = (
    "In the thin air of the highest legs, the planned airspeed is below 1.2 times the stall speed; "
    "the autopilot is asked for that speed there, and flies faster than planned."
)


def flight_plan(
    problem: Problem,
    track: SmoothedTrack,
    *,
    feasible: bool | None = None,
    wanted: HandOver = USUAL,
) -> FlightPlan:
    """Return the flight plan of a path.

    Parameters
    ----------
    problem : Problem
        The problem; its terrain has a place on Earth.
    feasible : bool, optional
        The verdict on the path.
    wanted : HandOver
        The user's choices.

    Raises
    ------
    InputError
        If the terrain has no place on Earth.
    NoRoomError
        If the end has no room.
    LateClimbError
        If the path is feasible, but a late autopilot does not keep half of the clearance on it.
    """
    terrain, aircraft = problem.terrain, problem.aircraft
    check_place(terrain)
    points = flyable(problem, track, wanted.simplify_m)
    if feasible:
        check_climbs(problem, points)
    ground_m = min(terrain.ground(points[0].x_m, points[0].y_m), points[0].z_m)
    apart = apart_m(problem)
    end = finish(problem, points, apart, wanted.ending, ground_m, wanted.autopilot)
    points += end.way
    x, y = np.array([(point.x_m, point.y_m) for point in points]).T
    places = degrees(terrain, x, y)
    waypoints = tuple(
        Item(WAYPOINT, (0.0, float(point.acceptance_m), 0.0, None), lat, lon, point.z_m)
        for point, (lat, lon) in zip(points, places, strict=True)
    )
    start = waypoints[0]
    room = room_of(wanted.autopilot, wanted.fence_corners)
    after_x, after_y = places_of(end.end)
    reached = np.append(x, after_x), np.append(y, after_y)
    fence, fence_said = fences(problem, track, room, reached)
    datum = heights_datum(terrain)
    items, is_thin = with_speeds((*waypoints, *end.items), aircraft)
    return FlightPlan(
        (start.lat, start.lon, ground_m),
        items,
        fence,
        # An autopilot returns to a rally point that is nearer than home.
        () if end.end.kind == "rtl" else _rally(problem, (*points, *_waits(end.end)), ground_m),
        aircraft.cruise_speed_m_s,
        (
            *fence_said,
            *fence_notes(fence, wanted.autopilot),
            *end.notes,
            *([_THIN] if is_thin else []),
        ),
        feasible,
        "" if datum.startswith("AMSL") else datum,
        end.end,
    )


def _waits(end: End) -> list[RoutePoint]:
    """Return the middle of the circle at the end, if there is one."""
    circle = end.circle
    return [] if circle is None else [RoutePoint(circle.x_m, circle.y_m, circle.z_m, 0)]


def _rally(
    problem: Problem, points: Sequence[RoutePoint], home_m: float
) -> tuple[tuple[float, float, float], ...]:
    """Return rally points; their heights over home are whole metres, as ArduPilot keeps them."""
    found = rally_points(problem, points)
    x, y = np.array([(point.x_m, point.y_m) for point in found]).reshape(-1, 2).T
    heights = (float(math.ceil(point.z_m - home_m)) for point in found)
    places = degrees(problem.terrain, x, y) if found else ()
    return tuple((lat, lon, z) for (lat, lon), z in zip(places, heights, strict=True))
