"""Places on a plane around home, and vectors on it."""

from __future__ import annotations

import math
from dataclasses import dataclass


__all__ = ["Plane", "Vector", "cross", "distance", "dot", "past", "share"]

#: East and north, metres.
Vector = tuple[float, float]

#: Metres of a degree along a meridian, the constant that ArduPilot uses.
_DEGREE_M = 111318.84502145034


@dataclass(frozen=True)
class Plane:
    """A plane that touches the Earth at a place.

    A degree of longitude has its length at ``lat`` everywhere, which is 0.1 % wrong at 5 km north
    of 53 degrees. Legs stay straight and pass through their waypoints.

    Parameters
    ----------
    lat, lon : float
        Degrees.
    """

    lat: float
    lon: float

    def local(self, lat: float, lon: float) -> Vector:
        """Return metres east and north of the plane's place."""
        return (lon - self.lon) * _DEGREE_M * self._narrow, (lat - self.lat) * _DEGREE_M

    def degrees(self, place: Vector) -> tuple[float, float]:
        """Return latitude and longitude."""
        east, north = place
        return self.lat + north / _DEGREE_M, self.lon + east / (_DEGREE_M * self._narrow)

    @property
    def _narrow(self) -> float:
        return math.cos(math.radians(self.lat))


def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Vector, b: Vector) -> float:
    """Return the product of two vectors that is positive if ``b`` points to the right of ``a``."""
    return a[1] * b[0] - a[0] * b[1]


def distance(a: Vector, b: Vector) -> float:
    """Return the distance of two places."""
    return math.hypot(a[0] - b[0], a[1] - b[1])


def share(place: Vector, start: Vector, stop: Vector) -> float:
    """Return the share of a leg that lies before the foot of a place, 1 for a leg of no length."""
    leg = (stop[0] - start[0], stop[1] - start[1])
    square = dot(leg, leg)
    if square < 1e-3:
        return 1.0
    return dot(leg, (place[0] - start[0], place[1] - start[1])) / square


def past(place: Vector, start: Vector, stop: Vector) -> bool:
    """Return whether a place lies beyond the line across the end of a leg."""
    return share(place, start, stop) >= 1.0
