"""A small ground station for the simulated autopilot, which shares no code with the host's."""

import csv
from dataclasses import dataclass, field

from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.connection import Connection
from pathgene.sim.autopilot.items import Item
from pathgene.sim.autopilot.pilot import Kind
from tests.support.host.cases import flight_folder


HOME = (46.0, 8.0, 500.0)
ACCEPTED, ERROR, NO_SPACE, INVALID_SEQUENCE, DENIED = 0, 1, 4, 13, 14


def exported(name):
    """Return the mission of a real flight as version 0.2.0 exported it, home first."""
    with (flight_folder(name) / "mission.waypoints").open() as file:
        rows = list(csv.reader(file, delimiter="\t"))[1:]
    return [
        Item(
            int(row[3]),
            int(row[2]),
            tuple(map(float, row[4:8])),
            round(float(row[8]) * 1e7),
            round(float(row[9]) * 1e7),
            float(row[10]),
        )
        for row in rows
    ]


def at(east_m, north_m, z=600.0, command=16, frame=0, params=(0.0, 10.0, 0.0, 0.0)):
    """Return an item at a distance from home."""
    degree = 111_318.845
    lat = HOME[0] + north_m / degree
    lon = HOME[1] + east_m / (degree * 0.6946583704589973)
    return Item(command, frame, params, round(lat * 1e7), round(lon * 1e7), z)


def autopilot_at(items, kind=Kind.ARDUPLANE, **options):
    """Return an autopilot over the home of a mission."""
    home = items[0]
    return Autopilot(kind, Start((home.lat, home.lon, home.z)), **options)


@dataclass
class Station:
    """A ground station that answers every request.

    Parameters
    ----------
    patient : bool
        Whether complaints of the sequence are ignored while requests arrive; the uploader of
        version 0.2.0 took each for the end.

    Attributes
    ----------
    texts, acks, states : list
        Texts, results of uploads, and states of the mission that have arrived.
    """

    connection: Connection
    patient: bool = True
    texts: list = field(default_factory=list)
    acks: list = field(default_factory=list)
    states: list = field(default_factory=list)
    results: list = field(default_factory=list)

    def upload(self, items, kind=0, quiet_s=20.0):
        """Upload a list and return the result, or None if the autopilot falls silent."""
        mav = self.connection.mav
        mav.mission_count_send(1, 1, len(items), kind)
        while (message := self._read(quiet_s)) is not None:
            name = message.get_type()
            if name in ("MISSION_REQUEST", "MISSION_REQUEST_INT") and message.mission_type == kind:
                self.send_item(items[message.seq], message.seq, kind)
            is_end = name == "MISSION_ACK" and message.mission_type == kind
            if is_end and not (self.patient and message.type == INVALID_SEQUENCE):
                return message.type
        return None

    def send_item(self, item, seq, kind=0):
        self.connection.mav.mission_item_int_send(
            *(1, 1, seq, item.frame, item.command, 0, item.autocontinue),
            *(*item.params, item.x, item.y, item.z, kind),
        )

    def download(self, kind=0):
        """Return the items that the autopilot holds."""
        mav = self.connection.mav
        mav.mission_request_list_send(1, 1, kind)
        count = self._until("MISSION_COUNT").count
        items = []
        for seq in range(count):
            mav.mission_request_int_send(1, 1, seq, kind)
            items.append(self._until("MISSION_ITEM_INT"))
        return items

    def command(self, number, *params):
        """Send a command and return its result."""
        values = [*params, *[0.0] * (7 - len(params))]
        self.connection.mav.command_long_send(1, 1, number, 0, *values)
        return self._until("COMMAND_ACK").result

    def parameter(self, name):
        """Return a parameter."""
        self.connection.mav.param_request_read_send(1, 1, name.encode(), -1)
        return self._until("PARAM_VALUE").param_value

    def wait(self, seconds):
        """Let time pass."""
        for message in self.connection.wait(seconds):
            self._note(message)

    def _until(self, name):
        while (message := self._read(20.0)) is not None:
            if message.get_type() == name:
                return message
        raise AssertionError(f"no {name}")

    def _read(self, quiet_s):
        """Return the next message that is no telemetry, or None after a silence."""
        end_s = self.connection.now_s + quiet_s
        while (left_s := end_s - self.connection.now_s) > 0:
            message = self.connection.recv_match(timeout=left_s)
            if message is not None and not self._note(message):
                return message
        return None

    def _note(self, message):
        """Note a message; return whether it is telemetry."""
        match message.get_type():
            case "STATUSTEXT" if message.chunk_seq and self.texts:
                self.texts[-1] += message.text
            case "STATUSTEXT":
                self.texts.append(message.text)
            case "MISSION_CURRENT":
                self.states.append(message.mission_state)
            case "MISSION_ACK":
                self.acks.append(message.type)
                return False
            case "HEARTBEAT" | "GLOBAL_POSITION_INT" | "ATTITUDE" | "VFR_HUD":
                pass
            case "MISSION_ITEM_REACHED":
                pass
            case _:
                return False
        return True


def connected(autopilot, **options):
    """Return a station on a link without faults, or with them."""
    patient = options.pop("patient", True)
    return Station(Connection(autopilot, **options), patient)
