"""A link in virtual time: it packs messages, delays and loses them by a seed, and delivers them."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import common as mavlink


__all__ = ["Faults", "Wire"]


@dataclass(frozen=True)
class Faults:
    """Faults of one direction of a link.

    Parameters
    ----------
    delay_s, jitter_s : float
        Every message takes the delay, and up to ``jitter_s`` more; order may change.
    loss : float
        Share of messages that do not arrive, 0 to 1.
    twice : float
        Share of messages that arrive twice, 0 to 1.
    dies_s, heals_s : float
        Instants from which nothing is sent, and from which messages are sent again.
    """

    delay_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    twice: float = 0.0
    dies_s: float = float("inf")
    heals_s: float = float("inf")


class Wire:
    """One direction of a link, from a system to whoever reads it.

    Messages travel as the bytes of MAVLink 2, with header and checksum.

    Parameters
    ----------
    system, component : int
        Address of the sender.
    seed : int
        Seed of losses and jitter.
    drops : callable, optional
        Takes a message and returns whether it is lost, for faults at a chosen message.
    """

    def __init__(
        self,
        system: int,
        component: int,
        faults: Faults | None = None,
        *,
        seed: int = 0,
        drops: Callable[[Any], bool] = lambda _message: False,
    ) -> None:
        self.faults = Faults() if faults is None else faults
        self.drops = drops
        self._packer = mavlink.MAVLink(None, system, component)
        self._parser = mavlink.MAVLink(None)
        self._random = np.random.default_rng(seed)
        self._queue: list[tuple[float, int, bytes]] = []
        self._order = count()

    def send(self, message: Any, now_s: float) -> None:
        """Put a message on the wire."""
        faults = self.faults
        packed = bytes(message.pack(self._packer))
        self._packer.seq = (self._packer.seq + 1) % 256
        is_dead = faults.dies_s <= now_s < faults.heals_s
        is_lost = self._random.random() < faults.loss or is_dead
        late_s = faults.delay_s + faults.jitter_s * self._random.random()
        if is_lost or self.drops(message):
            return
        heapq.heappush(self._queue, (now_s + late_s, next(self._order), packed))
        if faults.twice and self._random.random() < faults.twice:
            late_s = faults.delay_s + faults.jitter_s * self._random.random()
            heapq.heappush(self._queue, (now_s + late_s, next(self._order), packed))

    def restart(self) -> None:
        """Number messages from 0 again, as a system does that has restarted."""
        self._packer.seq = 0

    def next_s(self) -> float:
        """Return the instant at which the next message arrives, infinite for none."""
        return self._queue[0][0] if self._queue else float("inf")

    def arrived(self, now_s: float) -> list[Any]:
        """Return the messages that have arrived."""
        out: list[Any] = []
        while self._queue and self._queue[0][0] <= now_s:
            _, _, packed = heapq.heappop(self._queue)
            out += self._parser.parse_buffer(packed) or []
        return out
