"""Arcs of circles on the ellipsoid as corners of polygons that the arcs never leave."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from pyproj import Geod

from pathgene.host.formats.features import Position


__all__ = ["Arc", "around", "bearing", "corner", "unwrapped"]

_EARTH = Geod(ellps="WGS84")
# Maximum distance between an arc and its polygon, metres, and the distance between a polygon and
# the arc, because edges are straight in degrees.
_TOLERANCE_M = 0.25
_APART_M = 0.05


class Arc:
    """An arc around a centre, from one bearing to another.

    Parameters
    ----------
    centre : Position
        Centre.
    start, end : (float, float)
        Bearing in degrees and radius in metres of both ends; the radius between them is linear.
    clockwise : bool
        Direction from start to end; equal bearings make a circle.
    """

    def __init__(
        self,
        centre: Position,
        start: tuple[float, float],
        end: tuple[float, float],
        *,
        clockwise: bool,
    ) -> None:
        self.centre, self.clockwise = centre, clockwise
        self._first, self._radius_m = start
        self._growth_m = end[1] - start[1]
        sweep = (end[0] - start[0]) % 360.0 if clockwise else (start[0] - end[0]) % 360.0
        self._sweep = (sweep or 360.0) * (1.0 if clockwise else -1.0)

    def corners(self, *, grown: bool) -> list[Position]:
        """Return corners from start to end, on the arc or, if ``grown``, of tangents to it.

        The chain lies within half a metre of the arc, on one side: nearer to the centre, or farther
        if it is grown.
        """
        radius_m = max(self._radius_m, self._radius_m + self._growth_m, 1e-3)
        half = math.acos(radius_m / (radius_m + _TOLERANCE_M))
        steps = max(4, math.ceil(math.radians(abs(self._sweep)) / (2 * half)))
        if not grown:
            return self._at(np.arange(steps + 1) / steps)
        longer = 1 / math.cos(math.radians(abs(self._sweep)) / steps / 2)
        added_m = abs(self._growth_m) / steps / 2 + _APART_M
        middles = self._at((np.arange(steps) + 0.5) / steps, longer, added_m)
        first, last = self._at(np.array([0.0, 1.0]))
        return [first, *middles, last]

    def _at(
        self, shares: NDArray[np.float64], longer: float = 1.0, added_m: float = 0.0
    ) -> list[Position]:
        """Return the positions at shares of the arc, with longer radii."""
        radii_m = (self._radius_m + shares * self._growth_m) * longer + added_m
        longitude, latitude = (np.full(len(shares), angle) for angle in self.centre)
        bearings = self._first + shares * self._sweep
        longitudes, latitudes, _ = _EARTH.fwd(longitude, latitude, bearings, radii_m)
        longitudes = longitudes + 360.0 * np.round((self.centre[0] - longitudes) / 360.0)
        return list(zip(longitudes.tolist(), latitudes.tolist(), strict=True))


def corner(centre: Position, bearing_deg: float, distance_m: float) -> Position:
    """Return the position at a bearing and a distance, its longitude near the centre's."""
    longitude, latitude, _ = _EARTH.fwd(*centre, bearing_deg, distance_m)
    return unwrapped((longitude, latitude), centre[0])


def bearing(centre: Position, position: Position) -> tuple[float, float]:
    """Return bearing in degrees and distance in metres of a position from a centre."""
    degrees, _, distance_m = _EARTH.inv(*centre, *position)
    return degrees, distance_m


def unwrapped(position: Position, longitude: float) -> Position:
    """Return a position with its longitude within half a turn of another."""
    turns = round((longitude - position[0]) / 360.0)
    return position[0] + 360.0 * turns, position[1]


def around(first: Position, second: Position, half_width_m: float) -> tuple[Position, ...]:
    """Return the rectangle around a line, half its width to either side."""
    there, back, _ = _EARTH.inv(*first, *second)
    return (
        corner(first, there - 90.0, half_width_m),
        corner(second, back + 90.0, half_width_m),
        corner(second, back - 90.0, half_width_m),
        corner(first, there + 90.0, half_width_m),
    )
