"""MAVSDK as the peer: a reader of plans, and an autopilot that accepts missions over UDP."""

import contextlib
import select
import socket
import threading

from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.mission_raw import MissionRaw
from mavsdk.plugins.mission_raw_server import MissionRawServer, MissionRawServerResult
from pymavlink.dialects.v20 import common as mavlink


def free_port():
    """Return a UDP port that is currently free."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def _mavsdk(kind):
    return Mavsdk(Configuration.create_with_component_type(kind))


@contextlib.contextmanager
def importer():
    """Yield MAVSDK's function that reads the text of a ``.plan``."""
    port = free_port()
    vehicle, station = _mavsdk(ComponentType.AUTOPILOT), _mavsdk(ComponentType.GROUND_STATION)
    try:
        station.add_any_connection(f"udpin://127.0.0.1:{port}")
        vehicle.add_any_connection(f"udpout://127.0.0.1:{port}")
        system = station.first_autopilot(20.0)
        assert system is not None, "MAVSDK does not see its own autopilot"
        yield MissionRaw(system).import_qgroundcontrol_mission_from_string
    finally:
        vehicle.destroy()
        station.destroy()


class Autopilot:
    """An autopilot of MAVSDK that accepts missions and fences over UDP.

    ``received`` has the items of each complete list in the order of arrival.
    """

    def __init__(self):
        self.port = free_port()
        self.address = f"udpout:127.0.0.1:{self.port}"
        self.received = []
        self._vehicle = _mavsdk(ComponentType.AUTOPILOT)
        self._vehicle.add_any_connection(f"udpin://127.0.0.1:{self.port}")
        self._server = MissionRawServer(self._vehicle.server_component())
        self._server.subscribe_incoming_mission(self._take)

    def _take(self, result, plan, _context):
        if result == MissionRawServerResult.SUCCESS:
            self.received.append(plan.mission_items)

    def close(self):
        self._vehicle.destroy()


class Proxy(threading.Thread):
    """A UDP link that carries messages from an autopilot until it breaks, then nothing.

    ``breaks`` is called with each message of the autopilot; the first one for which it returns
    true is lost, and all after it.
    """

    def __init__(self, port, breaks):
        super().__init__(daemon=True)
        self._inside = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._inside.connect(("127.0.0.1", port))
        self._outside = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._outside.bind(("127.0.0.1", 0))
        self.address = f"udpout:127.0.0.1:{self._outside.getsockname()[1]}"
        self._breaks = breaks
        self._closed = threading.Event()
        self.start()

    def run(self):
        client = None
        broken = False
        parser = mavlink.MAVLink(None)
        while not self._closed.is_set():
            ready, _, _ = select.select([self._inside, self._outside], [], [], 0.05)
            if self._outside in ready:
                data, client = self._outside.recvfrom(65536)
                if not broken:
                    self._inside.send(data)
            if self._inside in ready:
                data = self._inside.recv(65536)
                broken = broken or any(map(self._breaks, parser.parse_buffer(data) or []))
                if client and not broken:
                    self._outside.sendto(data, client)

    def close(self):
        self._closed.set()
        self.join()
        self._inside.close()
        self._outside.close()
