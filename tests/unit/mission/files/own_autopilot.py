"""An autopilot of our own on UDP, whose faults can be set."""

import os
import threading


os.environ["MAVLINK20"] = "1"

from pymavlink import mavutil


class OwnAutopilot(threading.Thread):
    """Keeps a list for each kind of mission and gives it back, a little wrong if told so.

    Attributes
    ----------
    kind : int
        Value of MAV_AUTOPILOT in its heartbeat.
    lists : dict
        Items by the kind of mission.
    alter : callable
        Changes an item before it is given back.
    keeps : int
        Most items that it gives back.
    drops : int
        Loses every so many messages that it receives; 0 for none.
    refuses : tuple
        Number of items, and the result with which it refuses the next.
    """

    def __init__(self):
        super().__init__(daemon=True)
        self.kind = 0
        self.lists = {0: [], 1: []}
        self.alter = lambda _item: None
        self.keeps = 10_000
        self.drops = 0
        self.refuses = None
        self.asks_by = "mission_request_int_send"
        self.has_fences = True
        self.moves_home = False
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
                self._link.mav.heartbeat_send(1, self.kind, 0, 0, 0)
                continue
            number += 1
            if not self.drops or number % self.drops:
                self._answer(message)

    def _answer(self, message):
        mav, to = self._link.mav, (message.get_srcSystem(), message.get_srcComponent())
        kind = getattr(message, "mission_type", 0)
        match message.get_type():
            case "MISSION_COUNT" | "MISSION_CLEAR_ALL" if kind == 1 and not self.has_fences:
                mav.mission_ack_send(*to, 3, kind)
            case "MISSION_CLEAR_ALL":
                self.lists[kind] = []
                mav.mission_ack_send(*to, 0, kind)
            case "MISSION_COUNT":
                self.lists[kind] = [None] * message.count
                self._ask(to, 0, kind)
            case "MISSION_ITEM_INT":
                items = self.lists[kind]
                items[message.seq] = message
                if self.refuses and kind == 0 and message.seq + 1 == self.refuses[0]:
                    mav.mission_ack_send(*to, self.refuses[1], kind)
                elif message.seq + 1 < len(items):
                    self._ask(to, message.seq + 1, kind)
                else:
                    mav.mission_ack_send(*to, 0, kind)
            case "MISSION_REQUEST_LIST":
                mav.mission_count_send(*to, min(self.keeps, len(self.lists[kind])), kind)
            case "MISSION_REQUEST_INT":
                self._give(to, message.seq, kind)

    def _ask(self, to, number, kind):
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
