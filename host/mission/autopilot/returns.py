"""Straight returns: the altitudes that keep the clearance between a mission and a destination.

An autopilot that breaks a mission off flies straight home or to a rally point. ArduPlane climbs at
once if its destination is higher, and otherwise descends evenly over the whole way. PX4 circles up
to its return height first, and keeps its height if it is higher.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.mission.autopilot.room import climb_slope
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain.surface import is_beyond, surface_below


__all__ = ["along", "lowest_m", "needed_m"]

Floats = NDArray[np.float64]

# Maximum number of points on a straight return of many, and of returns.
_MOST_POINTS, _MOST_RETURNS = 600, 400
# Points and lines beside each other to a cell for one return alone, and their maximum numbers.
_FINE, _MOST_FINE, _MOST_LINES = 24, 20_000, 20


def along(points: Sequence[RoutePoint], step_m: float) -> Floats:
    """Return places (n, 3) along a mission, metres, at most ``step_m`` apart if that is few."""
    corners = np.array([(point.x_m, point.y_m, point.z_m) for point in points])
    flown = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(corners[:, :2], axis=0).T))))
    count = min(math.ceil(flown[-1] / step_m) + 1, _MOST_RETURNS)
    at = np.unique(np.concatenate((np.linspace(0.0, flown[-1], count), flown)))
    return np.column_stack([np.interp(at, flown, column) for column in corners.T])


def needed_m(
    problem: Problem, places: Floats, to: tuple[float, float], *, climbs_first: bool = False
) -> Floats:
    """Return the minimum altitude at a destination for a straight return from each place.

    Parameters
    ----------
    places : ndarray
        (n, 3), metres in the terrain's frame and altitudes.
    climbs_first : bool
        The aircraft circles up before it returns, as with PX4, rather than on its way.

    Returns
    -------
    ndarray
        (n,) metres; infinite if no altitude will do, because the way leaves the map, meets a no-fly
        zone, or is steeper than the aircraft climbs.
    """
    if not len(places):
        return np.empty(0)
    x, y, z = (column[:, None] for column in places.T)
    away = np.hypot(to[0] - x, to[1] - y)
    is_single = len(places) == 1
    count = _points_of(problem, float(away.max()), is_single=is_single)
    share = np.linspace(0.0, 1.0, count)[None, 1:]
    way_x, way_y = x + share * (to[0] - x), y + share * (to[1] - y)
    # A unit vector across each return, times a distance beside it.
    across_x, across_y = (y - to[1]) / np.maximum(away, 1e-9), (to[0] - x) / np.maximum(away, 1e-9)
    lowest = np.maximum.reduce(
        [
            lowest_m(problem, way_x + beside_m * across_x, way_y + beside_m * across_y)
            for beside_m in _beside(problem, is_single=is_single)
        ]
    )
    highest = lowest.max(axis=1)
    if climbs_first:
        return np.asarray(highest)
    speed_m_s = problem.aircraft.cruise_speed_m_s
    lead_m = problem.aircraft.height_lag_s * (speed_m_s + math.hypot(*problem.wind))
    climbed = z + climb_slope(problem) * np.maximum(share * away - lead_m, 0.0)
    with np.errstate(invalid="ignore"):
        level = (z - (z - lowest) / share).max(axis=1)
    too_steep = (lowest > climbed).any(axis=1)
    return np.where(highest <= z[:, 0], level, np.where(too_steep, math.inf, highest))


def _beside(problem: Problem, *, is_single: bool) -> list[float]:
    """Return the distances from a return at which the surface counts, within the corridor."""
    corridor_m = 0.0 if problem.rules is None else problem.rules.corridor_m
    if not corridor_m:
        return [0.0]
    cell_m = min(problem.terrain.dx_m, problem.terrain.dy_m)
    fine = min(math.ceil(_FINE * corridor_m / cell_m), _MOST_LINES)
    lines = fine if is_single else 1
    distances: list[float] = np.linspace(-corridor_m, corridor_m, 2 * lines + 1).tolist()
    return distances


def _points_of(problem: Problem, away_m: float, *, is_single: bool) -> int:
    cell_m = min(problem.terrain.dx_m, problem.terrain.dy_m)
    to_a_cell, most = (_FINE, _MOST_FINE) if is_single else (2, _MOST_POINTS)
    return int(np.clip(math.ceil(to_a_cell * away_m / cell_m), 16, most)) + 1


def lowest_m(problem: Problem, x: Floats, y: Floats) -> Floats:
    """Return the altitude that keeps the clearance, infinite off the map and in zones."""
    shape = x.shape
    x, y = x.ravel(), y.ravel()
    clearance = np.zeros(len(x))
    if problem.rules is not None:
        clearance = np.maximum(problem.demand.required_m(x, y), 0.0)
    lowest = surface_below(problem.terrain, x, y) + clearance
    is_barred = is_beyond(problem.terrain, x, y)
    is_barred |= problem.nofly_raster[problem.terrain.nearest_nodes(x, y)]
    return np.where(is_barred, math.inf, lowest).reshape(shape)
