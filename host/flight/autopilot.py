"""Autopilot: control surfaces, throttle and air brake that follow the commands of the guidance."""

from __future__ import annotations

import math

from pathgene.host.flight.guidance import Commands, State
from pathgene.host.flight.models import FlightModel
from pathgene.host.flight.simulator import Controls
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.atmosphere import air_density
from pathgene.host.problem.limits import GRAVITY_M_S2


__all__ = ["Autopilot"]

# Roll rate per error of bank, 1/s, and the largest, rad/s.
_BANK_GAIN = 2.5
_MOST_ROLL_RAD_S = 0.6
# Aileron per roll-rate error, as a share of the fed-forward aileron, and per integral of the bank
# error.
_ROLL_GAIN = 0.2
_BANK_TRIM_GAIN = 0.15
# Pitch rate per error of the angle of the flight path, 1/s, and the largest, rad/s.
_SLOPE_GAIN = 1.2
# Pitch rate per error of the pitch, 1/s.
_PITCH_GAIN = 2.0
_MOST_PITCH_RAD_S = 0.25
# Below this multiple of the stall speed, or this share of the airspeed if that is lower, or the
# model's own share, all averaged over the time, height is traded for speed: the sine of the
# flight-path angle is reduced by the missing share.
_OVER_STALL = 1.3
_SLOW = 0.9
_SLOW_S = 1.5
# The maximum throttle falls at this rate per share of power beyond the limit, and rises more slowly
# below the limit.
_POWER_GAIN = 2.0
_POWER_BACK_GAIN = 0.3


