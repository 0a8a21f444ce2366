"""True metres and true north of a reference system, measured by geodesics along its axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pyproj import Geod

from pathgene.host.terrain.geodesy import WGS84, LocalFrame, place_points


__all__ = ["MOST_CONVERGENCE_DEG", "Metric", "measure", "measure_frame"]

Floats = NDArray[np.float64]

#: Largest difference of lengths over a map, and between its axes, as a share.
_MOST_SPREAD = 0.0005
#: Maximum difference between grid north and true north at the middle of a map; otherwise its raster
#: is warped.
MOST_CONVERGENCE_DEG = 10.0
# Side of the cross that is measured, in cells.
_CELLS = 4.0
_GEODESICS = Geod(ellps="WGS84")


@dataclass(frozen=True, eq=False)
class Metric:
    """A reference system, measured along its axes at nine points of a map, row by row from south.

    Parameters
    ----------
    east_m, north_m : ndarray
        Metres on the ground for a unit along the first axis and along the second, (9,).
    convergence_deg : ndarray
        Direction of the second axis, degrees clockwise from true north, (9,).
    skew_deg : ndarray
        Difference of the angle between the axes from a right angle, (9,).
    """

    east_m: Floats
    north_m: Floats
    convergence_deg: Floats
    skew_deg: Floats

    @property
    def middle(self) -> tuple[float, float]:
        """Metres for a unit along each axis at the middle; one number if the axes agree."""
        east, north = float(self.east_m[4]), float(self.north_m[4])
        if abs(east - north) <= 1e-6 * east:
            east = north = 0.5 * (east + north)
        return east, north

    @property
    def spread(self) -> float:
        """Greatest difference of the lengths of a unit, between points and axes, as a share."""
        lengths = np.concatenate((self.east_m, self.north_m))
        return float(np.ptp(lengths) / lengths.mean())

    @property
    def is_metric(self) -> bool:
        """True if a single scale is valid over the map and for both axes, at right angles."""
        return self.spread <= _MOST_SPREAD and self._is_right_angled

    @property
    def between(self) -> float | None:
        """Metres for a unit halfway between the shortest and the longest.

        None if a length differs from it by more than 0.05 %, or the axes are not at right angles.
        """
        lengths = np.concatenate((self.east_m, self.north_m))
        found = 0.5 * float(lengths.min() + lengths.max())
        is_near = self.spread <= 2 * _MOST_SPREAD
        return found if is_near and self._is_right_angled else None

    @property
    def _is_right_angled(self) -> bool:
        return float(np.abs(np.radians(self.skew_deg)).max()) <= _MOST_SPREAD

    @property
    def is_north_up(self) -> bool:
        """True if the second axis points roughly north at the middle."""
        return abs(self.convergence_at_middle_deg) <= MOST_CONVERGENCE_DEG

    @property
    def convergence_at_middle_deg(self) -> float:
        """Direction of the second axis at the middle, degrees clockwise from true north."""
        return float(self.convergence_deg[4])


def measure(
    crs: str, x: tuple[float, float], y: tuple[float, float], cell: tuple[float, float]
) -> Metric:
    """Measure a reference system over a map.

    Parameters
    ----------
    crs : str
        Projected reference system.
    x, y : tuple of float
        First and last coordinate of each axis, in its units.
    cell : tuple of float
        Sides of a cell, in its units.

    Raises
    ------
    InputError
        If a point of the map has no place on Earth.
    """
    along_x, along_y = (np.linspace(min(ends), max(ends), 3) for ends in (x, y))
    east, north = (axis.ravel() for axis in np.meshgrid(along_x, along_y))
    return measure_at(crs, east, north, (_CELLS * abs(cell[0]), _CELLS * abs(cell[1])))


def measure_at(crs: str, x: Floats, y: Floats, step: tuple[float, float]) -> Metric:
    """Measure a reference system at nine points, (9,) each, along a cross of sides ``step``."""
    half_x, half_y = 0.5 * step[0], 0.5 * step[1]
    lon, lat = place_points(
        crs,
        WGS84,
        np.concatenate((x - half_x, x + half_x, x, x, x)),
        np.concatenate((y, y, y - half_y, y + half_y, y)),
    )
    west, east, south, north, middle = zip(np.split(lon, 5), np.split(lat, 5), strict=True)
    _, east_m = _geodesic(west, east)
    _, north_m = _geodesic(south, north)
    # Diagonals, because the directions of meridians differ between the points of a cross at a pole.
    (_, right), (_, left) = _geodesic(east, north), _geodesic(west, north)
    skew = np.degrees(np.arcsin(np.clip((left**2 - right**2) / (east_m * north_m), -1, 1)))
    along_north, _ = _geodesic(middle, north)
    return Metric(east_m / step[0], north_m / step[1], along_north, skew)


def _geodesic(start: tuple[Floats, Floats], end: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Return direction in degrees and length in metres between longitudes and latitudes."""
    direction, _, length = _GEODESICS.inv(start[0], start[1], end[0], end[1])
    return np.asarray(direction), np.asarray(length)


def measure_frame(
    frame: LocalFrame, size_m: tuple[float, float], cell_m: tuple[float, float]
) -> Metric:
    """Measure the metres of a local frame over a map of ``size_m`` east and north."""
    (east, north), (unit_x, unit_y) = frame.origin, frame.metres_per_unit
    found = measure(
        frame.crs,
        (east, east + size_m[0] / unit_x),
        (north, north + size_m[1] / unit_y),
        (cell_m[0] / unit_x, cell_m[1] / unit_y),
    )
    return Metric(
        found.east_m / unit_x, found.north_m / unit_y, found.convergence_deg, found.skew_deg
    )
