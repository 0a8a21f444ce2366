"""Motion of a point mass with bank and pitch, a tenth of a second at a time."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.sim.autopilot.compiled import COMPILER


__all__ = ["STATES", "STEPS", "STEP_S", "fly"]

#: Steps of a call, and the seconds of a step.
STEPS = 10
STEP_S = 0.01
#: Places in the state: east, north and altitude (m); velocity over ground (m/s); bank, its rate,
#: pitch and its rate (radians); throttle (0 to 1).
STATES = ("x", "y", "z", "vx", "vy", "vz", "roll", "roll_rate", "pitch", "pitch_rate", "throttle")

_GRAVITY = 9.80665
# The throttle follows its demand in this time.
_MOTOR_S = 0.1


@COMPILER.compiled
def _clipped(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


@COMPILER.compiled
def fly(
    state: NDArray[np.float64],
    airframe: NDArray[np.float64],
    demand: NDArray[np.float64],
    wind: NDArray[np.float64],
) -> None:
    """Advance a state by :data:`STEPS` steps.

    Bank and pitch follow their demands by a rate that is proportional to the error, limited, and
    itself delayed. Lift acts at right angles to the airflow, tilted by the bank; the nose points
    into the airflow, except for the slip of a turn.

    Parameters
    ----------
    state : array
        As in :data:`STATES`; it is changed in place.
    airframe : array
        Mass, area, lift at zero, slope and maximum, drag at zero, induced factor, thrust, power,
        side force, slip per turn, lags of roll and pitch.
    demand : array
        Bank, pitch (radians), throttle, time constants of roll and pitch (s), maximum rates
        (rad/s), air density (kg/m^3).
    wind : (STEPS, 3) array
        Velocity of the air east, north and up, m/s.
    """
    mass, area, lift_zero, lift_slope, lift_max = airframe[0:5]
    drag_zero, induced, thrust_max, power = airframe[5:9]
    side_force, slip_m, roll_lag, pitch_lag = airframe[9:13]
    bank_dem, pitch_dem, throttle_dem, roll_tc, pitch_tc, roll_max, pitch_max, rho = demand
    for step in range(STEPS):
        rate = _clipped((bank_dem - state[6]) / roll_tc, roll_max)
        state[7] += (rate - state[7]) * STEP_S / (roll_lag + STEP_S)
        state[6] += state[7] * STEP_S
        rate = _clipped((pitch_dem - state[8]) / pitch_tc, pitch_max)
        state[9] += (rate - state[9]) * STEP_S / (pitch_lag + STEP_S)
        state[8] += state[9] * STEP_S
        state[10] += (throttle_dem - state[10]) * STEP_S / (_MOTOR_S + STEP_S)

        ax, ay, az = state[3] - wind[step, 0], state[4] - wind[step, 1], state[5] - wind[step, 2]
        level = max(math.sqrt(ax * ax + ay * ay), 0.1)
        speed = max(math.sqrt(level * level + az * az), 1.0)
        slope = math.atan2(az, level)
        alpha = state[8] - slope
        lift = min(max(lift_zero + lift_slope * alpha, -0.5 * lift_max), lift_max)
        pressure = 0.5 * rho * speed * speed * area / mass
        thrust = min(state[10] * thrust_max, state[10] * power / speed) / mass
        up = pressure * lift + thrust * math.sin(alpha)
        along = thrust * math.cos(alpha) - pressure * (drag_zero + induced * lift * lift)
        sine, cosine = math.sin(state[6]), math.cos(state[6])
        # The slip follows the yaw rate, which follows the turn that the slip leaves.
        yaw = up * sine * cosine / speed
        gain = pressure * side_force * slip_m / (speed * speed)
        side = gain * yaw * speed / (1.0 + gain * cosine * cosine)
        turn = up * sine - side * cosine
        rise = up * cosine + side * sine

        east, north = ax / level, ay / level
        flat, steep = math.cos(slope), math.sin(slope)
        horizontal = along * flat - rise * steep
        state[3] += (horizontal * east + turn * north) * STEP_S
        state[4] += (horizontal * north - turn * east) * STEP_S
        state[5] += (along * steep + rise * flat - _GRAVITY) * STEP_S
        state[0] += state[3] * STEP_S
        state[1] += state[4] * STEP_S
        state[2] += state[5] * STEP_S