class Autopilot:
    """Loops of roll, pitch, yaw and airspeed of a flight model.

    Parameters
    ----------
    aircraft : Aircraft
        Its figures: the true airspeed to hold, the engine's power, to which the throttle is
        limited, and the stall speed.
    period_s : float
        Time between two calls of :meth:`controls`.
    """

    def __init__(self, model: FlightModel, aircraft: Aircraft, period_s: float) -> None:
        self.airspeed_m_s = aircraft.cruise_speed_m_s
        self._model = model
        self._period_s = period_s
        self._bank_trim = 0.0
        self._pitch_trim = 0.0
        self._speed_trim = 0.0
        self._mean_speed_m_s = self.airspeed_m_s
        self._most_watts = aircraft.engine_power_W or math.inf
        # Its square times the density is constant; without a stall speed there is no stall.
        lift = aircraft.lift_coefficient_max
        self._stall = 2 * aircraft.weight_N / (aircraft.wing_area_m2 * lift) if lift else 0.0
        self._most_throttle = 1.0

    def controls(self, state: State, commands: Commands) -> Controls:
        """Return the controls for the next period."""
        model = self._model
        speed = max(state.airspeed_m_s, 0.5 * self.airspeed_m_s)
        self._mean_speed_m_s += (state.airspeed_m_s - self._mean_speed_m_s) * (
            self._period_s / _SLOW_S
        )
        slowest = _OVER_STALL * math.sqrt(self._stall / air_density(state.z)) / self.airspeed_m_s
        slowest = max(min(slowest, _SLOW), model.slowest)
        missing = max(slowest - self._mean_speed_m_s / self.airspeed_m_s, 0.0)
        climb_m_s = commands.climb_m_s - missing * self.airspeed_m_s
        aileron = self._aileron(state, commands.bank_rad, self.airspeed_m_s / speed)
        elevator = self._elevator(state, climb_m_s, speed)
        rudder = _within(model.rudder_gain * state.sideslip_rad, 1.0)
        throttle, brake = self._power(
            state, commands.climb_m_s, self.airspeed_m_s * (1.0 - commands.slow)
        )
        return aileron, elevator, rudder, throttle, brake

    def attitude(
        self, state: State, roll_rad: float, pitch_rad: float, throttle: float
    ) -> Controls:
        """Return the controls for the next period that lead to an attitude.

        The air brake opens with the slope flown, as a mixer couples it.
        """
        model = self._model
        speed = max(state.airspeed_m_s, 0.5 * self.airspeed_m_s)
        aileron = self._aileron(state, roll_rad, self.airspeed_m_s / speed)
        wanted = _within(_PITCH_GAIN * (pitch_rad - state.pitch_rad), _MOST_PITCH_RAD_S)
        elevator = self._elevator_of_rate(state, wanted, speed)
        rudder = _within(model.rudder_gain * state.sideslip_rad, 1.0)
        brake = self._brake(state.climb_m_s / speed, 1.0 - state.airspeed_m_s / self.airspeed_m_s)
        return aileron, elevator, rudder, min(throttle, self._stop(state.power_W)), brake

    def _aileron(self, state: State, bank_rad: float, slow: float) -> float:
        error = bank_rad - state.roll_rad
        wanted = _within(_BANK_GAIN * error, _MOST_ROLL_RAD_S)
        if abs(error) < 0.1:
            self._bank_trim = _within(
                self._bank_trim + _BANK_TRIM_GAIN * error * self._period_s, 0.3
            )
        rate = wanted + _ROLL_GAIN * (wanted - state.p_rad_s)
        return _within(rate / self._model.roll_rate_rad_s * slow + self._bank_trim, 1.0)

    def _elevator(self, state: State, climb_m_s: float, speed: float) -> float:
        wanted = math.asin(_within(climb_m_s / speed, 0.9))
        slope = math.asin(_within(state.climb_m_s / speed, 0.9))
        rate = _within(_SLOPE_GAIN * (wanted - slope), _MOST_PITCH_RAD_S)
        return self._elevator_of_rate(state, rate, speed)

    def _elevator_of_rate(self, state: State, rate_rad_s: float, speed: float) -> float:
        """Return the elevator for a pitch rate beyond the rate of the turn."""
        model = self._model
        bank = _within(state.roll_rad, 1.0)
        # The pitch rate of a level turn.
        turn = GRAVITY_M_S2 / speed * math.sin(bank) * math.tan(bank)
        error = rate_rad_s + turn - state.q_rad_s
        self._pitch_trim = _within(
            self._pitch_trim + model.pitch_trim_gain * error * self._period_s, 0.8
        )
        slow = (self.airspeed_m_s / speed) ** 2
        return _within(slow * (model.pitch_gain * error + self._pitch_trim), 1.0)

    def _power(self, state: State, climb_m_s: float, airspeed_m_s: float) -> tuple[float, float]:
        """Return throttle and air brake."""
        model = self._model
        short = 1.0 - state.airspeed_m_s / airspeed_m_s
        sine = _within(climb_m_s / self.airspeed_m_s, 0.9)
        thrust = (
            model.throttle_level
            + model.throttle_climb * sine
            + model.speed_gain * short
            + self._speed_trim
        )
        # The integral waits while the throttle is at a stop.
        if 0.0 < thrust < 1.0 or (thrust <= 0.0) == (short > 0.0):
            self._speed_trim = _within(
                self._speed_trim + model.speed_trim_gain * short * self._period_s, 0.5
            )
        return min(max(thrust, 0.0), self._stop(state.power_W)), self._brake(sine, short)

    def _brake(self, sine: float, short: float) -> float:
        """Return the air brake for the sine of a slope and the missing share of airspeed."""
        model = self._model
        if not model.brake_climb:
            return 0.0
        brake = model.brake_climb * (-sine - model.brake_level) - 2.0 * short
        return min(max(brake, 0.0), 1.0)

    def _stop(self, watts: float) -> float:
        """Return the current maximum throttle."""
        if math.isfinite(self._most_watts):
            left = 1.0 - watts / self._most_watts
            gain = _POWER_GAIN if left < 0 else _POWER_BACK_GAIN
            self._most_throttle += gain * left * self._period_s
            self._most_throttle = min(max(self._most_throttle, 0.2), 1.0)
        return self._most_throttle


def _within(value: float, most: float) -> float:
    """Return ``value``, clamped to ``most`` on either side of 0."""
    return min(max(value, -most), most)
