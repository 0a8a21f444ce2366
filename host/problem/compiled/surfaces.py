"""The surface below a few points, equal to :func:`pathgene.host.terrain.surface.surface_below`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.compiled.jit import compiled, inlined
from pathgene.host.terrain.grid import Terrain
from pathgene.host.terrain.surface import ANY_VOID_M, VOID_M


__all__ = ["nodes_around", "surfaces_below"]

_Floats = NDArray[np.float64]


@compiled
def _write_surfaces(
    elevation: _Floats,
    first: tuple[int, int],
    shape: tuple[int, int],
    sides_m: tuple[float, float],
    points: _Floats,
    voids: tuple[float, float, float],
    surfaces: _Floats,
) -> None:
    """Write the surface below points (2, k), of a part of the nodes that begins at ``first``.

    ``voids`` are the height of a void in sums, a height that only sums with a void exceed, and the
    surface there.
    """
    void_m, any_void_m, written_m = voids
    (south, west), (rows, columns), (dx_m, dy_m) = first, shape, sides_m
    for i in range(points.shape[1]):
        x, y = points[0, i], points[1, i]
        gx = min(max(x / dx_m, 0.0), columns - 1.0)
        gy = min(max(y / dy_m, 0.0), rows - 1.0)
        column, row = min(int(gx), columns - 2), min(int(gy), rows - 2)
        east, north = gx - column, gy - row
        j, k = row - south, column - west
        below = _between(elevation, j, k, east, void_m)
        above = _between(elevation, j + 1, k, east, void_m)
        between = (1 - north) * below + north * above
        nearest_row = int(min(max(np.floor(y / dy_m + 0.5), 0.0), rows - 1.0))
        nearest_column = int(min(max(np.floor(x / dx_m + 0.5), 0.0), columns - 1.0))
        nearest = _height(elevation[nearest_row - south, nearest_column - west], void_m)
        highest = max(between, nearest)
        surfaces[i] = written_m if highest > any_void_m else highest


@inlined
def _between(elevation: _Floats, row: int, column: int, east: float, void_m: float) -> float:
    """Return the height between two nodes of a row."""
    west = _height(elevation[row, column], void_m)
    return (1 - east) * west + east * _height(elevation[row, column + 1], void_m)


@inlined
def _height(metres: float, void_m: float) -> float:
    return void_m if math.isnan(metres) else metres


def surfaces_below(
    terrain: Terrain,
    points: _Floats,
    void_m: float,
    elevation: _Floats | None = None,
    first: tuple[int, int] = (0, 0),
) -> _Floats:
    """Return the surface below points (2, k), (k,), metres.

    Parameters
    ----------
    void_m : float
        Surface at voids.
    elevation : (rows, columns) float64, optional
        Other heights of the nodes in :func:`nodes_around` the points, or in more rows and columns.
    first : (int, int)
        First row and column of these nodes.
    """
    surfaces: _Floats = np.empty(points.shape[1])
    heights = terrain.elevation if elevation is None else np.ascontiguousarray(elevation)
    sides_m = terrain.dx_m, terrain.dy_m
    voids = VOID_M, ANY_VOID_M, void_m
    _write_surfaces(heights, first, terrain.shape, sides_m, points, voids, surfaces)
    return surfaces


def nodes_around(terrain: Terrain, points: _Floats) -> tuple[slice, slice]:
    """Return rows and columns of the nodes that determine the surface below points (2, k)."""
    rows, columns = (
        (
            min(int(min(max(low / side, 0.0), count - 1.0)), count - 2),
            min(int(min(max(high / side, 0.0), count - 1.0)), count - 2) + 2,
        )
        for low, high, side, count in zip(
            points.min(axis=1).tolist()[::-1],
            points.max(axis=1).tolist()[::-1],
            (terrain.dy_m, terrain.dx_m),
            terrain.shape,
            strict=True,
        )
    )
    return slice(*rows), slice(*columns)
