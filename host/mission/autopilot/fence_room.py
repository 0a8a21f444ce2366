"""The room that autopilots have for fences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pathgene.host.formats.flight_plan import Fence, FenceCircle
from pathgene.host.mission.autopilot.mission_lists import ARDUPILOT, PX4


__all__ = ["MOST_CORNERS", "Room", "fence_notes", "no_room", "room_of"]

# ArduPilot on a board with 16 kB of storage: bytes for fences, of which the list itself, a polygon,
# a corner and a circle take some.
_BYTES, _LIST, _POLYGON, _CORNER, _CIRCLE = 672, 4, 2, 8, 13
# Corners and circles together that PX4 keeps, and that ArduPilot accepts in a count.
_PX4_ITEMS, _ARDUPILOT_ITEMS = 64, 84
_REMEDY = "leave out zones that the path does not reach, or give them fewer corners"
#: Maximum number of corners and circles: the count of a list is 16 bits.
MOST_CORNERS = 65_535


@dataclass(frozen=True)
class Room:
    """Room for fences.

    Parameters
    ----------
    items : int
        Corners of polygons and circles together.
    size : int or None
        Bytes, counted as ArduPilot does; None without a limit.
    """

    items: int
    size: int | None = None

    def has(self, corners: int, polygons: int, circles: int) -> bool:
        """Return whether polygons with corners in all, and circles, have room."""
        needed = _bytes(corners, polygons, circles)
        return corners + circles <= self.items and (self.size is None or needed <= self.size)


def room_of(autopilot: int | None = None, corners: int | None = None) -> Room:
    """Return the room for fences of an autopilot.

    Parameters
    ----------
    autopilot : int, optional
        Value of MAV_AUTOPILOT; of an unknown one, the room that both ArduPilot and PX4 have.
    corners : int, optional
        Corners and circles, if a user gives them. More than ArduPilot has on a board with 16 kB of
        storage need a larger board, so the bytes do not count.
    """
    if corners is not None:
        return Room(corners, _BYTES if corners <= _ARDUPILOT_ITEMS else None)
    if autopilot == ARDUPILOT:
        return Room(_ARDUPILOT_ITEMS, _BYTES)
    return Room(_PX4_ITEMS, None if autopilot == PX4 else _BYTES)


def no_room(fence: Sequence[Fence], autopilot: int, corners: int | None = None) -> str | None:
    """Return why an autopilot has no room for fences, a sentence, or None if it has.

    Parameters
    ----------
    autopilot : int
        Value of MAV_AUTOPILOT.
    corners : int, optional
        Corners and circles for which it has room, if a user says so.
    """
    used = sum(0 if isinstance(each, FenceCircle) else len(each.corners) for each in fence)
    circles = sum(isinstance(each, FenceCircle) for each in fence)
    polygons = len(fence) - circles
    size = f"The fence has {used} corners of polygons and {circles} circles"
    if autopilot not in (ARDUPILOT, PX4) or room_of(autopilot, corners).has(
        used, polygons, circles
    ):
        return None
    if corners is not None:
        return f"{size}, more than --fence-corners {corners} has room for; {_REMEDY}."
    if autopilot == PX4:
        return f"{size}, but PX4 keeps {_PX4_ITEMS} corners and circles in all; {_REMEDY}."
    return (
        f"{size}, which need {_bytes(used, polygons, circles)} bytes, but ArduPilot keeps {_BYTES} "
        f"bytes of fences, 83 corners of one polygon; {_REMEDY}."
    )


def fence_notes(fence: Sequence[Fence], autopilot: int | None = None) -> tuple[str, ...]:
    """Return a sentence for each autopilot that has no room for fences; of one that is known, none.

    An upload to that one is refused in words of its own.
    """
    if autopilot is not None:
        return ()
    return tuple(note for kind in (ARDUPILOT, PX4) if (note := no_room(fence, kind)) is not None)


def _bytes(corners: int, polygons: int, circles: int) -> int:
    return _LIST + _POLYGON * polygons + _CORNER * corners + _CIRCLE * circles
