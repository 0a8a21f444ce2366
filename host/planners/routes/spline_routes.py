"""The planners of *cheng* on terrain: routes of B-splines in three dimensions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.base import Options, Progress, Result, Run, Stop
from pathgene.host.planners.grid.initial import astar_paths, check_init
from pathgene.host.planners.routes.field import (
    FEWEST_CONTROL_POINTS,
    MOST_CONTROL_POINTS,
    MOST_POINTS,
    READINGS,
    Floats,
    Graph,
    Ints,
    Route,
    Segments,
    check_reading,
)
from pathgene.host.planners.routes.point_sampler import KINDS, PointSampler
from pathgene.host.planners.routes.programming import best_by_sum, segments_of
from pathgene.host.planners.routes.search import (
    ADDED_POINTS,
    CHROMOSOMES,
    ConventionalSearch,
    DeterministicSearch,
    Search,
)
from pathgene.host.planners.routes.spline import equal_steps


__all__ = ["WAYPOINTS", "ConventionalRoutePlanner", "DeterministicRoutePlanner", "TerrainField"]

#: Waypoints of a segment: the last one is the crossover point at its end.
WAYPOINTS = 8

# Number of routes, the best by the estimate, that are evaluated in full (reading ``route``).
_CANDIDATES = 16
# Cost of a metre of penalty: higher than any cost, because a feasible path has no penalty.
_PENALTY_WEIGHT_PER_M = 1e6


class TerrainField:
    """A planning problem as crossover points and segments between them.

    A route becomes a path of 8 waypoints for each segment, at equal arc length; the fitness of the
    route is F of that path. F is not a sum, so the deterministic crossover uses an additive
    estimate: each segment is evaluated as a separate path, and the penalties and costs of the
    segments, equations (1) and (2), add up to the penalty and the cost of the route. The estimate
    omits the turn arcs at crossover points and the loss of weight by burned fuel, and counts the
    share of impossible arcs by segment. A lower penalty is better; if penalties are equal, the
    lower cost wins.

    The estimate is close, but no bound. Reading ``sum`` takes the best route by the estimate;
    ``route`` evaluates the 16 best in full, including arcs at crossover points, and takes the best
    by F. With either reading, a route is kept until another one has a better F.

    Parameters
    ----------
    run : Run
        Evaluates paths and keeps the record; a segment counts as an evaluation.
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
        """Return penalty in metres and cost of segments, (m, 2)."""
        run = self._run
        with run.phase("segments"):
            paths = equal_steps(control, counts, WAYPOINTS)
            lengths = np.full(len(paths), WAYPOINTS + 1)
            penalty, cost = run.evaluator.segments_penalty_cost(paths, lengths)
        run.evaluations += len(paths)
        return np.stack((penalty, cost), axis=1)

    def costs(self, terms: Floats) -> Floats:
        """Return penalty before cost as one number for each segment, (m,)."""
        penalty, cost = terms.T
        costs: Floats = _PENALTY_WEIGHT_PER_M * penalty + cost
        return costs

    def best_routes(self, graph: Graph) -> list[Ints]:
        """Return the best routes by the estimate."""
        with self._run.phase("crossover"):
            routes, costs = best_by_sum(
                graph.tails,
                graph.heads,
                self.costs(graph.segments.terms),
                len(graph.points),
                self._candidates,
            )
            return [segments_of(route) for route in routes[np.isfinite(costs)]]

    def worth(self, routes: Sequence[Route]) -> Floats:
        """Return the fitness F of routes, (m,)."""
        return self._run.fitness([self.path(route) for route in routes])

    def route(self, path: Floats) -> Route:
        """Return a route of straight segments along ``path``, (n, 3) metres with 2 to 10 points."""
        count = FEWEST_CONTROL_POINTS
        part = np.arange(count)[:, None] / (count - 1)
        control = np.zeros((len(path) - 1, MOST_CONTROL_POINTS, 3))
        control[:, :count] = path[:-1, None] + part * np.diff(path, axis=0)[:, None]
        control[:, count - 1] = path[1:]
        counts = np.full(len(control), count)
        return Route(path, Segments(control, counts, self.measure(control, counts)))

    def path(self, route: Route) -> Floats:
        """Return the waypoints of a route, (8 k + 1, 3) float64 metres, start and goal included."""
        segments = route.segments
        steps = equal_steps(segments.control, segments.counts, WAYPOINTS)
        return np.concatenate((route.points[:1], steps[:, 1:].reshape(-1, 3)))


