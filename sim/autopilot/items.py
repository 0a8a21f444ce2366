"""Items of missions, fences and rally points, and the commands of MAVLink that they carry."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Any


__all__ = [
    "DEGREES",
    "FENCE",
    "FRAMES",
    "MISSION",
    "NAVIGATES",
    "RALLY",
    "Command",
    "Frame",
    "Item",
    "has_place",
]

#: Kinds of lists, values of MAV_MISSION_TYPE.
MISSION, FENCE, RALLY = 0, 1, 2
#: Units of a degree in the places of items.
DEGREES = 1e7


class Command(IntEnum):
    """Values of MAV_CMD that occur in lists or are sent alone."""

    WAYPOINT = 16
    LOITER = 17
    LOITER_TURNS = 18
    LOITER_TIME = 19
    RTL = 20
    LAND = 21
    TAKEOFF = 22
    CONTINUE_AND_CHANGE_ALT = 30
    LOITER_TO_ALT = 31
    DELAY = 93
    DO_JUMP = 177
    DO_CHANGE_SPEED = 178
    DO_SET_HOME = 179
    DO_RETURN_PATH_START = 188
    DO_LAND_START = 189
    DO_GO_AROUND = 191
    DO_REPOSITION = 192
    DO_FENCE_ENABLE = 207
    DO_SET_MISSION_CURRENT = 224
    MISSION_START = 300
    ARM_DISARM = 400
    REQUEST_MESSAGE = 512
    DO_SET_MODE = 176
    FENCE_RETURN_POINT = 5000
    FENCE_POLYGON_IN = 5001
    FENCE_POLYGON_OUT = 5002
    FENCE_CIRCLE_IN = 5003
    FENCE_CIRCLE_OUT = 5004
    RALLY_POINT = 5100


#: Commands that fly somewhere; a mission does one at a time.
NAVIGATES = frozenset(
    {
        *(Command.WAYPOINT, Command.LOITER, Command.LOITER_TURNS, Command.LOITER_TIME),
        *(Command.RTL, Command.LAND, Command.TAKEOFF, Command.CONTINUE_AND_CHANGE_ALT),
        *(Command.LOITER_TO_ALT, Command.DELAY),
    }
)


class Frame(IntEnum):
    """Meanings of an item's altitude."""

    AMSL = 0
    NONE = 2
    HOME = 3
    TERRAIN = 10


#: Frames of MAVLink by their values; the newer values mean the same.
FRAMES = {
    0: Frame.AMSL,
    5: Frame.AMSL,
    2: Frame.NONE,
    3: Frame.HOME,
    6: Frame.HOME,
    10: Frame.TERRAIN,
    11: Frame.TERRAIN,
}


@dataclass(frozen=True)
class Item:
    """An item as MAVLink carries it.

    Parameters
    ----------
    params : tuple of float
        Parameters 1 to 4; NaN leaves a choice to the autopilot.
    x, y : int
        Latitude and longitude, 1e-7 degrees.
    z : float
        Altitude, metres, in the frame ``frame``, a value of MAV_FRAME.
    """

    command: int
    frame: int
    params: tuple[float, float, float, float]
    x: int
    y: int
    z: float
    autocontinue: int = 1

    @classmethod
    def of(cls, message: Any) -> Item:
        """Return the item of a message MISSION_ITEM_INT or MISSION_ITEM."""
        is_float = message.get_type() == "MISSION_ITEM"
        scale = DEGREES if is_float else 1
        return cls(
            message.command,
            message.frame,
            (message.param1, message.param2, message.param3, message.param4),
            round(message.x * scale),
            round(message.y * scale),
            message.z,
            message.autocontinue,
        )

    @property
    def lat(self) -> float:
        """Latitude, degrees."""
        return self.x / DEGREES

    @property
    def lon(self) -> float:
        """Longitude, degrees."""
        return self.y / DEGREES

    @property
    def navigates(self) -> bool:
        """True if the mission waits until this item is done."""
        return self.command in NAVIGATES


def has_place(item: Item) -> bool:
    """Return whether an item names a place; latitude and longitude 0 mean the present one."""
    return (item.x, item.y) != (0, 0) and math.isfinite(item.z)
