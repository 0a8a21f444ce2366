"""Limits of an aircraft, a class each: allowed value, check along a track, formulas and advice.

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
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.limits import (
    GRAVITY_M_S2,
    pressure_on_wing,
    steady_thrust,
    turn_radius_in_wind_m,
)
from pathgene.host.problem.problem import Problem


__all__ = [
    "AIRCRAFT_LIMITS",
    "CLIMB",
    "DESCENT",
    "FUEL",
    "POWER",
    "SERVICE_CEILING",
    "STALL",
    "AircraftLimit",
    "Worst",
    "limit_named",
    "line_limits",
    "unit_of",
]


class Worst(NamedTuple):
    """The worst value of a limit on a track.

    Parameters
    ----------
    value : float
        The value, in the unit of the limit.
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
    is_minimum : bool
        True if a value must not be below the allowed one, False if it must not be above.
    is_compiled : bool
        True if the kernels judge it. Another limit adds the metres of its stretches to the penalty.
    meaning : str
        Headline of a diagnosis that finds the limit as its reason; empty if none does.
    """

    name: ClassVar[str]
    unit: ClassVar[str]
    is_minimum: ClassVar[bool] = False
    is_compiled: ClassVar[bool] = False
    meaning: ClassVar[str] = ""

    @abstractmethod
    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        """Return the worst value on a track, or None if the limit does not apply."""

    @abstractmethod
    def stretches(self, problem: Problem, track: LaidTrack) -> Iterable[broken.Span]:
        """Return the stretches of a track that break the limit, in metres flown."""

    def altitude_m(self, problem: Problem) -> float | None:
        """Return the altitude that pictures draw for a limit on altitudes, or None."""
        return None

    def words(self, problem: Problem) -> str:
        """Return the name of the limit in a sentence."""
        return f"the {self.name.replace('-', ' ')} of {problem.aircraft.name}"

    @property
    def label(self) -> str:
        """The name of the limit in pictures."""
        return self.name.replace("-", " ")


class _Slope(AircraftLimit):
    """The vertical speed of the steepest climb or descent.

    Attributes
    ----------
    sign : int
        1 for climbs, -1 for descents.
    end : str
        The end of the path whose surroundings need the slope.
    """

    unit, is_compiled = "m/s", True
    sign: ClassVar[int]
    end: ClassVar[str]
    way: ClassVar[str]

    @abstractmethod
    def degrees(self, aircraft: Aircraft) -> float:
        """Return the steepest slope in still air, degrees."""

    def advice(
        self, problem: Problem, degrees: float, place: tuple[float, float], *, proven: bool
    ) -> str:
        """Return a sentence: every short route needs a slope; ``proven`` if no circle fits."""
        circling = (
            "there is no room to circle."
            if proven
            else "there may be room to circle, which no planner does."
        )
        return (
            f"Every short way {self.way} the {self.end} is too steep: near ({place[0]:.0f}, "
            f"{place[1]:.0f}) m it takes a {self.name} of {degrees:.1f} degrees, and the limit is "
            f"{self.degrees(problem.aircraft):g}; {circling}"
        )

    def worst(self, problem: Problem, track: LaidTrack) -> Worst:
        worst, at = track.most(self.sign, rule_kernels.VERTICAL_SPEED)
        slope = math.radians(self.degrees(problem.aircraft))
        allowed = problem.aircraft.cruise_speed_m_s * math.sin(slope)
        return Worst(max(worst, 0.0), allowed, track.flown_m(*at))

    def stretches(self, problem: Problem, track: LaidTrack) -> Iterator[broken.Span]:
        return broken.too_steep(track, self.sign)


class Climb(_Slope):
    """The steepest climb."""

    name, meaning = "climb", "The climb is too weak"
    sign, end, way = 1, "start", "out of"

    def degrees(self, aircraft: Aircraft) -> float:
        return aircraft.max_climb_deg


class Descent(_Slope):
    """The steepest descent."""

    name, meaning = "descent", "The descent is too shallow"
    sign, end, way = -1, "goal", "down to"

    def degrees(self, aircraft: Aircraft) -> float:
        return aircraft.max_descent_deg


class Power(AircraftLimit):
    """The shaft power of the engine."""

    name, unit, is_compiled = "power", "W", True
    meaning = "The engine is too weak"

    @staticmethod
    def shaft_power(aircraft: Aircraft, thrust: float) -> float:
        """Return the shaft power of a thrust at cruise speed, watts."""
        return max(thrust, 0.0) * aircraft.cruise_speed_m_s / aircraft.propeller_efficiency

    def climbing_power(self, aircraft: Aircraft, slope: float) -> float:
        """Return the shaft power that holds a slope (a tangent) at take-off weight."""
        return self.shaft_power(
            aircraft, steady_thrust(aircraft, math.atan(slope), aircraft.weight_N)
        )

    def climb_advice(
        self, problem: Problem, degrees: float, place: tuple[float, float], needed: float
    ) -> str:
        """Return that the engine cannot hold a climb that the aircraft allows."""
        return (
            f"{self._engine(problem)}, enough for a climb of "
            f"{math.degrees(problem.limits.climb_rad):.1f} degrees; the way out of the start takes "
            f"{degrees:.1f} degrees near ({place[0]:.0f}, {place[1]:.0f}) m, {needed:.0f} W."
        )

    def level_advice(self, problem: Problem, needed: float, consequence: str) -> str:
        """Return that the engine cannot hold level flight."""
        return (
            f"{self._engine(problem)} and level flight takes {needed:.0f} W: the aircraft sinks, "
            f"and {consequence}."
        )

    @staticmethod
    def _engine(problem: Problem) -> str:
        return f"The engine of {problem.aircraft.name} gives {problem.aircraft.engine_power_W:g} W"

    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        aircraft = problem.aircraft
        if aircraft.engine_power_W is None:
            return None
        worst, at = track.most(1, rule_kernels.THRUST)
        power = self.shaft_power(aircraft, worst)
        return Worst(power, aircraft.engine_power_W, track.flown_m(*at))

    def stretches(self, problem: Problem, track: LaidTrack) -> Iterator[broken.Span]:
        return broken.too_weak(track, problem.limits.thrust_N)


class Fuel(AircraftLimit):
    """The fuel without the reserve."""

    name, unit, is_compiled = "fuel", "N", True
    meaning = "The fuel is too little"

    def least(self, problem: Problem) -> float:
        """Return the minimum fuel in newtons that any path within the limits burns.

        The thrust along a path is the drag plus the component of the weight along the slope. The
        drag is minimal at the minimum weight and the steepest slope; the weight does work against
        the rise from start to goal, less the saving of a lighter aircraft on climbs from the lowest
        ground. At best, wind shortens the distance through the air to V / (V + wind) of the
        distance over the ground.
        """
        aircraft = problem.aircraft
        burned_per_work = (
            aircraft.specific_fuel_consumption_N_per_Ws / aircraft.propeller_efficiency
        )
        # Without a tank size, the whole weight might be fuel.
        lightest = max(aircraft.weight_N - problem.limits.fuel_N, 0.0)
        steepest = math.radians(max(aircraft.max_climb_deg, aircraft.max_descent_deg))
        area = pressure_on_wing(aircraft)
        lift = lightest * math.cos(min(steepest, 0.5 * math.pi))
        drag = (
            area * aircraft.zero_lift_drag_coefficient
            + aircraft.induced_drag_factor * lift**2 / area
        )
        rise = problem.goal[2] - problem.start[2]
        work = drag * math.dist(problem.start, problem.goal) + aircraft.weight_N * rise
        wind = math.hypot(*problem.wind)
        shortest = aircraft.cruise_speed_m_s / (aircraft.cruise_speed_m_s + wind)
        above = max(problem.goal[2] - problem.terrain.lowest, 0.0)
        return max(burned_per_work * shortest * work / (1 + burned_per_work * above), 0.0)

    def advice(self, reserve: float, burnt: float, allowed: float, tank: float) -> str:
        """Return that the fuel does not even last for the straight line."""
        return (
            f"The fuel does not last: even the straight line burns {burnt:g} N, and "
            f"{allowed:g} N may be burnt with a reserve of {100 * reserve:g} %; at least "
            f"{tank:g} N of fuel is needed."
        )

    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        if problem.aircraft.fuel_weight_N is None:
            return None
        return Worst(track.fuel, problem.limits.fuel_N, track.length_m)

    def stretches(self, problem: Problem, track: LaidTrack) -> Iterator[broken.Span]:
        return broken.out_of_fuel(track, problem.limits.fuel_N)


def _stalls(problem: Problem) -> bool:
    """Return whether the aircraft stalls in a turn at its cruise speed."""
    return problem.limits.stall_speed_m_s > problem.aircraft.aerodynamic_speed_m_s


class Turn(AircraftLimit):
    """The radius of a turn over the ground, in wind."""

    name, unit, is_minimum, is_compiled = "turn", "m", True, True
    meaning = "No turn is possible"

    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        radius, at = track.tightest_turn()
        if not math.isfinite(radius):
            return None
        allowed = turn_radius_in_wind_m(problem.aircraft, problem.wind)
        return Worst(radius, allowed, track.flown_m(*at))

    def stretches(self, problem: Problem, track: LaidTrack) -> Iterable[broken.Span]:
        if _stalls(problem):
            return ()
        return broken.impossible_turns(track, problem.aircraft.turn_radius_m)


class Stall(AircraftLimit):
    """The stall speed in a turn at take-off weight."""

    name, unit, is_minimum, is_compiled = "stall", "m/s", True, True

    def least_speed_m_s(self, problem: Problem) -> float | None:
        """Return a cruise speed at which the aircraft does not stall in its turn, or None.

        At a higher speed the turn has more bank, and the stall speed is higher.
        """
        aircraft = problem.aircraft
        speed = aircraft.aerodynamic_speed_m_s
        square = GRAVITY_M_S2 * aircraft.turn_radius_m * (speed / aircraft.cruise_speed_m_s) ** 2
        bank = math.hypot(1.0, speed**2 / square)
        level = problem.limits.stall_speed_m_s**4 / bank**2
        rest = 1.0 - level / square**2
        return float((level / rest) ** 0.25) if rest > 0 else None

    def advice(self, problem: Problem, stall_m_s: float, place: tuple[float, float]) -> str:
        """Return that the aircraft stalls in any turn while the line is blocked."""
        aircraft = problem.aircraft
        return (
            f"{aircraft.name} stalls in every turn of {aircraft.turn_radius_m:g} m at "
            f"{aircraft.aerodynamic_speed_m_s:g} m/s, below {stall_m_s:.1f} m/s, and the straight "
            f"line to the goal is closed near ({place[0]:.0f}, {place[1]:.0f}) m."
        )

    def worst(self, problem: Problem, track: LaidTrack) -> Worst | None:
        stall = problem.limits.stall_speed_m_s
        if not stall > 0:
            return None
        radius, at = track.tightest_turn()
        if not math.isfinite(radius):
            return None
        return Worst(problem.aircraft.aerodynamic_speed_m_s, stall, track.flown_m(*at))

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


SERVICE_CEILING, CLIMB, DESCENT = ServiceCeiling(), Climb(), Descent()
POWER, FUEL, STALL = Power(), Fuel(), Stall()
#: Every limit of an aircraft, in the order of reports that find them equally near.
AIRCRAFT_LIMITS: list[AircraftLimit] = [
    SERVICE_CEILING,
    CLIMB,
    DESCENT,
    POWER,
    FUEL,
    Turn(),
    STALL,
]


def limit_named(name: str) -> AircraftLimit | None:
    """Return a limit by its name, or None for another kind of limit, such as a zone's."""
    return next((limit for limit in AIRCRAFT_LIMITS if limit.name == name), None)


def unit_of(name: str) -> str:
    """Return the unit of any limit, by the name that it has in a report."""
    limit = limit_named(name)
    return "m" if limit is None else limit.unit


def line_limits(problem: Problem) -> Iterator[tuple[AircraftLimit, float]]:
    """Yield the limits on altitudes with their altitudes, as pictures draw them."""
    for limit in AIRCRAFT_LIMITS:
        if (altitude := limit.altitude_m(problem)) is not None:
            yield limit, altitude
