"""Missions as files state them: items of MAVLink with their numbers, home and rally points.

A reader of a format turns its file into a :class:`MissionFile` and knows no terrain: heights stay
in the frames of the items. It raises InputError for a file from which no mission can be read.
"""

from __future__ import annotations

from dataclasses import dataclass

from pathgene.host.remarks import Remark


__all__ = [
    "AMSL",
    "ARDUPILOT",
    "PX4",
    "TERRAIN",
    "Entry",
    "Home",
    "MissionFile",
    "MissionItem",
    "line_file",
]

#: Values of MAV_FRAME for altitudes above mean sea level and heights above the ground.
AMSL, TERRAIN = 0, 10
#: Autopilots that missions are made for.
ARDUPILOT, PX4 = "ArduPilot", "PX4"

_WAYPOINT = 16

#: Latitude, longitude and altitude; None for an altitude that the file does not state.
Home = tuple[float, float, float | None]


@dataclass(frozen=True)
class MissionItem:
    """An item of a mission.

    Parameters
    ----------
    number : int
        Its number in the file.
    command : int
        Value of MAV_CMD.
    frame : int
        Value of MAV_FRAME.
    params : tuple of (float or None)
        Parameters 1 to 4; None leaves one to the autopilot.
    lat, lon : float, optional
        WGS84 degrees; None for an item without a place.
    alt_m : float, optional
        Altitude or height in the frame.
    within : str
        Complex item that it belongs to, such as ``survey``; empty for a simple item.
    """

    number: int
    command: int
    frame: int
    params: tuple[float | None, float | None, float | None, float | None]
    lat: float | None
    lon: float | None
    alt_m: float | None
    within: str = ""


@dataclass(frozen=True)
class MissionFile:
    """A mission of a file.

    Parameters
    ----------
    kind : str
        Kind of the file, such as ``a .plan of QGroundControl``.
    items : tuple of MissionItem
        Its items without home, in the order of the file; one or more.
    home : tuple, optional
        Place of home; None if the file has none.
    rally : tuple of (float, float, float)
        Latitude, longitude and height above home of places to return to.
    autopilot : str
        Autopilot that the mission is made for; empty for any.
    has_fences : bool
        The file has fences, which a reader of zones finds.
    word : str
        Word for an item in sentences: ``item``, or ``point`` in a file of a line.
    remarks : tuple of Remark
        Sentences on the file.
    """

    kind: str
    items: tuple[MissionItem, ...]
    home: Home | None = None
    rally: tuple[tuple[float, float, float], ...] = ()
    autopilot: str = ""
    has_fences: bool = False
    word: str = "item"
    remarks: tuple[Remark, ...] = ()


@dataclass(frozen=True)
class Entry:
    """An item of a changed mission.

    Parameters
    ----------
    item : MissionItem
        The item as it is to be written.
    place : int, optional
        Index of its original among the items of the file; None for a new item.
    """

    item: MissionItem
    place: int | None = None


def line_file(
    kind: str,
    points: list[tuple[float, float, float]],
    frame: int,
    remarks: tuple[Remark, ...] = (),
    first: int = 1,
) -> MissionFile:
    """Return the points of a line, latitude, longitude and height each, as waypoints.

    Parameters
    ----------
    first : int
        Number of the first point.
    """
    items = tuple(
        MissionItem(number, _WAYPOINT, frame, (0.0, 0.0, 0.0, None), *point)
        for number, point in enumerate(points, start=first)
    )
    return MissionFile(kind, items, word="point", remarks=remarks)
