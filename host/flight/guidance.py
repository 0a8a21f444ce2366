"""Guidance: bank and climb rate that bring an aircraft onto a route and keep it there.

Laterally, the L1 law of Park, Deyst and How, "A New Nonlinear Guidance Logic for Trajectory
Tracking" (2004): the acceleration ``2 V^2 sin(eta) / L1`` leads on a circle to the point of the
route at the distance L1 ahead, where eta is the angle from the ground velocity to that point.
Vertically, the slope of the route ahead plus a share of the height error.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from pathgene.host.flight.route import Place, Route
from pathgene.host.problem.limits import GRAVITY_M_S2


__all__ = ["MEAN_S", "Commands", "Guidance", "Limits", "State"]

#: Seconds over which the mean bank is limited, and the factor of the momentary limit: a turn begins
#: with more bank than it holds.
MEAN_S = 5.0
PEAK = 1.25
# Maximum reduction of the airspeed in a turn that needs nearly all of the bank or more, because
# gusts from astern widen a turn; then the share of the bank at which the reduction begins, its
# look-ahead and its rate.
_SLOWEST = 0.1
_SLOW_FROM = 0.85
_SLOW_AHEAD_S = 4.0
_SLOW_S = 1.0


@dataclass(frozen=True)
class State:
    """The part of an aircraft's state that guidance and control use.

    Parameters
    ----------
    time_s : float
        Simulated seconds.
    x, y, z : float
        Position in the terrain's frame and altitude, metres.
    east_m_s, north_m_s, climb_m_s : float
        Velocity over ground.
    airspeed_m_s : float
        True airspeed.
    roll_rad, pitch_rad : float
        Attitude, positive to the right and up.
    p_rad_s, q_rad_s : float
        Rates of roll and pitch.
    sideslip_rad : float
        Positive with the wind from the right.
    power_W : float
        Shaft power.
    """

    time_s: float
    x: float
    y: float
    z: float
    east_m_s: float
    north_m_s: float
    climb_m_s: float
    airspeed_m_s: float
    roll_rad: float
    pitch_rad: float
    p_rad_s: float
    q_rad_s: float
    sideslip_rad: float
    power_W: float


@dataclass(frozen=True)
class Limits:
    """Largest commands.

    Parameters
    ----------
    bank_rad : float
        Bank to either side, as a mean over :data:`MEAN_S`; momentarily it may be :data:`PEAK` times
        greater.
    climb_m_s, descent_m_s : float
        Vertical speeds, both positive.
    power_W : float
        Shaft power; infinite if the aircraft has no limit.
    """

    bank_rad: float
    climb_m_s: float
    descent_m_s: float
    power_W: float = math.inf


@dataclass(frozen=True)
class Commands:
    """Commands of the guidance.

    Parameters
    ----------
    bank_rad : float
        Positive to the right.
    height_error_m : float
        Height over the route.
    slow : float
        Share of the airspeed to give up for a turn that needs more bank than allowed.
    """

    place: Place
    bank_rad: float
    climb_m_s: float
    height_error_m: float
    slow: float = 0.0


class Guidance:
    """L1 guidance along a route.

    Parameters
    ----------
    route : Route
        Replace it with :meth:`follow` at any time.
    limits : Limits
        Largest commands.
    lookahead_s : float
        L1 divided by the current ground speed.
    lead_s : float
        Look-ahead of the slope that is fed forward, because the aircraft responds late.
    height_gain : float
        Vertical speed per metre of height error, 1/s.
    period_s : float
        Time between two calls of :meth:`commands`.
    """

    def __init__(
        self,
        route: Route,
        limits: Limits,
        *,
        lookahead_s: float,
        lead_s: float,
        height_gain: float,
        period_s: float,
    ) -> None:
        self.limits = limits
        self._lookahead_s = lookahead_s
        self._lead_s = lead_s
        self._height_gain = height_gain
        count = round(MEAN_S / period_s)
        self._banks = deque([0.0] * count, maxlen=count)
        self._bank_sum = 0.0
        self._period_s = period_s
        self._slow = 0.0
        self.follow(route)

    def follow(self, route: Route) -> None:
        """Continue along ``route``, which begins next to or astern of the aircraft.

        The search for its nearest point starts at the beginning, because later parts may cross the
        same place.
        """
        self.route = route
        self._leg = 0

    def commands(self, state: State) -> Commands:
        """Return the commands for a state."""
        route = self.route
        place = route.locate(state.x, state.y, self._leg)
        self._leg = place.leg
        speed = math.hypot(state.east_m_s, state.north_m_s)
        bank = self._bank(state, place, speed)
        limited = self._limited(bank)
        self._slow_down(abs(bank) - abs(limited), place, speed)
        return Commands(place, limited, *self._climb(state, place, speed), self._slow)

    def _bank(self, state: State, place: Place, speed: float) -> float:
        lookahead = max(speed, 1.0) * self._lookahead_s
        # Farther off than L1, the route is met at a right angle.
        ahead = math.sqrt(max(lookahead**2 - place.cross_m**2, 0.0))
        x, y = self.route.point(place.along_m + ahead, place.leg)
        dx, dy = x - state.x, y - state.y
        distance = max(math.hypot(dx, dy), 1.0)
        # Sine of the angle from the velocity to the point, positive to the left.
        sine = (state.east_m_s * dy - state.north_m_s * dx) / (max(speed, 1.0) * distance)
        cosine = state.east_m_s * dx + state.north_m_s * dy
        if cosine < 0:
            sine = math.copysign(1.0, sine)
        acceleration = 2 * speed**2 * sine / distance
        return -math.atan(acceleration / GRAVITY_M_S2)

    def _limited(self, bank: float) -> float:
        """Return ``bank``, limited so that it and its mean magnitude keep their limits."""
        banks, most = self._banks, self.limits.bank_rad
        count = len(banks)
        left = most * count - (self._bank_sum - banks[0])
        # The limit tightens gradually as the mean approaches its own limit, so that the bank is
        # never cut off abruptly.
        peak = most * PEAK - (PEAK - 1) * self._bank_sum / count
        size = min(abs(bank), peak, max(left, 0.0))
        self._bank_sum += size - banks[0]
        banks.append(size)
        return math.copysign(size, bank)

    def _slow_down(self, missing_rad: float, place: Place, speed: float) -> None:
        """Update the airspeed to give up; ``missing_rad`` is the bank beyond its limit."""
        most = self.limits.bank_rad
        curvature = max(
            abs(self.route.curvature(place.along_m + ahead_s * speed, place.leg))
            for ahead_s in (0.0, _SLOW_AHEAD_S)
        )
        needed = math.atan(speed**2 * curvature / GRAVITY_M_S2) / most
        short = max((needed - _SLOW_FROM) / (1.0 - _SLOW_FROM), missing_rad / (0.5 * most))
        wanted = _SLOWEST * min(max(short, 0.0), 1.0)
        self._slow += (wanted - self._slow) * (self._period_s / _SLOW_S)

    def _climb(self, state: State, place: Place, speed: float) -> tuple[float, float]:
        height, _ = self.route.height(place.along_m, place.leg)
        _, slope = self.route.height(place.along_m + speed * self._lead_s, place.leg)
        error = state.z - height
        climb = speed * slope - self._height_gain * error
        return min(max(climb, -self.limits.descent_m_s), self.limits.climb_m_s), error
