"""Grid search, then few waypoints, then the lowest altitudes: what any reader would try first."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from host.errors import InputError
from host.evaluation import Evaluator
from host.planners.altitudes import lowest_altitudes
from host.planners.base import Options, Progress, Result, Run, Stop
from host.planners.grid_search import SearchGrid
from host.planners.polylines import lengthened, on_corners, polylines, thinned
from host.problem import ChipMap


__all__ = ["DEFAULT_MAX_WAYPOINTS", "MOST_SEARCHES", "AstarPlanner", "searches"]

Path = NDArray[np.float64]

# Steepness of the surface of each search, in climb limits; the ground is infinitely steep.
_STEEPNESS = (2.5, 1.5, 1.0, math.inf)
# Way round voids and zones, in turning radii; the second if the first leads to nothing feasible.
_MARGINS = (0.0, 0.5)
#: Searches there can be.
MOST_SEARCHES = len(_MARGINS) * len(_STEEPNESS)
# Turns that are tried with each route, as shares of the most waypoints.
_SHARES = (1.0, 0.75, 0.5, 0.25, 0.125)
_MOST_WAYPOINTS = 100
#: Most waypoints of a path by default.
DEFAULT_MAX_WAYPOINTS = 16


class AstarPlanner:
    """Grid search in 2.5 dimensions. Nothing is random: all seeds give the same path.

    Each search is a generation: a surface that slopes by at most so much is laid over a coarse
    grid of the ground, the cheapest route at its altitudes is found and reduced to a few turns,
    waypoints are added on the straight pieces, and all get the lowest altitudes that ground and
    climb limits allow. Of all searches and all
    numbers of turns the best path is returned.

    A gently sloping surface knows that the aircraft has to climb before a pass, but not that a
    valley between steep walls can be flown through; the ground itself knows the opposite. So four
    are tried, and four more that keep away from voids and zones if none led to a feasible path.

    The route is Dijkstra's, as cheap as that of A*: SciPy's search of the whole grid takes less
    time than the building of the graph, so that a heuristic would save nothing.

    Parameters
    ----------
    max_waypoints : int
        Most waypoints between start and goal, 1 to 100.

    Raises
    ------
    InputError
        If ``max_waypoints`` is outside its range.
    """

    def __init__(self, *, max_waypoints: int = DEFAULT_MAX_WAYPOINTS) -> None:
        if not 1 <= max_waypoints <= _MOST_WAYPOINTS:
            raise InputError(
                f"The most waypoints of a path must be from 1 to {_MOST_WAYPOINTS}, "
                f"not {max_waypoints}."
            )
        self.max_waypoints = max_waypoints

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`host.planners.base.Planner`.

        Generation 0 is the straight line, each other one a search; there are at most 8.

        Raises
        ------
        InputError
            If a population is asked for.
        """
        if options.population is not None:
            raise InputError("The planner astar has no population; leave out --population.")
        run = Run(evaluator, options, progress, stop)
        problem = evaluator.problem
        run.record(0, run.fitness([np.array([problem.start, problem.goal])]))
        with run.search():
            found = searches(run, self.max_waypoints)
            generation = 0
            while run.stopped_by() is None and (paths := next(found, None)) is not None:
                generation += 1
                run.record(generation, np.array([fitness for fitness, _ in paths]))
        return run.result()


def searches(
    run: Run,
    most: int,
    lattice: ChipMap | None = None,
) -> Iterator[list[tuple[float, Path]]]:
    """Search with one surface after the other.

    Parameters
    ----------
    run : Run
        Evaluates the paths; its evaluator has the problem.
    most : int
        Most waypoints between start and goal.
    lattice : ChipMap, optional
        On whose cells and altitude steps waypoints must lie.

    Yields
    ------
    list of (float, ndarray)
        Fitness and path, (n, 3) float64 metres with both ends, for several numbers of turns.
        A search that finds no way yields nothing.
    """
    problem, best = run.evaluator.problem, 0.0
    for margin in _MARGINS:
        with run.phase("search"):
            grid = SearchGrid(problem, margin * problem.aircraft.turn_radius_m)
        for steepness in _STEEPNESS:
            with run.phase("search"):
                paths = _paths(grid, steepness, most, lattice)
            if paths:
                fitness = run.fitness(paths).tolist()
                best = max(best, *fitness)
                yield list(zip(fitness, paths, strict=True))
        if best > 1:
            return


def _paths(grid: SearchGrid, steepness: float, most: int, lattice: ChipMap | None) -> list[Path]:
    """Paths of several numbers of turns along one route; none if there is no way."""
    problem = grid.problem
    surface = grid.surface(steepness * math.tan(math.radians(problem.aircraft.max_climb_deg)))
    route = grid.route(surface)
    if route is None:
        return []
    points = thinned(route, None if lattice is None else lattice.scale_m[:2])
    lines = polylines(points, grid, surface, most)
    steps = {} if lattice is None else {"base_m": lattice.base_m, "step_m": lattice.step_m}
    found = []
    for line in (lines[count] for count in _counts(most)):
        if line is None:
            continue
        # More waypoints on the same track allow lower altitudes, but on a lattice they may turn.
        places = lengthened(points[line], most, problem.aircraft.turn_radius_m)
        if lattice is not None:
            places[1:-1] = on_corners(places[1:-1], lattice.scale_m[:2])
        path = lowest_altitudes(problem, grid.prices, places, **steps)
        if path is None and lattice is not None:
            path = lowest_altitudes(problem, grid.prices, points[line], **steps)
        if path is not None:
            found.append(path)
    return found


def _counts(most: int) -> list[int]:
    """Numbers of turns to try, from the fewest on."""
    return sorted({max(1, round(share * most)) for share in _SHARES})
