"""The landing of ArduPlane: its slope, its speed and its flare.

The rules are ArduPilot's for a landing on a slope, as its sources and the documentation of
``LAND_*`` state them, without a range finder, a pre-flare and flaps. The slope leads through an aim
point before the touch-down and above it, and is computed again at each call with the present speed
over ground, so that it fits the wind. Below the height of the flare the engine stops, the bank is
small, and the height control brings the sink rate to ``TECS_LAND_SINK``.
"""

from __future__ import annotations

import math

from pathgene.sim.autopilot.parameters import Parameters
from pathgene.sim.autopilot.places import distance, dot, share
from pathgene.sim.autopilot.targets import Air, Approach, Target


__all__ = ["PlaneLanding"]

# The slope leads to a point this far after the touch-down, so that it has no end there.
_BEYOND_M = 500.0
# Share of a new sink rate in the filtered one.
_NEW_SINK = 0.2
# The aircraft is lined up within this angle and this distance of the leg.
_LINED_UP_RAD, _ON_LINE_M = math.radians(10), 5.0
# Slower speeds over ground count as this one.
_SLOWEST_M_S = 0.5


class PlaneLanding:
    """State of a landing.

    Parameters
    ----------
    parameters : Parameters
        Parameters of ArduPlane, read at each call.
    begin, end : Target
        Ends of the last leg; the second one is the touch-down.
    """

    def __init__(self, parameters: Parameters, begin: Target, end: Target) -> None:
        self._parameters = parameters
        self._begin, self._end = begin, end
        self._is_lined_up = self._flares = False
        self._sink_m_s = 0.0

    def update(self, air: Air, crosstrack_m: float, height_m: float) -> tuple[float, Approach]:
        """Return the altitude to ask for, and the state of the landing.

        Parameters
        ----------
        crosstrack_m : float
            Distance from the leg.
        height_m : float
            Altitude AMSL on the straight line of the leg, which is flown until the aircraft is
            lined up.
        """
        self._sink_m_s += (-air.climb_m_s - self._sink_m_s) * _NEW_SINK
        flown = share(air.place, self._begin.place, self._end.place)
        ground_m = self._end.altitude_m(air.earth, air.place)
        above_m = air.altitude_m - ground_m
        self._is_lined_up |= self._lines_up(air, flown, crosstrack_m)
        self._flares |= self._is_low(above_m, flown)
        if self._flares:
            height_m = ground_m
        elif self._is_lined_up:
            height_m = ground_m + self._slope_m(air, flown)
        return height_m, Approach(
            min(max(flown, 0.0), 1.0), above_m, self._airspeed_m_s(air), self._flares
        )

    def _lines_up(self, air: Air, flown: float, crosstrack_m: float) -> bool:
        (x0, y0), (x1, y1) = self._begin.place, self._end.place
        east, north = air.motion.velocity
        turn = math.atan2(east, north) - math.atan2(x1 - x0, y1 - y0)
        is_ahead = abs(math.remainder(turn, 2 * math.pi)) < _LINED_UP_RAD
        is_lower = air.altitude_m < self._begin.altitude_m(air.earth, air.place)
        return (
            (flown >= 0 and is_ahead and abs(crosstrack_m) < _ON_LINE_M)
            or (flown > 0.15 and is_ahead and is_lower)
            or flown > 0.5
        )

    def _is_low(self, above_m: float, flown: float) -> bool:
        get = self._parameters
        if self._is_lined_up and above_m <= get["LAND_FLARE_ALT"]:
            return True
        is_soon = above_m <= self._sink_m_s * get["LAND_FLARE_SEC"]
        return (self._is_lined_up and is_soon and flown > 0.5) or flown >= 1

    def _slope_m(self, air: Air, flown: float) -> float:
        """Return the height of the slope above the touch-down, for the present speed."""
        get = self._parameters
        high_m = self._begin.altitude_m(air.earth, air.place)
        high_m -= self._end.altitude_m(air.earth, air.place)
        length_m = max(distance(self._begin.place, self._end.place), 1.0)
        speed = max(math.hypot(*air.motion.velocity), _SLOWEST_M_S)
        sink = high_m * speed / length_m
        flare_alt_m = get["LAND_FLARE_ALT"]
        aim_m = get["LAND_FLARE_SEC"] * sink
        if aim_m <= 0:
            aim_m = flare_alt_m
        if flare_alt_m > 0:
            aim_m = min(aim_m, 2 * flare_alt_m)
        weight = min(max(get["LAND_FLARE_AIM"] / 100, 0.0), 1.0)
        mean = max(weight * get["TECS_LAND_SINK"] + (1 - weight) * sink, 0.1)
        before_m = min(speed * aim_m / mean, 0.5 * length_m)
        slope = (high_m - aim_m) / (length_m - before_m)
        least_m = aim_m - slope * _BEYOND_M
        height_m = aim_m + slope * ((1 - flown) * length_m - before_m)
        return min(max(height_m, least_m), high_m)

    def _airspeed_m_s(self, air: Air) -> float:
        """Return the equivalent airspeed: between minimum and cruise, more in a head wind."""
        get = self._parameters
        cruise = get["AIRSPEED_CRUISE"]
        if not self._is_lined_up:
            return cruise
        wanted = get["TECS_LAND_ARSPD"]
        if wanted < 0:
            wanted = 0.5 * (cruise + get["AIRSPEED_MIN"])
        head_m_s = -dot(air.wind, air.motion.nose) * get["LAND_WIND_COMP"] / 100
        return min(max(wanted + head_m_s, wanted), max(cruise, wanted))
