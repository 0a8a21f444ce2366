"""Grid search, reduction to few waypoints, lowest altitudes: the obvious method to beat."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options, Progress, Result, Run, Stop
from pathgene.host.planners.boxed import plan_in_box
from pathgene.host.planners.grid.altitudes import lowest_altitudes
from pathgene.host.planners.grid.corners import cornered
from pathgene.host.planners.grid.fine_grid import fine_grid
from pathgene.host.planners.grid.grid_search import MOST_NODES, SearchGrid
from pathgene.host.planners.grid.narrow import narrow_searches
from pathgene.host.planners.grid.polylines import (
    Leads,
    around,
    between,
    leads,
    lengthened,
    on_corners,
    polylines,
    routed,
    sloped,
    thinned,
    with_leads,
)
from pathgene.host.planners.grid.tangents import tangent_routes
from pathgene.host.problem.chip_map import ChipMap
from pathgene.host.problem.problem import Problem


__all__ = [
    "DEFAULT_MAX_TURNS",
    "DEFAULT_MAX_WAYPOINTS",
    "QUICK_SEARCHES",
    "AstarPlanner",
    "fine_searches",
    "searches",
]

Path = NDArray[np.float64]
# Maximum numbers of waypoints of a path, and of those at which it turns.
_Sizes = tuple[int, int]

# Steepness of the surface of each search, as a multiple of the climb limit; infinite for the ground
# itself.
_STEEPNESS = (2.5, 1.5, 1.0, math.inf)
# Nodes on the longer side of a fine grid, cells along a node at most, and the surfaces tried there.
_FINE_NODES, _MOST_CELLS = 256, 4
_FINE_STEEPNESS = (1.5, 1.0)
# Routes along tangents of zones.
_TANGENT_ROUTES = 10
# Margin around voids and zones, in turn radii; the second if the first gives no feasible path.
_MARGINS = (0.0, 0.5)
# Distances of waypoints around the ends, in turn radii, and the surfaces tried with them.
_AWAY_RADII = (2.0, 4.0)
_STEEPNESS_FROM_SIDES = (1.5, math.inf)
# Numbers of turns tried with each route, as shares of the maximum number of waypoints.
_SHARES = (1.0, 0.75, 0.5, 0.25, 0.125)
_MOST_WAYPOINTS = 100
#: Default maximum number of waypoints of a path, of those at which it turns, and of waypoints of a
#: path that the quick searches do not find.
DEFAULT_MAX_WAYPOINTS, DEFAULT_MAX_TURNS, NARROW_WAYPOINTS = 32, 16, 64
#: Maximum number of quick searches. A plan of no more generations has no narrow searches.
QUICK_SEARCHES = 40


class AstarPlanner:
    """Grid search in 2.5 dimensions. Nothing is random: all seeds give the same path.

    Each search is one generation. It lays a surface of limited slope over a coarse grid of the
    ground, finds the cheapest route at the altitudes of the surface, reduces the route to a few
    turns, adds waypoints on the straight pieces, and gives all waypoints the lowest altitudes that
    ground and climb limits allow. The result is the best path of all searches and all numbers of
    turns.

    A gently sloping surface accounts for the climb before a pass, but closes a valley between steep
    walls; the ground itself does the opposite. Therefore four surfaces are tried, and four more
    with a margin around voids and zones if none of them gives a feasible path. Under the rules of
    safe flight, where paths are compared by the strict rule, at most 32 more searches follow, which
    leave the start or reach the goal in one of eight directions.

    If all of these fail, narrower and longer ways are searched
    (:func:`~pathgene.host.planners.grid.narrow.narrow_searches`), unless the plan has no more than
    :data:`QUICK_SEARCHES` generations. They take seconds.

    The route comes from Dijkstra's algorithm and costs the same as with A*. A kernel searches the
    whole grid in less time than it takes to build the graph, so a heuristic would save nothing.

    Parameters
    ----------
    max_waypoints : int, optional
        Maximum number of waypoints between start and goal, 1 to 100. By default it is 32, of which
        16 may turn, or 64 for narrow ways.

    Raises
    ------
    InputError
        If ``max_waypoints`` is outside its range.
    """

    def __init__(self, *, max_waypoints: int | None = None) -> None:
        if max_waypoints is not None and not 1 <= max_waypoints <= _MOST_WAYPOINTS:
            raise InputError(
                f"The most waypoints of a path must be from 1 to {_MOST_WAYPOINTS}, "
                f"not {max_waypoints}."
            )
        self.max_waypoints = DEFAULT_MAX_WAYPOINTS if max_waypoints is None else max_waypoints
        self._max_turns = DEFAULT_MAX_TURNS if max_waypoints is None else max_waypoints
        self._narrow_waypoints = NARROW_WAYPOINTS if max_waypoints is None else max_waypoints

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`pathgene.host.planners.base.Planner`.

        Generation 0 is the straight line; each later generation is a search.

        Raises
        ------
        InputError
            If a population is given.
        """
        if options.population is not None:
            raise InputError("The planner astar has no population; leave it out (--population).")
        return plan_in_box(self._plan, evaluator, options, progress, stop)

    def _plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None,
        stop: Stop | None,
    ) -> Result:
        run = Run(evaluator, options, progress, stop)
        problem = evaluator.problem
        run.record(0, run.fitness([np.array([problem.start, problem.goal])]))
        with run.search():
            found = self._all(run)
            generation = 0
            while run.stopped_by() is None and (paths := next(found, None)) is not None:
                generation += 1
                run.record(generation, np.array([fitness for fitness, _ in paths]))
        return run.result()

    def _all(self, run: Run) -> Iterator[list[tuple[float, Path]]]:
        """Search quickly and, if that finds no feasible path, for narrow ways."""
        best = 0.0
        for paths in searches(run, self.max_waypoints, most_turns=self._max_turns):
            best = max(best, *(fitness for fitness, _ in paths))
            yield paths
        if best <= 1 and run.options.generations > QUICK_SEARCHES:
            yield from narrow_searches(run, self._narrow_waypoints)


