"""The autopilot as links see it."""

from __future__ import annotations

from typing import Any, Protocol


__all__ = ["Endpoint"]


class Endpoint(Protocol):
    """A system that takes and sends messages.

    Attributes
    ----------
    system, component : int
        Its address.
    """

    system: int
    component: int

    @property
    def time_s(self) -> float:
        """Instant up to which it has acted."""

    def handle(self, message: Any, now_s: float) -> list[Any]:
        """Return the answers to a message."""

    def advance(self, now_s: float) -> list[Any]:
        """Act up to an instant and return the unrequested messages."""
