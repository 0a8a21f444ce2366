"""The highest surface around the nodes and other places of a terrain, within a corridor."""

from __future__ import annotations

import math
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import VOID_M, surface_below


__all__ = ["Surroundings", "around"]

Floats = NDArray[np.float64]

# Places on the rim of the corridor around an end, and metres by which they may miss the highest
# surface there.
_RIM_PLACES = 3600
_RIM_SLACK_M = 1e-3
# Number of places of a terrain whose surroundings are cached.
_MOST_PLACES = 64
# Nodes whose surroundings are computed at a time, so that they fit into a processor's cache.
_BAND_NODES = 100_000


class Surroundings:
    """The highest surface around places of a terrain, cached because changed problems ask again.

    Parameters
    ----------
    corridor_m : float
        Distance within which the surface counts.
    """

    def __init__(self, corridor_m: float) -> None:
        # Without a reference to the terrain, which is the weak key of this object.
        self.corridor_m = corridor_m
        self._nodes: Floats | None = None
        self._within: dict[tuple[float, float], float] = {}

    def nodes(self, terrain: Terrain) -> Floats:
        """Return :func:`_highest_around` for all nodes, (ny, nx); do not write to it."""
        if self._nodes is None:
            rows, columns = terrain.shape
            self._nodes = np.empty((rows, columns))
            step = max(_BAND_NODES // columns, 1)
            for first in range(0, rows, step):
                band = slice(first, min(first + step, rows)), slice(0, columns)
                self._nodes[band] = _highest_around(terrain, self.corridor_m, *band)
        return self._nodes

    def highest_within(self, terrain: Terrain, x: float, y: float, enough_m: float) -> float:
        """Return the highest surface around a point, metres; infinite near a void.

        If no surface around the nearest node's square is above ``enough_m``, its highest is
        returned.
        """
        row, column = terrain.nearest_node(x, y)
        if self._nodes is None:
            # The planners may need the rasters of a part of the map only.
            place = slice(row, row + 1), slice(column, column + 1)
            nearest = float(_highest_around(terrain, self.corridor_m, *place)[0, 0])
        else:
            nearest = float(self._nodes[row, column])
        if nearest <= enough_m:
            return nearest
        if (x, y) not in self._within:
            if len(self._within) >= _MOST_PLACES:
                self._within.clear()
            self._within[x, y] = _highest_within(terrain, x, y, self.corridor_m)
        return self._within[x, y]


# The surroundings for the latest corridor of each terrain.
_AROUND: WeakKeyDictionary[Terrain, Surroundings] = WeakKeyDictionary()


def around(terrain: Terrain, corridor_m: float) -> Surroundings:
    """Return the surroundings of a terrain for a corridor, which are computed once."""
    known = _AROUND.get(terrain)
    if known is None or known.corridor_m != corridor_m:
        known = _AROUND[terrain] = Surroundings(corridor_m)
    return known


def _highest_around(terrain: Terrain, corridor_m: float, rows: slice, columns: slice) -> Floats:
    """Return the highest surface within ``corridor_m`` of nodes' squares, in both axes.

    The nodes are those in some rows and columns; nodes near a void are very high.
    """
    reach = [0.5 + corridor_m / side for side in (terrain.dy_m, terrain.dx_m)]
    # Squares of nodes this far away are touched, too.
    nodes = [math.floor(cells + 0.5) for cells in reach]
    # One more node on each side, between which and the last the rim may lie.
    wide = [
        slice(max(part.start - far - 1, 0), min(part.stop + far + 1, count))
        for part, far, count in zip((rows, columns), nodes, terrain.shape, strict=True)
    ]
    heights = terrain.elevation[wide[0], wide[1]]
    heights = np.where(np.isnan(heights), VOID_M, heights)
    highest = _spread(_spread(heights, 0, nodes[0]), 1, nodes[1])
    for axis in (0, 1):
        for side in (-1, 1):
            # Between nodes, heights are linear along each axis: the extremes lie at the rim.
            rim = _moved(heights, axis, side * reach[axis])
            other = 1 - axis
            np.maximum(highest, _spread(rim, other, math.floor(reach[other])), out=highest)
            if axis == 0:
                for sign in (-1, 1):
                    np.maximum(highest, _moved(rim, 1, sign * reach[1]), out=highest)
    return highest[
        rows.start - wide[0].start : rows.stop - wide[0].start,
        columns.start - wide[1].start : columns.stop - wide[1].start,
    ]


def _spread(raster: Floats, axis: int, nodes: int) -> Floats:
    """Return the maximum within ``nodes`` of each node along an axis; SciPy takes 0.3 s to load."""
    spread = raster.copy()
    highest = np.moveaxis(spread, axis, 0)
    nodes = min(nodes, len(highest) - 1)
    within = 0
    while within < nodes:
        # The windows around nodes this far away touch the window around the node.
        step = min(2 * within + 1, nodes - within)
        near = highest.copy()
        np.maximum(highest[step:], near[:-step], out=highest[step:])
        np.maximum(highest[:-step], near[step:], out=highest[:-step])
        np.maximum(highest[:step], near[0], out=highest[:step])
        np.maximum(highest[-step:], near[-1], out=highest[-step:])
        within += step
    return spread


def _moved(raster: Floats, axis: int, cells: float) -> Floats:
    """Return the raster shifted by ``cells`` along an axis, linear between nodes."""
    before = math.floor(cells)
    share = cells - before
    index = np.arange(raster.shape[axis])
    last = raster.shape[axis] - 1
    low = np.take(raster, np.clip(index + before, 0, last), axis=axis)
    if share == 0:
        return low
    return (1 - share) * low + share * np.take(
        raster, np.clip(index + before + 1, 0, last), axis=axis
    )


def _highest_within(terrain: Terrain, x: float, y: float, radius_m: float) -> float:
    """Return the highest surface within a distance of a point, metres; infinite near a void.

    The maximum lies at a node, on the rim, or where the rim crosses a line of nodes or of the
    squares around them. A millimetre is added because the rim is sampled.
    """
    if radius_m == 0:
        return float(surface_below(terrain, np.array([x]), np.array([y]))[0])
    angles = [np.linspace(0.0, 2 * math.pi, _RIM_PLACES, endpoint=False)]
    for at, side, shift in ((x, terrain.dx_m, 0.0), (y, terrain.dy_m, 0.5 * math.pi)):
        lines = (
            0.5
            * side
            * np.arange(
                math.ceil(2 * (at - radius_m) / side), math.floor(2 * (at + radius_m) / side) + 1
            )
        )
        turn = np.arccos(np.clip((lines - at) / radius_m, -1, 1))
        angles += [shift + turn, shift - turn]
    around = np.concatenate(angles)
    # Both sides of a border between two squares.
    rim = (radius_m + np.array([[-1e-6], [0.0], [1e-6]])) * np.stack(
        (np.cos(around), np.sin(around))
    )[:, None]
    highest = surface_below(terrain, x + rim[0].ravel(), y + rim[1].ravel()).max()
    # Nodes whose squares the circle touches.
    rows, columns = terrain.shape
    across = np.arange(columns) * terrain.dx_m
    up = np.arange(rows) * terrain.dy_m
    away_x = np.maximum(np.abs(across - x) - 0.5 * terrain.dx_m, 0.0)
    away_y = np.maximum(np.abs(up - y) - 0.5 * terrain.dy_m, 0.0)
    near_x, near_y = np.flatnonzero(away_x <= radius_m), np.flatnonzero(away_y <= radius_m)
    touched = np.hypot(away_x[None, near_x], away_y[near_y, None]) <= radius_m
    nodes = terrain.elevation[np.ix_(near_y, near_x)][touched]
    nodes = np.where(np.isnan(nodes), np.inf, nodes)
    return float(max(highest, nodes.max(initial=-np.inf))) + _RIM_SLACK_M
