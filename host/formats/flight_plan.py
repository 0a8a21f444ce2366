"""A path as an autopilot reads it: items, fences, home and rally points, in degrees and AMSL."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


__all__ = [
    "CHANGE_SPEED",
    "LAND",
    "LAND_START",
    "LOITER",
    "LOITER_TO_ALT",
    "RTL",
    "WAYPOINT",
    "Circling",
    "End",
    "EndKind",
    "Fence",
    "FenceCircle",
    "FencePolygon",
    "FlightPlan",
    "Item",
]

#: MAV_CMD_NAV_WAYPOINT, MAV_CMD_NAV_LOITER_UNLIM and MAV_CMD_DO_CHANGE_SPEED.
WAYPOINT, LOITER, CHANGE_SPEED = 16, 17, 178
#: MAV_CMD_NAV_RETURN_TO_LAUNCH.
RTL = 20
#: MAV_CMD_DO_LAND_START, MAV_CMD_NAV_LOITER_TO_ALT and MAV_CMD_NAV_LAND.
LAND_START, LOITER_TO_ALT, LAND = 189, 31, 21

#: Ends of a mission: a circle to wait on, a landing, or a return to home.
EndKind = Literal["loiter", "land", "rtl"]

Position = tuple[float, float, float]


@dataclass(frozen=True)
class FenceCircle:
    """A circle that an autopilot keeps out of, or in.

    Parameters
    ----------
    lat, lon : float
        Centre, WGS84 degrees.
    radius_m : float
        Radius.
    inclusion : bool
        Keep in rather than out.
    """

    lat: float
    lon: float
    radius_m: float
    inclusion: bool = False


@dataclass(frozen=True)
class FencePolygon:
    """A polygon that an autopilot keeps out of, or in.

    Parameters
    ----------
    corners : tuple of (float, float)
        Latitude and longitude of each corner, WGS84 degrees; three or more.
    inclusion : bool
        Keep in rather than out.
    """

    corners: tuple[tuple[float, float], ...]
    inclusion: bool = False


Fence = FenceCircle | FencePolygon


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
class Circling:
    """A circle to fly on, and the disc around it that is clear; in the terrain's frame.

    Parameters
    ----------
    x_m, y_m, z_m : float
        Centre, and the altitude.
    radius_m : float
        Radius that the autopilot is asked for.
    disc_m : float
        Radius of the disc, which is larger because an autopilot may fly wider.
    """

    x_m: float
    y_m: float
    z_m: float
    radius_m: float
    disc_m: float


@dataclass(frozen=True)
class End:
    """The end of a mission after its goal, to be drawn; in metres of the terrain's frame.

    Parameters
    ----------
    kind : str
        ``loiter``, ``land`` or ``rtl``.
    way : tuple of (float, float, float)
        Places and altitudes from the goal on, for a landing down to the touch-down.
    circle : Circling or None
        Where the mission waits, or where a landing loses its height; none of a return.
    go_around : tuple of (float, float, float)
        Places and altitudes of the climb after a missed approach, for a landing.
    go_around_circle : Circling or None
        The circle at the top of that climb.
    """

    kind: EndKind
    way: tuple[Position, ...] = ()
    circle: Circling | None = None
    go_around: tuple[Position, ...] = ()
    go_around_circle: Circling | None = None


@dataclass(frozen=True)
class FlightPlan:
    """Everything that an autopilot is told.

    Parameters
    ----------
    home : tuple of float
        Latitude, longitude and altitude of the ground below the start.
    items : tuple of Item
        The mission without home, from the start to its end.
    fence : tuple of Fence
        Fences to keep out of.
    rally : tuple of (float, float, float)
        Latitude, longitude and height above home of the places to return to: circles with room.
    cruise_speed_m_s : float
        Planned airspeed.
    notes : tuple of str
        A sentence about each fact that the autopilot is not told.
    feasible : bool or None
        The verdict on the path; None if there is none, as in the plans of ground stations.
    heights : str
        Datum of the altitudes if it is not mean sea level; otherwise empty.
    end : End or None
        The end of the mission after the goal; None if it is unknown, as in the plans of ground
        stations.
    """

    home: Position
    items: tuple[Item, ...]
    fence: tuple[Fence, ...]
    rally: tuple[Position, ...]
    cruise_speed_m_s: float
    notes: tuple[str, ...] = ()
    feasible: bool | None = None
    heights: str = ""
    end: End | None = None
