"""The surface that paths must clear: the higher of nearest node and interpolation.

The compiled form for a single point is
:func:`pathgene.host.evaluation.terrain_rule.surface_at`, and for a few points
:func:`pathgene.host.problem.compiled.surfaces.surfaces_below`; all give the same numbers, bit for
bit.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.terrain.grid import Terrain


__all__ = ["ANY_VOID_M", "VOID_M", "is_beyond", "surface_below"]

Floats = NDArray[np.float64]

#: Height of a void in weighted sums, where an infinite height would give NaN.
VOID_M = 1e300
#: Greater than any height, and less than any sum that includes the height of a void.
ANY_VOID_M = 1e200
# Coordinates are rounded, so the edge of the map is this wide, metres.
_EDGE_M = 1e-6


def surface_below(
    terrain: Terrain,
    x: Floats,
    y: Floats,
    *,
    void_m: float = math.inf,
) -> Floats:
    """Return the surface below points (k,) of the frame, metres.

    Outside the map, the nearest point of its edge is used; see :func:`is_beyond`. If the nearest
    node, or one of the four nodes with a nonzero weight, is a void, the surface is ``void_m``:
    infinite for a rule that must reject voids, NaN for a figure that is unknown there.
    """
    rows, columns = terrain.shape
    gx = np.clip(x / terrain.dx_m, 0, columns - 1)
    gy = np.clip(y / terrain.dy_m, 0, rows - 1)
    column = np.minimum(gx.astype(np.intp), columns - 2)
    row = np.minimum(gy.astype(np.intp), rows - 2)

    def height(row: NDArray[np.integer], column: NDArray[np.integer]) -> Floats:
        heights: Floats = terrain.elevation[row, column]
        return np.where(np.isnan(heights), VOID_M, heights)

    east, north = gx - column, gy - row
    below = (1 - east) * height(row, column) + east * height(row, column + 1)
    above = (1 - east) * height(row + 1, column) + east * height(row + 1, column + 1)
    between = (1 - north) * below + north * above
    highest = np.maximum(between, height(*terrain.nearest_nodes(x, y)))
    return np.where(highest > ANY_VOID_M, void_m, highest)


def is_beyond(terrain: Terrain, x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Return which points lie beyond the edge of the map, where the surface is unknown."""
    return (
        (x < -_EDGE_M)
        | (x > terrain.width_m + _EDGE_M)
        | (y < -_EDGE_M)
        | (y > terrain.height_m + _EDGE_M)
    )
