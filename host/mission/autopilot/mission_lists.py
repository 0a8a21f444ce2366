"""One list of an autopilot, such as its mission: it is sent, read, cleared and compared.

The mission protocol of MAVLink (https://mavlink.io/en/services/mission.html) carries the items.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from pathgene.host.formats.flight_plan import LAND, LOITER_TO_ALT
from pathgene.host.mission.autopilot.mavlink_link import Link, NoReplyError


__all__ = [
    "ARDUPILOT",
    "DEGREES",
    "FENCE",
    "MISSION",
    "NAMES",
    "PX4",
    "RALLY",
    "ListError",
    "WireItem",
    "cancel",
    "holds",
    "read",
    "transfer",
]

#: Values of MAV_AUTOPILOT.
ARDUPILOT, PX4 = 3, 12
#: Values of MAV_MISSION_TYPE, and their names in sentences.
MISSION, FENCE, RALLY = 0, 1, 2
NAMES = {MISSION: "mission", FENCE: "fence", RALLY: "rally list"}
#: Steps of a position on the wire, for each degree.
DEGREES = 10_000_000

# Values of MAV_MISSION_RESULT.
_ACCEPTED, _ERROR, _UNSUPPORTED = 0, 1, 3
_INVALID_SEQUENCE, _DENIED, _CANCELLED = 13, 14, 15
# Results that only an upload has, so that a request for a list is not answered by them.
_ENDS = (_ACCEPTED, _INVALID_SEQUENCE, _CANCELLED)
# Frames that mean the same on the wire: AMSL with degrees, and with degrees times 10 million.
_SAME_FRAMES = {5: 0, 6: 3, 11: 10}
# ArduPilot keeps altitudes in whole centimetres.
_ARDUPILOT_ALTITUDE_M = 0.0101
# Parameters that ArduPilot does not keep, by commands: the heading of a landing, and the request to
# leave a loiter towards the next waypoint, which it does anyway.
_UNKEPT = {LAND: 4, LOITER_TO_ALT: 1}
# Maximum answers to a list, for each item, before the autopilot counts as stuck. PX4 asks again
# after 0.25 s, so 16 times during a round trip of 4 s.
_MAX_ANSWERS = 32
# No autopilot keeps more items; a count of 65,535 is an error.
_MOST_ITEMS = 10_000
# Restarts of an upload that the autopilot gave up because messages were lost.
_RESTARTS = 3


class ListError(Exception):
    """A list that the autopilot refuses, or holds in another form than it was sent.

    Parameters
    ----------
    reason : str
        The beginning of a sentence about the autopilot.
    silent : bool
        The autopilot does not answer.
    """

    def __init__(self, reason: str, *, silent: bool = False) -> None:
        super().__init__(reason)
        self.reason, self.silent = reason, silent


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
    current, autocontinue : int
        1 if the aircraft is flying this item, and 1 if it then continues with the next item.
    """

    command: int
    frame: int
    params: tuple[float, float, float, float]
    x: int
    y: int
    z: float
    current: int = 0
    autocontinue: int = 1


def transfer(link: Link, mission_type: int, items: Sequence[WireItem], autopilot: int) -> None:
    """Send a list, read it back and compare; an empty list clears the list of the autopilot.

    An autopilot without such lists accepts the empty one. On a link that loses messages, a list
    that is read back differently is sent once more: a late acknowledgement of an earlier list can
    end an upload too early.

    Raises
    ------
    ListError
        If the autopilot refuses an item, falls silent, or returns a different list.
    """
    try:
        _transfer(link, mission_type, items, autopilot)
    except _OtherListError:
        if not link.loses:
            raise
        _transfer(link, mission_type, items, autopilot)


def _transfer(link: Link, mission_type: int, items: Sequence[WireItem], autopilot: int) -> None:
    link.settle()
    try:
        if not _send(link, mission_type, items):
            return
    except _UnconfirmedError as error:
        # The confirmation may be lost, and ArduPilot answers a repeated last item with an error.
        link.settle()
        try:
            _compare(mission_type, items, read(link, mission_type) or (), autopilot)
        except ListError:
            raise error from None
        return
    # The autopilot complains about items that were repeated because a request came late.
    link.settle()
    try:
        got = read(link, mission_type) or ()
    except ListError as error:
        raise ListError(
            f"The autopilot took the {NAMES[mission_type]}, but {error.reason}", silent=error.silent
        ) from None
    _compare(mission_type, items, got, autopilot)


