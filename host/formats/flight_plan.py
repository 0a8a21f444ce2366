"""A path as an autopilot reads it: items, fences, home and rally point, in degrees and AMSL."""

from __future__ import annotations

from dataclasses import dataclass


__all__ = [
    "CHANGE_SPEED",
    "LOITER",
    "WAYPOINT",
    "Fence",
    "FenceCircle",
    "FencePolygon",
    "FlightPlan",
    "Item",
]

#: MAV_CMD_NAV_WAYPOINT, MAV_CMD_NAV_LOITER_UNLIM and MAV_CMD_DO_CHANGE_SPEED.
WAYPOINT, LOITER, CHANGE_SPEED = 16, 17, 178

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
class FlightPlan:
    """Everything that an autopilot is told.

    Parameters
    ----------
    home : tuple of float
        Latitude, longitude and altitude of the ground below the start.
    items : tuple of Item
        The mission without home, from the start to a loiter over the goal.
    fence : tuple of Fence
        Fences to keep out of.
    rally : tuple of (float, float, float)
        Latitude, longitude and height above home of the places to return to: the start.
    cruise_speed_m_s : float
        Planned airspeed.
    notes : tuple of str
        A sentence about each fact that the autopilot is not told.
    feasible : bool or None
        The verdict on the path; None if there is none, as in the plans of ground stations.
    heights : str
        Datum of the altitudes if it is not mean sea level; otherwise empty.
    """

    home: Position
    items: tuple[Item, ...]
    fence: tuple[Fence, ...]
    rally: tuple[Position, ...]
    cruise_speed_m_s: float
    notes: tuple[str, ...] = ()
    feasible: bool | None = None
    heights: str = ""
