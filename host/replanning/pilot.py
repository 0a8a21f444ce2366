"""The aircraft in the air: its current and earlier tracks, and its flown positions."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

from pathgene.host.flight.flight import PERIOD_S, Flight, Sample
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.replanning.planner import Attempt
from pathgene.host.replanning.tracks import Pose, Track, pose_at


__all__ = ["Change", "Leg", "Pending", "Pilot"]


@dataclass
class Change:
    """A change of the situation, with its planning attempts and outcome.

    Parameters
    ----------
    at_s : float
        Seconds since the start of the path was passed.
    needed : bool
        The track could no longer be followed: a zone is on it, or the goal or the wind changed.
    inside_m : float
        The shortest route out of the zones that the aircraft is in; 0 outside.
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


# The remaining fuel is at least this share.
_LEAST_FUEL = 1e-6


class Pilot:
    """Flies along a track that can be replaced at any time.

    Parameters
    ----------
    flight : Flight
        A flight that has not begun; it is flown up to the start of its track.
    aircraft : Aircraft
        The aircraft at the beginning of the flight.

    Attributes
    ----------
    samples : list of Sample
        The flight, every :data:`pathgene.host.flight.flight.PERIOD_S`, beginning at the start
        of the track.
    burnt_N : float
        Fuel burnt.
    """

    def __init__(self, flight: Flight, track: Track, aircraft: Aircraft) -> None:
        self.flight, self.track = flight, track
        self._aircraft = aircraft
        self.burnt_N = 0.0
        self.samples: list[Sample] = []
        self.legs = [Leg(0.0, "path", track)]
        while self.along_m < 0:
            flight.step()

    @property
    def time_s(self) -> float:
        """Seconds since the start of the first track was passed."""
        return len(self.samples) * PERIOD_S

    @property
    def kind(self) -> str:
        """Kind of the current track: ``path``, ``holding`` or ``way-out``."""
        return self.legs[-1].kind

    @property
    def along_m(self) -> float:
        """Distance along the track, metres."""
        return self.flight.commands.place.along_m

    @property
    def has_arrived(self) -> bool:
        """True once the end of the track is reached."""
        return self.along_m >= self.flight.route.length_m

    @property
    def aircraft(self) -> Aircraft:
        """The aircraft with its remaining fuel."""
        began = self._aircraft
        if began.fuel_weight_N is None:
            return began
        # Its figures must be positive even if no fuel is left.
        burnt = min(self.burnt_N, (1 - _LEAST_FUEL) * began.fuel_weight_N)
        return dataclasses.replace(
            began,
            weight_N=began.weight_N - burnt,
            fuel_weight_N=began.fuel_weight_N - burnt,
        )

    @property
    def ground_speed_m_s(self) -> float:
        """Speed over ground."""
        state = self.flight.state
        return math.hypot(state.east_m_s, state.north_m_s)

    def pose(self, ahead_m: float = 0.0) -> Pose:
        """Return the pose of the track at a distance ahead of the aircraft."""
        return pose_at(self.track, self.along_m + ahead_m)

    def follow(self, kind: str, track: Track) -> None:
        """Continue along another track, which begins next to or astern of the aircraft."""
        self.track = track
        self.flight.follow(track)
        self.legs.append(Leg(self.time_s, kind, track))

    def step(self) -> Sample:
        """Fly for :data:`pathgene.host.flight.flight.PERIOD_S`; return the sample."""
        sample = self.flight.step()
        self.samples.append(sample)
        consumption = self._aircraft.specific_fuel_consumption_N_per_Ws
        self.burnt_N += self.flight.state.power_W * PERIOD_S * consumption
        return sample
