"""The end of a mission as an autopilot gets it: waypoints and items after the goal."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import JobError
from pathgene.host.formats.flight_plan import (
    LAND,
    LAND_START,
    LOITER,
    LOITER_TO_ALT,
    RTL,
    WAYPOINT,
    Circling,
    End,
    Item,
)
from pathgene.host.formats.places import degrees
from pathgene.host.mission.autopilot.landing import Landing, NoApproachError, landing
from pathgene.host.mission.autopilot.loiter import loiter
from pathgene.host.mission.autopilot.mission_lists import ARDUPILOT, PX4
from pathgene.host.mission.autopilot.other_goal import OtherGoal, other_goal
from pathgene.host.mission.autopilot.returns import needed_m
from pathgene.host.mission.autopilot.room import disc_height_m, disc_places, is_clear
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.ending import Ending
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import wholes
from pathgene.host.terrain.surface import is_beyond, surface_below


__all__ = ["Finish", "NoRoomError", "finish", "places_of"]
Floats = NDArray[np.float64]

# Other headings of a landing that are tried, relative to the given one.
_TURNS_DEG = (*(sign * turn for turn in range(15, 180, 15) for sign in (1, -1)), 180)
# The way of an end is compared with zones at points this far apart, metres.
_STEP_M = 5.0
# A landing this far above the water may be on it, metres.
_WET_M = 0.01
# A weaker tail wind of a landing is not mentioned, m/s.
_TAIL_M_S = 1.0


class NoRoomError(JobError):
    """A mission whose end has no room, so that it has no flight plan.

    Parameters
    ----------
    goal : OtherGoal, optional
        A goal whose circle has room, which the sentence names.
    """

    def __init__(self, text: str, goal: OtherGoal | None = None) -> None:
        super().__init__(text)
        self.goal = goal


@dataclass(frozen=True)
class Finish:
    """The end of a mission.

    Parameters
    ----------
    way : tuple of RoutePoint
        Waypoints after the goal.
    items : tuple of Item
        The items after those waypoints.
    end : End
        The same as data to draw.
    notes : tuple of str
        A sentence about each fact that the user should know.
    """

    way: tuple[RoutePoint, ...]
    items: tuple[Item, ...]
    end: End
    notes: tuple[str, ...] = ()


def finish(
    problem: Problem,
    points: Sequence[RoutePoint],
    apart_m: float,
    ending: Ending,
    home_m: float,
    autopilot: int | None = None,
) -> Finish:
    """Return the end of a mission.

    Parameters
    ----------
    points : sequence of RoutePoint
        The waypoints up to the goal.
    apart_m : float
        Minimum distance of two waypoints.
    home_m : float
        Altitude of home, below the first waypoint.
    autopilot : int, optional
        Value of MAV_AUTOPILOT, if it is known: a return needs room for this one. Otherwise it needs
        room for one of ArduPlane and PX4.

    Raises
    ------
    NoRoomError
        If it has no room.
    """
    if ending.kind == "rtl":
        return _return(problem, points, apart_m, home_m, autopilot)
    if ending.land is not None:
        return _landing(problem, points, apart_m, ending.land, home_m)
    return _loiter(problem, points, apart_m, home_m)


def places_of(end: End) -> tuple[Floats, Floats]:
    """Return places along the ways of an end and on the discs of its circles."""
    angles, radii = (
        grid.ravel()
        for grid in np.meshgrid(np.linspace(0, 2 * np.pi, 64, endpoint=False), np.linspace(0, 1, 9))
    )
    places = [
        (
            circle.x_m + radii * circle.disc_m * np.cos(angles),
            circle.y_m + radii * circle.disc_m * np.sin(angles),
        )
        for circle in (end.circle, end.go_around_circle)
        if circle is not None
    ]
    for a, b in (*pairwise(end.way), *pairwise(end.go_around)):
        share = np.linspace(0, 1, math.ceil(math.dist(a[:2], b[:2]) / _STEP_M) + 1)
        places.append((a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])))
    x, y = (np.concatenate(column) for column in zip(*places, strict=True))
    return x, y


def _loiter(
    problem: Problem, points: Sequence[RoutePoint], apart_m: float, home_m: float
) -> Finish:
    found = loiter(problem, _heading(points), apart_m)
    circle = Circling(found.x_m, found.y_m, found.z_m, found.radius_m, found.disc_m)
    if not found.has_room:
        start = points[0]
        goal = other_goal(problem)
        remedies = "a larger map" if goal is None else _instead(problem, goal)
        if any(each.height_m is not None for each in _return_heights(problem, start, home_m)):
            remedies += ", --end rtl, which has room"
        raise NoRoomError(
            f"The mission cannot end with a circle of {found.radius_m} m around the goal, which "
            f"{_fault(problem, circle)}, and no other circle near it has room; give {remedies}, or "
            "a landing (--land).",
            goal,
        )
    x, y, z = problem.goal
    notes: tuple[str, ...] = ()
    if found.way:
        away_m = math.hypot(found.x_m - x, found.y_m - y)
        notes = (
            f"A circle of {found.radius_m} m around the goal has no room, so the mission ends with "
            f"one {away_m:.0f} m from the goal and {found.z_m - z:.0f} m above it.",
        )
    # ArduPilot refuses a loiter whose heading is left to the autopilot.
    item = _item(problem, LOITER, (0.0, 0.0, float(found.radius_m), 0.0), circle)
    return Finish(found.way, (item,), End("loiter", _way(problem, found.way), circle), notes)


def _landing(
    problem: Problem,
    points: Sequence[RoutePoint],
    apart_m: float,
    land: tuple[float, float, float],
    home_m: float,
) -> Finish:
    x, y, heading_deg = land
    attempt = partial(landing, problem, _heading(points), apart_m, (x, y), home_m=home_m)
    try:
        found = attempt(heading_deg)
    except NoApproachError as error:
        other_deg = _other_heading(attempt, heading_deg)
        remedy = "give another place (--land), or --end rtl"
        if other_deg is not None:
            remedy = f"there is room with a heading of {other_deg:g}, else {remedy}"
        raise NoRoomError(
            f"The mission cannot land at {x:.0f}, {y:.0f} with a heading of {heading_deg:g} "
            f"degrees: {error}; {remedy}."
        ) from None
    circle, glide, top = found.circle, found.glide, found.go_around_circle
    low = RoutePoint(*found.touch_down, 0)
    abort_m = float(math.ceil(top.z_m - home_m))
    items = (
        _item(problem, LAND_START, (0.0, 0.0, 0.0, 0.0), circle),
        _item(problem, LOITER_TO_ALT, (1.0, float(circle.radius_m), 0.0, 0.0), circle),
        _item(problem, WAYPOINT, (0.0, float(glide.acceptance_m), 0.0, None), glide),
        _item(problem, LAND, (abort_m, 0.0, 0.0, heading_deg), low),
    )
    return Finish(found.way, items, _landing_end(problem, found), _landing_notes(problem, found))


def _other_heading(attempt: Callable[[float], Landing], heading_deg: float) -> float | None:
    """Return the nearest heading with which a landing has room, or None."""
    for turn_deg in _TURNS_DEG:
        try:
            attempt((heading_deg + turn_deg) % 360.0)
        except NoApproachError:
            continue
        return (heading_deg + turn_deg) % 360.0
    return None


def _landing_end(problem: Problem, found: Landing) -> End:
    way = (*_way(problem, found.way), (found.glide.x_m, found.glide.y_m, found.glide.z_m))
    return End(
        "land", (*way, found.touch_down), found.circle, found.go_around, found.go_around_circle
    )


def _tail_wind(problem: Problem, found: Landing) -> tuple[str, ...]:
    """Return a note of the tail wind at the touch-down, with the heading against it."""
    (x, y, _), glide = found.touch_down, found.glide
    east, north = problem.wind
    along_m_s = (x - glide.x_m) * east + (y - glide.y_m) * north
    along_m_s /= math.hypot(x - glide.x_m, y - glide.y_m)
    if along_m_s < _TAIL_M_S:
        return ()
    against = round(problem.true_heading_deg(math.degrees(math.atan2(-east, -north)))) % 360
    return (
        f"The landing has a tail wind of {along_m_s:.0f} m/s, in which the touch-down may be "
        f"hundreds of metres late; against the wind, its heading is {against}.",
    )


def _landing_notes(problem: Problem, found: Landing) -> tuple[str, ...]:
    """Return the sentences on the height of the approach and of the go-around."""
    x, y, ground_m = found.touch_down
    circle, top = found.circle, found.go_around_circle
    glide_m = math.hypot(found.glide.x_m - x, found.glide.y_m - y)
    around_m = disc_height_m(problem, x, y, ground_m)
    px4 = "climbs in a circle over the landing point, which has room at no height"
    if math.isfinite(around_m):
        room_m = math.ceil(around_m - ground_m)
        px4 = (
            f"climbs in a circle over the landing point, which has room from {room_m} m above it "
            f"on: set MIS_LND_ABRT_ALT to {room_m} m or more, and break no landing off below"
        )
    level_m = problem.terrain.reading.facts.get("water_level_m")
    wet: tuple[str, ...] = ()
    if level_m is not None and ground_m <= level_m + _WET_M:
        wet = (f"The landing ends at {ground_m:.1f} m, the level of the water; is it on land?",)
    return (
        *wet,
        *_tail_wind(problem, found),
        f"The landing begins with a circle of {circle.radius_m:.0f} m at {circle.z_m:.0f} m above "
        f"sea level, and glides {glide_m:.0f} m.",
        f"After a missed approach, ArduPlane climbs straight ahead to {top.z_m:.0f} m above sea "
        f"level and begins the approach again; PX4 {px4}.",
    )


def _instead(problem: Problem, goal: OtherGoal) -> str:
    """Return a goal that has room, in words."""
    x, y, z = goal.place
    if (x, y) == problem.goal[:2]:
        said = f"a goal {math.ceil(z - problem.goal[2])} m higher"
    else:
        said = f"a goal at x {x:.0f} m, y {y:.0f} m and an altitude of {z:.0f} m"
    start = f" with a start {goal.raise_m} m higher" if goal.raise_m else ""
    return f"{said}{start}, where a circle has room"


@dataclass(frozen=True)
class _ReturnHeight:
    """The return height of an autopilot above home; None, and the reason, without room."""

    number: int
    autopilot: str
    parameter: str
    height_m: float | None
    reason: str = ""

    def __str__(self) -> str:
        if self.height_m is None:
            return f"{self.autopilot} has room at no return height"
        return f"{self.autopilot} needs {self.parameter} of {math.ceil(self.height_m)} m or more"


def _return_heights(
    problem: Problem, start: RoutePoint, home_m: float
) -> tuple[_ReturnHeight, _ReturnHeight]:
    """Return the return heights of ArduPlane and PX4."""
    home = start.x_m, start.y_m
    room_m, ceiling_m = disc_height_m(problem, *home, home_m), problem.limits.ceiling_m

    def of(number: int, autopilot: str, parameter: str, climbs_first: bool) -> _ReturnHeight:
        goal = np.array([problem.goal])
        way_m = float(needed_m(problem, goal, home, climbs_first=climbs_first)[0])
        if not math.isfinite(room_m):
            reason = "no circle around home has room"
        elif math.isfinite(way_m) and max(way_m, room_m) <= ceiling_m:
            height_m = max(way_m, room_m) - home_m
            return _ReturnHeight(number, autopilot, parameter, height_m)
        elif math.isfinite(way_m):
            reason = (
                f"it needs an altitude of {way_m:.0f} m, above the ceiling of {ceiling_m:.0f} m"
            )
        else:
            steep = "" if climbs_first else ", or is steeper than the aircraft climbs"
            reason = f"it passes through a no-fly zone or off the map{steep}"
        return _ReturnHeight(number, autopilot, parameter, None, reason)

    return (
        of(ARDUPILOT, "ArduPlane", "RTL_ALTITUDE", False),
        of(PX4, "PX4", "RTL_RETURN_ALT", True),
    )


def _return(
    problem: Problem,
    points: Sequence[RoutePoint],
    apart_m: float,
    home_m: float,
    autopilot: int | None,
) -> Finish:
    start = points[0]
    found = _return_heights(problem, start, home_m)
    judged = [each for each in found if autopilot in (None, each.number)]
    if judged and all(each.height_m is None for each in judged):
        has_loiter = loiter(problem, _heading(points), apart_m).has_room
        remedy = "--end loiter, which has room" if has_loiter else "another goal or start"
        reason = judged[0].reason
        raise NoRoomError(
            "The mission cannot end with a straight return to home at any return height, because "
            f"{reason}; give {remedy}, or a landing (--land)."
        )
    note = (
        "The mission ends with a straight return to home, so it has no rally points: "
        f"{', '.join(map(str, found))}."
    )
    high_m = found[0].height_m
    way = (
        problem.goal,
        (start.x_m, start.y_m, problem.goal[2] if high_m is None else home_m + high_m),
    )
    item = Item(RTL, (0.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    return Finish((), (item,), End("rtl", way), (note,))


def _item(
    problem: Problem,
    command: int,
    params: tuple[float | None, float | None, float | None, float | None],
    at: RoutePoint | Circling,
) -> Item:
    ((lat, lon),) = degrees(problem.terrain, np.array([at.x_m]), np.array([at.y_m]))
    return Item(command, params, lat, lon, at.z_m)


def _way(problem: Problem, points: Sequence[RoutePoint]) -> tuple[tuple[float, float, float], ...]:
    return (problem.goal, *((point.x_m, point.y_m, point.z_m) for point in points))


def _heading(points: Sequence[RoutePoint]) -> tuple[float, float]:
    """Return the direction of the last leg, a unit vector."""
    before, last = points[-2:]
    east, north = last.x_m - before.x_m, last.y_m - before.y_m
    length = math.hypot(east, north)
    return (east / length, north / length) if length else (1.0, 0.0)


def _fault(problem: Problem, circle: Circling) -> str:
    """Return the reason why the circle around the goal has no room, in words."""
    terrain = problem.terrain
    places = disc_places(problem, circle.x_m, circle.y_m, circle.disc_m)
    if is_beyond(terrain, *places).any():
        return "leaves the map"
    highest_m = float(np.max(surface_below(terrain, *places)))
    if not math.isfinite(highest_m):
        return "is over ground of unknown height"
    if is_clear(problem, places, circle.z_m, np.full(len(places[0]), -math.inf)):
        lowest_m = circle.z_m - highest_m
        return f"is over ground {abs(lowest_m):.0f} m {'below' if lowest_m >= 0 else 'above'} it"
    zone = min(
        wholes(problem.zones), key=lambda zone: float(zone.footprint.distance_m(*places).min())
    )
    return f"meets the no-fly zone {zone.name}" if zone.name else "meets a no-fly zone"