def read(link: Link, mission_type: int) -> list[WireItem] | None:
    """Return a list of the autopilot, or None if it has no such lists.

    Raises
    ------
    ListError
        If the autopilot does not send its list; the reason is the end of a sentence.
    """
    to = link.system, link.component
    items: list[WireItem] = []
    count: int | None = None
    try:
        count = _count(link, mission_type)
        if count is None:
            return None
        while len(items) < count:
            found = link.ask(
                lambda: link.mav.mission_request_int_send(*to, len(items), mission_type),
                ("MISSION_ITEM_INT", "MISSION_ACK"),
                lambda found: (
                    found.mission_type == mission_type
                    and (
                        found.type not in _ENDS
                        if found.get_type() == "MISSION_ACK"
                        else found.seq == len(items)
                    )
                ),
            )
            if found.get_type() == "MISSION_ACK":
                raise ListError(
                    f"it does not give item {len(items)} of {count} ({_result(found.type)})"
                )
            items.append(_item(found))
    except NoReplyError:
        known = "?" if count is None else count
        raise ListError(
            f"it does not give its list ({len(items)} of {known} items)", silent=True
        ) from None
    link.mav.mission_ack_send(*to, _ACCEPTED, mission_type)
    return items


def holds(link: Link, mission_type: int, items: Sequence[WireItem], autopilot: int) -> bool:
    """Return whether the autopilot still holds a list that it has confirmed, by its length.

    Raises
    ------
    ListError
        If the autopilot does not answer.
    """
    try:
        count = _count(link, mission_type) or 0
    except NoReplyError:
        raise ListError("The autopilot fell silent", silent=True) from None
    link.mav.mission_ack_send(link.system, link.component, _ACCEPTED, mission_type)
    is_home = mission_type == MISSION and autopilot == ARDUPILOT and not items
    return count == len(items) or (is_home and count == 1)


def cancel(link: Link, mission_types: Iterable[int]) -> None:
    """Release an autopilot that still waits for items, and discard its late requests for them."""
    for mission_type in mission_types:
        link.mav.mission_ack_send(link.system, link.component, _CANCELLED, mission_type)
    link.drain(late=True)


class _OtherListError(ListError):
    """The autopilot gives back another list than it was sent."""


class _UnconfirmedError(ListError):
    """All items are sent, but the autopilot has not confirmed them."""


def _count(link: Link, mission_type: int) -> int | None:
    """Return the length of a list, or None if the autopilot has no such lists."""
    to = link.system, link.component
    answer = _when_free(
        link, mission_type, lambda: link.mav.mission_request_list_send(*to, mission_type)
    )
    if answer.get_type() == "MISSION_ACK":
        if answer.type == _UNSUPPORTED:
            return None
        raise ListError(f"it does not give its list ({_result(answer.type)})")
    count = int(answer.count)
    if count > _MOST_ITEMS:
        raise ListError(f"it states {count} items, more than any autopilot keeps")
    return count


def _when_free(link: Link, mission_type: int, send: Callable[[], None]) -> Any:
    """Return the answer to a request for a list.

    ArduPilot denies the request while it waits for items of an aborted upload; it gives up after 8
    s. On a link that loses messages, an error is perhaps a late complaint about a repeated item.
    """
    busy = False

    def is_answer(found: Any) -> bool:
        nonlocal busy
        if found.mission_type != mission_type:
            return False
        if found.get_type() != "MISSION_ACK":
            return True
        is_denial = found.type == _DENIED or (found.type == _ERROR and link.loses)
        busy = busy or is_denial
        return not is_denial and found.type not in _ENDS

    kinds = ("MISSION_COUNT", "MISSION_ACK")
    try:
        return link.ask(send, kinds, is_answer)
    except NoReplyError:
        if not busy:
            raise
    return link.ask(send, kinds, is_answer)


def _item(found: Any) -> WireItem:
    params = found.param1, found.param2, found.param3, found.param4
    return WireItem(
        found.command,
        found.frame,
        params,
        found.x,
        found.y,
        found.z,
        found.current,
        found.autocontinue,
    )


