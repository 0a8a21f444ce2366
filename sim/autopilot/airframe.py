"""Figures of an aircraft, and of the air around it."""

from __future__ import annotations

import math
from dataclasses import dataclass


__all__ = ["GRAVITY_M_S2", "SIMULATED_PLANE", "Airframe", "density", "eas2tas"]

GRAVITY_M_S2 = 9.80665
_SEA_LEVEL_KG_M3 = 1.225


def density(altitude_m: float) -> float:
    """Return the density of the standard atmosphere below 11 km, kg/m^3."""
    return _SEA_LEVEL_KG_M3 * math.pow(1.0 - 2.25577e-5 * altitude_m, 4.25588)


def eas2tas(altitude_m: float) -> float:
    """Return true airspeed divided by equivalent airspeed in the standard atmosphere."""
    return math.sqrt(_SEA_LEVEL_KG_M3 / density(altitude_m))


@dataclass(frozen=True)
class Airframe:
    """Mass, aerodynamics and engine of a small aircraft.

    Lift and drag coefficients are ``lift_zero + lift_slope * alpha`` and ``drag_zero + induced *
    lift^2``. In a turn the yaw damping of the fuselage makes it slip outwards by ``turn_slip_m``
    times the yaw rate divided by the airspeed, and ``side_force`` times that angle is a side force
    coefficient that widens the turn.

    Parameters
    ----------
    mass_kg, wing_area_m2 : float
        Mass and reference area.
    lift_zero, lift_slope, lift_max : float
        Lift coefficient without angle of attack, per radian, and its maximum.
    drag_zero, induced : float
        Drag coefficient without lift, and the factor of the squared lift coefficient.
    thrust_N, power_W : float
        Maximum thrust, and the maximum product of thrust and airspeed.
    side_force : float
        Side force coefficient per radian of slip, positive.
    turn_slip_m : float
        Slip per yaw rate and airspeed, metres.
    roll_lag_s, pitch_lag_s : float
        Time constants in which the rates of roll and pitch follow their demands.
    pitot_exponent : float
        The airspeed sensor shows the true airspeed divided by this power of
        :func:`eas2tas`: 1 for a sensor that shows equivalent airspeed.
    """

    mass_kg: float
    wing_area_m2: float
    lift_zero: float
    lift_slope: float
    lift_max: float
    drag_zero: float
    induced: float
    thrust_N: float
    power_W: float = math.inf
    side_force: float = 0.0
    turn_slip_m: float = 0.0
    roll_lag_s: float = 0.1
    pitch_lag_s: float = 0.1
    pitot_exponent: float = 1.0

    @classmethod
    def of(
        cls,
        *,
        weight_n: float,
        wing_area_m2: float,
        span_m: float,
        drag_zero: float,
        lift_max: float,
        power_w: float,
        cruise_m_s: float,
    ) -> Airframe:
        """Return the airframe of figures that a planner has: a straight wing.

        Pitch is measured from its angle in level cruise, as an autopilot's trim sets it. Oswald's
        factor is 0.85, the propeller's efficiency 0.75, and the maximum thrust half of the weight.
        """
        ratio = span_m**2 / wing_area_m2
        pressure = 0.5 * _SEA_LEVEL_KG_M3 * cruise_m_s**2
        return cls(
            mass_kg=weight_n / GRAVITY_M_S2,
            wing_area_m2=wing_area_m2,
            lift_zero=min(weight_n / (pressure * wing_area_m2), 0.9 * lift_max),
            lift_slope=2 * math.pi * ratio / (ratio + 2),
            lift_max=lift_max,
            drag_zero=drag_zero,
            induced=1 / (math.pi * 0.85 * ratio),
            thrust_N=0.5 * weight_n,
            power_W=0.75 * power_w,
        )


#: ArduPilot's own simulated plane, by its published coefficients: 2 kg, 0.45 m^2, span 1.88 m, a
#: motor that holds it vertically at 0.7 of the throttle. The slip is the balance of its yaw damping
#: (-1) against its weathercock stability (0.25, and 0.147 / 1.88 by its centre of gravity), half of
#: the span per unit of rate. Its airspeed sensor applies the ratio of airspeeds twice: in four calm
#: flights the true airspeed was the demanded one times the square of :func:`eas2tas`, to 1 %.
SIMULATED_PLANE = Airframe(
    mass_kg=2.0,
    wing_area_m2=0.45,
    lift_zero=0.56,
    lift_slope=6.9,
    lift_max=2.5,
    drag_zero=0.1,
    induced=1 / (math.pi * 0.9 * 1.88**2 / 0.45),
    thrust_N=2.0 * GRAVITY_M_S2 / 0.7,
    side_force=0.98,
    turn_slip_m=0.5 * 1.88 / (0.25 + 0.15 * 0.98 / 1.88),
    pitot_exponent=2.0,
)
