"""Upload of a mission, its fence and its rally points: all of them, or the earlier ones stay.

ArduPilot writes each item of a mission as it arrives, so an upload that fails leaves the first
items of the new mission before the last items of the old one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np

from pathgene.host.errors import JobError
from pathgene.host.formats.flight_plan import (
    CHANGE_SPEED,
    WAYPOINT,
    FenceCircle,
    FlightPlan,
    Item,
)
from pathgene.host.mission.autopilot.fence_room import no_room
from pathgene.host.mission.autopilot.flight_state import Mission, begin_at, flies_mission
from pathgene.host.mission.autopilot.mavlink_link import Link
from pathgene.host.mission.autopilot.mission_lists import (
    ARDUPILOT,
    DEGREES,
    FENCE,
    MISSION,
    NAMES,
    PX4,
    RALLY,
    ListError,
    WireItem,
    cancel,
    holds,
    read,
    transfer,
)


__all__ = ["AUTOPILOTS", "Uploaded", "upload"]

#: Values of MAV_AUTOPILOT by the names that users give.
AUTOPILOTS = {"ardupilot": ARDUPILOT, "px4": PX4}

# Parameters, counted from 1, in which ArduPilot accepts NaN, by command: waypoint, landing and
# take-off, vertical take-off and landing. It refuses NaN everywhere else.
_NAN_IN = {16: (4,), 21: (4,), 22: (4,), 84: (4,), 85: (3, 4)}
# MAV_CMD_NAV_RALLY_POINT, and MAV_FRAME_GLOBAL_RELATIVE_ALT, as every ArduPilot takes its height.
_RALLY_POINT, _OVER_HOME = 5100, 3
# Attempts to restore a list; a late answer to the failed upload can spoil the first attempt.
_ATTEMPTS = 2


class _State(Enum):
    """Content of a list of the autopilot after a failed upload."""

    EARLIER = auto()
    NEW = auto()
    CLEARED = auto()
    UNKNOWN = auto()


@dataclass(frozen=True)
class Uploaded:
    """Lists that an autopilot has confirmed and returned unchanged.

    Parameters
    ----------
    mission_items, fence_items : int
        Numbers of items, ArduPilot's home included.
    rally_points : int or None
        Number of rally points; None if the autopilot has no such list.
    mission : Mission
        The mission as it will be flown.
    """

    system: int
    autopilot: int
    mission_items: int
    fence_items: int
    rally_points: int | None
    mission: Mission

    @property
    def autopilot_name(self) -> str:
        """Its kind in words."""
        names = {value: name for name, value in AUTOPILOTS.items()}
        return names.get(self.autopilot, f"autopilot of kind {self.autopilot}")


def upload(
    plan: FlightPlan,
    link: Link,
    *,
    autopilot: int | None = None,
    fence_corners: int | None = None,
) -> Uploaded:
    """Upload the fence, the rally points and the mission; read all back and compare.

    An upload replaces these lists of the autopilot, so a plan without fences clears the fence of an
    earlier one. All are read first. After a failure or an interruption, they are restored; on the
    ground, a list that cannot be restored is cleared. A new mission begins with its first item.

    Parameters
    ----------
    link : Link
        Connection on which the autopilot has been found.
    autopilot : int, optional
        Its kind; by default the kind in its heartbeat. ArduPilot takes item 0 as home.
    fence_corners : int, optional
        Corners and circles for which it has room; by default those that its kind usually has.

    Raises
    ------
    JobError
        If the aircraft flies its mission, or if the autopilot has no room for the fence, refuses an
        item, falls silent, or returns a different list, or if the upload is interrupted. The
        sentence says which lists the autopilot holds.
    """
    kind = link.autopilot if autopilot is None else autopilot
    too_large = no_room(plan.fence, kind, fence_corners)
    if too_large is not None:
        raise JobError(f"{too_large.removesuffix('.')}; nothing is uploaded.")
    if flies_mission(link, kind):
        raise JobError(
            "The aircraft flies its mission, and an upload would change it under way, so nothing "
            "is uploaded; land first, or let the aircraft circle in another mode."
        )
    link.texts.clear()
    lists = {FENCE: _fence(plan, kind), RALLY: _rally(plan), MISSION: _mission(plan, kind)}
    read_before = {mission_type: _earlier(link, mission_type) for mission_type in lists}
    has_rally = read_before[RALLY] is not None
    if not has_rally:
        del lists[RALLY], read_before[RALLY]
    earlier = {mission_type: items or [] for mission_type, items in read_before.items()}
    states = dict.fromkeys(lists, _State.EARLIER)
    try:
        for _ in range(_ATTEMPTS):
            for mission_type, items in lists.items():
                if flies_mission(link, kind):
                    raise ListError("The aircraft has begun its mission during the upload")
                states[mission_type] = _State.UNKNOWN
                transfer(link, mission_type, items, kind)
                states[mission_type] = _State.NEW
            mission = _begun(link, lists[MISSION], kind)
            # An autopilot that restarts may lose a list that it has confirmed.
            if all(holds(link, each, items, kind) for each, items in lists.items()):
                break
        else:
            raise ListError("The autopilot loses lists that it has confirmed")
    except (ListError, OSError, KeyboardInterrupt) as error:
        is_silent = _recover(link, states, earlier, kind)
        held = _held(states, lists, earlier, link, is_silent=is_silent)
        raise JobError(f"{_reason(error)}; {held}.") from None
    return Uploaded(
        link.system,
        kind,
        len(lists[MISSION]),
        len(lists[FENCE]),
        len(lists[RALLY]) if has_rally else None,
        mission,
    )


def _begun(link: Link, items: Sequence[WireItem], autopilot: int) -> Mission:
    """Let a new mission begin with its first item."""
    first = 1 if autopilot == ARDUPILOT else 0
    flown = (number for number, item in enumerate(items) if item.command != CHANGE_SPEED)
    return begin_at(link, first, next((n for n in flown if n >= first), first), autopilot)


def _earlier(link: Link, mission_type: int) -> list[WireItem] | None:
    """Return a list that the autopilot holds before the upload, None if it has no such lists."""
    try:
        return read(link, mission_type)
    except ListError as error:
        raise JobError(
            f"The autopilot holds a {NAMES[mission_type]} that could not be restored, because "
            f"{error.reason}; nothing is uploaded, check the link or clear the "
            f"{NAMES[mission_type]} there, and upload again."
        ) from None


def _recover(
    link: Link,
    states: dict[int, _State],
    earlier: Mapping[int, Sequence[WireItem]],
    autopilot: int,
) -> bool:
    """Restore the lists that have changed, the last one first; return True if it fell silent."""
    begun = [each for each, state in states.items() if state is not _State.EARLIER]
    try:
        cancel(link, begun)
        for mission_type in reversed(states):
            items = earlier[mission_type]
            if mission_type in begun or not holds(link, mission_type, items, autopilot):
                states[mission_type] = _State.UNKNOWN
                states[mission_type] = _restored(link, mission_type, items, autopilot)
        # It may have restarted meanwhile.
        for mission_type, state in states.items():
            items = earlier[mission_type] if state is _State.EARLIER else ()
            if state is not _State.UNKNOWN and not holds(link, mission_type, items, autopilot):
                states[mission_type] = _State.UNKNOWN
    except (ListError, _SilentError, OSError, KeyboardInterrupt):
        return True  # The remaining lists stay as they are.
    return False


class _SilentError(Exception):
    """The autopilot does not answer, so nothing can be restored."""


def _restored(link: Link, mission_type: int, items: Sequence[WireItem], autopilot: int) -> _State:
    """Restore an earlier list or, if that fails on the ground, clear it."""
    attempts = [items] * _ATTEMPTS
    if not link.armed:
        attempts.append(())
    for attempt in attempts:
        try:
            transfer(link, mission_type, attempt, autopilot)
        except ListError as error:
            if error.silent:
                raise _SilentError from None
            cancel(link, (mission_type,))
        else:
            return _State.EARLIER if attempt is items else _State.CLEARED
    return _State.UNKNOWN


def _reason(error: BaseException) -> str:
    """Return why an upload failed, as the beginning of a sentence."""
    if isinstance(error, ListError):
        return error.reason
    if isinstance(error, OSError):
        return f"The connection to the autopilot broke ({error.strerror or error})"
    return "The upload is interrupted"


def _held(
    states: Mapping[int, _State],
    lists: Mapping[int, Sequence[WireItem]],
    earlier: Mapping[int, Sequence[WireItem]],
    link: Link,
    *,
    is_silent: bool,
) -> str:
    """Return which lists an autopilot holds, and a remedy: the end of a sentence."""
    texts = []
    for mission_type in sorted(states):
        name = NAMES[mission_type]
        texts.append(
            {
                _State.EARLIER: f"its earlier {name} ({len(earlier[mission_type])} items)",
                _State.NEW: f"the new {name} ({len(lists[mission_type])} items)",
                _State.CLEARED: f"no {name}, because the earlier one could not be restored",
                _State.UNKNOWN: f"an unknown {name}, perhaps parts of the old and the new one",
            }[states[mission_type]]
        )
    remedy = (
        "upload again"
        if _State.UNKNOWN not in states.values()
        else "do not start the mission before an upload succeeds"
        if link.armed
        else "do not fly before an upload succeeds"
    )
    *some, last = texts
    when = "held, when it last answered," if is_silent else "now holds"
    return f"the autopilot {when} {', '.join(some)}, and {last}; {remedy}"


def _mission(plan: FlightPlan, autopilot: int) -> list[WireItem]:
    home = Item(WAYPOINT, (0.0, 0.0, 0.0, None), *plan.home)
    items = (home, *plan.items) if autopilot == ARDUPILOT else plan.items
    made = [
        _wire(item.command, item.params, item.lat, item.lon, item.alt_m, autopilot)
        for item in items
    ]
    # PX4 continues with the item that is marked, or with the number of the item under way.
    return [replace(made[0], current=1), *made[1:]] if autopilot == PX4 and made else made


def _rally(plan: FlightPlan) -> list[WireItem]:
    """Return the rally points as items; ArduPilot keeps their heights in whole metres."""
    return [
        WireItem(
            _RALLY_POINT,
            _OVER_HOME,
            (0.0, 0.0, 0.0, 0.0),
            round(lat * DEGREES),
            round(lon * DEGREES),
            float(math.ceil(height_m)),
        )
        for lat, lon, height_m in plan.rally
    ]


def _fence(plan: FlightPlan, autopilot: int) -> list[WireItem]:
    """Return the fences as items: one for a circle, and one for each corner of a polygon."""
    items = []
    for fence in plan.fence:
        if isinstance(fence, FenceCircle):
            command, places, first = 5004, [(fence.lat, fence.lon)], fence.radius_m
        else:
            command, places, first = 5002, list(fence.corners), float(len(fence.corners))
        command -= fence.inclusion
        items += [
            _wire(command, (first, 0.0, 0.0, 0.0), lat, lon, 0.0, autopilot) for lat, lon in places
        ]
    return items


def _wire(
    command: int,
    params: Sequence[float | None],
    lat: float,
    lon: float,
    alt_m: float,
    autopilot: int,
) -> WireItem:
    """Return an item as MAVLink carries it, with NaN only if the autopilot accepts it."""
    first, second, third, fourth = (
        _single(param)
        if param is not None
        else math.nan
        if autopilot != ARDUPILOT or number in _NAN_IN.get(command, ())
        else 0.0
        for number, param in enumerate(params, start=1)
    )
    x, y = round(lat * DEGREES), round(lon * DEGREES)
    return WireItem(command, 0, (first, second, third, fourth), x, y, _single(alt_m))


def _single(value: float) -> float:
    return float(np.float32(value))