def _send(link: Link, mission_type: int, items: Sequence[WireItem]) -> bool:
    """Send a list; an empty list clears the list of the autopilot.

    Returns False if the list is empty and the autopilot has no such lists.
    """
    to = link.system, link.component
    name, sent = NAMES[mission_type], 0

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
            item.current,
            item.autocontinue,
            *item.params,
            item.x,
            item.y,
            item.z,
            mission_type,
        )

    def is_answer(found: Any) -> bool:
        if found.mission_type != mission_type:
            return False
        if found.get_type() == "MISSION_ACK":
            # ArduPilot complains about an item that it no longer asks for, and waits for the next.
            return bool(found.type != _INVALID_SEQUENCE)
        # A late request for an item that has arrived meanwhile. One for the latest item is answered
        # each time: on a link that loses messages, one of the answers arrives.
        return bool(found.seq >= sent - 1)

    send: Callable[[], None] = announce
    answers = ("MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK")
    restarts = 0
    for _ in range(_MAX_ANSWERS * (len(items) + 1)):
        kind = _UnconfirmedError if sent == len(items) else ListError
        place = f"item {sent} of {len(items)} of the {name}"
        try:
            message = link.ask(send, answers, is_answer)
        except NoReplyError:
            raise kind(f"The autopilot fell silent at {place}", silent=True) from None
        if message.get_type() == "MISSION_ACK":
            if message.type == _UNSUPPORTED and not items:
                return False
            # An item that arrives after the autopilot gave up is an error. It said so in a message
            # that may be lost. A list that is accepted too early is an earlier one.
            is_early = message.type == _ACCEPTED and sent < len(items)
            is_late = message.type == _ERROR or is_early
            gave_up = message.type == _CANCELLED or (link.loses and is_late)
        else:
            # A late request of an earlier upload of a longer list.
            gave_up = message.seq >= len(items)
        if gave_up and restarts < _RESTARTS:
            restarts += 1
            link.settle()
            sent, send = 0, announce
            continue
        if message.get_type() == "MISSION_ACK":
            if message.type != _ACCEPTED:
                raise kind(f"The autopilot refuses {place} ({_result(message.type)})")
            if sent < len(items):
                raise ListError(
                    f"The autopilot accepts the {name} after {sent} of its {len(items)} items"
                )
            return True
        number = message.seq
        if number >= len(items):
            raise ListError(
                f"The autopilot asks for item {number} of the {name}, which has {len(items)} items"
            )
        sent = max(sent, number + 1)
        send = partial(hand_over, number)
    raise ListError(f"The autopilot repeats its requests for the same items of the {name}")


def _compare(
    mission_type: int, sent: Sequence[WireItem], got: Sequence[WireItem], autopilot: int
) -> None:
    """Refuse a list that differs from the one sent."""
    name = NAMES[mission_type]
    has_home = mission_type == MISSION and autopilot == ARDUPILOT
    if has_home and not sent and len(got) == 1:
        return  # Home stays when a mission is cleared.
    if len(sent) != len(got):
        raise _OtherListError(
            f"The autopilot gives back {len(got)} items of the {name}, not {len(sent)}"
        )
    for number, (ours, theirs) in enumerate(zip(sent, got, strict=True)):
        if has_home and number == 0:
            continue  # Home is where the aircraft was armed.
        difference = _difference(ours, theirs, autopilot, mission_type=mission_type)
        if difference:
            raise _OtherListError(
                f"The autopilot gives back item {number} of the {name} with another {difference}"
            )


def _difference(
    ours: WireItem, theirs: WireItem, autopilot: int, *, mission_type: int
) -> str | None:
    """Return the difference between two items, or None.

    Fences have no heights. Only missions continue with the next item; which item is the current one
    depends on the flight.
    """
    if ours.command != theirs.command:
        return f"command ({theirs.command}, not {ours.command})"
    if (ours.x, ours.y) != (theirs.x, theirs.y):
        return (
            f"place ({theirs.x / DEGREES:.7f}, {theirs.y / DEGREES:.7f}, not "
            f"{ours.x / DEGREES:.7f}, {ours.y / DEGREES:.7f})"
        )
    unkept = _UNKEPT.get(ours.command) if autopilot == ARDUPILOT else None
    for number, (our, their) in enumerate(zip(ours.params, theirs.params, strict=True), start=1):
        if number == unkept:
            continue
        # An autopilot may report 0 for a parameter that is left to it.
        if our != their and not (math.isnan(our) and (their == 0 or math.isnan(their))):
            return f"parameter {number} ({their:g}, not {our:g})"
    if mission_type == MISSION and ours.autocontinue != theirs.autocontinue:
        return f"autocontinue ({theirs.autocontinue}, not {ours.autocontinue})"
    if mission_type == FENCE:
        return None
    our_frame, their_frame = (_SAME_FRAMES.get(item.frame, item.frame) for item in (ours, theirs))
    if our_frame != their_frame:
        return f"frame ({theirs.frame}, not {ours.frame})"
    slack_m = _ARDUPILOT_ALTITUDE_M if autopilot == ARDUPILOT else 0.0
    if not abs(ours.z - theirs.z) <= slack_m:
        return f"altitude ({theirs.z:.3f} m, not {ours.z:.3f} m)"
    return None


def _result(result: int) -> str:
    """Return the name of a result of the protocol, in words."""
    from pymavlink import mavutil

    known: dict[int, Any] = mavutil.mavlink.enums["MAV_MISSION_RESULT"]
    name = known[result].name if result in known else f"result {result}"
    return str(name).removeprefix("MAV_MISSION_").replace("_", " ").lower()
