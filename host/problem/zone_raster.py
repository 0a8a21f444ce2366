"""The conservative raster of zones for the search: every cell that meets a zone or its margin.

The cell of a node is the closed rectangle of one cell's size around it. A path that stays in cells
that are not blocked cannot meet a zone, however small or thin.

A zone with its margin is the zone and, around each edge, all places within the margin: a capsule,
which is convex. In a row of cells, the capsule's part within the row is convex too, so it meets the
cells from its westernmost to its easternmost place only, and both places have a closed form. A cell
that meets no edge's capsule is entirely inside or outside, like its node.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.rings import EDGE_M
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


__all__ = ["Part", "blocked_cells"]

# Wider than the strict rule's micrometre, so that a free cell contains no place that the rule
# rejects.
_SLACK_M = 2 * EDGE_M
# An edge that rises by less counts as level.
_LEVEL_M = 1e-9

_Floats = NDArray[np.float64]
#: Rows and columns of a raster, each with a start and a stop.
Part = tuple[slice, slice]


def blocked_cells(
    zones: Iterable[Zone], terrain: Terrain, margin_m: float, part: Part | None = None
) -> NDArray[np.bool_]:
    """Return the nodes of ``terrain`` whose cells meet a zone, (ny, nx) bool, row 0 the south.

    Parameters
    ----------
    zones : iterable of Zone
        Zones; their heights and times are ignored.
    terrain : Terrain
        The grid.
    margin_m : float
        Distance by which a zone is widened, 0 or more.
    part : (slice, slice), optional
        Rows and columns to return; all by default.
    """
    rows, columns = terrain.shape
    part = (slice(0, rows), slice(0, columns)) if part is None else part
    inside = np.zeros([max(places.stop - places.start, 0) for places in part], dtype=bool)
    if not inside.size:
        return inside
    capsules = []
    for zone in zones:
        if not _may_meet(zone, terrain, margin_m, part):
            continue
        pieces = zone.footprint.capsules(margin_m)
        pieces[:, 4] += _SLACK_M
        capsules.append(pieces)
        if zone.footprint.rings:
            _add_nodes(inside, pieces[:, :4], terrain, part)
    if capsules:
        _add_capsules(inside, np.concatenate(capsules), terrain, part)
    return inside


def _may_meet(zone: Zone, terrain: Terrain, margin_m: float, part: Part) -> bool:
    """Return whether the box of a zone with its margin is within a cell of a part of the grid."""
    west, south, east, north = zone.footprint.box
    reach_m = margin_m + _SLACK_M
    return all(
        low - reach_m <= (places.stop + 1) * side and (places.start - 1) * side <= high + reach_m
        for low, high, places, side in (
            (south, north, part[0], terrain.dy_m),
            (west, east, part[1], terrain.dx_m),
        )
    )


def _spread(first: _Floats, last: _Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return an entry (item, row) for every row from ``first`` to ``last`` of each item."""
    counts = np.maximum(last - first + 1, 0).astype(np.intp)
    item = np.repeat(np.arange(len(counts)), counts)
    row = np.arange(len(item)) - np.repeat(np.cumsum(counts) - counts, counts)
    return item, row + first.astype(np.intp)[item]


