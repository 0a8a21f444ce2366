"""The autopilot as its commands and its telemetry see it."""

from __future__ import annotations

from enum import IntEnum
from typing import Protocol

from pathgene.sim.autopilot.lists import Lists
from pathgene.sim.autopilot.parameters import Parameters
from pathgene.sim.autopilot.pilot import Kind, Pilot
from pathgene.sim.autopilot.targets import Earth


__all__ = ["CommandResult", "Controlled"]


class CommandResult(IntEnum):
    """Values of MAV_RESULT."""

    ACCEPTED = 0
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4


class Controlled(Protocol):
    """State and actions of the autopilot; see :class:`Autopilot`."""

    kind: Kind
    parameters: Parameters
    earth: Earth
    lists: Lists
    pilot: Pilot
    armed: bool
    booted_s: float

    def say(self, text: str) -> None:
        """Send a text to the ground station."""

    def fly_mission(self) -> CommandResult:
        """Begin the mission."""

    def mission_refusal(self) -> str | None:
        """Return why the mission will not start."""

    def set_current(self, index: int) -> bool:
        """Continue the mission with another item."""

    def return_home(self, reason: str) -> None:
        """Return home."""

    def tell(self, number: int) -> CommandResult:
        """Send the message of a number."""
