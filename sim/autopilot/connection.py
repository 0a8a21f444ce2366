"""A ground station's connection to the simulated autopilot, in virtual time.

It has the methods of pymavlink's connections that a ground station uses. A call that waits lets the
virtual time pass, the autopilot fly and the messages travel, so an upload with timeouts of seconds
takes milliseconds and is the same each time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from pathgene.sim.autopilot.endpoint import Endpoint
from pathgene.sim.autopilot.link import Faults, Wire
from pathgene.sim.autopilot.vehicle import PERIOD_S


__all__ = ["Connection"]


class Connection:
    """A link between a ground station and an autopilot.

    Parameters
    ----------
    autopilot : Endpoint
        The autopilot, or a part of a test that stands before it and alters its messages.
    up, down : Faults, optional
        Faults of the way to the autopilot, and back.
    seed : int
        Seed of the faults.
    system, component : int
        Address of the ground station.
    beside : sequence of Endpoint
        Further systems on the same link; only the wire to the first one's station has faults.

    Attributes
    ----------
    now_s : float
        The present instant.
    mav : pymavlink's MAVLink
        Sends messages: a method for each.
    up, down : Wire
        The two directions, which can lose chosen messages.
    """

    def __init__(
        self,
        autopilot: Endpoint,
        up: Faults | None = None,
        down: Faults | None = None,
        *,
        seed: int = 0,
        system: int = 255,
        component: int = 190,
        beside: Sequence[Endpoint] = (),
    ) -> None:
        self.autopilot = autopilot
        self.now_s = autopilot.time_s
        self.up = Wire(system, component, up, seed=2 * seed)
        self.down = Wire(autopilot.system, autopilot.component, down, seed=2 * seed + 1)
        self._ways = [(autopilot, self.down)]
        self._ways += [(other, Wire(other.system, other.component)) for other in beside]
        self.mav = mavlink.MAVLink(_Port(self), system, component)
        self.port = None
        self._parser = mavlink.MAVLink(None)
        self._inbox: deque[Any] = deque()
        self._next_tick_s = self.now_s + PERIOD_S

    def clock(self) -> float:
        """Return the present instant, as ``time.monotonic`` does."""
        return self.now_s

    def recv_msg(self) -> Any:
        """Return a message that has arrived, or None."""
        self._happen()
        return self._inbox.popleft() if self._inbox else None

    def recv_match(
        self, type: Any = None, *, blocking: bool = True, timeout: float | None = None
    ) -> Any:
        """Return the next message, of one of some types if they are named, or None in the end.

        Parameters
        ----------
        type : str or sequence of str, optional
            Types of messages; messages of another type are discarded.
        timeout : float
            Seconds to wait; a call that blocks needs it.
        """
        types = (type,) if isinstance(type, str) else type
        end_s = self.now_s + (timeout or 0.0) * blocking
        while True:
            self._happen()
            while self._inbox:
                message = self._inbox.popleft()
                if types is None or message.get_type() in types:
                    return message
            if self.now_s >= end_s:
                return None
            self._pass_to(end_s)

    def wait(self, seconds: float) -> list[Any]:
        """Let time pass and return all messages that arrive."""
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            self._pass_to(end_s)
            self._happen()
        arrived, self._inbox = list(self._inbox), deque()
        return arrived

    def close(self) -> None:
        """End the connection; the autopilot remains."""

    def put(self, packed: bytes) -> None:
        """Put packed messages on the wire to the autopilot."""
        for message in self._parser.parse_buffer(packed) or []:
            self.up.send(message, self.now_s)

    def _pass_to(self, end_s: float) -> None:
        """Go to the next instant at which something happens, at the latest ``end_s``."""
        down_s = (down.next_s() for _, down in self._ways)
        next_s = min(self.up.next_s(), *down_s, self._next_tick_s, end_s)
        self.now_s = max(self.now_s, next_s)

    def _happen(self) -> None:
        """Deliver the messages that are due, and let the autopilot act."""
        # Another connection may have let time pass.
        self.now_s = max(self.now_s, self.autopilot.time_s)
        for message in self.up.arrived(self.now_s):
            for system, down in self._ways:
                self._reply(system.handle(message, self.now_s), down)
        if self.now_s >= self._next_tick_s:
            self._next_tick_s = self.now_s + PERIOD_S
            for system, down in self._ways:
                self._reply(system.advance(self.now_s), down)
        for _, down in self._ways:
            self._inbox.extend(down.arrived(self.now_s))

    def _reply(self, messages: list[Any], down: Wire) -> None:
        for message in messages:
            down.send(message, self.now_s)


class _Port:
    """A file that puts all bytes on the wire."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def write(self, packed: bytes) -> None:
        """Send packed messages."""
        self._connection.put(bytes(packed))
