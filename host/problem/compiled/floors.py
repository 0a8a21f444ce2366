"""The floor of the search near start and goal; see :mod:`pathgene.host.problem.surface`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.compiled.jit import compiled, inlined


__all__ = ["EndDemand", "NearEnd", "ease_near_end", "require_near_end", "without_voids"]

_Floats = NDArray[np.float64]


class EndDemand(NamedTuple):
    """The clearance that an end excuses, at its own place and growing with the distance.

    Parameters
    ----------
    x_m, y_m, altitude_m : float
        The end.
    height_m, beside_m : float
        Clearance at the end over the surface below, and over the highest surface in the corridor.
    slope : float
        Growth with the distance.
    """

    x_m: float
    y_m: float
    altitude_m: float
    height_m: float
    beside_m: float
    slope: float


class NearEnd(NamedTuple):
    """Nodes of a part of the grid near an end.

    Parameters
    ----------
    first_row, stop_row, first_column, stop_column : int
        The nodes, counted in the whole grid.
    south, west : int
        First row and column of the part.
    dx_m, dy_m : float
        Sides of a cell.
    clearance_m : float
        Clearance of the rule.
    half_diagonal_m : float
        Half the diagonal of a cell.
    void_m, any_void_m : float
        Height of a void in sums, and a height that only sums with a void exceed.
    """

    first_row: int
    stop_row: int
    first_column: int
    stop_column: int
    south: int
    west: int
    dx_m: float
    dy_m: float
    clearance_m: float
    half_diagonal_m: float
    void_m: float
    any_void_m: float


@inlined
def _away_m(end: EndDemand, x: float, y: float, nearer_m: float) -> float:
    """Return the distance of a point from an end, as if it were nearer, but not below 0."""
    return max(math.hypot(x - end.x_m, y - end.y_m) - nearer_m, 0.0)


@compiled
def require_near_end(
    floor: _Floats, highest: _Floats, near: NearEnd, start: EndDemand, goal: EndDemand
) -> None:
    """Write the floor of the nodes near an end, above the ``highest`` surface, both of the part."""
    for row in range(near.first_row, near.stop_row):
        y = row * near.dy_m
        for column in range(near.first_column, near.stop_column):
            x = column * near.dx_m
            required = near.clearance_m
            away = _away_m(start, x, y, -near.half_diagonal_m)
            required = min(required, start.beside_m + start.slope * away)
            away = _away_m(goal, x, y, -near.half_diagonal_m)
            required = min(required, goal.beside_m + goal.slope * away)
            i, j = row - near.south, column - near.west
            floor[i, j] = highest[i, j] + required


@compiled
def ease_near_end(
    floor: _Floats,
    elevation: _Floats,
    near: NearEnd,
    ends: tuple[EndDemand, EndDemand],
    number: int,
    ramp: tuple[float, float, float, float],
) -> None:
    """Lower the floor around an end to the climb that the aircraft can fly from there.

    Parameters
    ----------
    floor : (rows, columns) float64
        Floor of the part.
    elevation : (ny, nx) float64
        The whole terrain, NaN at voids.
    number : int
        Index of the end: 0 or 1.
    ramp : (float, float, float, float)
        Distance within which the floor is lowered; the same next to a void; slope of the climb;
        altitude of the nodes at the end itself.
    """
    end = ends[number]
    near_m, near_void_m, steepest, top_m = ramp
    for row in range(near.first_row, near.stop_row):
        y = row * near.dy_m
        for column in range(near.first_column, near.stop_column):
            x = column * near.dx_m
            away = _away_m(end, x, y, near.half_diagonal_m)
            if away > near_m:
                continue
            i, j = row - near.south, column - near.west
            there = floor[i, j]
            # Nodes near a void are not lowered, unless the end itself is next to the void.
            if not (there < near.any_void_m or away <= near_void_m):
                continue
            required = near.clearance_m
            for each in ends:
                nearer = _away_m(each, x, y, near.half_diagonal_m)
                required = min(required, each.height_m + each.slope * nearer)
            ground = elevation[row, column]
            least = (near.void_m if math.isnan(ground) else ground) + required
            eased = max(least, min(there, end.altitude_m + steepest * away))
            floor[i, j] = min(eased, top_m) if away == 0.0 else eased


@compiled
def without_voids(floor: _Floats, any_void_m: float) -> None:
    """Write NaN to nodes with a void."""
    for i in range(floor.shape[0]):
        for j in range(floor.shape[1]):
            if floor[i, j] > any_void_m:
                floor[i, j] = math.nan
