"""Rules by which ArduPlane and PX4 take items: which are refused, and how they are stored."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from pathgene.sim.autopilot.items import FENCE, FRAMES, MISSION, RALLY, Command, Frame, Item


__all__ = ["ARDUPLANE_RULES", "PX4_RULES", "Result", "Rules"]


class Result(IntEnum):
    """Values of MAV_MISSION_RESULT."""

    ACCEPTED = 0
    ERROR = 1
    UNSUPPORTED_FRAME = 2
    UNSUPPORTED = 3
    NO_SPACE = 4
    INVALID = 5
    INVALID_PARAM1 = 6
    INVALID_PARAM2 = 7
    INVALID_PARAM3 = 8
    INVALID_PARAM4 = 9
    INVALID_PARAM5_X = 10
    INVALID_PARAM6_Y = 11
    INVALID_PARAM7 = 12
    INVALID_SEQUENCE = 13
    DENIED = 14
    CANCELLED = 15


# Parameters, from 0, that ArduPilot takes as NaN, by commands; 84 and 85 take off and land
# vertically.
_NAN_IN: dict[int, set[int]] = {16: {3}, 21: {3}, 22: {3}, 84: {3}, 85: {2, 3}}
_FENCES = frozenset(range(Command.FENCE_RETURN_POINT, Command.FENCE_CIRCLE_OUT + 1))
_HIGHEST_M = 83_000.0
# Commands that either autopilot takes in a mission, beyond those that fly.
_DOES = frozenset({*range(84, 86), *range(112, 116), 93, *range(176, 255), *range(2000, 2006)})
# Commands that PX4 refuses in a mission.
_NOT_PX4 = frozenset({Command.LOITER_TURNS, Command.CONTINUE_AND_CHANGE_ALT})


@dataclass(frozen=True)
class Rules:
    """The protocol of lists of an autopilot.

    Parameters
    ----------
    in_place : frozenset of int
        Kinds of lists whose items replace earlier ones as they arrive. A list of another kind is
        replaced when its last item has arrived.
    most_items : mapping
        Maximum number of items by kind.
    retry_s, timeout_s : float
        Seconds after which an item is asked for again, and after which an upload is given up.
    asks_for_integers : bool
        Whether items are asked for by MISSION_REQUEST_INT rather than MISSION_REQUEST.
    complains_of_sequence : bool
        Whether an item other than the one asked for is answered by INVALID_SEQUENCE.
    is_ardupilot : bool
        Chooses the rules for items, and those for clearing and for a busy list.
    """

    in_place: frozenset[int]
    most_items: Mapping[int, int]
    retry_s: float
    timeout_s: float
    asks_for_integers: bool
    complains_of_sequence: bool
    is_ardupilot: bool

    def judge(self, item: Item, kind: int) -> Result:
        """Return the result for an item that arrives."""
        if self.is_ardupilot:
            return _judge_ardupilot(item, kind)
        return _judge_px4(item, kind)

    def kept(self, item: Item, kind: int) -> Item:
        """Return an item as the autopilot stores it."""
        return _kept_ardupilot(item, kind) if self.is_ardupilot else item


#: ArduPlane 4.6 on a board with 16 kB of storage: 724 items, 84 corners, 50 rally points.
ARDUPLANE_RULES = Rules(
    in_place=frozenset({MISSION, RALLY}),
    most_items={MISSION: 724, FENCE: 84, RALLY: 50},
    retry_s=1.0,
    timeout_s=8.0,
    asks_for_integers=False,
    complains_of_sequence=True,
    is_ardupilot=True,
)

#: PX4 1.15.
PX4_RULES = Rules(
    in_place=frozenset(),
    most_items={MISSION: 2000, FENCE: 64, RALLY: 32},
    retry_s=0.25,
    timeout_s=5.0,
    asks_for_integers=True,
    complains_of_sequence=False,
    is_ardupilot=False,
)


def _judge_ardupilot(item: Item, kind: int) -> Result:
    if kind == FENCE:
        if FRAMES.get(item.frame, Frame.NONE) == Frame.NONE:
            return Result.UNSUPPORTED_FRAME
        return Result.ACCEPTED if item.command in _FENCES else Result.UNSUPPORTED
    if kind == RALLY:
        return _judge_rally(item)
    allowed = _NAN_IN.get(item.command, set())
    for number, value in enumerate(item.params):
        if math.isinf(value) or (math.isnan(value) and number not in allowed):
            return Result(Result.INVALID_PARAM1 + number)
    return _judge_place(item)


def _judge_rally(item: Item) -> Result:
    """Return the result for a rally point, whose height ArduPilot keeps in two bytes."""
    if item.command != Command.RALLY_POINT:
        return Result.UNSUPPORTED
    if abs(item.x) > 90 * 10_000_000:
        return Result.INVALID_PARAM5_X
    if abs(item.y) > 180 * 10_000_000:
        return Result.INVALID_PARAM6_Y
    return Result.ACCEPTED if -32768 <= item.z <= 32767 else Result.INVALID_PARAM7


def _judge_place(item: Item) -> Result:
    """Return the result for the command, the frame and the place of an item of a mission."""
    if not (item.navigates or item.command in _DOES):
        return Result.UNSUPPORTED
    if item.frame not in FRAMES:
        return Result.UNSUPPORTED_FRAME
    if abs(item.x) > 90 * 10_000_000:
        return Result.INVALID_PARAM5_X
    if abs(item.y) > 180 * 10_000_000:
        return Result.INVALID_PARAM6_Y
    if not abs(item.z) <= _HIGHEST_M:
        return Result.INVALID_PARAM7
    return Result.ACCEPTED


def _judge_px4(item: Item, kind: int) -> Result:
    if kind == FENCE:
        return Result.ACCEPTED if item.command in _FENCES else Result.UNSUPPORTED
    if kind == RALLY:
        known = item.command == Command.RALLY_POINT
        return Result.ACCEPTED if known else Result.UNSUPPORTED
    if item.command in _NOT_PX4:
        return Result.UNSUPPORTED
    result = _judge_place(item)
    if result == Result.ACCEPTED and FRAMES[item.frame] == Frame.TERRAIN:
        return Result.UNSUPPORTED_FRAME
    return result


def _kept_ardupilot(item: Item, kind: int) -> Item:
    """Return an item with whole centimetres, whole metres of radius and no heading."""
    if kind == FENCE:
        return replace(item, params=(item.params[0], 0.0, 0.0, 0.0), z=0.0)
    if kind == RALLY:
        return replace(item, params=(0.0, 0.0, 0.0, 0.0), z=float(int(item.z)))
    # In single precision, so that a height that is read and written back may lose a centimetre.
    z = float(np.float32(int(np.float32(item.z) * np.float32(100))) * np.float32(0.01))
    first, second, third, fourth = item.params
    match item.command:
        case Command.WAYPOINT:
            # Acceptance radius and distance to pass by are bytes; the delay is not used.
            params = (0.0, _byte(second), _byte(third), 0.0)
        case Command.LOITER:
            params = (0.0, 0.0, float(int(third)), 0.0)
        case Command.LOITER_TO_ALT:
            params = (0.0, float(int(second)), 0.0, float(fourth > 0))
        case Command.LAND:
            # The sign of the heading is kept, and nothing else.
            params = (float(int(first)), 0.0, 0.0, -1.0 if fourth < 0 else 1.0)
        case Command.TAKEOFF:
            params = (first, 0.0, 0.0, 0.0)
        case _:
            params = item.params
    return replace(item, params=params, z=z, autocontinue=1)


def _byte(value: float) -> float:
    return float(min(max(int(value), 0), 255))
