"""The simulated autopilot on UDP, in a thread, in the time of the clock."""

from __future__ import annotations

import socket
import threading
import time
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from pathgene.sim.autopilot.endpoint import Endpoint


__all__ = ["Served"]

# Seconds between two calls of the autopilot without a message.
_PAUSE_S = 0.02


class Served(threading.Thread):
    """A thread that serves an autopilot to every ground station that sends it a datagram.

    Parameters
    ----------
    speed : float
        Seconds of flight per second of the clock.

    Attributes
    ----------
    port : int
        UDP port on the local host.
    """

    def __init__(self, autopilot: Endpoint, *, port: int = 0, speed: float = 1.0) -> None:
        super().__init__(daemon=True)
        self.autopilot = autopilot
        self._speed = speed
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", port))
        self._socket.settimeout(_PAUSE_S)
        self.port = self._socket.getsockname()[1]
        self._packer = mavlink.MAVLink(None, autopilot.system, autopilot.component)
        self._parsers: dict[Any, Any] = {}
        self._closed = threading.Event()

    def run(self) -> None:
        """Answer until :meth:`close`."""
        begun = time.monotonic()
        while not self._closed.is_set():
            try:
                packed, sender = self._socket.recvfrom(65536)
            except TimeoutError:
                packed, sender = b"", None
            now_s = (time.monotonic() - begun) * self._speed
            if sender is not None:
                parser = self._parsers.setdefault(sender, mavlink.MAVLink(None))
                for message in parser.parse_buffer(packed) or []:
                    self._send(self.autopilot.handle(message, now_s), [sender])
            self._send(self.autopilot.advance(now_s), list(self._parsers))

    def close(self) -> None:
        """Stop the thread and close the port."""
        self._closed.set()
        self.join()
        self._socket.close()

    def _send(self, messages: list[Any], receivers: list[Any]) -> None:
        for message in messages:
            packed = bytes(message.pack(self._packer))
            self._packer.seq = (self._packer.seq + 1) % 256
            for receiver in receivers:
                self._socket.sendto(packed, receiver)
