"""MAVSDK as the other end: a reader of plans, and an autopilot that takes missions over UDP."""

import contextlib
import socket

from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.mission_raw import MissionRaw


def free_port():
    """Return a UDP port that nobody has at the moment."""
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
