"""Upload of a mission and its fence by the mission protocol of MAVLink, read back and compared.

The protocol is that of https://mavlink.io/en/services/mission.html.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from host.errors import JobError
from host.mission.files.fence import FenceCircle
from host.mission.files.flight_plan import WAYPOINT, FlightPlan, Item
from host.mission.files.mavlink_link import Link, NoReplyError


__all__ = ["ARDUPILOT", "AUTOPILOTS", "Uploaded", "WireItem", "upload"]

#: Values of MAV_AUTOPILOT.
ARDUPILOT, PX4 = 3, 12
AUTOPILOTS = {"ardupilot": ARDUPILOT, "px4": PX4}

# Values of MAV_MISSION_TYPE, and their names in sentences.
_MISSION, _FENCE = 0, 1
_NAMES = {_MISSION: "mission", _FENCE: "fence"}
_ACCEPTED, _UNSUPPORTED, _CANCELLED = 0, 3, 15
# Frames that mean the same on the wire: AMSL with degrees, and with degrees times 10 million.
_SAME_FRAMES = {5: 0, 6: 3, 11: 10}
# ArduPilot keeps altitudes in whole centimetres.
_ARDUPILOT_ALTITUDE_M = 0.0101
# Most answers to a list, for each item, before the autopilot counts as stuck.
_MOST_ANSWERS = 8
_DEGREES = 10_000_000


@dataclass(frozen=True)
class WireItem:
    """An item as MAVLink carries it.

    Parameters
    ----------
    command, frame : int
        Values of MAV_CMD and MAV_FRAME.
    params : tuple of float
        The first four parameters, NaN where left to the autopilot; single precision.
    x, y : int
        Latitude and longitude in degrees times 10 million.
    z : float
        Altitude in metres, single precision.
    """

    command: int
    frame: int
    params: tuple[float, float, float, float]
    x: int
    y: int
    z: float


@dataclass(frozen=True)
class Uploaded:
    """What an autopilot has confirmed and given back equal.

    Parameters
    ----------
    system : int
        System of the autopilot.
    autopilot : int
        Its kind: a value of MAV_AUTOPILOT.
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

    An upload replaces what the autopilot has: a plan without fences clears those of an earlier one.

    Parameters
    ----------
    plan : FlightPlan
        Mission and fence.
    link : Link
        Connection on which the autopilot has been found.
    autopilot : int, optional
        Its kind, if not that of its heartbeat. ArduPilot takes item 0 as home.

    Raises
    ------
    JobError
        If the autopilot refuses an item, falls silent, or gives back anything else.
    """
    kind = link.autopilot if autopilot is None else autopilot
    for mission_type, items in ((_FENCE, _fence(plan)), (_MISSION, _mission(plan, kind))):
        link.drain()
        if _send(link, mission_type, items):
            _compare(mission_type, items, _read(link, mission_type), kind)
    return Uploaded(link.system, kind, len(_mission(plan, kind)), len(_fence(plan)))


def _mission(plan: FlightPlan, autopilot: int) -> list[WireItem]:
    home = Item(WAYPOINT, (0.0, 0.0, 0.0, None), *plan.home)
    items = (home, *plan.items) if autopilot == ARDUPILOT else plan.items
    return [_wire(item.command, item.params, item.lat, item.lon, item.alt_m) for item in items]


def _fence(plan: FlightPlan) -> list[WireItem]:
    """Return the fences as items: a circle is one, a polygon one for each corner."""
    items = []
    for fence in plan.fence:
        if isinstance(fence, FenceCircle):
            command, places, first = 5004, [(fence.lat, fence.lon)], fence.radius_m
        else:
            command, places, first = 5002, list(fence.corners), float(len(fence.corners))
        command -= fence.inclusion
        items += [_wire(command, (first, 0.0, 0.0, 0.0), lat, lon, 0.0) for lat, lon in places]
    return items


def _wire(
    command: int, params: Sequence[float | None], lat: float, lon: float, alt_m: float
) -> WireItem:
    first, second, third, fourth = (
        math.nan if param is None else _single(param) for param in params
    )
    x, y = round(lat * _DEGREES), round(lon * _DEGREES)
    return WireItem(command, 0, (first, second, third, fourth), x, y, _single(alt_m))


def _single(value: float) -> float:
    return float(np.float32(value))


def _send(link: Link, mission_type: int, items: list[WireItem]) -> bool:
    """Hand over a list; an empty one clears the autopilot's.

    Returns False where the list is empty and the autopilot keeps no such lists.
    """
    to = link.system, link.component
    name, sent = _NAMES[mission_type], 0

    def announce() -> None:
        if items:
            link.mav.mission_count_send(*to, len(items), mission_type)
        else:
            link.mav.mission_clear_all_send(*to, mission_type)

    def hand_over(number: int) -> None:
        item = items[number]
        link.mav.mission_item_int_send(
            *to,
            number,
            item.frame,
            item.command,
            0,
            1,
            *item.params,
            item.x,
            item.y,
            item.z,
            mission_type,
        )

    send: Callable[[], None] = announce
    answers = ("MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK")
    for _ in range(_MOST_ANSWERS * (len(items) + 1)):
        try:
            message = link.ask(send, answers, lambda found: found.mission_type == mission_type)
        except NoReplyError:
            # Frees an autopilot that hears us but is not heard.
            link.mav.mission_ack_send(*to, _CANCELLED, mission_type)
            raise JobError(
                f"The autopilot fell silent at item {sent} of {len(items)} of the {name}; check "
                "the link and upload again."
            ) from None
        if message.get_type() == "MISSION_ACK":
            if message.type == _UNSUPPORTED and not items:
                return False
            if message.type != _ACCEPTED:
                raise JobError(
                    f"The autopilot refuses the {name} at item {sent} of {len(items)} "
                    f"({_reason(message.type)})."
                )
            if sent < len(items):
                raise JobError(
                    f"The autopilot accepts the {name} after {sent} of its {len(items)} items; "
                    "upload again."
                )
            return True
        number = message.seq
        if number >= len(items):
            break
        sent = max(sent, number + 1)
        send = partial(hand_over, number)
    raise JobError(f"The autopilot asks for the same items of the {name} again and again.")


def _read(link: Link, mission_type: int) -> list[WireItem]:
    """Read a list back."""
    to = link.system, link.component
    items: list[WireItem] = []
    count = None
    try:
        count = link.ask(
            lambda: link.mav.mission_request_list_send(*to, mission_type),
            ("MISSION_COUNT",),
            lambda found: found.mission_type == mission_type,
        ).count
        for _ in range(count):
            found = link.ask(
                lambda: link.mav.mission_request_int_send(*to, len(items), mission_type),
                ("MISSION_ITEM_INT",),
                lambda found: found.mission_type == mission_type and found.seq == len(items),
            )
            params = found.param1, found.param2, found.param3, found.param4
            items.append(WireItem(found.command, found.frame, params, found.x, found.y, found.z))
    except NoReplyError:
        name = _NAMES[mission_type]
        raise JobError(
            f"The autopilot took the {name} but does not give it back "
            f"({len(items)} of {'?' if count is None else count} items); check the link and upload "
            "again."
        ) from None
    link.mav.mission_ack_send(*to, _ACCEPTED, mission_type)
    return items


def _compare(mission_type: int, sent: list[WireItem], got: list[WireItem], autopilot: int) -> None:
    """Refuse a list that differs from the one sent."""
    name = _NAMES[mission_type]
    if len(sent) != len(got):
        raise JobError(
            f"The autopilot gives back {len(got)} items of the {name}, not {len(sent)}; do not "
            "fly it."
        )
    is_mission = mission_type == _MISSION
    for number, (ours, theirs) in enumerate(zip(sent, got, strict=True)):
        if is_mission and number == 0 and autopilot == ARDUPILOT:
            continue  # Home is where the aircraft was armed.
        what = _difference(ours, theirs, autopilot, heights=is_mission)
        if what:
            raise JobError(
                f"The autopilot gives back item {number} of the {name} with another {what}; do "
                "not fly it."
            )


def _difference(ours: WireItem, theirs: WireItem, autopilot: int, *, heights: bool) -> str | None:
    """Return what differs between two items; fences have no heights."""
    if ours.command != theirs.command:
        return f"command ({theirs.command}, not {ours.command})"
    if (ours.x, ours.y) != (theirs.x, theirs.y):
        return (
            f"place ({theirs.x / _DEGREES:.7f}, {theirs.y / _DEGREES:.7f}, not "
            f"{ours.x / _DEGREES:.7f}, {ours.y / _DEGREES:.7f})"
        )
    for number, (our, their) in enumerate(zip(ours.params, theirs.params, strict=True), start=1):
        # An autopilot may say 0 for a parameter that is left to it.
        if our != their and not (math.isnan(our) and (their == 0 or math.isnan(their))):
            return f"parameter {number} ({their:g}, not {our:g})"
    if not heights:
        return None
    if ours.frame != _SAME_FRAMES.get(theirs.frame, theirs.frame):
        return f"frame ({theirs.frame}, not {ours.frame})"
    slack_m = _ARDUPILOT_ALTITUDE_M if autopilot == ARDUPILOT else 0.0
    if not abs(ours.z - theirs.z) <= slack_m:
        return f"altitude ({theirs.z:.3f} m, not {ours.z:.3f} m)"
    return None


def _reason(result: int) -> str:
    """Return the name of a result of the protocol, in words."""
    from pymavlink import mavutil

    known: dict[int, Any] = mavutil.mavlink.enums["MAV_MISSION_RESULT"]
    name = known[result].name if result in known else f"result {result}"
    return str(name).removeprefix("MAV_MISSION_").replace("_", " ").lower()
