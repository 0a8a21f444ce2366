"""Searches for narrow or winding ways, made when the quick searches of ``astar`` find no path.

They differ from the quick ones in five respects: routes keep away from obstacles where there is
room; corners of the route, instead of evenly spaced points, may become waypoints, and more of them;
the ground under a route that breaks a limit becomes dearer, so that the next route avoids it; paths
that break limits near an end are repaired; and the nodes are finer than the terrain's cells.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Run
from pathgene.host.planners.grid.altitudes import lowest_altitudes
from pathgene.host.planners.grid.circuits import circuits
from pathgene.host.planners.grid.corners import cornered
from pathgene.host.planners.grid.fine_grid import fine_grid
from pathgene.host.planners.grid.grid_search import SearchGrid
from pathgene.host.planners.grid.polylines import (
    Leads,
    leads,
    lengthened,
    polylines,
    routed,
    with_leads,
)
from pathgene.host.planners.grid.repairs import repair
from pathgene.host.problem.problem import Problem


__all__ = ["narrow_searches"]

Floats = NDArray[np.float64]
Path = NDArray[np.float64]

# Nodes on the longer side of the fine grid, and into how many parts it may divide a cell.
_MOST_NODES, _MOST_PARTS = 480, 3
# Slopes of the surfaces, as multiples of the climb limit, and routes tried on each.
_STEEPNESS = (1.5, math.inf, 1.0)
_ROUTES = 5
# A node beside an obstacle costs this much more than one farther than two turn radii from it.
_BESIDE = 3.0
_ROOM_RADII = 2.0
# Nodes within this many turn radii of a broken limit cost this many times more.
_BROKEN_RADII, _BROKEN = 2.0, 3.0
# Numbers of turns tried, more than the fewest.
_MORE_TURNS = (0, 1, 2, 4, 8, 16)
# Numbers of turns tried where each chord meets a blocked node, and the factor of its price there.
_TURNS = (4, 6, 8, 10, 12, 14, 17, 20, 24, 32, 48)
_BLOCKED = 20.0
# Moves of the waypoints around a broken limit, in turn radii, their directions and their number.
_MOVES = (0.07, 0.2, 0.6)
_MOVE_DIRECTIONS = 8
_MOST_MOVES = 40
# Fewest waypoints of a path, where straight pieces have room for them.
_FEWEST = 32


def narrow_searches(run: Run, most: int) -> Iterator[list[tuple[float, Path]]]:
    """Search with one route after another until a path is feasible.

    Parameters
    ----------
    run : Run
        Evaluates the paths; its evaluator holds the problem.
    most : int
        Maximum number of waypoints between start and goal.

    Yields
    ------
    list of (float, ndarray)
        Fitness and path, (n, 3) float64 metres with both ends, of the paths along a route.
    """
    problem = run.evaluator.problem
    if not math.isfinite(problem.limits.turn_radius_m):
        return
    for grid, ways in _grids(problem):
        for way, steepness in itertools.product(ways, _STEEPNESS):
            for found in _routes(run, grid, steepness, most, way):
                yield found
                if max(fitness for fitness, _ in found) > 1:
                    return


def _grids(problem: Problem) -> Iterator[tuple[SearchGrid, list[Leads]]]:
    """Yield grids with the beginnings and ends of the routes over them."""
    ways = list(leads(problem))
    grid = SearchGrid(problem)
    yield _roomy(grid), ways
    finer = fine_grid(problem, _MOST_NODES, _MOST_PARTS)
    if finer.shape != grid.shape:
        yield _roomy(finer), ways
    for circuit in circuits(problem):
        grid = SearchGrid(problem, gain_m=circuit.gain_m)
        yield _roomy(grid), [(circuit.places, way[1]) for way in ways[:1]]


def _roomy(grid: SearchGrid) -> SearchGrid:
    """Make nodes beside obstacles cost more."""
    from scipy import ndimage

    room_m = _ROOM_RADII * grid.problem.limits.turn_radius_m
    # Beyond the edge of the map, there is no room either.
    blocked = np.pad(grid.blocked, 1, constant_values=True)
    away = ndimage.distance_transform_edt(~blocked, sampling=(grid.dy_m, grid.dx_m))[1:-1, 1:-1]
    grid.factors = 1.0 + _BESIDE * np.maximum(0.0, 1.0 - away / room_m)
    return grid


def _routes(
    run: Run, grid: SearchGrid, steepness: float, most: int, way: Leads
) -> Iterator[list[tuple[float, Path]]]:
    """Search with one route after another, each avoiding the places where earlier ones failed."""
    factors = grid.factors
    assert factors is not None
    most_inner = most - sum(map(len, way))
    seen: set[bytes] = set()
    dearer = np.ones(grid.shape)
    for _ in range(_ROUTES):
        if most_inner < 1:
            break
        with run.phase("search"):
            paths = _paths(grid, steepness, most_inner, way)
        if not paths:
            break
        fitness = run.fitness(paths, strict=True).tolist()
        best = paths[int(np.argmax(fitness))]
        if max(fitness) <= 1:
            for mended in _mended(run, best):
                if len(mended) - 2 <= most:
                    paths.append(mended)
                    fitness += run.fitness([mended], strict=True).tolist()
        yield list(zip(fitness, paths, strict=True))
        if max(fitness) > 1 or best.tobytes() in seen:
            break
        seen.add(best.tobytes())
        dearer = _dearer(run.evaluator, grid, best) * dearer
        grid.factors = factors * dearer
    grid.factors = factors


def _mended(run: Run, path: Path) -> Iterator[Path]:
    """Yield a path repaired at its ends, then with its waypoints moved, and both."""
    with run.phase("repair"):
        first = repair(run.evaluator, path)
    if first is not None:
        yield first
    moved = _moved(run, path)
    if moved is not path:
        yield moved
        with run.phase("repair"):
            last = repair(run.evaluator, moved)
        if last is not None:
            yield last


def _moved(run: Run, path: Path) -> Path:
    """Return a path whose waypoints beside broken limits have moved until it breaks less."""
    evaluator = run.evaluator
    if evaluator.problem.rules is None:
        return path
    angles = 2 * math.pi * np.arange(_MOVE_DIRECTIONS) / _MOVE_DIRECTIONS
    steps = evaluator.problem.limits.turn_radius_m * np.array(
        [
            (size * math.cos(angle), size * math.sin(angle), 0.0)
            for size in _MOVES
            for angle in angles
        ]
    )
    best = float(run.fitness([path], strict=True)[0])
    for _ in range(_MOST_MOVES):
        stretches = evaluator.broken(path)
        if not stretches or run.stopped_by() is not None:
            break
        track = evaluator.track(path)
        samples = track.sample(evaluator.problem.limits.turn_radius_m)
        middle = 0.5 * (stretches[0].from_m + stretches[0].to_m)
        at = int(np.abs(samples.s - middle).argmin())
        away = np.hypot(path[1:-1, 0] - samples.x[at], path[1:-1, 1] - samples.y[at])
        near = 1 + np.argsort(away)[:4]
        tried = []
        for which in (*near[:, None].tolist(), sorted(near[:2].tolist())):
            for step in steps:
                variant = path.copy()
                variant[which] += step
                tried.append(variant)
        fitness = run.fitness(tried, strict=True)
        if not fitness.max() > best:
            break
        best, path = float(fitness.max()), tried[int(fitness.argmax())]
        if best > 1:
            break
    return path


def _dearer(evaluator: Evaluator, grid: SearchGrid, path: Path) -> Floats:
    """Return factors of the nodes around the places where a path breaks a limit."""
    from scipy import ndimage

    samples = evaluator.track(path).sample(grid.problem.limits.turn_radius_m)
    if evaluator.problem.rules is None:
        at = samples.clearance <= 0
    else:
        at = np.zeros(len(samples.s), dtype=bool)
        for stretch in evaluator.broken(path):
            middle = 0.5 * (stretch.from_m + stretch.to_m)
            at |= (samples.s >= stretch.from_m) & (samples.s <= stretch.to_m)
            at[np.abs(samples.s - middle).argmin()] = True
    if not at.any():
        return np.ones(grid.shape)
    away = np.ones(grid.shape, dtype=bool)
    away[grid.nodes(samples.x[at], samples.y[at])] = False
    distance = ndimage.distance_transform_edt(away, sampling=(grid.dy_m, grid.dx_m))
    near_m = _BROKEN_RADII * grid.problem.limits.turn_radius_m
    return np.where(distance <= near_m, _BROKEN, 1.0)


def _paths(grid: SearchGrid, steepness: float, most: int, way: Leads) -> list[Path]:
    """Return paths with different numbers of turns along one route; none if there is no route."""
    problem = grid.problem
    surface, route = routed(grid, steepness, way)
    if route is None:
        return []
    points = cornered(route, 0.25 * min(grid.dx_m, grid.dy_m))
    if len(points) < 2:
        # The goal is straight above or below the start.
        return []
    lines = polylines(points, grid, surface, most)
    turns = [count for count, line in enumerate(lines) if line is not None]
    if turns:
        counts = sorted({min(turns[0] + more, most) for more in _MORE_TURNS})
    else:
        grid.blocked_factor = _BLOCKED
        lines = polylines(points, grid, surface, most)
        grid.blocked_factor = None
        counts = sorted({min(count, most) for count in _TURNS})
    found = []
    for count in counts:
        line = lines[count]
        if line is None:
            continue
        places = with_leads(problem, way, points[line])
        fewest = min(most + sum(map(len, way)), max(_FEWEST, len(places) + 4))
        places = lengthened(places, fewest, problem.limits.turn_radius_m)
        path = lowest_altitudes(problem, grid.prices, places)
        if path is not None:
            found.append(path)
    return found