class DeterministicRoutePlanner:
    """``ga-dp``: the :class:`~pathgene.host.planners.routes.search.DeterministicSearch` on terrain.

    Source: *cheng*, section IV; on terrain, :class:`TerrainField` gives the fitness of a route.
    Generation 0 is the first generation of the paper.

    Parameters
    ----------
    reading : str
        ``route`` or ``sum``; see :class:`TerrainField`.
    draws : str
        ``near`` or ``uniform``; see
        :class:`pathgene.host.planners.routes.point_sampler.PointSampler`.
    added_points : int
        Crossover points added per generation, 1 to 50.
    init : str
        ``random``, or ``astar``: the first kept route is the best path of the planner ``astar``
        with at most 8 waypoints, as straight segments.
    """

    def __init__(
        self,
        *,
        reading: str = READINGS[0],
        draws: str = KINDS[0],
        added_points: int = ADDED_POINTS,
        init: str = "random",
    ) -> None:
        self.reading, self.draws, self.added_points = reading, draws, added_points
        self.from_astar = check_init(init)

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`pathgene.host.planners.base.Planner`.

        Raises
        ------
        InputError
            If a population is given, an option is out of range, or the map has no flyable cell.
        """
        if options.population is not None:
            raise InputError("ga-dp has no population; leave it out (--population).")
        problem = _Problem(Run(evaluator, options, progress, stop), self.reading, self.from_astar)
        return problem.searched(
            DeterministicSearch(
                problem.field,
                problem.sampler(self.draws),
                problem.rng,
                added=self.added_points,
                given=problem.given,
            )
        )


class ConventionalRoutePlanner:
    """``ga-auv``: the :class:`~pathgene.host.planners.routes.search.ConventionalSearch` on terrain.

    Source: *cheng*, section V; on terrain, :class:`TerrainField` gives the fitness of a route.
    Generation 0 is the first generation of the paper.

    Parameters
    ----------
    draws, added_points, init
        As for :class:`DeterministicRoutePlanner`.
    """

    def __init__(
        self, *, draws: str = KINDS[0], added_points: int = ADDED_POINTS, init: str = "random"
    ) -> None:
        self.draws, self.added_points = draws, added_points
        self.from_astar = check_init(init)

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`pathgene.host.planners.base.Planner`.

        Raises
        ------
        InputError
            If the population or an option is out of range, or the map has no flyable cell.
        """
        count = CHROMOSOMES if options.population is None else options.population
        problem = _Problem(Run(evaluator, options, progress, stop), READINGS[0], self.from_astar)
        return problem.searched(
            ConventionalSearch(
                problem.field,
                problem.sampler(self.draws),
                problem.rng,
                added=self.added_points,
                chromosomes=count,
                given=problem.given,
            )
        )


class _Problem:
    """A run with the field, sampler and first routes that both searches use."""

    def __init__(self, run: Run, reading: str, from_astar: bool) -> None:
        self._run = run
        self.field = TerrainField(run, reading=reading)
        self.rng = np.random.default_rng(run.options.seed)
        #: The best route of a grid search, if one is requested and succeeds.
        self.given: list[Route] = []
        if from_astar:
            found = astar_paths(run, self.rng, 1, MOST_POINTS - 2)
            self.given = [] if found is None else [self.field.route(path) for path in found]

    def sampler(self, kind: str) -> PointSampler:
        return PointSampler(Airspace(self._run.evaluator.problem), kind)

    def searched(self, search: Search) -> Result:
        """Run generations until a stop criterion is met."""
        run = self._run
        run.record(0, search.step().fitness)
        generation = 0
        with run.search():
            while run.stopped_by() is None:
                generation += 1
                run.record(generation, search.step().fitness)
        return run.result()
