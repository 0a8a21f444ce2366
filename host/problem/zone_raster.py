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
    sides_m, first = (terrain.dx_m, terrain.dy_m), (part[0].start, part[1].start)
    # Numba, which compiles the kernels, is loaded with the first zone.
    from pathgene.host.problem.compiled.zone_cells import add_capsules, add_nodes

    capsules = []
    odd: NDArray[np.bool_] | None = None
    for zone in zones:
        if not _may_meet(zone, terrain, margin_m, part):
            continue
        pieces = zone.footprint.capsules(margin_m)
        pieces[:, 4] += _SLACK_M
        capsules.append(pieces)
        if zone.footprint.rings:
            if odd is None:
                odd = np.empty((inside.shape[0], inside.shape[1] + 1), dtype=bool)
            add_nodes(inside, np.ascontiguousarray(pieces[:, :4]), sides_m, first, odd)
    if capsules:
        add_capsules(inside, np.concatenate(capsules), sides_m, first)
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
