"""Limits of an aircraft in flight: turns and slopes in wind, power, fuel and ceilings.

With ``as_paper``, they are the figures in the aircraft's file. Under the rules of safe flight the
wind, the engine and the stall limit them further.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.atmosphere import SEA_LEVEL_DENSITY_KG_M3
from pathgene.host.problem.rules import Rules


__all__ = [
    "GRAVITY_M_S2",
    "Limits",
    "pressure_on_wing",
    "slope_limits",
    "slope_of_thrust",
    "steady_thrust",
    "turn_radius_in_wind_m",
]

Floats = NDArray[np.float64]

GRAVITY_M_S2 = 9.80665
_HALVINGS = 60


@dataclass(frozen=True)
class Limits:
    """The limits that hold for a path; infinite if there is none.

    Parameters
    ----------
    turn_radius_m : float
        Radius of every arc over the ground: R (1 + wind / V)^2, flown with the constant bank of R
        in still air. Infinite, so that no turn is possible, if the aircraft would stall in the
        turn.
    climb_rad, descent_rad : float
        Steepest slopes in still air that the aircraft's file and its engine, at take-off weight,
        allow; the climb is negative if the engine cannot hold level flight.
    thrust_N : float
        Maximum thrust: the engine's power through the propeller at cruise speed.
    fuel_N : float
        Fuel that a path may burn, without the reserve.
    ceiling_m : float
        Maximum altitude: the lower one of the rule and the aircraft's service ceiling.
    stall_speed_m_s : float
        Stall speed in the turn at take-off weight; 0 without a lift coefficient.
    """

    turn_radius_m: float
    climb_rad: float
    descent_rad: float
    thrust_N: float = math.inf
    fuel_N: float = math.inf
    ceiling_m: float = math.inf
    stall_speed_m_s: float = 0.0

    @staticmethod
    def of(aircraft: Aircraft, wind: tuple[float, float], rules: Rules | None) -> Limits:
        """Return the limits of ``aircraft`` in ``wind`` (m/s); no ``rules`` means ``as_paper``."""
        climb, descent = (
            math.radians(aircraft.max_climb_deg),
            math.radians(aircraft.max_descent_deg),
        )
        if rules is None:
            return Limits(aircraft.turn_radius_m, climb, descent)
        stall = stall_speed_in_turn_m_s(aircraft)
        thrust = math.inf
        if aircraft.engine_power_W is not None:
            power = aircraft.engine_power_W * aircraft.propeller_efficiency
            thrust = power / aircraft.cruise_speed_m_s
            climb = min(climb, slope_of_thrust(aircraft, thrust, aircraft.weight_N)[0])
        ceilings = (rules.ceiling_m, aircraft.service_ceiling_m)
        return Limits(
            turn_radius_in_wind_m(aircraft, wind)
            if stall <= aircraft.aerodynamic_speed_m_s
            else math.inf,
            climb,
            descent,
            thrust,
            math.inf
            if aircraft.fuel_weight_N is None
            else aircraft.fuel_weight_N * (1.0 - rules.reserve),
            min((ceiling for ceiling in ceilings if ceiling is not None), default=math.inf),
            stall,
        )


def turn_radius_in_wind_m(aircraft: Aircraft, wind: tuple[float, float]) -> float:
    """Return the radius over the ground of a turn with the bank of R in still air."""
    return aircraft.turn_radius_m * (1.0 + math.hypot(*wind) / aircraft.cruise_speed_m_s) ** 2


def stall_speed_in_turn_m_s(aircraft: Aircraft) -> float:
    """Return the stall speed at the bank of the turn radius, at take-off weight; 0 if unknown."""
    if aircraft.lift_coefficient_max is None:
        return 0.0
    tan_bank = aircraft.cruise_speed_m_s**2 / (GRAVITY_M_S2 * aircraft.turn_radius_m)
    lift = aircraft.weight_N * math.hypot(1.0, tan_bank)
    area = SEA_LEVEL_DENSITY_KG_M3 * aircraft.wing_area_m2 * aircraft.lift_coefficient_max
    return math.sqrt(2.0 * lift / area)


def pressure_on_wing(aircraft: Aircraft) -> float:
    """Return the dynamic pressure at cruise times the wing area, newtons.

    The density is the one at sea level, so it suits an equivalent airspeed.
    """
    speed = aircraft.aerodynamic_speed_m_s
    return 0.5 * SEA_LEVEL_DENSITY_KG_M3 * speed**2 * aircraft.wing_area_m2


def steady_thrust(aircraft: Aircraft, slope_rad: float, weight: float) -> float:
    """Return the thrust that holds a slope at a weight, newtons."""
    return _thrust_on_slope(aircraft, weight)(slope_rad)


def _thrust_on_slope(aircraft: Aircraft, weight: float) -> Callable[[float], float]:
    """Return the function from a slope, radians, to the thrust that holds it, newtons."""
    area = pressure_on_wing(aircraft)
    least_drag = area * aircraft.zero_lift_drag_coefficient
    factor = aircraft.induced_drag_factor

    def thrust(slope_rad: float) -> float:
        lift = weight * math.cos(slope_rad)
        drag = least_drag + factor * lift**2 / area
        return drag + weight * math.sin(slope_rad)

    return thrust


def slope_of_thrust(aircraft: Aircraft, thrust: float, weight: float) -> tuple[float, float]:
    """Return bounds of the steepest slope that ``thrust`` holds at a weight, radians."""
    low, high = -0.5 * math.pi, 0.5 * math.pi
    needed = _thrust_on_slope(aircraft, weight)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        held = needed(middle) <= thrust
        low, high = (middle, high) if held else (low, middle)
    return low, high


def slope_limits(
    limits: Limits,
    airspeed_m_s: float,
    wind: tuple[float, float],
    east: Floats,
    north: Floats,
) -> tuple[Floats, Floats]:
    """Return the steepest climbs and descents over the ground along unit directions, as tangents.

    In wind the vertical speed, ground speed times slope, must not exceed the vertical speed of the
    steepest slope in still air: with a tailwind the slope over the ground is gentler.

    Parameters
    ----------
    limits : Limits
        Limits of the aircraft.
    airspeed_m_s : float
        The aircraft's speed through the air.
    wind : (float, float)
        Wind that slopes are limited in, m/s; (0, 0) with ``as_paper``.
    east, north : (n,) float64
        Horizontal unit directions of flight.

    Returns
    -------
    tuple of (n,) float64
        Both are positive for an aircraft that can climb, and 0 if the wind makes the direction
        impossible.
    """
    climb, descent = math.tan(limits.climb_rad), math.tan(limits.descent_rad)
    if wind == (0.0, 0.0):
        return np.full(east.shape, climb), np.full(east.shape, descent)
    along = wind[0] * east + wind[1] * north
    cross = wind[0] * north - wind[1] * east

    def steepest(still_air_rad: float) -> Floats:
        most = airspeed_m_s * math.sin(still_air_rad)
        low, high = np.zeros_like(along), np.full_like(along, 0.5 * math.pi)
        for _ in range(_HALVINGS):
            slope = 0.5 * (low + high)
            square = (airspeed_m_s * np.cos(slope)) ** 2 - cross**2
            ground = along + np.sqrt(np.maximum(square, 0.0))
            held = (square > 0) & (ground > 0) & (ground * np.tan(slope) <= most)
            low, high = np.where(held, slope, low), np.where(held, high, slope)
        return np.tan(low)

    # Against the wind, a steeper slope would be allowed, but the engine may not hold it.
    return (
        np.minimum(steepest(max(limits.climb_rad, 0.0)), climb),
        np.minimum(steepest(limits.descent_rad), descent),
    )
