"""The last part of a plan: turns of the best path moved at random, each time with new altitudes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.planners.base import Run
from pathgene.host.planners.grid.altitudes import lowest_altitudes
from pathgene.host.planners.grid.astar import DEFAULT_MAX_WAYPOINTS
from pathgene.host.planners.grid.fine_grid import covered_cells
from pathgene.host.planners.grid.grid_search import Prices
from pathgene.host.planners.grid.polylines import lengthened
from pathgene.host.stages import stage
from pathgene.host.terrain import Terrain


__all__ = ["TRIALS", "refined"]

Floats = NDArray[np.float64]
Path = NDArray[np.float64]

#: Number of paths tried. Each takes about 8 ms of a processor.
TRIALS = 80
# Standard deviation of a move, as a share of the distance from start to goal, and its scales.
_MOVE = 0.05
_SCALES = (1.0, 0.5, 0.25, 0.1, 0.03)
# Shares of the trials that add a turn or remove one.
_ADDED, _REMOVED = 0.15, 0.1
# Moves drawn for a trial, at most: the first that crosses no more of the zones is tried.
_DRAWS = 10
# Waypoints that turn less lie on a straight piece.
_LEAST_TURN_RAD = 1e-3


def refined(run: Run, path: Path, fitness: float) -> list[Path]:
    """Return better and better copies of a feasible path, each with a turn moved; maybe none.

    A trial moves a turn of the best known path, adds one at the middle of a segment, or removes
    one; more waypoints on the straight pieces and the lowest altitudes follow, as in the searches
    of ``astar``. A move that crosses more of the zones than the best path, or leaves the map, is
    drawn again. Next to an end with a heading, the turn stays where it is. The seed of the plan
    determines all trials. They end early with a stop criterion. Their time is the phase
    ``refinement``, apart from the evaluation.

    Parameters
    ----------
    run : Run
        Evaluates the trials, which become candidates of the plan.
    path : (n, 3) float64, metres
        Start and goal included.
    fitness : float
        Its fitness.
    """
    problem = run.evaluator.problem
    rng, prices = np.random.default_rng(run.options.seed), Prices(problem)
    radius_m = problem.limits.turn_radius_m
    move_m = _MOVE * math.dist(problem.start[:2], problem.goal[:2])
    turns = _turns(path[:, :2])
    found: list[Path] = []
    # The first turn after a heading lies straight ahead.
    after, before = (int(heading is not None) for heading in problem.headings)
    if len(turns) - after - before < 2:
        return []
    terrain, covered = problem.terrain, covered_cells(problem)
    crossed = _crossed(terrain, covered, turns)
    for trial_number in range(TRIALS):
        if run.stopped_by() not in (None, "generations") or run.out_of_time:
            break
        span = slice(after, len(turns) - before)
        stage("refining the route", trial_number / TRIALS)
        with run.phase("refinement"):
            for _ in range(_DRAWS):
                moved = _moved(rng, turns, move_m * float(rng.choice(_SCALES)), span)
                if _crossed(terrain, covered, moved) <= crossed:
                    break
            places = lengthened(moved, DEFAULT_MAX_WAYPOINTS, radius_m)
            trial = lowest_altitudes(problem, prices, places)
        if trial is None:
            continue
        value = float(run.fitness([trial], strict=True)[0])
        if value > fitness:
            fitness, turns = value, moved
            crossed = _crossed(terrain, covered, turns)
            found.append(trial)
    return found


def _crossed(terrain: Terrain, covered: NDArray[np.bool_], turns: Floats) -> int:
    """Return how many samples of the lines between turns lie in covered cells or off the map."""
    runs = np.hypot(*np.diff(turns, axis=0).T)
    parts = np.maximum(np.ceil(runs / min(terrain.dx_m, terrain.dy_m)), 1).astype(np.int64)
    line = np.repeat(np.arange(len(runs)), parts)
    share = (np.arange(len(line)) - (np.cumsum(parts) - parts)[line] + 0.5) / parts[line]
    at = turns[line] + share[:, None] * (turns[line + 1] - turns[line])
    size = terrain.width_m, terrain.height_m
    inside = ((at >= 0) & (at <= size)).all(axis=1)
    return int(covered[terrain.nearest_nodes(*at[inside].T)].sum()) + int((~inside).sum())


def _turns(places: Floats) -> Floats:
    """Return the places at which a path turns, with both ends, (m, 2) metres."""
    way = np.diff(places, axis=0)
    cross = way[:-1, 0] * way[1:, 1] - way[:-1, 1] * way[1:, 0]
    turn = np.abs(np.arctan2(cross, (way[:-1] * way[1:]).sum(axis=1)))
    kept: Floats = places[np.concatenate(([True], turn > _LEAST_TURN_RAD, [True]))]
    return kept


def _moved(rng: np.random.Generator, turns: Floats, move_m: float, span: slice) -> Floats:
    """Return places of which one has moved, is new or is missing, (m, 2) metres.

    The places before ``span`` and after it stay, and so do its first and its last one.
    """
    kind, count = rng.random(), span.stop - span.start - 2
    move = move_m * rng.standard_normal(2)
    if count == 0 or (kind < _ADDED and len(turns) - 2 < DEFAULT_MAX_WAYPOINTS):
        after = span.start + int(rng.integers(count + 1))
        return np.insert(turns, after + 1, turns[after : after + 2].mean(axis=0) + move, axis=0)
    which = span.start + 1 + int(rng.integers(count))
    if kind < _ADDED + _REMOVED:
        return np.delete(turns, which, axis=0)
    moved = turns.copy()
    moved[which] += move
    return moved