def searches(
    run: Run, most: int, lattice: ChipMap | None = None, *, most_turns: int | None = None
) -> Iterator[list[tuple[float, Path]]]:
    """Search with one surface after another.

    Parameters
    ----------
    run : Run
        Evaluates the paths; its evaluator holds the problem.
    most : int
        Maximum number of waypoints between start and goal.
    lattice : ChipMap, optional
        Map on whose cells and altitude steps waypoints must lie.
    most_turns : int, optional
        Maximum number of waypoints at which a path turns; more lie on its straight pieces. By
        default all may turn.

    Yields
    ------
    list of (float, ndarray)
        Fitness and path, (n, 3) float64 metres with both ends, for several numbers of turns.
        A search that finds no route yields nothing.
    """
    problem, best = run.evaluator.problem, 0.0
    sizes = most, most if most_turns is None else most_turns
    for margin in _MARGINS:
        with run.phase("search"):
            grid = SearchGrid(problem, margin * problem.limits.turn_radius_m)
        for steepness in _STEEPNESS:
            with run.phase("search"):
                paths = [
                    path
                    for way in leads(problem)
                    for path in _paths(grid, steepness, sizes, lattice, way)
                ]
            if paths:
                fitness = run.fitness(paths, strict=True).tolist()
                best = max(best, *fitness)
                yield list(zip(fitness, paths, strict=True))
        if best > 1:
            return
    if best > 0 and problem.rules is not None:
        yield from _from_all_sides(run, sizes, lattice, grid, best)


def fine_searches(run: Run, most: int) -> Iterator[list[tuple[float, Path]]]:
    """Search along tangents of zones, and over smaller nodes than the quick searches.

    The quick searches see no gap that is narrower than their nodes, and cannot tell some routes
    apart. A terrain whose cells are their nodes is searched along tangents only; on one with many
    more cells the nodes would be no smaller: ``astar`` searches a box of it.

    Parameters
    ----------
    run : Run
        Evaluates the paths; its evaluator holds the problem.
    most : int
        Maximum number of waypoints between start and goal.

    Yields
    ------
    list of (float, ndarray)
        As of :func:`searches`, along tangents and then from one surface after another; with a
        margin around voids and zones if no path is feasible without.
    """
    problem = run.evaluator.problem
    nodes = max(problem.terrain.shape)
    if nodes > _MOST_CELLS * _FINE_NODES:
        return
    best = 0.0
    for margin in _MARGINS:
        with run.phase("search"):
            grid = fine_grid(problem, _FINE_NODES, margin_m=margin * problem.limits.turn_radius_m)
        if margin == 0:
            with run.phase("search"):
                paths = _past_zones(grid, problem, most)
            if paths:
                fitness = run.fitness(paths, strict=True).tolist()
                best = max(fitness)
                yield list(zip(fitness, paths, strict=True))
        if nodes <= MOST_NODES:
            return
        for steepness in _FINE_STEEPNESS:
            with run.phase("search"):
                paths = [
                    path
                    for way in leads(problem)
                    for path in _paths(
                        grid, steepness, (most, most), None, way, turns_at_corners=True
                    )
                ]
            if paths:
                fitness = run.fitness(paths, strict=True).tolist()
                best = max(best, *fitness)
                yield list(zip(fitness, paths, strict=True))
        if best > 1:
            return