def _add_nodes(inside: NDArray[np.bool_], borders: _Floats, terrain: Terrain, part: Part) -> None:
    """Set the nodes inside a polygon, by the even-odd rule; ``borders`` are x, y, x, y of edges."""
    rows, columns = part
    low, high = np.minimum(borders[:, 1], borders[:, 3]), np.maximum(borders[:, 1], borders[:, 3])
    edge, row = _spread(
        np.ceil(np.clip(low / terrain.dy_m, rows.start, rows.stop)),
        np.ceil(np.clip(high / terrain.dy_m, rows.start, rows.stop)) - 1,
    )
    if not len(row):
        return
    xa, ya, xb, yb = borders[edge].T
    x = xa + (row * terrain.dy_m - ya) / (yb - ya) * (xb - xa)
    # Crossings to the west of the part count at its first column.
    column = np.ceil(np.clip(x / terrain.dx_m, columns.start, columns.stop)).astype(np.intp)
    south, north = int(row.min()), int(row.max()) + 1
    crossings = np.zeros((north - south, columns.stop - columns.start + 1), dtype=np.int32)
    np.add.at(crossings, (row - south, column - columns.start), 1)
    # A row crosses a ring an even number of times, so the counts to the west and to the east agree
    # modulo 2.
    is_odd = np.cumsum(crossings, axis=1, dtype=np.int32)[:, :-1] % 2 == 1
    inside[south - rows.start : north - rows.start] |= is_odd


def _add_capsules(
    inside: NDArray[np.bool_], capsules: _Floats, terrain: Terrain, part: Part
) -> None:
    """Set the cells that capsules meet: rows of two ends x, y, x, y and the radius."""
    rows, columns = part
    low, high = (
        np.minimum(capsules[:, 1], capsules[:, 3]),
        np.maximum(capsules[:, 1], capsules[:, 3]),
    )
    which, row = _spread(
        np.ceil(np.clip((low - capsules[:, 4]) / terrain.dy_m - 0.5, rows.start, rows.stop)),
        np.floor(
            np.clip((high + capsules[:, 4]) / terrain.dy_m + 0.5, rows.start - 1, rows.stop - 1)
        ),
    )
    middle: _Floats = row * np.float64(terrain.dy_m)
    south, north = middle - 0.5 * terrain.dy_m, middle + 0.5 * terrain.dy_m
    xa, ya, xb, yb, radius = capsules[which].T
    east = _easternmost(xa, ya, xb, yb, radius, south, north)
    west = -_easternmost(-xa, ya, -xb, yb, radius, south, north)
    left = np.ceil(np.clip(west / terrain.dx_m - 0.5, columns.start, columns.stop))
    right = np.floor(np.clip(east / terrain.dx_m + 0.5, columns.start - 1, columns.stop - 1))
    met = left <= right
    if not met.any():
        return
    row = row[met] - rows.start
    left, right = ((each[met] - columns.start).astype(np.intp) for each in (left, right))
    # Zones are usually small.
    south_row, north_row = int(row.min()), int(row.max()) + 1
    west_column, east_column = int(left.min()), int(right.max()) + 1
    changes = np.zeros((north_row - south_row, east_column - west_column + 1), dtype=np.int32)
    np.add.at(changes, (row - south_row, left - west_column), 1)
    np.add.at(changes, (row - south_row, right + 1 - west_column), -1)
    met_there = np.cumsum(changes, axis=1, dtype=np.int32)[:, :-1] > 0
    inside[south_row:north_row, west_column:east_column] |= met_there


def _easternmost(
    xa: _Floats,
    ya: _Floats,
    xb: _Floats,
    yb: _Floats,
    radius: _Floats,
    south: _Floats,
    north: _Floats,
) -> _Floats:
    """Return the maximum x of capsules between two values of y that they reach."""
    dx, dy = xb - xa, yb - ya
    # The eastern border of a convex shape is a concave function of y, with its maximum level with
    # the eastern end.
    y = np.clip(np.where(dx > 0, yb, ya), south, north)
    # The circle that reaches farthest at y has its centre where the radius is perpendicular to the
    # edge, or else at the nearest end.
    level = np.abs(dy) < _LEVEL_M
    rise = np.where(level, 1.0, dy)
    aside = -radius * dx / np.hypot(dx, rise) * np.sign(rise)
    along = np.where(level, dx > 0, np.clip((y - ya - aside) / rise, 0, 1))
    away = y - ya - along * dy
    east: _Floats = xa + along * dx + np.sqrt(np.maximum(radius * radius - away * away, 0))
    return east
