"""Lateral guidance of ArduPlane: acceleration across the path, along legs and on circles.

The law of Park, Deyst and How (2004) as ArduPilot documents its parameters ``NAVL1_PERIOD`` and
``NAVL1_DAMPING``: the distance L1 to the reference point is ``damping * period * ground speed /
pi``, and the acceleration ``4 damping^2 V^2 / L1 sin(nu)``. On a circle, a proportional and
differential law holds the radius.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from pathgene.sim.autopilot.places import Vector, cross, dot


__all__ = ["L1", "Motion"]

# A leg is met at 45 degrees at most.
_CAPTURE = math.sin(math.radians(45))
# A leg that the aircraft has passed by this time is left for its end point.
_PASSED_S = 3.0
# The integral grows only while the angle to the leg is smaller, and its bound, radians.
_NEAR_RAD = math.radians(5)
_MOST_INTEGRAL_RAD = 0.1
# Two directions to turn are equally short near this angle; the earlier choice is kept.
_UNDECIDED_RAD = 0.9 * math.pi


@dataclass(frozen=True)
class Motion:
    """Position (m), velocity over ground (m/s) and the heading's unit vector, east and north."""

    place: Vector
    velocity: Vector
    nose: Vector


class L1:
    """State of the lateral law.

    Parameters
    ----------
    period_s, damping, integral_gain : float
        ``NAVL1_PERIOD``, ``NAVL1_DAMPING`` and ``NAVL1_XTRACK_I``.

    Attributes
    ----------
    crosstrack_m : float
        Distance from the leg, positive to its right, or from the circle, positive outside.
    distance_m : float
        Distance of the reference point.
    is_on_circle : bool
        Whether the law of the circle is in force rather than the law that leads there.
    """

    def __init__(self, period_s: float, damping: float, integral_gain: float) -> None:
        self.period_s = period_s
        self.damping = damping
        self._integral_gain = integral_gain
        self._integral = 0.0
        self._last_nu = 0.0
        self.crosstrack_m = 0.0
        self.distance_m = 0.0
        self.is_on_circle = False

    def leg(self, motion: Motion, start: Vector, stop: Vector, dt_s: float) -> float:
        """Return the acceleration to the right that leads along a leg, m/s^2."""
        self.is_on_circle = False
        velocity = motion.velocity
        speed = math.hypot(*velocity)
        if speed < 0.1 or dot(velocity, motion.nose) < 0:
            speed = 0.1
            velocity = (motion.nose[0] * speed, motion.nose[1] * speed)
        self.distance_m = self.damping * self.period_s * speed / math.pi
        along, length = _direction(start, stop)
        if length < 1e-6:
            along, _ = _direction(motion.place, stop)
            if along == (0.0, 0.0):
                along = motion.nose
        offset = (motion.place[0] - start[0], motion.place[1] - start[1])
        self.crosstrack_m = cross(along, offset)
        flown = dot(offset, along)
        away = math.hypot(*offset)
        if away > self.distance_m and flown < -_CAPTURE * max(away, 1.0):
            nu = _angle_to(velocity, _direction(motion.place, start)[0])
        elif flown > length + speed * _PASSED_S:
            nu = _angle_to(velocity, _direction(motion.place, stop)[0])
        else:
            nu = self._angle_to_leg(dt_s) + _angle_to(velocity, along)
        nu = self._decided(nu, motion, stop)
        return self._acceleration(speed, nu)

    def circle(self, motion: Motion, centre: Vector, radius_m: float, *, clockwise: bool) -> float:
        """Return the acceleration to the right that leads onto a circle, m/s^2."""
        sense = 1.0 if clockwise else -1.0
        omega = 2 * math.pi / self.period_s
        speed = max(math.hypot(*motion.velocity), 1.0)
        self.distance_m = self.damping * self.period_s * speed / math.pi
        inwards, away = _direction(motion.place, centre)
        if away < 0.1:
            inwards = (-motion.nose[0], -motion.nose[1])
        nu = self._decided(_angle_to(motion.velocity, inwards), motion, centre)
        capture = self._acceleration(speed, nu)
        outwards = -dot(motion.velocity, inwards)
        error = away - radius_m
        self.crosstrack_m = error
        correction = error * omega**2 + outwards * 2 * self.damping * omega
        tangent = cross(motion.velocity, inwards) * sense
        if outwards > 0 and tangent < 0:
            correction = max(correction, 0.0)
        centripetal = tangent**2 / max(0.5 * radius_m, away)
        circling = sense * (correction + centripetal)
        if error > 0 and sense * capture < sense * circling:
            self.is_on_circle = False
            return capture
        self.is_on_circle = True
        return circling

    def heading(self, motion: Motion, course: Vector) -> float:
        """Return the acceleration to the right that holds a course, m/s^2."""
        self.is_on_circle = False
        self.crosstrack_m = 0.0
        speed = math.hypot(*motion.velocity)
        omega = math.sqrt(2) * math.pi / self.period_s
        nu = min(max(_angle_to(motion.nose, course), -math.pi / 2), math.pi / 2)
        return 2 * math.sin(nu) * speed * omega

    def _angle_to_leg(self, dt_s: float) -> float:
        """Return the angle between the leg and the reference point on it, radians."""
        sine = -self.crosstrack_m / max(self.distance_m, 0.1)
        angle = math.asin(min(max(sine, -_CAPTURE), _CAPTURE))
        if self._integral_gain <= 0:
            self._integral = 0.0
        elif abs(angle) < _NEAR_RAD:
            grown = self._integral + angle * self._integral_gain * dt_s
            self._integral = min(max(grown, -_MOST_INTEGRAL_RAD), _MOST_INTEGRAL_RAD)
        return angle + self._integral

    def _decided(self, nu: float, motion: Motion, target: Vector) -> float:
        """Return the angle to turn by, in the earlier direction where both are equally short."""
        to_target, _ = _direction(motion.place, target)
        flies_away = dot(motion.nose, to_target) < -0.5
        both = abs(nu) > _UNDECIDED_RAD and abs(self._last_nu) > _UNDECIDED_RAD
        if both and flies_away and nu * self._last_nu < 0:
            nu = self._last_nu
        self._last_nu = nu
        return nu

    def _acceleration(self, speed: float, nu: float) -> float:
        nu = min(max(nu, -math.pi / 2), math.pi / 2)
        return 4 * self.damping**2 * speed**2 / self.distance_m * math.sin(nu)


def _direction(start: Vector, stop: Vector) -> tuple[Vector, float]:
    """Return the unit vector between two places, (0, 0) for one place, and their distance."""
    east, north = stop[0] - start[0], stop[1] - start[1]
    length = math.hypot(east, north)
    if length < 1e-9:
        return (0.0, 0.0), 0.0
    return (east / length, north / length), length


def _angle_to(velocity: Vector, direction: Vector) -> float:
    """Return the turn to the right from a velocity to a direction, radians."""
    return math.atan2(cross(velocity, direction), dot(velocity, direction))
