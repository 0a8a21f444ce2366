"""Our own autopilot on UDP, with configurable faults."""

import math
import os
import threading
import time


os.environ["MAVLINK20"] = "1"

from pymavlink import mavutil

from pathgene.host.mission.autopilot.mavlink_link import open_link
from pathgene.host.mission.autopilot.upload import upload


ARDUPILOT = 3
# Values of MAV_MISSION_RESULT.
ACCEPTED, ERROR, UNSUPPORTED, INVALID_PARAM1 = 0, 1, 3, 6
INVALID_SEQUENCE, DENIED, CANCELLED = 13, 14, 15
# Parameters, from 0, that ArduPilot accepts as NaN, by commands (AP_Mission::sanity_check_params).
NAN_IN = {16: {3}, 21: {3}, 22: {3}, 84: {3}, 85: {2, 3}}


class OwnAutopilot(threading.Thread):
    """Stores a list for each kind of mission and returns it, with an error if told to.

    As ArduPilot (``kind`` 3), it refuses NaN and infinite parameters by ArduPilot's rules, shortens
    its mission when a count arrives and writes each item in its place, keeps the items of a fence
    until the last has arrived, refuses to clear a mission that runs, and denies its lists while it
    waits for items. As any other kind, it replaces a list when the last item has arrived.

    Attributes
    ----------
    kind : int
        Value of MAV_AUTOPILOT in its heartbeat.
    armed, runs : bool
        Whether its motors run, and whether it flies its mission.
    lists : dict
        Items by the kind of mission.
    alter : callable
        Changes an item before it is returned.
    keeps : int
        Maximum number of items that it returns.
    drops : int
        Loses every n-th message that it receives; 0 for none.
    breaks : callable
        Sees each message before it is handled. It may return a result, which is the answer, or
        "lost", for a message that does not arrive.
    asks_twice_after_s : float or None
        It asks for item 2 again after this time, like an autopilot that receives it late.
    asks_for : callable
        Maps the number of the item that it needs to the number that it asks for.
    mixes_lists : bool
        It first answers a request for the mission by the size of the fence, and the reverse.
    keeps_home : bool
        Home stays when its mission is cleared.
    loses : callable
        Sees each acknowledgement, result and kind, and tells whether it is lost.
    """

    def __init__(self):
        super().__init__(daemon=True)
        self.kind = 0
        self.armed = self.runs = False
        self.lists = {0: [], 1: []}
        self.alter = lambda _item: None
        self.keeps = 10_000
        self.drops = 0
        self.breaks = lambda _message: None
        self.loses = lambda _result, _kind: False
        self.asks_by = "mission_request_int_send"
        self.asks_for = lambda number: number
        self.mixes_lists = self.keeps_home = False
        self.has_fences = True
        self.moves_home = False
        self.upload_timeout_s = 8.0
        self.asks_twice_after_s = None
        # Kind, number of items, items that have arrived, and time of the last one.
        self.receiving = None
        self._link = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=7)
        self.address = f"udpout:127.0.0.1:{self._link.port.getsockname()[1]}"
        self._closed = threading.Event()
        self.start()

    def close(self):
        self._closed.set()
        self.join()
        self._link.close()

    def run(self):
        number = 0
        while not self._closed.is_set():
            message = self._link.recv_match(blocking=True, timeout=0.05)
            if message is None:
                continue
            if message.get_type() == "HEARTBEAT":
                mode = 128 if self.armed else 0
                self._link.mav.heartbeat_send(1, self.kind, mode, 0, 0)
                continue
            number += 1
            broken = self.breaks(message)
            if broken == "lost" or (self.drops and not number % self.drops):
                continue
            self._answer(message, broken)

    def _answer(self, message, broken):
        to = (message.get_srcSystem(), message.get_srcComponent())
        kind = getattr(message, "mission_type", 0)
        if self.receiving and time.monotonic() - self.receiving[3] > self.upload_timeout_s:
            self.receiving = None
        if broken is not None:
            self._acknowledge(to, broken, kind)
            if message.get_type() == "MISSION_ITEM_INT":
                self.receiving = None
            return
        is_busy = self.receiving is not None and self.kind == ARDUPILOT
        match message.get_type():
            case "MISSION_COUNT" | "MISSION_CLEAR_ALL" | "MISSION_REQUEST_LIST" if (
                kind == 1 and not self.has_fences
            ):
                self._acknowledge(to, UNSUPPORTED, kind)
            case "MISSION_CLEAR_ALL":
                runs = self.runs and kind == 0
                if self.kind == ARDUPILOT and (runs or is_busy):
                    self._acknowledge(to, ERROR, kind)
                else:
                    self.lists[kind] = self.lists[kind][: self.keeps_home and kind == 0]
                    self._acknowledge(to, ACCEPTED, kind)
            case "MISSION_COUNT":
                self.receiving = (kind, message.count, [], time.monotonic())
                if self._is_in_place(kind):
                    del self.lists[0][message.count :]
                self._ask(to, 0, kind)
            case "MISSION_ITEM_INT":
                self._take(to, message, kind)
            case "MISSION_ACK" if message.type == CANCELLED and self.kind != ARDUPILOT:
                self.receiving = None
            case "MISSION_REQUEST_LIST" | "MISSION_REQUEST_INT" if is_busy:
                self._acknowledge(to, DENIED, kind)
            case "MISSION_REQUEST_LIST":
                if self.mixes_lists:
                    self._link.mav.mission_count_send(*to, len(self.lists[1 - kind]), 1 - kind)
                count = min(self.keeps, len(self.lists[kind]))
                self._link.mav.mission_count_send(*to, count, kind)
            case "MISSION_REQUEST_INT":
                self._give(to, message.seq, kind)

    def _is_in_place(self, kind):
        return self.kind == ARDUPILOT and kind == 0

    def _take(self, to, item, kind):
        if self.receiving is None:
            self._acknowledge(to, ERROR, kind)
            return
        _, count, arrived, _ = self.receiving
        if self.kind == ARDUPILOT and item.seq != len(arrived):
            self._acknowledge(to, INVALID_SEQUENCE, kind)
            return
        result = self._judge(item) if self._is_in_place(kind) else ACCEPTED
        if result != ACCEPTED:
            self.receiving = None
            self._acknowledge(to, result, kind)
            return
        if item.seq == len(arrived):
            arrived.append(item)
            if self._is_in_place(kind):
                self.lists[0][item.seq : item.seq + 1] = [item]
        self.receiving = (kind, count, arrived, time.monotonic())
        if len(arrived) < count:
            self._ask(to, len(arrived), kind)
            return
        self.lists[kind] = arrived
        self.receiving = None
        self._acknowledge(to, ACCEPTED, kind)

    @staticmethod
    def _judge(item):
        """Return ArduPilot's result for the parameters of an item."""
        allowed = NAN_IN.get(item.command, ())
        for number in range(4):
            value = getattr(item, f"param{number + 1}")
            if math.isinf(value) or (math.isnan(value) and number not in allowed):
                return INVALID_PARAM1 + number
        return ACCEPTED

    def _acknowledge(self, to, result, kind):
        if not self.loses(result, kind):
            self._link.mav.mission_ack_send(*to, result, kind)

    def _ask(self, to, number, kind):
        getattr(self._link.mav, self.asks_by)(*to, self.asks_for(number), kind)
        if self.asks_twice_after_s is not None and number == 2:
            time.sleep(self.asks_twice_after_s)
            getattr(self._link.mav, self.asks_by)(*to, number, kind)

    def _give(self, to, number, kind):
        item = self.lists[kind][number]
        before = {name: getattr(item, name) for name in item.fieldnames}
        self.alter(item)
        if self.moves_home and (number, kind) == (0, 0):
            item.x += 1000
        values = {name: getattr(item, name) for name in item.fieldnames}
        for name, value in before.items():
            setattr(item, name, value)
        values |= {"target_system": to[0], "target_component": to[1]}
        self._link.mav.mission_item_int_send(**values)


def connect(address, answer_s=0.3):
    """Return a link on which the autopilot has been found."""
    link = open_link(address, answer_s=answer_s)
    link.find(20.0)
    return link


def uploaded(own, plan, **options):
    """Upload a plan and close the link."""
    link = connect(own.address, answer_s=0.3)
    try:
        return upload(plan, link, **options)
    finally:
        link.close()
