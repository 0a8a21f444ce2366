"""Limits of an aircraft, a class each: the allowed value, its check along a track, its texts.

The verdict, the report of a path, the pictures, the page and the diagnosis take the limits from
:data:`AIRCRAFT_LIMITS`. CONTRIBUTING.md says how to add one.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from typing import ClassVar, NamedTuple

from pathgene.host.evaluation import broken, rule_kernels
from pathgene.host.evaluation.laid_track import LaidTrack
from pathgene.host.problem.problem import Problem


__all__ = ["AIRCRAFT_LIMITS", "AircraftLimit", "Worst", "limit_named", "line_limits"]


class Worst(NamedTuple):
    """The worst value of a limit on a track.

    Parameters
    ----------
    value : float
        The value, in the unit of the limit.
    allowed : float
        The allowed value.
    at_m : float
        Metres flown to the place of the value.
    """

    value: float
    allowed: float
    at_m: float


class AircraftLimit(ABC):
    """A limit of the aircraft.

    Attributes
    ----------
    name : str
        Its name in summaries.
    unit : str
        Unit of its values.
    is_minimum : bool
        True if a value must not be below the allowed one, False if it must not be above.
    is_compiled : bool
        True if the kernels judge it. Another limit adds the metres of its stretches to the penalty.
    """

    name: ClassVar[str]
    unit: ClassVar[str]
    is_minimum: ClassVar[bool] = False
    is_compiled: ClassVar[bool] = False

    @abstractmethod
    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        """Return the worst value on a track, or None where the limit does not apply."""

    @abstractmethod
    def stretches(self, problem: Problem, track: LaidTrack) -> Iterable[broken.Span]:
        """Return the stretches of a track that break the limit, in metres flown."""

    def altitude_m(self, problem: Problem) -> float | None:
        """Return the altitude of a limit on altitudes, which pictures draw as a line, else None."""
        return None

    def words(self, problem: Problem) -> str:
        """Return the name of the limit in a sentence."""
        return f"the {self.name.replace('-', ' ')} of {problem.aircraft.name}"

    @property
    def label(self) -> str:
        """The name of the limit in pictures."""
        return self.name.replace("-", " ")


class _Slope(AircraftLimit):
    """The vertical speed of the steepest climb or descent."""

    unit, is_compiled = "m/s", True
    sign: ClassVar[int]

    @abstractmethod
    def _degrees(self, problem: Problem) -> float:
        """Return the steepest slope in still air, degrees."""

    def worst(self, problem: Problem, track: LaidTrack) -> Worst:
        worst, at = track.most(self.sign, rule_kernels.VERTICAL_SPEED)
        slope = math.radians(self._degrees(problem))
        allowed = problem.aircraft.cruise_speed_m_s * math.sin(slope)
        return Worst(max(worst, 0.0), allowed, track.flown_m(*at))

    def stretches(self, problem: Problem, track: LaidTrack) -> Iterator[broken.Span]:
        return broken.too_steep(track, self.sign)


class Climb(_Slope):
    """The steepest climb."""

    name, sign = "climb", 1

    def _degrees(self, problem: Problem) -> float:
        return problem.aircraft.max_climb_deg


class Descent(_Slope):
    """The steepest descent."""

    name, sign = "descent", -1

    def _degrees(self, problem: Problem) -> float:
        return problem.aircraft.max_descent_deg


class Power(AircraftLimit):
    """The shaft power of the engine."""

    name, unit, is_compiled = "power", "W", True

    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        aircraft = problem.aircraft
        if aircraft.engine_power_W is None:
            return None
        worst, at = track.most(1, rule_kernels.THRUST)
        power = max(worst, 0.0) * aircraft.cruise_speed_m_s / aircraft.propeller_efficiency
        return Worst(power, aircraft.engine_power_W, track.flown_m(*at))

    def stretches(self, problem: Problem, track: LaidTrack) -> Iterator[broken.Span]:
        return broken.too_weak(track, problem.limits.thrust_N)


class Fuel(AircraftLimit):
    """The fuel without the reserve."""

    name, unit, is_compiled = "fuel", "N", True

    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        if problem.aircraft.fuel_weight_N is None:
            return None
        return Worst(track.fuel, problem.limits.fuel_N, track.length_m)

    def stretches(self, problem: Problem, track: LaidTrack) -> Iterator[broken.Span]:
        return broken.out_of_fuel(track, problem.limits.fuel_N)


def _stalls(problem: Problem) -> bool:
    """Return whether the aircraft stalls in a turn at its cruise speed."""
    return problem.limits.stall_speed_m_s > problem.aircraft.cruise_speed_m_s


class Turn(AircraftLimit):
    """The radius of a turn over the ground, in wind."""

    name, unit, is_minimum, is_compiled = "turn", "m", True, True

    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        radius, at = track.tightest_turn()
        if not math.isfinite(radius):
            return None
        aircraft, wind = problem.aircraft, math.hypot(*problem.wind)
        allowed = aircraft.turn_radius_m * (1.0 + wind / aircraft.cruise_speed_m_s) ** 2
        return Worst(radius, allowed, track.flown_m(*at))

    def stretches(self, problem: Problem, track: LaidTrack) -> Iterable[broken.Span]:
        if _stalls(problem):
            return ()
        return broken.impossible_turns(track, problem.aircraft.turn_radius_m)


class Stall(AircraftLimit):
    """The stall speed in a turn at take-off weight."""

    name, unit, is_minimum, is_compiled = "stall", "m/s", True, True

    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        stall = problem.limits.stall_speed_m_s
        if not stall > 0:
            return None
        radius, at = track.tightest_turn()
        if not math.isfinite(radius):
            return None
        return Worst(problem.aircraft.cruise_speed_m_s, stall, track.flown_m(*at))

    def stretches(self, problem: Problem, track: LaidTrack) -> Iterable[broken.Span]:
        if not _stalls(problem):
            return ()
        return broken.impossible_turns(track, problem.aircraft.turn_radius_m)


class ServiceCeiling(AircraftLimit):
    """The service ceiling."""

    name, unit, is_compiled = "service-ceiling", "m", True

    def altitude_m(self, problem: Problem) -> float | None:
        return problem.aircraft.service_ceiling_m

    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        ceiling = problem.aircraft.service_ceiling_m
        if ceiling is None:
            return None
        top, at = track.highest()
        return Worst(top, ceiling, track.flown_m(*at))

    def stretches(self, problem: Problem, track: LaidTrack) -> Iterable[broken.Span]:
        ceiling = problem.aircraft.service_ceiling_m
        return () if ceiling is None else broken.above(track, ceiling)


#: Every limit of an aircraft, in the order of reports that find them equally near.
AIRCRAFT_LIMITS: list[AircraftLimit] = [
    ServiceCeiling(),
    Climb(),
    Descent(),
    Power(),
    Fuel(),
    Turn(),
    Stall(),
]


def limit_named(name: str) -> AircraftLimit | None:
    """Return a limit by its name, or None for another kind of limit, such as a zone's."""
    return next((limit for limit in AIRCRAFT_LIMITS if limit.name == name), None)


def line_limits(problem: Problem) -> Iterator[tuple[AircraftLimit, float]]:
    """Yield the limits on altitudes with their altitudes, as pictures draw them."""
    for limit in AIRCRAFT_LIMITS:
        if (altitude := limit.altitude_m(problem)) is not None:
            yield limit, altitude
