"""Routes past zones through gaps that are narrower than the nodes of a grid.

Points lie around each zone, on a polygon that contains it, and in narrow gaps. Two of them are
linked where the line between them meets no blocked cell of the terrain. The cheapest routes along
these lines are those that two searches find: for each point, the cheapest way from the start and
the cheapest one to the goal.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.planners.grid.grid_search import LEAST_COST, SearchGrid
from pathgene.host.planners.grid.shortest_paths import Graph, shortest_paths
from pathgene.host.problem.footprints import Footprint
from pathgene.host.problem.problem import Problem


__all__ = ["tangent_routes"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Corners of the polygon around a zone.
_CORNERS = 12
# Its distance from the zone: in diagonals of a cell, and at least in turn radii, because turns cut
# corners.
_AWAY_CELLS, _AWAY_RADII = 0.75, 0.15
# Gaps between two zones that have a point in their middle: their width in diagonals of a cell, and
# the maximum number of pairs; points on the outline of a zone, from which gaps are measured.
_GAP_CELLS, _MOST_PAIRS, _OUTLINE_POINTS = 5.0, 500, 64
# Points along the axis of a gap, in diagonals of a cell, and projections that find its middle.
_ALONG_CELLS = (-8.0, -3.0, 0.0, 3.0, 8.0)
_PROJECTIONS = 8
# Longest routes, as a multiple of the straight line, and the maximum number of points.
_LONGEST, _MOST_POINTS = 1.2, 300
# Shortest line between two turns, in turn radii: each may turn by 28 degrees.
_SHORTEST_RADII = 0.5
# Samples of lines, in cells: few rule out most lines.
_COARSE, _FINE = 8.0, 0.5
# Maximum cost of a route as a multiple of the cheapest.
_DEAREST = 1.05


def tangent_routes(
    problem: Problem, grid: SearchGrid, surface: Floats, ends: Floats, most: int
) -> list[Floats]:
    """Return the cheapest routes along tangents of zones, the cheapest one first.

    The cost of a route is the cost of level flight on ``surface``.

    Parameters
    ----------
    grid : SearchGrid
        Prices, and the blocked cells of the terrain.
    surface : (rows, columns) float64, metres
        Altitudes of the nodes of the grid.
    ends : (2, 2) float64, metres
        First and last point of the routes.
    most : int
        Maximum number of routes.

    Returns
    -------
    list of ndarray
        Turns of each with both ends, (n, 2) float64 metres; none if there is no route.
    """
    points = _points(problem, grid, ends)
    one, other, lines = _lines(points, grid, surface)
    last = len(points) - 1
    to, before = shortest_paths(*Graph.of_pairs(one, other, lines, len(points)), 0)
    onwards, after = shortest_paths(*Graph.of_pairs(other, one, lines, len(points)), last)
    costs = to + onwards
    if not np.isfinite(costs[last]):
        return []
    routes: dict[tuple[int, ...], None] = {}
    for via in np.argsort(costs, kind="stable").tolist():
        if len(routes) == most or not costs[via] <= _DEAREST * costs[last]:
            break
        routes[(*_walk(before, via)[::-1], *_walk(after, via)[1:])] = None
    return [points[list(route)] for route in routes]


def _points(problem: Problem, grid: SearchGrid, ends: Floats) -> Floats:
    """Return points around zones between both ends, outside all zones and on the map, (n, 2)."""
    terrain = problem.terrain
    away_m = max(
        _AWAY_CELLS * math.hypot(terrain.dx_m, terrain.dy_m),
        _AWAY_RADII * problem.limits.turn_radius_m,
    )
    if problem.rules is not None:
        away_m += problem.rules.zone_margin_m
    footprints = [zone.footprint for zone in problem.zones]
    cell_m = math.hypot(terrain.dx_m, terrain.dy_m)
    around = np.concatenate((_around(footprints, away_m), _gaps(footprints, cell_m)))
    size = terrain.width_m, terrain.height_m
    around = around[((around >= 0) & (around <= size)).all(axis=1)]
    around = around[~grid.blocked_cells[terrain.nearest_nodes(*around.T)]]
    way_m = _distances(ends[:1], around)[0] + _distances(around, ends[1:])[:, 0]
    kept = np.flatnonzero(way_m <= _LONGEST * math.dist(*ends))
    kept = np.sort(kept[np.argsort(way_m[kept], kind="stable")[:_MOST_POINTS]])
    return np.concatenate((ends[:1], around[kept], ends[1:]))


def _around(footprints: Iterable[Footprint], away_m: float) -> Floats:
    """Return the corners of polygons at a distance from footprints, (n, 2) metres."""
    angle = 2 * math.pi / _CORNERS
    angles = angle * np.arange(_CORNERS)
    normals = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    along = np.stack((-normals[:, 1], normals[:, 0]), axis=1)
    polygons = [np.empty((0, 2))]
    for footprint in footprints:
        if footprint.disc is None:
            corners, radius_m = np.array(footprint.rings[0]), 0.0
        else:
            x, y, radius_m = footprint.disc
            corners = np.array([(x, y)])
        # Sides with these normals touch the footprint; a corner lies on two of them.
        sides = (corners[:, :2] @ normals.T).max(axis=0) + radius_m + away_m
        shift = (np.roll(sides, -1) - sides * math.cos(angle)) / math.sin(angle)
        polygons.append(sides[:, None] * normals + shift[:, None] * along)
    return np.concatenate(polygons)


def _gaps(footprints: Sequence[Footprint], cell_m: float) -> Floats:
    """Return points on the axes of narrow gaps between two footprints, (n, 2) metres."""
    widest_m = _GAP_CELLS * cell_m
    boxes = np.array([footprint.box for footprint in footprints]).reshape(-1, 4)
    low, high = boxes[:, :2], boxes[:, 2:]
    apart = np.maximum(low[:, None] - high, low - high[:, None]).max(axis=2, initial=-math.inf)
    one, other = np.nonzero(np.triu(apart < widest_m, 1))
    outlines = {at: _outline(footprints[at]) for at in {*one.tolist(), *other.tolist()}}
    middles = [np.empty((0, 2))]
    for pair in list(zip(one.tolist(), other.tolist(), strict=True))[:_MOST_PAIRS]:
        this, that = (outlines[at] for at in pair)
        away = _distances(this, that)
        far = that[away.min(axis=0).argmin()]
        # The points on the outlines are farther apart than the gap is wide.
        for _ in range(_PROJECTIONS):
            near = _projected(footprints[pair[0]], far)
            far = _projected(footprints[pair[1]], near)
        width_m = math.dist(near, far)
        if 0 < width_m < widest_m:
            across = (far - near) / width_m
            axis = np.array((-across[1], across[0]))
            middles.append(0.5 * (near + far) + cell_m * np.outer(_ALONG_CELLS, axis))
    return np.concatenate(middles)


def _projected(footprint: Footprint, point: Floats) -> Floats:
    """Return the point on the outline of a footprint that is nearest to ``point``, (2,) metres."""
    if footprint.disc is not None:
        middle = np.array(footprint.disc[:2])
        away_m = max(math.dist(middle, point), LEAST_COST)
        on_circle: Floats = middle + footprint.disc[2] / away_m * (point - middle)
        return on_circle
    start = np.array(footprint.rings[0])[:, :2]
    edge = np.roll(start, -1, axis=0) - start
    length = np.maximum((edge**2).sum(axis=1), LEAST_COST)
    share = np.clip(((point - start) * edge).sum(axis=1) / length, 0, 1)
    on_edges = start + share[:, None] * edge
    nearest: Floats = on_edges[((on_edges - point) ** 2).sum(axis=1).argmin()]
    return nearest


def _outline(footprint: Footprint) -> Floats:
    """Return points on the outline of a footprint, (n, 2) metres."""
    ring = np.array(footprint.outline(_OUTLINE_POINTS)[0])[:, :2]
    shares = np.arange(max(_OUTLINE_POINTS // len(ring), 1))[:, None, None]
    along = shares / len(shares)
    return np.concatenate(ring + along * (np.roll(ring, -1, axis=0) - ring))


def _lines(points: Floats, grid: SearchGrid, surface: Floats) -> tuple[Integers, Integers, Floats]:
    """Return the free lines from points to points: both ends of each, and its cost."""
    count = len(points)
    terrain = grid.problem.terrain
    cell_m = min(terrain.dx_m, terrain.dy_m)
    runs = _distances(points, points)
    shortest = np.full((count, count), _SHORTEST_RADII * grid.problem.limits.turn_radius_m)
    shortest[[0, -1]] = shortest[:, [0, -1]] = 0.0
    ways = runs[0][:, None] + runs + runs[-1]
    one, other = np.nonzero((runs > shortest) & (ways <= _LONGEST * runs[0, -1]))
    for cells in (_COARSE, _FINE):
        at, line = _samples(points[one], points[other], cells * cell_m)
        is_free = np.ones(len(one), dtype=bool)
        is_free[line[grid.blocked_cells[terrain.nearest_nodes(*at.T)]]] = False
        one, other = one[is_free], other[is_free]
    at, line = _samples(points[one], points[other], min(grid.dx_m, grid.dy_m))
    # Blocked nodes have free cells.
    price = grid.level_price_per_m(surface)
    sums = np.bincount(line, weights=price[grid.nodes(*at.T)], minlength=len(one))
    means = sums / np.bincount(line, minlength=len(one))
    costs = np.maximum(means * runs[one, other], LEAST_COST)
    return one, other, costs


def _samples(start: Floats, stop: Floats, step_m: float) -> tuple[Floats, Integers]:
    """Return points on lines, (n, 2) metres, and the number of the line of each."""
    runs = np.hypot(*(stop - start).T)
    parts = np.maximum(np.ceil(runs / step_m), 1).astype(np.int64)
    line = np.repeat(np.arange(len(runs)), parts)
    share = (np.arange(len(line)) - (np.cumsum(parts) - parts)[line] + 0.5) / parts[line]
    return start[line] + (stop - start)[line] * share[:, None], line


def _distances(one: Floats, other: Floats) -> Floats:
    """Return the distance of each point of one array from each of another, (n, m)."""
    distances: Floats = np.hypot(*(one[:, None] - other[None]).transpose(2, 0, 1))
    return distances


def _walk(before: NDArray[np.int32], point: int) -> list[int]:
    points = [point]
    while before[points[-1]] >= 0:
        points.append(int(before[points[-1]]))
    return points
