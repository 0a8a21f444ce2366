"""The exported mission of a path, flown item by item by the laws of an autopilot in JSBSim."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from statistics import fmean

import numpy as np

from pathgene.host.errors import JobError
from pathgene.host.flight.autopilots import SimulatedAutopilot
from pathgene.host.flight.flight import PERIOD_S, Flight, Flown, Sample, flown_of
from pathgene.host.flight.guidance import State
from pathgene.host.flight.models import FlightModel
from pathgene.host.formats.flight_plan import FlightPlan
from pathgene.host.planners.base import Stop
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.problem import Problem


__all__ = ["fly_mission"]

# Samples of a tenth of a second, in which the autopilot gives one set of demands.
_SAMPLES = round(0.1 / PERIOD_S)
# The mission begins this long before the start of the path, so that the autopilot has settled.
_JOIN_S = 15.0
# The pitch of level cruise is a mean over this time before.
_TRIM_S = 10.0
_CROSS, _HEIGHT, _ALONG = 5, 6, 4


class _Carried:
    """The aircraft of a flight under the demands of an autopilot; it records the flight.

    Parameters
    ----------
    trim_rad : float
        Pitch in level cruise, from which an autopilot measures the pitch.
    """

    def __init__(self, flight: Flight, model: FlightModel, trim_rad: float) -> None:
        self._flight = flight
        self._trim_rad = trim_rad
        self.level_throttle = model.throttle_level
        self.climb_throttle = model.throttle_climb
        self.throttle = model.throttle_level
        self.samples: list[Sample] = []

    @property
    def state(self) -> State:
        """The present state."""
        state = self._flight.state
        return replace(state, pitch_rad=state.pitch_rad - self._trim_rad)

    @property
    def wind(self) -> tuple[float, float]:
        """Velocity of the air over ground, gusts included, m/s in x and y."""
        return self._flight.wind

    def step(self, roll_rad: float, pitch_rad: float, throttle: float) -> None:
        """Fly for a tenth of a second with these demands."""
        self.throttle = throttle
        pitch_rad += self._trim_rad
        for _ in range(_SAMPLES):
            self.samples.append(self._flight.step_attitude(roll_rad, pitch_rad, throttle))


def fly_mission(
    flight: Flight,
    plan: FlightPlan,
    autopilot: SimulatedAutopilot,
    problem: Problem,
    figures: tuple[FlightModel, Aircraft],
    stop: Stop | None = None,
) -> tuple[Flown, list[str]]:
    """Fly the items of a plan and the end of its mission, without the glide of a landing.

    Parameters
    ----------
    flight : Flight
        The flight, not begun yet; the ideal guidance flies its lead-in.
    figures : (FlightModel, Aircraft)
        The aircraft that flies, and its figures.

    Returns
    -------
    tuple of (Flown, list of str)
        The flight since the start of the track, and notes on the autopilot's parameters.

    Raises
    ------
    JobError
        If the autopilot refuses the plan, or the aircraft is lost before it reaches the start.
    KeyboardInterrupt
        If ``stop`` ends the flight before the start.
    """
    model, aircraft = figures
    stop = Stop() if stop is None else stop
    join_m = -_JOIN_S * aircraft.cruise_speed_m_s
    incidences: deque[float] = deque(maxlen=round(_TRIM_S / PERIOD_S))
    while flight.commands.place.along_m < join_m and not stop.requested:
        flight.step()
        state = flight.state
        slope = math.asin(max(-1.0, min(state.climb_m_s / max(state.airspeed_m_s, 1.0), 1.0)))
        incidences.append(state.pitch_rad - slope)
    craft = _Carried(flight, model, fmean(incidences or [0.0]))
    mission = autopilot.accept(problem, plan, aircraft, craft)
    at_end = math.inf
    while not (interrupted := stop.requested) and not mission.is_over:
        mission.tick()
        if mission.is_at_end:
            at_end = min(at_end, len(craft.samples))
        if not all(map(math.isfinite, craft.samples[-1])):
            del craft.samples[-_SAMPLES:]
            break
    stop.heeded = True
    lands = plan.end is not None and plan.end.kind == "land"
    flown = craft.samples[: int(at_end)] if lands and at_end < math.inf else craft.samples
    samples = _since_start(flown, flight.route.length_m, at_end)
    if not samples:
        if interrupted:
            raise KeyboardInterrupt
        raise JobError(
            "The aircraft did not reach the start of the path; the gusts are too strong."
        )
    arrived = mission.has_arrived and not interrupted
    return flown_of(samples, arrived=arrived, interrupted=interrupted), mission.notes


def _since_start(samples: list[Sample], length_m: float, at_end: float) -> list[Sample]:
    """Return the samples from the start of the track on, those after its end marked as such."""
    if not samples:
        return []
    table = np.array(samples)
    along = table[:, _ALONG]
    beyond = np.maximum.accumulate(along >= length_m) | (np.arange(len(table)) >= at_end)
    reached = np.flatnonzero((along >= 0) & ~beyond)
    if not len(reached):
        return []
    table[beyond, _ALONG] = length_m
    table[beyond, _CROSS] = table[beyond, _HEIGHT] = np.nan
    return [tuple(row) for row in table[reached[0] :].tolist()]
