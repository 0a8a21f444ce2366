"""Cells and corners of a part of a chip's map; see :mod:`pathgene.host.problem.corner_map`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.compiled.jit import compiled


__all__ = [
    "cell_heights",
    "corners_of_cells",
    "draw",
    "extent",
    "least_values",
    "lower_corners",
    "mark_beside",
]

_Flags = NDArray[np.bool_]
_Floats = NDArray[np.float64]
_Indices = NDArray[np.int64]
_Steps = NDArray[np.uint16]


@compiled
def cell_heights(
    elevation: _Floats,
    is_blocked: _Flags,
    first_nodes: tuple[_Indices, _Indices],
    scale: tuple[float, float, int],
    heights: _Steps,
) -> None:
    """Write the step at or above the highest node of each cell that has nodes.

    Parameters
    ----------
    elevation, is_blocked : (rows, columns)
        Altitude of the nodes, metres, and whether they are blocked.
    first_nodes : ((m + 1,), (n + 1,)) int64
        First node of each row and of each column of cells, and the end.
    scale : (float, float, int)
        Altitude of step 0, height of a step, and the step of a blocked cell.
    heights : (m or more, n or more) uint16
        The result; further rows and columns are not written.
    """
    by_row, by_column = first_nodes
    base_m, step_m, blocked = scale
    for v in range(len(by_row) - 1):
        for u in range(len(by_column) - 1):
            highest = -math.inf
            for row in range(by_row[v], by_row[v + 1]):
                for column in range(by_column[u], by_column[u + 1]):
                    if is_blocked[row, column]:
                        steps = float(blocked)
                    else:
                        metres = elevation[row, column]
                        steps = np.ceil((metres - base_m) / step_m)
                        # The difference may have been rounded down to a step below the ground.
                        if base_m + steps * step_m < metres:
                            steps += 1.0
                    highest = max(highest, steps)
            heights[v, u] = np.int64(highest)


@compiled
def corners_of_cells(cells: _Steps, corners: _Steps) -> None:
    """Write the highest of the four cells around each corner that has four."""
    for v in range(cells.shape[0] - 1):
        for u in range(cells.shape[1] - 1):
            corners[v, u] = max(
                max(cells[v, u], cells[v, u + 1]), max(cells[v + 1, u], cells[v + 1, u + 1])
            )


@compiled
def lower_corners(
    corners: _Steps,
    cells: _Steps,
    box: tuple[int, int, int, int],
    end: tuple[int, int, int],
    share: float,
    blocked: int,
) -> None:
    """Lower corners around an end; see :class:`pathgene.host.problem.corner_map.Ease`.

    Parameters
    ----------
    corners, cells : uint16
        The same part of the map, with one more row and column of cells.
    box : (int, int, int, int)
        First row, row after the last, and the same of the columns, counted in the part.
    end : (int, int, int)
        Column and row of the end's corner, counted in the part, and its step.
    """
    x, y, altitude = end
    for v in range(box[0], box[1]):
        for u in range(box[2], box[3]):
            total = highest = np.int64(0)
            for row in range(v, v + 2):
                for column in range(u, u + 2):
                    cell = np.int64(cells[row, column])
                    total += cell
                    highest = max(highest, cell)
            if highest == blocked:
                continue
            top = np.int64(altitude)
            if u != x or v != y:
                mean = total / 4.0
                top = max(top, np.int64(math.ceil(mean + share * (highest - mean))))
            corners[v, u] = min(np.int64(corners[v, u]), top)


@compiled
def mark_beside(blocked: _Flags, first_nodes: tuple[_Indices, _Indices], corners: _Flags) -> None:
    """Set the corners around which a cell has a blocked node; see :func:`cell_heights`."""
    by_row, by_column = first_nodes
    rows, columns = corners.shape
    for v in range(len(by_row) - 1):
        for row in range(by_row[v], by_row[v + 1]):
            for u in range(len(by_column) - 1):
                for column in range(by_column[u], by_column[u + 1]):
                    if not blocked[row, column]:
                        continue
                    for j in range(max(v - 1, 0), min(v + 1, rows, len(by_row) - 2)):
                        for i in range(max(u - 1, 0), min(u + 1, columns, len(by_column) - 2)):
                            corners[j, i] = True


@compiled
def extent(inside: _Flags) -> tuple[int, int, int, int]:
    """Return first and last column and row of the set flags; the first are greater for none."""
    rows, columns = inside.shape
    first_x, first_y, last_x, last_y = columns, rows, -1, -1
    for y in range(rows):
        for x in range(columns):
            if inside[y, x]:
                first_x, last_x = min(first_x, x), max(last_x, x)
                first_y, last_y = min(first_y, y), max(last_y, y)
    return first_x, first_y, last_x, last_y


@compiled
def least_values(
    inside: _Flags,
    first: tuple[int, int],
    falls: _Indices,
    bend: tuple[int, int],
    least: _Indices,
) -> None:
    """Write the least value of each edge of a shape among the set flags.

    Parameters
    ----------
    first : (int, int)
        Column and row that the places of the shape count from.
    falls : (n, 2) int64
        Increase of an edge's value per column and row.
    bend : (int, int)
        Decrease with the squares of both.
    least : (n,) int64
        The result; on entry, values that are at least as great.
    """
    for y in range(inside.shape[0]):
        for x in range(inside.shape[1]):
            if inside[y, x]:
                u, v = x - first[0], y - first[1]
                bent = u * u * bend[0] + v * v * bend[1]
                for i in range(len(least)):
                    value = u * falls[i, 0] + v * falls[i, 1] - bent
                    least[i] = min(least[i], value)


@compiled
def draw(edges: _Indices, bend: tuple[int, int], drawn: _Flags) -> None:
    """Set the corners of a box that lie in a shape.

    Parameters
    ----------
    edges : (n, 3) int64
        Value at the first corner, and its increase per column and row. A corner is in the shape if
        no value is negative there.
    bend : (int, int)
        Decrease of the first edge's value with the squares of column and row.
    drawn : (rows, columns) bool
        The result.
    """
    for v in range(drawn.shape[0]):
        for u in range(drawn.shape[1]):
            is_drawn = True
            for i in range(len(edges)):
                value = edges[i, 0] + edges[i, 1] * u + edges[i, 2] * v
                if i == 0:
                    value -= bend[0] * u * u + bend[1] * v * v
                is_drawn &= value >= 0
            drawn[v, u] = is_drawn
