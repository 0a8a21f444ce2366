"""Height and speed control of ArduPlane: total energy, by throttle, and its balance, by pitch.

The equations of TECS as ArduPilot publishes them, with an airspeed sensor, in normal flight and in
landings. The demand for height is averaged over two calls, limited in its rate, and delayed by
``TECS_HDEM_TCONST``. In a landing the delay is compensated, the time constant is
``TECS_LAND_TCONST``, and pitch follows the height more and the speed less, until the height alone
counts at the touch-down. The flare turns the sink rate into ``TECS_LAND_SINK`` without throttle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from pathgene.sim.autopilot.airframe import GRAVITY_M_S2
from pathgene.sim.autopilot.parameters import Parameters
from pathgene.sim.autopilot.targets import Approach


__all__ = ["Demand", "Tecs", "Vertical"]


@dataclass(frozen=True)
class Vertical:
    """Measurements of the height and speed control.

    Parameters
    ----------
    height_m, climb_m_s : float
        Altitude and its rate.
    tas_m_s : float
        True airspeed, by the sensor.
    forward_m_s2 : float
        Acceleration along the nose.
    eas2tas : float
        True airspeed divided by equivalent airspeed.
    roll_rad, pitch_rad : float
        Attitude.
    """

    height_m: float
    climb_m_s: float
    tas_m_s: float
    forward_m_s2: float
    eas2tas: float
    roll_rad: float
    pitch_rad: float


@dataclass(frozen=True)
class Demand:
    """Pitch in radians and throttle from 0 to 1."""

    pitch_rad: float
    throttle: float


@dataclass
class _Flare:
    """The beginning of a flare, and its two heights: from the demanded and from the flown one."""

    begun_m: float
    climb_m_s: float
    demanded_m: float
    flown_m: float


class Tecs:
    """State of the total energy control.

    Parameters
    ----------
    parameters : Parameters
        Parameters of ArduPlane, read at each call.

    Attributes
    ----------
    height_m : float
        The delayed demand for height, ArduPilot's ``TECS.hdem``.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._is_new = True
        self._tas = self._tas_drift = 0.0
        self.height_m = self._height_rate = 0.0
        self._approach: Approach | None = None
        self._flare: _Flare | None = None

    def reset(self) -> None:
        """Begin again from the measured height at the next call."""
        self._is_new = True

    def update(
        self,
        now: Vertical,
        height_m: float,
        eas_m_s: float,
        load: float,
        dt_s: float,
        approach: Approach | None = None,
    ) -> Demand:
        """Return pitch and throttle for a demanded height and equivalent airspeed.

        Parameters
        ----------
        load : float
            Load factor of the demanded bank, which raises the minimum airspeed.
        dt_s : float
            Seconds since the last call; ArduPlane calls ten times a second.
        approach : Approach or None
            State of a landing.
        """
        self._approach = approach
        if self._is_new:
            self._initialize(now, eas_m_s)
        now = self._smoothed(now, dt_s)
        self._limit_speed(now, eas_m_s, load, dt_s)
        if approach is not None and approach.flares:
            self._sink_slowly(now, approach, dt_s)
            return Demand(self._pitch(now, dt_s), 0.0)
        self._flare = None
        self._delay_height(height_m, dt_s)
        lag_s = self._parameters["TECS_HDEM_TCONST"]
        self._followed_m = self.height_m + (0.0 if approach is None else lag_s * self._height_rate)
        pitch = self._pitch(now, dt_s)
        return Demand(pitch, self._throttle(now, dt_s))

    def _smoothed(self, now: Vertical, dt_s: float) -> Vertical:
        """Return the measurements with the airspeed that sensor and accelerometers agree on."""
        omega = self._parameters["TECS_SPD_OMEGA"]
        error = now.tas_m_s - self._tas
        self._tas_drift += error * omega**2 * dt_s
        rate = self._tas_drift + now.forward_m_s2 + error * omega * math.sqrt(2)
        self._tas = max(self._tas + rate * dt_s, 3.0)
        return replace(now, tas_m_s=self._tas)

    def _initialize(self, now: Vertical, eas_m_s: float) -> None:
        get = self._parameters
        self._is_new = False
        self._tas, self._tas_drift = now.tas_m_s, 0.0
        self.height_m = self._height_in = self._height_limited = now.height_m
        self._followed_m = now.height_m
        self._height_before = now.height_m
        self._height_rate = 0.0
        self._climb_scale = self._sink_scale = 1.0
        self._tas_dem = self._tas_dem_limited = eas_m_s * now.eas2tas
        self._tas_dem_rate = self._tas_dem_rate_slow = 0.0
        self._tas_rate_slow = now.forward_m_s2
        self._tas_most = get["AIRSPEED_MAX"] * now.eas2tas
        self._rate_error = 0.0
        self._throttle_sum = 0.0
        self._last_throttle = get["TRIM_THROTTLE"] / 100
        # The balance that holds the present pitch.
        self._balance_sum = now.pitch_rad * now.tas_m_s * GRAVITY_M_S2
        self._speed_sum = 0.0
        self._last_pitch = now.pitch_rad
        self._pitch_free = now.pitch_rad
        self._throttle_stop = self._balance_stop = 0

    def _limit_speed(self, now: Vertical, eas_m_s: float, load: float, dt_s: float) -> None:
        """Limit the demanded airspeed and its rate."""
        get = self._parameters
        most = get["TECS_CLMB_MAX"] * self._climb_scale * GRAVITY_M_S2
        least = -get["TECS_SINK_MIN"] * GRAVITY_M_S2
        self._energy_most, self._energy_least = most, least
        slowest = get["AIRSPEED_MIN"] * now.eas2tas
        if get["STALL_PREVENTION"]:
            slowest *= math.sqrt(load)
        speed = max(now.tas_m_s, 3.0)
        if self._throttle_stop > 0:
            self._tas_most += dt_s * 0.5 * least / speed
            self._tas_most = max(self._tas_most, get["AIRSPEED_CRUISE"] * now.eas2tas)
        else:
            self._tas_most += dt_s * 0.5 * most / speed
        self._tas_most = max(min(self._tas_most, get["AIRSPEED_MAX"] * now.eas2tas), slowest)
        self._tas_least = slowest
        wanted = min(max(eas_m_s * now.eas2tas, slowest), self._tas_most)
        rise = (wanted - self._tas_dem_limited) / dt_s
        rise = min(max(rise, 0.5 * least / speed), 0.5 * most / speed)
        self._tas_dem_limited += rise * dt_s
        self._tas_dem_rate = rise
        slow = dt_s / (dt_s + self._time_s)
        self._tas_dem_rate_slow += (rise - self._tas_dem_rate_slow) * slow
        self._tas_rate_slow += (now.forward_m_s2 - self._tas_rate_slow) * slow
        self._tas_dem_limited = min(max(self._tas_dem_limited, slowest), self._tas_most)

    def _delay_height(self, height_m: float, dt_s: float) -> None:
        """Average, limit and delay the demanded height."""
        get = self._parameters
        lag_s = get["TECS_HDEM_TCONST"]
        # A demand that the aircraft cannot follow stays where it is.
        if (self._cannot_climb and height_m > self._height_in) or (
            self._cannot_sink and height_m < self._height_in
        ):
            height_m = self._height_in
        average = 0.5 * (height_m + self._height_in)
        self._height_in = height_m
        rise = average - self._height_limited
        up = get["TECS_CLMB_MAX"] * self._climb_scale * dt_s
        down = get["TECS_SINK_MAX"] * self._sink_scale * dt_s
        self._height_limited += min(max(rise, -down), up)
        self._height_rate = (self._height_limited - self.height_m) / lag_s
        share = dt_s / (dt_s + lag_s)
        self.height_m += (self._height_limited - self.height_m) * share
        if self._approach is not None:
            return
        is_short_up = self._cannot_climb or self._balance_stop > 0
        is_short_down = self._cannot_sink or self._balance_stop < 0
        if is_short_up and self.height_m > self._height_before:
            self._climb_scale *= 1 - share
        elif is_short_down and self.height_m < self._height_before:
            self._sink_scale *= 1 - share
        else:
            self._climb_scale += (1 - self._climb_scale) * share
            self._sink_scale += (1 - self._sink_scale) * share
        self._height_before = self.height_m

    def _sink_slowly(self, now: Vertical, approach: Approach, dt_s: float) -> None:
        """Lead the sink rate over to the one at the touch-down, linearly with the height."""
        get = self._parameters
        if self._flare is None:
            climb = now.climb_m_s
            self._flare = _Flare(approach.above_m, climb, self._followed_m, now.height_m)
        flare, last_m = self._flare, get["TECS_FLARE_HGT"]
        share = 1.0
        if flare.begun_m > last_m:
            share = (flare.begun_m - approach.above_m) / (flare.begun_m - last_m)
            share = min(max(share, 0.0), 1.0)
        self._height_rate = flare.climb_m_s * (1 - share) - get["TECS_LAND_SINK"] * share
        flare.demanded_m += self._height_rate * dt_s
        flare.flown_m += self._height_rate * dt_s
        self._followed_m = flare.demanded_m * (1 - share) + flare.flown_m * share
        # After a missed approach, the demand begins at the present height.
        self.height_m = self._height_in = self._height_limited = now.height_m

    @property
    def _time_s(self) -> float:
        name = "TECS_TIME_CONST" if self._approach is None else "TECS_LAND_TCONST"
        return max(self._parameters[name], 0.1)

    @property
    def _speed_weight(self) -> float:
        """Weight of the speed in the pitch, which a landing lowers to 0."""
        get, approach = self._parameters, self._approach
        weight = get["TECS_SPDWEIGHT"]
        if approach is not None:
            weight *= 1 - approach.flown
            if get["TECS_LAND_SPDWGT"] >= 0:
                weight = get["TECS_LAND_SPDWGT"]
        return min(max(weight, 0.0), 2.0)

    @property
    def _cannot_climb(self) -> bool:
        return self._throttle_stop > 0 or self._pitch_free > self._pitch_limits[1]

    @property
    def _cannot_sink(self) -> bool:
        return self._throttle_stop < 0 or self._pitch_free < self._pitch_limits[0]

    @property
    def _pitch_limits(self) -> tuple[float, float]:
        get = self._parameters
        most, least = get["PTCH_LIM_MAX_DEG"], get["PTCH_LIM_MIN_DEG"]
        if get["TECS_PITCH_MAX"]:
            most = min(most, get["TECS_PITCH_MAX"])
        if get["TECS_PITCH_MIN"] < 0:
            least = max(least, get["TECS_PITCH_MIN"])
        if self._flare is not None and self._approach is not None:
            begun_m = self._flare.begun_m
            down = 1 - self._approach.above_m / begun_m if begun_m > get["TECS_FLARE_HGT"] else 1.0
            down = min(max(down, 0.0), 1.0)
            least = max(least, (1 - down) * least + down * get["LAND_PITCH_DEG"])
            most = max(get["TECS_LAND_PMAX"] or most, least)
        return math.radians(least), math.radians(most)

    def _pitch(self, now: Vertical, dt_s: float) -> float:
        """Return the pitch that exchanges speed and height as demanded."""
        get = self._parameters
        time_s = self._time_s
        least, most = self._pitch_limits
        weight = self._speed_weight
        for_height, for_speed = min(2.0 - weight, 1.0), min(weight, 1.0)
        speed = max(now.tas_m_s, 3.0)
        kinetic, kinetic_dem = 0.5 * speed**2, 0.5 * self._tas_dem_limited**2
        error = (self._followed_m - now.height_m) * GRAVITY_M_S2 * for_height
        error -= (kinetic_dem - kinetic) * for_speed
        rate = self._height_rate * GRAVITY_M_S2 * for_height + error / time_s
        up, down = get["TECS_CLMB_MAX"] * GRAVITY_M_S2, get["TECS_SINK_MAX"] * GRAVITY_M_S2
        self._balance_stop = int(rate > up) - int(rate < -down)
        rate = min(max(rate, -down), up)
        measured = now.climb_m_s * GRAVITY_M_S2 * for_height
        measured -= speed * (now.forward_m_s2 - self._tas_rate_slow) * for_speed
        rate_error = rate - measured
        total = rate + rate_error * get["TECS_LAND_DAMP" if self._flare else "TECS_PTCH_DAMP"]
        gain = speed * GRAVITY_M_S2
        slack = math.radians(5)
        low, high = gain * (least - slack) - total, gain * (most + slack) - total
        grown = rate_error * get["TECS_INTEG_GAIN"] * dt_s
        grown = min(max(grown, -0.1 * (high - low)), 0.1 * (high - low))
        free = (total + self._balance_sum + grown + self._speed_sum) / gain
        if (free > most and grown > 0) or (free < least and grown < 0):
            fade = 1 - dt_s / (dt_s + time_s)
            self._balance_sum *= fade
            self._speed_sum *= fade
        else:
            self._balance_sum += grown
            self._speed_sum += (kinetic - kinetic_dem) * for_speed * dt_s / time_s
        self._balance_sum = min(max(self._balance_sum, low), high)
        bound = 0.25 * (most - least) * gain
        self._speed_sum = min(max(self._speed_sum, -bound), bound)
        self._pitch_free = (total + self._balance_sum + self._speed_sum) / gain
        step = dt_s * get["TECS_VERT_ACC"] / speed
        pitch = min(max(self._pitch_free, least), most)
        self._last_pitch = min(max(pitch, self._last_pitch - step), self._last_pitch + step)
        return self._last_pitch

    def _throttle(self, now: Vertical, dt_s: float) -> float:
        """Return the throttle that changes the total energy as demanded."""
        get = self._parameters
        time_s = self._time_s
        most, least = get["THR_MAX"] / 100, get["THR_MIN"] / 100
        speed = max(now.tas_m_s, 3.0)
        kinetic = 0.5 * speed**2
        potential_error = (self._followed_m - now.height_m) * GRAVITY_M_S2
        most_error = max(kinetic - 0.5 * self._tas_least**2, 0.0)
        least_error = min(kinetic - 0.5 * self._tas_most**2, 0.0)
        error = (
            min(max(potential_error, least_error), most_error)
            + 0.5 * self._tas_dem_limited**2
            - kinetic
        )
        rate = potential_error / time_s
        rate += speed * (self._tas_dem_rate - self._tas_dem_rate_slow)
        rate = min(max(rate, self._energy_least), self._energy_most)
        measured = now.climb_m_s * GRAVITY_M_S2
        measured += speed * (now.forward_m_s2 - self._tas_rate_slow)
        share = min(2 * dt_s, 1.0)
        self._rate_error += (rate - measured - self._rate_error) * share
        span = self._energy_most - self._energy_least
        gain = (most - least) / (time_s * span)
        cosine = math.cos(now.roll_rad)
        rate += get["TECS_RLL2THR"] * (1 / min(max(cosine**2, 0.1), 1.0) - 1)
        throttle = get["TRIM_THROTTLE"] / 100 + rate / span * (most - least)
        throttle += (error + self._rate_error * get["TECS_THR_DAMP"]) * gain
        bound = 0.5 * (most - max(least, 0.0))
        high = min(max(most - throttle + 0.1, -bound), bound)
        low = min(max(least - throttle - 0.1, -bound), bound)
        self._throttle_sum += error * get["TECS_INTEG_GAIN"] * dt_s * gain
        self._throttle_sum = min(max(self._throttle_sum, low), high)
        slew = get["THR_SLEWRATE"] / 100 * dt_s * (most - max(least, 0.0))
        if slew:
            throttle = min(max(throttle, self._last_throttle - slew), self._last_throttle + slew)
            self._last_throttle = throttle
        throttle += self._throttle_sum
        self._throttle_stop = int(throttle > most) - int(throttle < least)
        return min(max(throttle, least), most)
