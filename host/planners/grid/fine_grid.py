"""Search grids as fine as the terrain or finer, for narrow gaps and better routes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.planners.grid.grid_search import SearchGrid
from pathgene.host.problem.finer import divided, on_grid
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


__all__ = ["covered_cells", "fine_grid"]

# Maximum corners of a zone whose distance from nodes is computed, edge by edge.
_MOST_ZONE_CORNERS = 64


def fine_grid(
    problem: Problem, most_nodes: int, most_parts: int = 1, margin_m: float = 0.0
) -> SearchGrid:
    """Return a grid of small nodes, of which zones block only those whose middle they reach.

    Elsewhere a zone blocks all cells that it touches, which closes narrow gaps. Zones with limits
    or many corners still do.

    Parameters
    ----------
    most_nodes : int
        Maximum number of nodes on the longer side.
    most_parts : int
        Number of parts into which the side of a cell may be divided.
    margin_m : float
        Distance of routes from blocked nodes.
    """
    parts = min(most_parts, max(most_nodes // max(problem.terrain.shape), 1))
    terrain = problem.terrain if parts == 1 else divided(problem.terrain, parts)
    if problem.rules is None:
        return SearchGrid(on_grid(problem, terrain), margin_m, most_nodes=most_nodes)
    plain = _plain(problem)
    others = tuple(zone for zone in problem.zones if not _is_plain(zone))
    return SearchGrid(
        on_grid(problem, terrain, others),
        margin_m,
        most_nodes=most_nodes,
        blocked=_reached(terrain, plain, problem.rules.zone_margin_m),
    )


def covered_cells(problem: Problem) -> NDArray[np.bool_]:
    """Return the cells of the terrain whose middle a zone covers, (ny, nx).

    Zones with limits or many corners do not count.
    """
    return _reached(problem.terrain, _plain(problem), 0.0)


def _plain(problem: Problem) -> list[Zone]:
    return [zone for zone in problem.zones if _is_plain(zone)]


def _is_plain(zone: Zone) -> bool:
    limits = zone.lower_m, zone.upper_m, zone.t0_s, zone.t1_s, zone.lower_agl_m, zone.upper_agl_m
    corners = sum(map(len, zone.footprint.rings))
    return all(limit is None for limit in limits) and corners <= _MOST_ZONE_CORNERS


def _reached(terrain: Terrain, zones: Sequence[Zone], margin_m: float) -> NDArray[np.bool_]:
    """Return the nodes of the terrain that lie within ``margin_m`` of a zone, (ny, nx)."""
    reached = np.zeros(terrain.shape, dtype=bool)
    sides = np.array((terrain.dx_m, terrain.dy_m))
    for zone in zones:
        box = np.array(zone.footprint.box).reshape(2, 2) + np.array(((-margin_m,), (margin_m,)))
        low, high = np.clip(
            np.stack((np.ceil(box[0] / sides), np.floor(box[1] / sides) + 1)).astype(int),
            0,
            terrain.shape[::-1],
        )
        if (high <= low).any():
            continue
        x, y = np.meshgrid(
            *(
                np.arange(one, other) * side
                for one, other, side in zip(low, high, sides, strict=True)
            )
        )
        near = zone.footprint.distance_m(x.ravel(), y.ravel()) <= margin_m
        reached[low[1] : high[1], low[0] : high[0]] |= near.reshape(x.shape)
    return reached
