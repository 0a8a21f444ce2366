"""The flight plan of a path: the items and fences that an autopilot needs to fly it."""

from __future__ import annotations

import math

import numpy as np

from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.formats.flight_plan import LOITER, WAYPOINT, FlightPlan, Item
from pathgene.host.formats.places import check_place, degrees
from pathgene.host.mission.autopilot.fence import fences
from pathgene.host.mission.autopilot.route import leg_tolerance_m, route
from pathgene.host.problem.problem import Problem


__all__ = ["flight_plan"]


def flight_plan(
    problem: Problem, track: SmoothedTrack, *, feasible: bool | None = None
) -> FlightPlan:
    """Return the flight plan of a path.

    Parameters
    ----------
    problem : Problem
        The problem; its terrain has a place on Earth.
    track : SmoothedTrack
        The path.
    feasible : bool, optional
        The verdict on the path.

    Raises
    ------
    InputError
        If the terrain has no place on Earth.
    """
    terrain, aircraft = problem.terrain, problem.aircraft
    check_place(terrain)
    corridor_m = None if problem.rules is None else problem.rules.corridor_m
    points = route(track, leg_tolerance_m(corridor_m))
    x, y = np.array([(point.x_m, point.y_m) for point in points]).T
    places = degrees(terrain, x, y)
    waypoints = tuple(
        Item(WAYPOINT, (0.0, float(point.acceptance_m), 0.0, None), lat, lon, point.z_m)
        for point, (lat, lon) in zip(points, places, strict=True)
    )
    start, goal = waypoints[0], waypoints[-1]
    # The radius that the aircraft can fly in a tailwind, in whole metres as in ArduPilot.
    drift = 1 + math.hypot(*problem.wind) / aircraft.cruise_speed_m_s
    radius_m = math.ceil(aircraft.turn_radius_m * drift**2)
    # ArduPilot refuses a loiter whose heading is left to the autopilot.
    loiter = Item(LOITER, (0.0, 0.0, float(radius_m), 0.0), goal.lat, goal.lon, goal.alt_m)
    fence, left_out = fences(problem.zones, track, terrain)
    # Rally points are relative to home, so with home on the ground, this one is at the altitude of
    # the start.
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
