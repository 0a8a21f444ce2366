"""Cells that zones meet; :mod:`pathgene.host.problem.zone_raster` explains the geometry."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.compiled.jit import compiled, inlined


__all__ = ["add_capsules", "add_nodes"]

# An edge that rises by less counts as level.
_LEVEL_M = 1e-9

_Flags = NDArray[np.bool_]
_Floats = NDArray[np.float64]


@inlined
def _clamp(value: float, low: float, high: float) -> float:
    """Return the value nearest to ``value`` between two limits."""
    return min(max(value, low), high)


@compiled
def add_nodes(
    inside: _Flags,
    borders: _Floats,
    sides_m: tuple[float, float],
    first: tuple[int, int],
    odd: _Flags,
) -> None:
    """Set the nodes inside a polygon, by the even-odd rule.

    Parameters
    ----------
    inside : (rows, columns) bool
        Nodes of a part of the grid.
    borders : (n, 4) float64
        Edges: x, y, x, y, metres.
    sides_m : (float, float)
        Sides of a cell in x and y.
    first : (int, int)
        First row and column of the part.
    odd : (rows, columns + 1) bool
        Work space.
    """
    dx_m, dy_m = sides_m
    south, west = first
    rows, columns = inside.shape
    lowest, highest = rows, 0
    for i in range(borders.shape[0]):
        low, high = _rows_between(borders, i, dy_m, south, rows)
        lowest, highest = min(lowest, low), max(highest, high)
    odd[lowest:highest] = False
    for i in range(borders.shape[0]):
        xa, ya, xb, yb = borders[i, 0], borders[i, 1], borders[i, 2], borders[i, 3]
        low, high = _rows_between(borders, i, dy_m, south, rows)
        for row in range(low, high):
            x = xa + ((row + south) * dy_m - ya) / (yb - ya) * (xb - xa)
            # Crossings to the west of the part count at its first column.
            column = math.ceil(_clamp(x / dx_m, float(west), float(west + columns)))
            odd[row, column - west] ^= True
    # A row crosses a ring an even number of times, so the counts to the west and to the east agree
    # modulo 2.
    for row in range(lowest, highest):
        is_odd = False
        for column in range(columns):
            is_odd ^= odd[row, column]
            inside[row, column] |= is_odd


@inlined
def _rows_between(borders: _Floats, i: int, dy_m: float, south: int, rows: int) -> tuple[int, int]:
    """Return the first row of the part that an edge crosses, and the one after its last."""
    low, high = min(borders[i, 1], borders[i, 3]), max(borders[i, 1], borders[i, 3])
    first, stop = float(south), float(south + rows)
    return (
        math.ceil(_clamp(low / dy_m, first, stop)) - south,
        math.ceil(_clamp(high / dy_m, first, stop)) - south,
    )


@compiled
def add_capsules(
    inside: _Flags, capsules: _Floats, sides_m: tuple[float, float], first: tuple[int, int]
) -> None:
    """Set the cells that capsules meet: rows of two ends x, y, x, y and the radius.

    See :func:`add_nodes` for the remaining parameters.
    """
    dx_m, dy_m = sides_m
    south, west = first
    rows, columns = inside.shape
    for i in range(capsules.shape[0]):
        xa, ya, xb, yb = capsules[i, 0], capsules[i, 1], capsules[i, 2], capsules[i, 3]
        radius = capsules[i, 4]
        low = (min(ya, yb) - radius) / dy_m - 0.5
        high = (max(ya, yb) + radius) / dy_m + 0.5
        lowest = math.ceil(_clamp(low, float(south), float(south + rows)))
        highest = math.floor(_clamp(high, float(south - 1), float(south + rows - 1)))
        for row in range(lowest, highest + 1):
            middle = row * dy_m
            from_m, to_m = middle - 0.5 * dy_m, middle + 0.5 * dy_m
            east_m = _easternmost(xa, ya, xb, yb, radius, from_m, to_m)
            west_m = -_easternmost(-xa, ya, -xb, yb, radius, from_m, to_m)
            left_m, right_m = west_m / dx_m - 0.5, east_m / dx_m + 0.5
            left = math.ceil(_clamp(left_m, float(west), float(west + columns)))
            right = math.floor(_clamp(right_m, float(west - 1), float(west + columns - 1)))
            for column in range(left, right + 1):
                inside[row - south, column - west] = True


@inlined
def _easternmost(
    xa: float, ya: float, xb: float, yb: float, radius: float, south: float, north: float
) -> float:
    """Return the maximum x of a capsule between two values of y that it reaches."""
    dx, dy = xb - xa, yb - ya
    # The eastern border of a convex shape is a concave function of y, with its maximum level with
    # the eastern end.
    y = _clamp(yb if dx > 0.0 else ya, south, north)
    # The circle that reaches farthest at y has its centre where the radius is perpendicular to the
    # edge, or else at the nearest end.
    if abs(dy) < _LEVEL_M:
        along = 1.0 if dx > 0.0 else 0.0
    else:
        aside = -radius * dx / math.hypot(dx, dy) * (1.0 if dy > 0.0 else -1.0)
        along = _clamp((y - ya - aside) / dy, 0.0, 1.0)
    away = y - ya - along * dy
    return xa + along * dx + math.sqrt(max(radius * radius - away * away, 0.0))
