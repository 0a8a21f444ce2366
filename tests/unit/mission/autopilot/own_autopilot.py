"""The simulated autopilot with faults that a test chooses, in virtual time or on UDP."""

from dataclasses import replace
from types import SimpleNamespace

from pymavlink.dialects.v20 import common as mavlink

from pathgene.host.mission.autopilot.mavlink_link import Link, open_link
from pathgene.host.mission.autopilot.upload import upload
from pathgene.sim.autopilot.autopilot import Autopilot, Start, parameters_of
from pathgene.sim.autopilot.connection import Connection
from pathgene.sim.autopilot.items import Item
from pathgene.sim.autopilot.pilot import Kind
from pathgene.sim.autopilot.rules import ARDUPLANE_RULES, PX4_RULES
from pathgene.sim.autopilot.served import Served


ARDUPILOT = 3
# Values of MAV_MISSION_RESULT.
ERROR, UNSUPPORTED, DENIED, CANCELLED = 1, 3, 14, 15


class OwnAutopilot:
    """An autopilot on the ground that stands between a link and the simulated one.

    As ArduPilot (``kind`` 3), it has ArduPlane's rules, as any other kind PX4's.

    Attributes
    ----------
    kind : int
        Value of MAV_AUTOPILOT in its heartbeat.
    armed, runs : bool
        Whether its motors run, and whether it flies its mission.
    lists : dict
        Items by the kind of mission, as the autopilot keeps them.
    arrived : dict
        The latest messages with items, as they arrived, by kind and number.
    alter : callable
        Changes the message of an item before it is returned.
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
        It first answers a request for a list by the size of another one.
    keeps_home : bool
        Home stays when its mission is cleared.
    loses : callable
        Sees each acknowledgement, result and kind, and tells whether it is lost.
    """

    system, component = 7, 1

    def __init__(self):
        self._autopilot = Autopilot(
            Kind.PX4, Start((46.0, 7.0, 500.0), armed=False), system=self.system
        )
        self._lists = self._autopilot.lists
        self._home = Item(16, 0, (0.0,) * 4, 460_000_000, 70_000_000, 500.0)
        self.runs = False
        self._lists._runs = lambda: self.runs
        self.arrived = {}
        self.alter = lambda _message: None
        self.keeps = 10_000
        self.drops = 0
        self.breaks = lambda _message: None
        self.loses = lambda _result, _kind: False
        self.asks_for = lambda number: number
        self.mixes_lists = self.keeps_home = False
        self.has_fences = True
        self.asks_twice_after_s = None
        self._received = 0
        self._late = []
        self._served = None
        self.kind = 0

    @property
    def kind(self):
        return self._kind

    @kind.setter
    def kind(self, kind):
        self._kind = kind
        self._lists.home = self._home if kind == ARDUPILOT else None
        self._lists.rules = ARDUPLANE_RULES if kind == ARDUPILOT else PX4_RULES
        self._autopilot.kind = Kind.ARDUPLANE if kind == ARDUPILOT else Kind.PX4
        # PX4 starts missions without a landing, too.
        self._autopilot.parameters = parameters_of(self._autopilot.kind)
        self._autopilot.parameters["MIS_TKO_LAND_REQ"] = 0.0

    @property
    def armed(self):
        return self._autopilot.armed

    @armed.setter
    def armed(self, armed):
        self._autopilot.armed = armed

    @property
    def lists(self):
        made = {}
        for kind in (0, 1, 2):
            made[kind] = [
                SimpleNamespace(
                    mission_type=kind,
                    seq=seq,
                    **{f"param{number}": value for number, value in enumerate(item.params, 1)},
                    **{name: getattr(item, name) for name in KEPT},
                )
                for seq, item in enumerate(self._lists.items[kind])
            ]
        return made

    def follow(self, **rules):
        """Change rules of the protocol, of :class:`pathgene.sim.autopilot.rules.Rules`."""
        self._lists.rules = replace(self._lists.rules, **rules)

    @property
    def current(self):
        """Number of the item that the mission begins with."""
        return self._autopilot.pilot.sequencer.resumes

    @current.setter
    def current(self, number):
        self._autopilot.set_current(number)

    @property
    def address(self):
        """Address on UDP; the first use begins to serve it there."""
        if self._served is None:
            self._served = Served(self)
            self._served.start()
        return f"udpout:127.0.0.1:{self._served.port}"

    def close(self):
        if self._served is not None:
            self._served.close()

    @property
    def time_s(self):
        return self._autopilot.time_s

    def handle(self, message, now_s):
        self._received += message.get_type() != "HEARTBEAT"
        interrupt = broken = None
        try:
            broken = self.breaks(message)
        except KeyboardInterrupt as error:
            # The ground station is interrupted while the message is on its way.
            interrupt = error
        is_dropped = self.drops and not self._received % self.drops
        if broken == "lost" or is_dropped:
            answers = []
        elif broken is not None:
            answers = [self._acknowledgement(message, broken)]
            if message.get_type() == "MISSION_ITEM_INT":
                self._lists.abandon(message.mission_type)
        elif not self.has_fences and getattr(message, "mission_type", 0) == 1:
            answers = [self._acknowledgement(message, UNSUPPORTED)]
        else:
            if message.get_type() == "MISSION_ITEM_INT":
                self.arrived[message.mission_type, message.seq] = message
            before = self._lists.items[0]
            answers = self._autopilot.handle(message, now_s)
            if self.keeps_home and message.get_type() == "MISSION_CLEAR_ALL":
                self._lists.items[0] = self._lists.items[0] or before[:1]
        answers = self._altered(answers, now_s)
        if interrupt is not None:
            self._late += [(now_s, answer) for answer in answers]
            raise interrupt
        return answers

    def advance(self, now_s):
        due = [message for time_s, message in self._late if time_s <= now_s]
        self._late = [(time_s, message) for time_s, message in self._late if time_s > now_s]
        return due + self._altered(self._autopilot.advance(now_s), now_s)

    @staticmethod
    def _acknowledgement(message, result):
        sender = message.get_srcSystem(), message.get_srcComponent()
        kind = getattr(message, "mission_type", 0)
        return mavlink.MAVLink_mission_ack_message(*sender, result, mission_type=kind)

    def _other_count(self, message):
        """Return the size of another list than the one that is asked for."""
        to = message.target_system, message.target_component
        other = (message.mission_type + 1) % 3
        return mavlink.MAVLink_mission_count_message(
            *to, len(self._lists.items[other]), mission_type=other
        )

    def _altered(self, messages, now_s):
        """Return the messages that are sent, with their faults."""
        out = []
        for message in messages:
            match message.get_type():
                case "HEARTBEAT":
                    message.autopilot = self.kind
                case "MISSION_ACK" if self.loses(message.type, message.mission_type):
                    continue
                case "MISSION_COUNT":
                    if self.mixes_lists:
                        out.append(self._other_count(message))
                    message.count = min(self.keeps, message.count)
                case "MISSION_ITEM_INT":
                    self.alter(message)
                case "MISSION_REQUEST" | "MISSION_REQUEST_INT":
                    if self.asks_twice_after_s is not None and message.seq == 2:
                        self._late.append((now_s + self.asks_twice_after_s, message))
                    message.seq = self.asks_for(message.seq)
            out.append(message)
        return out


#: Members of an item that :attr:`OwnAutopilot.lists` has.
KEPT = ("command", "frame", "x", "y", "z", "autocontinue")


def connect(to, answer_s=0.3, system=None):
    """Return a link on which the autopilot has been found: to an address, or in virtual time."""
    if isinstance(to, str):
        link = open_link(to, answer_s=answer_s)
    else:
        connection = Connection(to)
        link = Link(connection, answer_s, connection.clock)
    link.find(20.0, system)
    return link


def uploaded(own, plan, **options):
    """Upload a plan in virtual time and close the link."""
    link = connect(own)
    try:
        return upload(plan, link, **options)
    finally:
        link.close()
