"""Upload of a mission and its fence: the autopilot gets both in full, or keeps the earlier ones.

ArduPilot writes each item of a mission as it arrives, so an upload that fails leaves the first
items of the new mission before the last items of the old one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from pathgene.host.errors import JobError
from pathgene.host.formats.flight_plan import WAYPOINT, FenceCircle, FlightPlan, Item
from pathgene.host.mission.autopilot.fence_room import no_room
from pathgene.host.mission.autopilot.mavlink_link import Link
from pathgene.host.mission.autopilot.mission_lists import (
    ARDUPILOT,
    DEGREES,
    FENCE,
    MISSION,
    NAMES,
    PX4,
    ListError,
    WireItem,
    cancel,
    read,
    transfer,
)


__all__ = ["AUTOPILOTS", "Uploaded", "upload"]

#: Values of MAV_AUTOPILOT by the names that users give.
AUTOPILOTS = {"ardupilot": ARDUPILOT, "px4": PX4}

# Parameters, counted from 1, in which ArduPilot accepts NaN, by command: waypoint, landing and
# take-off, vertical take-off and landing. It refuses NaN everywhere else.
_NAN_IN = {16: (4,), 21: (4,), 22: (4,), 84: (4,), 85: (3, 4)}
# Attempts to restore a list; a late answer to the failed upload can spoil the first attempt.
_ATTEMPTS = 2


class _State(Enum):
    """Content of a list of the autopilot after a failed upload."""

    EARLIER = auto()
    CLEARED = auto()
    UNKNOWN = auto()


@dataclass(frozen=True)
class Uploaded:
    """Mission and fence that an autopilot has confirmed and returned unchanged.

    Parameters
    ----------
    mission_items, fence_items : int
        Numbers of items, ArduPilot's home included.
    """

    system: int
    autopilot: int
    mission_items: int
    fence_items: int

    @property
    def autopilot_name(self) -> str:
        """Its kind in words."""
        names = {value: name for name, value in AUTOPILOTS.items()}
        return names.get(self.autopilot, f"autopilot of kind {self.autopilot}")


def upload(plan: FlightPlan, link: Link, *, autopilot: int | None = None) -> Uploaded:
    """Upload the fence, then the mission; read both back and compare.

    An upload replaces the mission and the fence of the autopilot, so a plan without fences clears
    the fence of an earlier one. Both are read first. After a failure or an interruption, they are
    restored; on the ground, a list that cannot be restored is cleared.

    Parameters
    ----------
    link : Link
        Connection on which the autopilot has been found.
    autopilot : int, optional
        Its kind; by default the kind in its heartbeat. ArduPilot takes item 0 as home.

    Raises
    ------
    JobError
        If the autopilot has no room for the fence, refuses an item, falls silent, or returns a
        different list, or if the upload is interrupted. The sentence says which mission and fence
        the autopilot holds.
    """
    kind = link.autopilot if autopilot is None else autopilot
    too_large = no_room(plan.fence, kind)
    if too_large is not None:
        raise JobError(f"{too_large.removesuffix('.')}; nothing is uploaded.")
    lists = {FENCE: _fence(plan, kind), MISSION: _mission(plan, kind)}
    earlier = {mission_type: _earlier(link, mission_type) for mission_type in lists}
    begun: list[int] = []
    try:
        for mission_type, items in lists.items():
            begun.append(mission_type)
            transfer(link, mission_type, items, kind)
    except (ListError, OSError, KeyboardInterrupt) as error:
        states = _recovered(link, begun, earlier, kind)
        raise JobError(f"{_reason(error)}; {_held(states, earlier)}.") from None
    return Uploaded(link.system, kind, len(lists[MISSION]), len(lists[FENCE]))


def _earlier(link: Link, mission_type: int) -> list[WireItem]:
    """Return a list that the autopilot holds before the upload."""
    try:
        return read(link, mission_type)
    except ListError as error:
        raise JobError(
            f"The autopilot holds a {NAMES[mission_type]} that could not be restored, because "
            f"{error.reason}; nothing is uploaded, check the link or clear the "
            f"{NAMES[mission_type]} there, and upload again."
        ) from None


def _recovered(
    link: Link, begun: Sequence[int], earlier: Mapping[int, Sequence[WireItem]], autopilot: int
) -> dict[int, _State]:
    """Restore the lists that the upload has begun to replace, the last one first."""
    states = dict.fromkeys(earlier, _State.EARLIER)
    states |= dict.fromkeys(begun, _State.UNKNOWN)
    try:
        cancel(link, begun)
        for mission_type in reversed(begun):
            states[mission_type] = _restored(link, mission_type, earlier[mission_type], autopilot)
    except (_SilentError, OSError, KeyboardInterrupt):
        pass  # The remaining lists stay unknown.
    return states


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


def _held(states: Mapping[int, _State], earlier: Mapping[int, Sequence[WireItem]]) -> str:
    """Return which mission and fence an autopilot holds, and a remedy: the end of a sentence."""
    texts = []
    for mission_type in (MISSION, FENCE):
        name = NAMES[mission_type]
        texts.append(
            {
                _State.EARLIER: f"its earlier {name} ({len(earlier[mission_type])} items)",
                _State.CLEARED: f"no {name}, because the earlier one could not be restored",
                _State.UNKNOWN: f"an unknown {name}, perhaps parts of the old and the new one",
            }[states[mission_type]]
        )
    remedy = (
        "do not fly before an upload succeeds"
        if _State.UNKNOWN in states.values()
        else "upload again"
    )
    return f"the autopilot now holds {texts[0]}, and {texts[1]}; {remedy}"


def _mission(plan: FlightPlan, autopilot: int) -> list[WireItem]:
    home = Item(WAYPOINT, (0.0, 0.0, 0.0, None), *plan.home)
    items = (home, *plan.items) if autopilot == ARDUPILOT else plan.items
    return [
        _wire(item.command, item.params, item.lat, item.lon, item.alt_m, autopilot)
        for item in items
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
