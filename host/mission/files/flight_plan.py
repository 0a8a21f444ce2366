"""A path as an autopilot takes it: items, fences, home and rally point, in degrees and AMSL."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.mission.files.fence import Fence, degrees, fences
from pathgene.host.mission.files.route import leg_tolerance_m, route
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


__all__ = ["LOITER", "WAYPOINT", "FlightPlan", "Item", "check_place", "flight_plan"]

#: MAV_CMD_NAV_WAYPOINT and MAV_CMD_NAV_LOITER_UNLIM.
WAYPOINT, LOITER = 16, 17

Position = tuple[float, float, float]


@dataclass(frozen=True)
class Item:
    """An item of a mission, at an altitude above mean sea level (MAV_FRAME_GLOBAL, 0).

    Parameters
    ----------
    command : int
        Number of the MAVLink command.
    params : tuple of (float or None)
        The first four parameters of the command; None leaves one to the autopilot.
    lat, lon : float
        WGS84 degrees.
    alt_m : float
        Altitude in metres.
    """

    command: int
    params: tuple[float | None, float | None, float | None, float | None]
    lat: float
    lon: float
    alt_m: float


@dataclass(frozen=True)
class FlightPlan:
    """All that an autopilot is told.

    Parameters
    ----------
    home : tuple of float
        Latitude, longitude and altitude of the ground below the start.
    items : tuple of Item
        The mission, home not included: the start first, a loiter over the goal last.
    fence : tuple of Fence
        Fences to keep out of.
    rally : tuple of (float, float, float)
        Latitude, longitude and height above home of the places to return to: the start.
    cruise_speed_m_s : float
        Airspeed that the path is planned for.
    notes : tuple of str
        A sentence about each thing that the autopilot is not told.
    feasible : bool or None
        The verdict on the path; None where nobody states one, as in the plans of ground stations.
    """

    home: Position
    items: tuple[Item, ...]
    fence: tuple[Fence, ...]
    rally: tuple[Position, ...]
    cruise_speed_m_s: float
    notes: tuple[str, ...] = ()
    feasible: bool | None = None


def check_place(terrain: Terrain) -> None:
    """Refuse a terrain that has no place on Earth.

    Raises
    ------
    InputError
        If it has none.
    """
    if terrain.crs is None or terrain.origin is None:
        raise InputError(
            f"The terrain {terrain.name!r} has no place on Earth, which this file needs; give the "
            "latitude and longitude of its south-west node (--origin LAT,LON, or origin under "
            "[terrain] in a problem file)."
        )


def flight_plan(
    problem: Problem, path: NDArray[np.float64], *, feasible: bool | None = None
) -> FlightPlan:
    """Return what an autopilot must be told to fly a path.

    Parameters
    ----------
    problem : Problem
        The problem; its terrain has a place on Earth.
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    feasible : bool, optional
        The verdict on the path.

    Raises
    ------
    InputError
        If the terrain has no place on Earth.
    """
    terrain, aircraft = problem.terrain, problem.aircraft
    check_place(terrain)
    track = Evaluator(problem).track(path)
    corridor_m = None if problem.rules is None else problem.rules.corridor_m
    points = route(track, leg_tolerance_m(corridor_m))
    x, y = np.array([(point.x_m, point.y_m) for point in points]).T
    places = degrees(terrain, x, y)
    waypoints = tuple(
        Item(WAYPOINT, (0.0, float(point.acceptance_m), 0.0, None), lat, lon, point.z_m)
        for point, (lat, lon) in zip(points, places, strict=True)
    )
    start, goal = waypoints[0], waypoints[-1]
    # The radius that the aircraft can fly with the wind behind it, in whole metres as in ArduPilot.
    drift = 1 + math.hypot(*problem.wind) / aircraft.cruise_speed_m_s
    radius_m = math.ceil(aircraft.turn_radius_m * drift**2)
    # ArduPilot refuses a loiter whose heading is left to the autopilot.
    loiter = Item(LOITER, (0.0, 0.0, float(radius_m), 0.0), goal.lat, goal.lon, goal.alt_m)
    fence, left_out = fences(problem.zones, track, terrain)
    # Rally points are above home, so home on the ground puts this one at the start's own altitude.
    ground_m = min(terrain.ground(points[0].x_m, points[0].y_m), start.alt_m)
    return FlightPlan(
        (start.lat, start.lon, ground_m),
        (*waypoints, loiter),
        fence,
        ((start.lat, start.lon, start.alt_m - ground_m),),
        aircraft.cruise_speed_m_s,
        (*left_out, *_loiter_notes(problem, track, radius_m)),
        feasible,
    )


def _loiter_notes(problem: Problem, track: SmoothedTrack, radius_m: float) -> tuple[str, ...]:
    """Return a sentence if the circle over the goal comes near the ground or over a zone."""
    terrain = problem.terrain
    x, y, z = problem.goal
    angles = np.linspace(0, 2 * np.pi, 256, endpoint=False)
    around = x + radius_m * np.cos(angles), y + radius_m * np.sin(angles)
    lowest_m = z - float(np.nanmax(np.r_[terrain.ground(*around), terrain.ground(x, y)]))
    blocked = bool(problem.nofly_raster[terrain.nearest_nodes(*around)].any())
    needed_m = problem.rules.clearance_m if problem.rules else 0.0
    if lowest_m >= needed_m and not blocked:
        return ()
    side = "below" if lowest_m >= 0 else "above"
    what = "a no-fly zone" if blocked else f"ground {abs(lowest_m):.0f} m {side} it"
    return (
        f"The mission ends with a circle of {radius_m:.0f} m around the goal, over {what}; land or "
        "take over before the aircraft gets there.",
    )
