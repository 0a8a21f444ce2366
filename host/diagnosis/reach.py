"""Places that an aircraft reaches by climbing along the routes from a point, compiled."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from pathgene.host.evaluation.jit import allocating


__all__ = ["Reach", "has_room"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Subdivisions of a cell's side, to measure the room in small places.
_PARTS = 4
_MOST_PARTS = 4_000_000


@allocating
def _spread(
    heights: Floats,
    dx: float,
    dy: float,
    source_row: int,
    source_column: int,
    altitude: float,
    slope: float,
    flown: Floats,
    before: NDArray[np.int64],
) -> None:
    """Write the shortest distance to each node that is reached, and its predecessor.

    A node is entered only if the altitude there, ``altitude`` plus ``slope`` times the distance, is
    at least its height.
    """
    rows, columns = heights.shape
    flown[source_row, source_column] = 0.0
    heap = [(0.0, np.int64(source_row * columns + source_column))]
    diagonal = math.sqrt(dx * dx + dy * dy)
    while len(heap) > 0:
        distance, node = heapq.heappop(heap)
        row, column = node // columns, node % columns
        if distance > flown[row, column]:
            continue
        for up in range(-1, 2):
            for east in range(-1, 2):
                if up == 0 and east == 0:
                    continue
                r, c = row + up, column + east
                if r < 0 or r >= rows or c < 0 or c >= columns:
                    continue
                step = dx if up == 0 else dy if east == 0 else diagonal
                there = distance + step
                if there < flown[r, c] and heights[r, c] <= altitude + slope * there:
                    flown[r, c] = there
                    before[r, c] = node
                    heapq.heappush(heap, (there, np.int64(r * columns + c)))


@dataclass(frozen=True)
class Reach:
    """Nodes reached from a point along the shortest routes that the climb limit allows.

    Parameters
    ----------
    flown_m : (ny, nx) float64
        Horizontal distance to each node, infinite if it is not reached.
    before : (ny, nx) int64
        Flat index of the previous node.
    """

    flown_m: Floats
    before: NDArray[np.int64]

    @staticmethod
    def of(
        heights: Floats,
        sides: tuple[float, float],
        node: tuple[int, int],
        altitude_m: float,
        slope: float,
    ) -> Reach:
        """Spread from a point over a raster.

        Parameters
        ----------
        heights : (ny, nx) float64
            Minimum altitude at each node, infinite where it is blocked.
        sides : (float, float)
            Metres between nodes, east and north.
        altitude_m : float
            Its altitude.
        slope : float
            Tangent of the steepest climb.
        """
        flown = np.full(heights.shape, np.inf)
        before = np.full(heights.shape, -1, dtype=np.int64)
        _spread(heights, *sides, *node, altitude_m, slope, flown, before)
        return Reach(flown, before)

    @property
    def nodes(self) -> Flags:
        """Nodes that are reached."""
        return np.isfinite(self.flown_m)

    def way(self, node: tuple[int, int]) -> NDArray[np.int64]:
        """Return the rows and columns of the route to a reached node, (n, 2)."""
        columns = self.before.shape[1]
        at = node[0] * columns + node[1]
        way = [at]
        while (at := int(self.before.flat[at])) >= 0:
            way.append(at)
        return np.stack(np.divmod(np.array(way[::-1]), columns), axis=1)


def has_room(nodes: Flags, sides: tuple[float, float], radius_m: float) -> bool:
    """Return whether a circle may fit into the squares of ``nodes`` and the holes between them.

    If no circle fits, a track without tighter turns cannot close a loop there: a loop encloses a
    circle of its tightest turn.
    """
    if not np.isfinite(radius_m):
        return False
    rows, columns = np.nonzero(nodes)
    filled = ndimage.binary_fill_holes(
        nodes[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    )
    dx, dy = sides
    if filled.size * _PARTS**2 > _MOST_PARTS:
        return True
    fine = np.pad(np.kron(filled, np.ones((_PARTS, _PARTS), dtype=bool)), 1)
    dx, dy = dx / _PARTS, dy / _PARTS
    deepest = float(ndimage.distance_transform_edt(fine, sampling=(dy, dx)).max())
    return deepest + 0.5 * math.hypot(dx, dy) - 0.5 * min(dx, dy) >= radius_m