def _past_zones(grid: SearchGrid, problem: Problem, most: int) -> list[Path]:
    """Return paths along tangents of zones."""
    surface = sloped(grid, _FINE_STEEPNESS[0])
    found = []
    for way in leads(problem):
        first, last = between(way)
        ends = np.array((first or problem.start[:2], last or problem.goal[:2]))
        for turns in tangent_routes(problem, grid, surface, ends, _TANGENT_ROUTES):
            places = with_leads(problem, way, turns)
            if len(places) - 2 > most:
                continue
            places = lengthened(places, most, problem.limits.turn_radius_m)
            path = lowest_altitudes(problem, grid.prices, places)
            if path is not None:
                found.append(path)
    return found


def _from_all_sides(
    run: Run, sizes: _Sizes, lattice: ChipMap | None, grid: SearchGrid, best: float
) -> Iterator[list[tuple[float, Path]]]:
    """Search with a first waypoint in each direction from the start, then with a last one.

    An aircraft that starts low can climb out in some directions only, and the nodes of the grid are
    too far apart to tell. The best direction at the start is kept for the searches at the goal.
    """
    problem = run.evaluator.problem
    kept = list(next(leads(problem)))
    for radii in _AWAY_RADII:
        for at_goal in (False, True):
            for place in around(problem, at_goal, radii * problem.limits.turn_radius_m):
                way = (kept[0], place) if at_goal else (place, kept[1])
                with run.phase("search"):
                    paths = [
                        path
                        for steepness in _STEEPNESS_FROM_SIDES
                        for path in _paths(grid, steepness, sizes, lattice, way)
                    ]
                if not paths:
                    continue
                fitness = run.fitness(paths, strict=True).tolist()
                if max(fitness) > best:
                    best, kept[at_goal] = max(fitness), place
                yield list(zip(fitness, paths, strict=True))
            if best > 1:
                return


def _paths(
    grid: SearchGrid,
    steepness: float,
    sizes: _Sizes,
    lattice: ChipMap | None,
    way: Leads,
    *,
    turns_at_corners: bool = False,
) -> list[Path]:
    """Return paths with different numbers of turns along one route; none if there is no route.

    With ``turns_at_corners``, corners of the route may become waypoints where no polyline through
    evenly spaced points is free.
    """
    most, most_turns = sizes
    if most_turns < sum(map(len, way)):
        return []
    problem = grid.problem
    surface, route = routed(grid, steepness, way)
    if route is None:
        return []
    most_turns -= sum(map(len, way))
    points = thinned(route, None if lattice is None else lattice.scale_m[:2])
    if len(points) < 2:
        # The goal is straight above or below the start.
        return []
    lines = polylines(points, grid, surface, most_turns)
    if turns_at_corners and all(line is None for line in lines):
        points = cornered(route, 0.25 * min(grid.dx_m, grid.dy_m))
        lines = polylines(points, grid, surface, most_turns)
    steps = {} if lattice is None else {"base_m": lattice.base_m, "step_m": lattice.step_m}
    found = []
    for line in (lines[count] for count in _counts(most_turns)):
        if line is None:
            continue
        turns = with_leads(problem, way, points[line])
        # More waypoints on a track allow lower altitudes; on a lattice they may add turns.
        places = lengthened(turns, most, problem.limits.turn_radius_m)
        if lattice is not None:
            places[1:-1] = on_corners(places[1:-1], lattice.scale_m[:2])
        path = lowest_altitudes(problem, grid.prices, places, **steps)
        if path is None and lattice is not None:
            path = lowest_altitudes(problem, grid.prices, turns, **steps)
        if path is not None:
            found.append(path)
    return found


def _counts(most: int) -> list[int]:
    """Return the numbers of turns to try, in rising order."""
    return sorted({min(max(1, round(share * most)), most) for share in _SHARES})
