"""Fuel burned in steady flight: the closed solution and wind, in plain Python.

Source: Labonte 2015, rebuilt from the physics. With the drag ``D = q S CD0 + k (W cos gamma)^2 /
(q S)`` and the thrust ``T = D + W sin gamma``, the weight falls as ``dW/ds = -(sfc / eta) T``: a
Riccati equation with constant coefficients on a piece of constant slope.
"""

import math
from collections.abc import Iterable

from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.limits import pressure_on_wing


__all__ = [
    "air_distance",
    "fuel_burned",
    "level_range_m",
    "thrust_needed",
]


def fuel_burned(
    aircraft: Aircraft, weight: float, run_m: float, rise_m: float, air_distance_m: float
) -> float:
    """Return the fuel in newtons burned on one piece of constant slope.

    Parameters
    ----------
    weight : float
        Its weight at the start of the piece, newtons.
    run_m, rise_m : float
        Horizontal length and altitude gained: the slope. Not both 0.
    air_distance_m : float
        Distance flown through the air; the length of the piece when there is no wind.

    A glide that needs no thrust at the start of the piece burns no fuel on it.
    """
    a, b, e = _thrust_terms(aircraft, run_m, rise_m)
    thrust = a * weight**2 + b * weight + e
    if thrust <= 0:
        return 0.0
    discriminant = 4 * a * e - b**2
    half = (
        0.5
        * air_distance_m
        * (aircraft.specific_fuel_consumption_N_per_Ws / aircraft.propeller_efficiency)
    )
    root = math.sqrt(abs(discriminant))
    if discriminant > 0:
        tau = math.tan(half * root) / root
    elif discriminant < 0:
        tau = math.tanh(half * root) / root
    else:
        tau = half
    return 2 * thrust * tau / (1 + (2 * a * weight + b) * tau)


def thrust_needed(aircraft: Aircraft, weight: float, run_m: float, rise_m: float) -> float:
    """Return the thrust in newtons that holds a slope; arguments as for :func:`fuel_burned`."""
    a, b, e = _thrust_terms(aircraft, run_m, rise_m)
    return a * weight**2 + b * weight + e


def _thrust_terms(aircraft: Aircraft, run_m: float, rise_m: float) -> tuple[float, float, float]:
    """Return a, b and e of the thrust a W^2 + b W + e."""
    length = math.hypot(run_m, rise_m)
    cos, sin = run_m / length, rise_m / length
    pressure_area = pressure_on_wing(aircraft)
    return (
        aircraft.induced_drag_factor * cos**2 / pressure_area,
        sin,
        pressure_area * aircraft.zero_lift_drag_coefficient,
    )


def air_distance(
    length_m: float,
    run_m: float,
    directions: Iterable[tuple[float, float, float]],
    wind: tuple[float, float],
    airspeed_m_s: float,
) -> float | None:
    """Return the distance flown through the air on a piece; None if the wind makes it impossible.

    Parameters
    ----------
    length_m, run_m : float
        Length of the piece in three dimensions, and its horizontal length.
    directions : iterable of (float, float, float)
        Horizontal unit directions flown, x and y, and the metres of each. A vertical piece has
        none: it is impossible in wind, because no airspeed is left to hold against the wind.
    wind : (float, float)
        Metres per second, x and y. Without wind the result is exactly ``length_m``.
    """
    if wind == (0.0, 0.0):
        return length_m
    if run_m == 0:
        return None
    horizontal = airspeed_m_s * run_m / length_m
    time_s = 0.0
    for east, north, run in directions:
        cross = wind[0] * north - wind[1] * east
        square = horizontal**2 - cross**2
        if not square > 0:
            return None
        ground_speed = wind[0] * east + wind[1] * north + math.sqrt(square)
        if not ground_speed > 0:
            return None
        time_s += run / ground_speed
    return airspeed_m_s * time_s


def level_range_m(aircraft: Aircraft, burned: float, fuel: float) -> float:
    """Return the distance that ``fuel`` lasts in level flight at sea level in still air, metres.

    Parameters
    ----------
    burned, fuel : float
        Fuel already burned, and fuel left, newtons.
    """
    pressure_area = pressure_on_wing(aircraft)
    a = aircraft.induced_drag_factor / pressure_area
    e = pressure_area * aircraft.zero_lift_drag_coefficient
    burn_per_m = aircraft.specific_fuel_consumption_N_per_Ws / aircraft.propeller_efficiency
    root = math.sqrt(a / e)
    weight = aircraft.weight_N - burned
    # The integral of dW / (a W^2 + e), over the weights that burn the fuel.
    return (math.atan(root * weight) - math.atan(root * (weight - fuel))) / (
        burn_per_m * math.sqrt(a * e)
    )
