"""The planners of *cheng* on terrain: routes of B-splines in three dimensions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from host.errors import InputError
from host.evaluation import Evaluator
from host.planners.airspace import Airspace
from host.planners.base import Options, Progress, Result, Run, Stop
from host.planners.routes.draws import KINDS, Draws
from host.planners.routes.field import READINGS, Floats, Graph, Ints, Route, check_reading
from host.planners.routes.programming import best_by_sum, segments_of
from host.planners.routes.search import (
    ADDED_POINTS,
    CHROMOSOMES,
    ConventionalSearch,
    DeterministicSearch,
    Search,
)
from host.planners.routes.spline import equal_steps


__all__ = ["WAYPOINTS", "ConventionalRoutePlanner", "DeterministicRoutePlanner", "TerrainField"]

#: Waypoints of a segment: the last one is the crossover point at its end.
WAYPOINTS = 8

# Routes that the estimate calls best and that are evaluated in full (reading ``route``).
_CANDIDATES = 16
# A metre of penalty weighs more than any cost: a path that can be flown has none.
_PENALTY_WEIGHT_PER_M = 1e6


class TerrainField:
    """A planning problem as crossover points and segments between them.

    A route becomes a path of 8 waypoints for each segment, at equal arc length, and is worth that
    path's fitness F. F is no sum, so the deterministic crossover goes by an estimate that is one:
    each segment is evaluated as a path of its own, and penalties and costs, equations (1) and (2),
    add up to those of the route. What that leaves out are the turn arcs at crossover points and the
    fuel that makes the aircraft lighter later on, and the share of impossible arcs is each
    segment's own. Less penalty is better, and of equal penalties less cost.

    So the estimate is near, but no bound. Reading ``sum`` takes the best route by it; ``route``
    evaluates the 16 best in full, arcs at crossover points included, and takes the best by F. A
    route is kept until another has a better F, whatever the reading.

    Parameters
    ----------
    run : Run
        Evaluates and keeps the record; a segment counts as an evaluation, too.
    reading : str
        ``route`` or ``sum``.

    Raises
    ------
    InputError
        If there is no such reading.
    """

    def __init__(self, run: Run, *, reading: str = READINGS[0]) -> None:
        check_reading(reading)
        problem = run.evaluator.problem
        self.ends: Floats = np.array([problem.start, problem.goal])
        self._run = run
        self._candidates = _CANDIDATES if reading == "route" else 1

    def measure(self, control: Floats, counts: Ints) -> Floats:
        """Penalty in metres and cost of segments, (m, 2)."""
        run = self._run
        with run.phase("segments"):
            paths = equal_steps(control, counts, WAYPOINTS)
            lengths = np.full(len(paths), WAYPOINTS + 1)
            penalty, cost = run.evaluator.penalty_cost(paths, lengths)
        run.evaluations += len(paths)
        return np.stack((penalty, cost), axis=1)

    def costs(self, terms: Floats) -> Floats:
        """Penalty before cost, as one number of each segment, (m,)."""
        penalty, cost = terms.T
        costs: Floats = _PENALTY_WEIGHT_PER_M * penalty + cost
        return costs

    def best_routes(self, graph: Graph) -> list[Ints]:
        """The routes that the estimate calls best."""
        with self._run.phase("crossover"):
            routes, costs = best_by_sum(
                graph.tails, graph.heads, self.costs(graph.segments.terms), len(graph.points),
                self._candidates)
            return [segments_of(route) for route in routes[np.isfinite(costs)]]

    def worth(self, routes: Sequence[Route]) -> Floats:
        """Fitness F of routes, (m,)."""
        return self._run.fitness([self.path(route) for route in routes])

    def path(self, route: Route) -> Floats:
        """The waypoints of a route, (8 k + 1, 3) float64 metres, start and goal included."""
        segments = route.segments
        steps = equal_steps(segments.control, segments.counts, WAYPOINTS)
        return np.concatenate((route.points[:1], steps[:, 1:].reshape(-1, 3)))


class DeterministicRoutePlanner:
    """``ga-dp``: the :class:`~host.planners.routes.search.DeterministicSearch` on terrain.

    Source: *cheng*, section IV; on terrain a route is worth what :class:`TerrainField` says.
    Generation 0 is the paper's first.

    Parameters
    ----------
    reading : str
        ``route`` or ``sum``; see :class:`TerrainField`.
    draws : str
        ``near`` or ``uniform``; see :class:`host.planners.routes.draws.Draws`.
    added_points : int
        Crossover points added per generation, 1 to 50.
    """

    def __init__(
        self, *, reading: str = READINGS[0], draws: str = KINDS[0],
        added_points: int = ADDED_POINTS,
    ) -> None:
        self.reading, self.draws, self.added_points = reading, draws, added_points

    def plan(
        self, evaluator: Evaluator, options: Options,
        progress: Progress | None = None, stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`host.planners.base.Planner`.

        Raises
        ------
        InputError
            If a population is asked for, an option is out of range, or nothing of the map is free.
        """
        if options.population is not None:
            raise InputError("ga-dp has no population; leave out --population.")
        run = Run(evaluator, options, progress, stop)
        return _searched(run, DeterministicSearch(
            TerrainField(run, reading=self.reading),
            Draws(Airspace(evaluator.problem), self.draws),
            np.random.default_rng(options.seed), added=self.added_points))


class ConventionalRoutePlanner:
    """``ga-auv``: the :class:`~host.planners.routes.search.ConventionalSearch` on terrain.

    Source: *cheng*, section V; on terrain a route is worth what :class:`TerrainField` says.
    Generation 0 is the paper's first.

    Parameters
    ----------
    draws, added_points
        As for :class:`DeterministicRoutePlanner`.
    """

    def __init__(self, *, draws: str = KINDS[0], added_points: int = ADDED_POINTS) -> None:
        self.draws, self.added_points = draws, added_points

    def plan(
        self, evaluator: Evaluator, options: Options,
        progress: Progress | None = None, stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`host.planners.base.Planner`.

        Raises
        ------
        InputError
            If the population or an option is out of range, or nothing of the map is free.
        """
        count = CHROMOSOMES if options.population is None else options.population
        run = Run(evaluator, options, progress, stop)
        return _searched(run, ConventionalSearch(
            TerrainField(run), Draws(Airspace(evaluator.problem), self.draws),
            np.random.default_rng(options.seed), added=self.added_points, chromosomes=count))


def _searched(run: Run, search: Search) -> Result:
    """Run generations until a stop criterion is met."""
    run.record(0, search.step().fitness)
    generation = 0
    with run.search():
        while run.stopped_by() is None:
            generation += 1
            run.record(generation, search.step().fitness)
    return run.result()
