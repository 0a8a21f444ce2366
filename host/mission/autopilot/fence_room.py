"""The room that autopilots have for fences."""

from __future__ import annotations

from collections.abc import Sequence

from pathgene.host.formats.flight_plan import Fence, FenceCircle
from pathgene.host.mission.autopilot.mission_lists import ARDUPILOT, PX4


__all__ = ["fence_notes", "no_room"]

# ArduPilot on a board with 16 kB of storage: bytes for fences, of which the list itself, a polygon,
# a corner and a circle take some.
_BYTES, _LIST, _POLYGON, _CORNER, _CIRCLE = 672, 4, 2, 8, 13
# Corners and circles together that PX4 keeps, and that ArduPilot accepts in a count.
_PX4_ITEMS, _ARDUPILOT_ITEMS = 64, 84
_REMEDY = "leave out zones that the path does not reach, or give them fewer corners"


def no_room(fence: Sequence[Fence], autopilot: int) -> str | None:
    """Return why an autopilot has no room for fences, a sentence, or None if it has.

    Parameters
    ----------
    autopilot : int
        Value of MAV_AUTOPILOT.
    """
    corners = sum(0 if isinstance(each, FenceCircle) else len(each.corners) for each in fence)
    circles = sum(isinstance(each, FenceCircle) for each in fence)
    items = corners + circles
    polygons = len(fence) - circles
    size = f"The fence has {corners} corners of polygons and {circles} circles"
    if autopilot == PX4 and items > _PX4_ITEMS:
        return f"{size}, but PX4 keeps {_PX4_ITEMS} corners and circles in all; {_REMEDY}."
    needed = _LIST + _POLYGON * polygons + _CORNER * corners + _CIRCLE * circles
    if autopilot == ARDUPILOT and (needed > _BYTES or items > _ARDUPILOT_ITEMS):
        return (
            f"{size}, which need {needed} bytes, but ArduPilot keeps {_BYTES} bytes of fences, 83 "
            f"corners of one polygon; {_REMEDY}."
        )
    return None


def fence_notes(fence: Sequence[Fence]) -> tuple[str, ...]:
    """Return a sentence for each autopilot that has no room for fences."""
    return tuple(note for kind in (ARDUPILOT, PX4) if (note := no_room(fence, kind)) is not None)
