"""Zones by dense samples of a track and shapely, as an oracle for the strict rule."""

import numpy as np
import shapely

from pathgene.host.problem.zones import Circle


STEP_M = 0.1
_COARSE_M = 3.0


def outline(zone):
    """Return a polygonal zone as a shapely polygon."""
    return shapely.Polygon(zone.ring, zone.holes)


def distances(zone, x, y):
    """Return the horizontal distances of points (k,) to a zone without margin, 0 inside."""
    if isinstance(zone, Circle):
        return np.maximum(np.hypot(x - zone.x_m, y - zone.y_m) - zone.radius_m, 0)
    shape = outline(zone)
    shapely.prepare(shape)
    return shapely.distance(shape, shapely.points(x, y))


def fine_fractions(zone, piece, reach_m):
    """Return fractions of a piece at most ``STEP_M`` apart where it may be within ``reach_m``.

    A track of n metres comes at most n metres closer, so coarser samples rule out the rest.
    """
    parts = int(np.ceil(piece.length_m / _COARSE_M))
    coarse = np.linspace(0, 1, parts + 1)
    points = piece.points(coarse)
    gaps = distances(zone, points[:, 0], points[:, 1])
    near = np.flatnonzero(np.minimum(gaps[:-1], gaps[1:]) <= reach_m + _COARSE_M)
    fine = np.linspace(0, 1, int(np.ceil(piece.length_m / parts / STEP_M)) + 1)
    return (coarse[near, None] + fine / parts).ravel()


def enters(track, zones, margin_m, *, speed_m_s, spare_m=0.0):
    """Return whether a sample of a track is in a zone with its margin, or ``spare_m`` near it.

    ``track`` is a sequence of pieces, flown at one speed. A widened zone contains the places within
    its margin, and the heights strictly within its limits and the margin.
    """
    for zone in zones:
        low = -np.inf if zone.lower_m is None else zone.lower_m - margin_m - spare_m
        high = np.inf if zone.upper_m is None else zone.upper_m + margin_m + spare_m
        t0 = -np.inf if zone.t0_s is None else zone.t0_s
        t1 = np.inf if zone.t1_s is None else zone.t1_s
        flown = 0.0
        for piece in track:
            fractions = fine_fractions(zone, piece, margin_m + spare_m)
            x, y, z = piece.points(fractions).T
            times = (flown + fractions * piece.length_m) / speed_m_s
            flown += piece.length_m
            applies = (low < z) & (z < high) & (t0 <= times) & (times <= t1)
            if np.any(distances(zone, x[applies], y[applies]) <= margin_m + spare_m):
                return True
    return False
