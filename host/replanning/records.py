"""Records of a flight with replans: its tracks, and the changes with their planning attempts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pathgene.host.replanning.planner import Attempt
from pathgene.host.replanning.tracks import Track


__all__ = ["Change", "Leg", "Pending"]


@dataclass
class Change:
    """A change of the situation, with its planning attempts and outcome.

    Parameters
    ----------
    at_s : float
        Seconds since the start of the path was passed.
    what : str
        The change in words.
    needed : bool
        The track could no longer be followed: a zone is on it, or the goal or the wind changed.
    inside_m : float
        The shortest way out of the zones that the aircraft is in; 0 outside.
    attempts : list of (float, Attempt)
        Each attempt with the time at which it began.
    active_s : float or None
        Seconds until the autopilot had the new path; None if it never did.
    flown_m : float or None
        Metres flown by then.
    held : bool
        The aircraft had to wait on a circle.
    fitness : float or None
        F of the new path.
    """

    at_s: float
    what: str
    needed: bool
    inside_m: float = 0.0
    attempts: list[tuple[float, Attempt]] = field(default_factory=list)
    active_s: float | None = None
    flown_m: float | None = None
    held: bool = False
    fitness: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """The change as in ``flight.json``."""
        return {
            "at_s": self.at_s,
            "what": self.what,
            "needed": self.needed,
            "inside_m": self.inside_m,
            "active_ms": None if self.active_s is None else 1000 * self.active_s,
            "flown_m": self.flown_m,
            "held": self.held,
            "fitness": self.fitness,
            "attempts": [
                {
                    "at_s": at_s,
                    "planner": attempt.planner,
                    "found": attempt.plan is not None,
                    "reason": attempt.reason or None,
                    **attempt.time.to_dict(),
                }
                for at_s, attempt in self.attempts
            ],
        }


@dataclass(frozen=True)
class Pending:
    """An attempt in progress, ready at ``ready_s``; its path leaves the track at ``leaves_m``."""

    ready_s: float
    attempt: Attempt
    leaves_m: float
    track: Track | None


@dataclass(frozen=True)
class Leg:
    """A track, the time at which it began, and its kind: ``path``, ``holding`` or ``way-out``."""

    since_s: float
    kind: str
    track: Track
