"""The protocol of missions, fences and rally points: uploads, downloads and clearing.

The messages are pymavlink's, because its encoding is the one that ground stations use: its bytes
travel over a wire as they are. Time comes in as an argument, so a campaign runs
in virtual time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from pathgene.sim.autopilot.fence import Fence, storage_bytes
from pathgene.sim.autopilot.items import FENCE, MISSION, RALLY, Item
from pathgene.sim.autopilot.rules import Result, Rules


__all__ = ["KINDS", "Lists"]

#: The kinds of lists.
KINDS = (MISSION, FENCE, RALLY)
_ALL = 255
_NAMES = {MISSION: "Mission", FENCE: "Fence", RALLY: "Rally"}
# The storage that 16 kB leave ArduPilot for fences.
_FENCE_BYTES = 672

Address = tuple[int, int]


@dataclass
class _Upload:
    """An upload under way."""

    sender: Address
    count: int
    number: int = 0
    current: int | None = None
    items: list[Item] = field(default_factory=list)
    received_s: float = 0.0
    asked_s: float = 0.0


class Lists:
    """Mission, fence and rally points of an autopilot, and the protocol that changes them.

    Parameters
    ----------
    rules : Rules
        The autopilot's rules.
    runs : callable
        Returns whether the mission is being flown; ArduPilot refuses to clear it then.
    say : callable
        Takes a text for the ground station.
    changed : callable
        Called with the kind of each list that has changed.

    Attributes
    ----------
    items : dict
        Lists of items by kind.
    home : Item or None
        Item 0 of ArduPilot's mission, whatever a ground station writes there; None to keep that.
    current : callable
        Returns the number of the item under way, which is marked when it is read back.
    chosen : callable
        Called with the number of the item that an upload to PX4 marks as the current one.
    """

    def __init__(
        self,
        rules: Rules,
        *,
        runs: Callable[[], bool] = lambda: False,
        say: Callable[[str], None] = lambda _text: None,
        changed: Callable[[int], None] = lambda _kind: None,
    ) -> None:
        self.rules = rules
        self.items: dict[int, list[Item]] = {kind: [] for kind in KINDS}
        self.home: Item | None = None
        self.current: Callable[[], int] = lambda: -1
        self.chosen: Callable[[int], object] = lambda _number: None
        self._runs, self._say, self._changed = runs, say, changed
        self._uploads: dict[int, _Upload] = {}
        self._completed: dict[int, _Upload] = {}

    def abandon(self, kind: int) -> None:
        """Give an upload up without a word; items in their places stay there."""
        self._uploads.pop(kind, None)

    def restart(self, *, keeps: bool = True) -> None:
        """Forget uploads under way, and the lists, too, if no storage keeps them."""
        self._uploads.clear()
        self._completed.clear()
        for kind in KINDS if not keeps else ():
            self.items[kind] = []
            self._changed(kind)

    def is_receiving(self, kind: int) -> bool:
        """Return whether an upload of a kind is under way."""
        return kind in self._uploads

    def handle(self, message: Any, now_s: float) -> list[Any]:
        """Return the answers to a message of the protocol; other messages have none."""
        kind = getattr(message, "mission_type", MISSION)
        sender = (message.get_srcSystem(), message.get_srcComponent())
        name = message.get_type()
        if name == "MISSION_CLEAR_ALL":
            return self._clear(sender, kind)
        if kind not in KINDS:
            return [_ack(sender, Result.UNSUPPORTED, kind)] if name in _BEGINS else []
        match name:
            case "MISSION_COUNT":
                return self._begin(sender, message.count, kind, now_s)
            case "MISSION_ITEM_INT" | "MISSION_ITEM":
                return self._take(sender, message, kind, now_s)
            case "MISSION_REQUEST_LIST" | "MISSION_REQUEST_INT" | "MISSION_REQUEST":
                return self._give(sender, message, kind)
            case "MISSION_ACK":
                is_end = message.type == Result.CANCELLED and not self.rules.is_ardupilot
                if is_end and kind in self._uploads:
                    del self._uploads[kind]
        return []

    def tick(self, now_s: float) -> list[Any]:
        """Return requests for items that have not arrived, and give up old uploads."""
        answers = []
        for kind, upload in list(self._uploads.items()):
            if now_s - upload.received_s > self.rules.timeout_s:
                del self._uploads[kind]
                self._say(f"{_NAMES[kind]} upload timeout")
                answers.append(_ack(upload.sender, Result.CANCELLED, kind))
            elif now_s - upload.asked_s > self.rules.retry_s:
                answers.append(self._ask(upload, kind, now_s))
        return answers

    def _begin(self, sender: Address, count: int, kind: int, now_s: float) -> list[Any]:
        upload = self._uploads.get(kind)
        if upload is not None and upload.sender != sender:
            return [_ack(sender, Result.DENIED, kind)]
        self._uploads.pop(kind, None)
        most = self.rules.most_items[kind]
        if count > most:
            self._say(f"Only {most} items are supported")
            return [_ack(sender, Result.NO_SPACE, kind)]
        if kind in self.rules.in_place and count < len(self.items[kind]):
            del self.items[kind][count:]
            self._changed(kind)
        if count == 0:
            self.items[kind] = []
            self._changed(kind)
            return [_ack(sender, Result.ACCEPTED, kind)]
        upload = self._uploads[kind] = _Upload(sender, count, received_s=now_s)
        return [self._ask(upload, kind, now_s)]

    def _ask(self, upload: _Upload, kind: int, now_s: float) -> Any:
        upload.asked_s = now_s
        name = "request_int" if self.rules.asks_for_integers else "request"
        made = getattr(mavlink, f"MAVLink_mission_{name}_message")
        return made(*upload.sender, upload.number, mission_type=kind)

    def _take(self, sender: Address, message: Any, kind: int, now_s: float) -> list[Any]:
        """Take an item of an upload."""
        upload = self._uploads.get(kind)
        if upload is None:
            last = self._completed.get(kind)
            is_known = last is not None and (sender, message.seq + 1) == (last.sender, last.count)
            # PX4 takes a repeated last item as a sign that its confirmation was lost.
            is_repeated = is_known and not self.rules.is_ardupilot
            return [_ack(sender, Result.ACCEPTED if is_repeated else Result.ERROR, kind)]
        if message.seq != upload.number:
            wrong = [_ack(sender, Result.INVALID_SEQUENCE, kind)]
            return wrong if self.rules.complains_of_sequence else []
        if upload.sender != sender:
            return [_ack(sender, Result.DENIED, kind)]
        item = Item.of(message)
        result = self.rules.judge(item, kind)
        if result != Result.ACCEPTED:
            del self._uploads[kind]
            return [_ack(sender, result, kind)]
        item = self.rules.kept(item, kind)
        if kind == MISSION and upload.number == 0 and self.home is not None:
            item = self.home
        if kind in self.rules.in_place:
            self.items[kind][upload.number : upload.number + 1] = [item]
            self._changed(kind)
        else:
            upload.items.append(item)
            if message.current == 1:
                upload.current = upload.number
        upload.number += 1
        upload.received_s = now_s
        if upload.number < upload.count:
            return [self._ask(upload, kind, now_s)]
        self._completed[kind] = self._uploads.pop(kind)
        return [_ack(sender, self._complete(upload, kind), kind)]

    def _complete(self, upload: _Upload, kind: int) -> Result:
        """Replace a list that is not written in place, unless the whole is refused."""
        if kind in self.rules.in_place:
            return Result.ACCEPTED
        if kind == FENCE:
            reason = Fence.fault(upload.items)
            if reason is not None:
                self._say(reason)
                self._say("Fence validation failed")
                return Result.ERROR
            if self.rules.is_ardupilot and storage_bytes(upload.items) > _FENCE_BYTES:
                self._say("Fence exceeds storage size")
                return Result.ERROR
        self.items[kind] = upload.items
        self._changed(kind)
        if kind == MISSION and upload.current is not None:
            self.chosen(upload.current)
        return Result.ACCEPTED

    def _clear(self, sender: Address, kind: int) -> list[Any]:
        kinds = KINDS if kind == _ALL else (kind,)
        if not set(kinds) <= set(KINDS):
            return [_ack(sender, Result.UNSUPPORTED, kind)]
        for one in kinds:
            if self.rules.is_ardupilot:
                is_refused = one in self._uploads or (one == MISSION and self._runs())
                if is_refused:
                    return [_ack(sender, Result.ERROR, kind)]
            self._uploads.pop(one, None)
            self.items[one] = []
            self._changed(one)
        return [_ack(sender, Result.ACCEPTED, kind)]

    def _give(self, sender: Address, message: Any, kind: int) -> list[Any]:
        """Return the number of items, or an item."""
        if kind in self._uploads:
            busy = Result.DENIED if self.rules.is_ardupilot else Result.ERROR
            return [_ack(sender, busy, kind)]
        items = self.items[kind]
        count = mavlink.MAVLink_mission_count_message(*sender, len(items), mission_type=kind)
        if message.get_type() == "MISSION_REQUEST_LIST":
            return [count]
        if message.seq >= len(items):
            return [count, _ack(sender, Result.ERROR, kind)]
        item = items[message.seq]
        if kind == MISSION and message.seq == 0 and self.home is not None:
            item = self.home
        is_current = kind == MISSION and message.seq == self.current()
        is_float = message.get_type() == "MISSION_REQUEST"
        made = mavlink.MAVLink_mission_item_int_message
        place: tuple[float, float] = (item.x, item.y)
        if is_float:
            made, place = mavlink.MAVLink_mission_item_message, (item.lat, item.lon)
        return [
            made(
                *sender,
                message.seq,
                item.frame,
                item.command,
                int(is_current),
                item.autocontinue,
                *item.params,
                *place,
                item.z,
                mission_type=kind,
            )
        ]


_BEGINS = ("MISSION_COUNT", "MISSION_REQUEST_LIST", "MISSION_REQUEST_INT", "MISSION_REQUEST")


def _ack(sender: Address, result: Result, kind: int) -> Any:
    return mavlink.MAVLink_mission_ack_message(*sender, int(result), mission_type=kind)
