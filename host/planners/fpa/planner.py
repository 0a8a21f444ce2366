"""The flower pollination algorithm with or without 2-opt: *roberge*, sections 3.3 and 3.4."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.base import Options, Progress, Result, Run, Stop
from pathgene.host.planners.boxed import plan_in_box
from pathgene.host.planners.fpa.engines import CpuEngine, Engine, Setup
from pathgene.host.planners.fpa.steps import Pollination
from pathgene.host.planners.grid.astar import DEFAULT_MAX_TURNS
from pathgene.host.planners.grid.initial import astar_paths, check_init
from pathgene.host.planners.registry import ENGINES


__all__ = ["FlowerPollinationPlanner", "first_population", "with_more_waypoints"]


def first_population(
    space: Airspace,
    rng: np.random.Generator,
    count: int,
    waypoints: int,
    given: Sequence[Path] = (),
) -> NDArray[np.float64]:
    """Return ``count`` paths, (count, n, 3) float64 metres, start and goal included.

    The paths of ``given`` come first, in order;
    :meth:`~pathgene.host.planners.airspace.Airspace.draw` draws the waypoints of the remaining
    paths. All paths get the same number of waypoints, n - 2: ``waypoints``, or the maximum among
    the given paths if that is greater. A given path with fewer waypoints gets more on its track.

    Parameters
    ----------
    count, waypoints : int
        Number of paths, 1 or more; minimum number of waypoints, 0 or more.
    given : sequence of (k, 3) float64
        Paths to start from, including the ends; at most ``count`` are used.
    """
    points = max([waypoints + 2, *(len(path) for path in given)])
    paths = np.empty((count, points, 3))
    taken = [with_more_waypoints(path, points) for path in given[:count]]
    if taken:
        paths[: len(taken)] = taken
    drawn = count - len(taken)
    inner = space.draw(rng, drawn * (points - 2))
    paths[len(taken) :, 1:-1] = inner.reshape(drawn, points - 2, 3)
    paths[:, 0], paths[:, -1] = space.start, space.goal
    return paths


def with_more_waypoints(path: Path, points: int) -> Path:
    """Return ``path`` with new waypoints on its longest legs until it has ``points`` points."""
    while len(path) < points:
        legs = np.linalg.norm(np.diff(path, axis=0), axis=1)
        longest = int(np.argmax(legs))
        middle = path[longest : longest + 2].mean(axis=0)
        path = np.insert(path, longest + 1, middle, axis=0)
    return path


Path = NDArray[np.float64]

#: Default number of solutions (table 3), and of free waypoints, which the paper does not give.
POPULATION = 512
WAYPOINTS = 6
#: Iterations from one 2-opt to the next (table 3).
TWO_OPT_EVERY = 20

_SWITCH = 0.5  # Probability of a global step (table 3).
_FIRST_EPSILON, _LAST_EPSILON = 0.25, 0.02
_FEWEST, _MOST = 4, 100_000  # Solutions.
_MOST_WAYPOINTS = 100
# Iterations between two reads of the whole population for the final choice; the second applies to a
# GPU, where a launch and a read take as long as several iterations.
_LOOK_EVERY, _LOOK_EVERY_ON_GPU = 20, 50


class FlowerPollinationPlanner:
    """Flower pollination: solutions move relative to the best one or by a random pair.

    In an iteration each solution has a candidate, made by a Levy flight relative to the best
    (equation 4) or by a share of the difference of two random solutions (equation 5). A better
    candidate replaces the solution. At regular intervals the 2-opt operator reverses parts of all
    solutions as long as that improves them.

    Source: *roberge*, sections 3.3 and 3.4, table 3; :mod:`pathgene.host.planners.fpa.steps`
    settles the points that the paper leaves open. The first waypoints are drawn uniformly over free
    ground and the height above it; candidates are clipped to the box of
    :class:`~pathgene.host.planners.airspace.Airspace`. The 2-opt operator runs after iterations 20,
    40 and so on.

    Parameters
    ----------
    two_opt_every : int
        Iterations from one 2-opt to the next, 1 or more; 0 for the algorithm without it.
    waypoints : int, optional
        Free waypoints of a path, 1 to 100; by default 6, or 16 with ``astar``, whose best paths
        need 16; 6 if the grid search finds no route.
    engine : str
        ``threads``, all threads of the evaluator; ``sequential``, one; or ``gpu``. The first two
        give the same result to the last bit, the third rounds differently.
    init : str
        ``random``, or ``astar``: the first population comes from
        :func:`pathgene.host.planners.grid.initial.astar_paths`.
    give_up : bool
        Abandon a candidate once it cannot be better; the paths found do not depend on this.

    Raises
    ------
    InputError
        If an argument is outside its range.
    """

    def __init__(
        self,
        *,
        two_opt_every: int = TWO_OPT_EVERY,
        waypoints: int | None = None,
        engine: str = ENGINES[0],
        init: str = "random",
        give_up: bool = True,
    ) -> None:
        if two_opt_every < 0:
            raise InputError(
                f"The iterations between 2-opts must be 0 or more, not {two_opt_every}."
            )
        if waypoints is not None and not 1 <= waypoints <= _MOST_WAYPOINTS:
            raise InputError(
                f"The number of waypoints must be from 1 to {_MOST_WAYPOINTS}, not {waypoints}."
            )
        if engine not in ENGINES:
            raise InputError(
                f"There is no engine {engine!r}; the engines are {', '.join(ENGINES)}."
            )
        self.two_opt_every = two_opt_every
        self.waypoints = waypoints
        self.engine = engine
        self.from_astar = check_init(init)
        self.give_up = give_up

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`pathgene.host.planners.base.Planner`.

        Candidates that are abandoned because they cannot replace their solution do not count as
        evaluations. A time limit or an interrupt ends the search within an iteration, which is
        discarded; on the GPU it ends after at most 50 iterations.

        Raises
        ------
        InputError
            If the population is not from 4 to 100,000, the map has no flyable cell, or there is no
            GPU for the engine ``gpu``.
        """
        if self.engine == "gpu":
            return self._alone(evaluator, options, progress, stop)
        return plan_in_box(self._alone, evaluator, options, progress, stop)

    def _alone(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None,
        stop: Stop | None,
    ) -> Result:
        return self._plan([Run(evaluator, options, progress, stop)])[0]

    def plan_together(
        self, evaluators: Sequence[Evaluator], options: Sequence[Options], stop: Stop | None = None
    ) -> list[Result]:
        """Search for paths of several problems at once on a GPU; see :meth:`plan`.

        Without a time limit, which applies to all together, each result equals the result of
        :meth:`plan`, except that its times cover all runs together.

        Parameters
        ----------
        evaluators : sequence of Evaluator
            Evaluators of the problems, one or more.
        options : sequence of Options
            Options of each run. Generations, population, time limit and target must be equal.

        Raises
        ------
        InputError
            As for :meth:`plan`.
        JobError
            If the GPU fails before the first iteration, or has too little memory.
        ValueError
            If the engine is not ``gpu``, or the options differ in more than their seeds.
        """
        if self.engine != "gpu":
            raise ValueError(f"The engine {self.engine} has one run at a time")
        if len({dataclasses.replace(each, seed=0) for each in options}) != 1:
            raise ValueError("The options differ in more than their seeds")
        return self._plan(
            [
                Run(evaluator, each, None, stop)
                for evaluator, each in zip(evaluators, options, strict=True)
            ]
        )

    def _plan(self, runs: Sequence[Run]) -> list[Result]:
        options = runs[0].options
        count = POPULATION if options.population is None else options.population
        if not _FEWEST <= count <= _MOST:
            raise InputError(
                f"The population of fpa must be from {_FEWEST} to {_MOST}, not {count}."
            )
        if self.engine == "gpu":
            _check_gpu()
        setups = [self._setup(run, count) for run in runs]
        # If the grid search finds no route, paths have fewer points.
        for points in sorted({setup.paths.shape[1] for setup in setups}):
            alike = [at for at, setup in enumerate(setups) if setup.paths.shape[1] == points]
            together = [runs[at] for at in alike]
            try:
                with (
                    contextlib.closing(self._engine([setups[at] for at in alike])) as engine,
                    contextlib.ExitStack() as searches,
                ):
                    for run in together:
                        searches.enter_context(run.search())
                    _pollinate(together, engine, self._look_every)
            except JobError as error:  # The GPU is lost; earlier results are kept.
                if all(len(run.history) == 1 for run in runs):
                    raise
                for run in together:
                    if run.ended_by is None:
                        run.failure = str(error)
        return [run.result() for run in runs]

    def _setup(self, run: Run, count: int) -> Setup:
        """Draw and evaluate the first population of a run."""
        options = run.options
        space = Airspace(run.evaluator.problem)
        rng = np.random.default_rng(options.seed)
        found = None
        if self.from_astar:
            waypoints = self.waypoints or DEFAULT_MAX_TURNS
            found = astar_paths(run, rng, count, waypoints, fewest=waypoints)
        paths = first_population(space, rng, count, self.waypoints or WAYPOINTS, found or ())
        fitness = run.fitness(list(paths))
        run.record(0, fitness)
        parameters = Pollination(
            np.uint64(options.seed),
            options.generations,
            _SWITCH,
            _FIRST_EPSILON,
            _LAST_EPSILON,
            int(self.give_up),
        )
        box = np.stack((space.low, space.high))
        return Setup(run.evaluator, parameters, box, paths, fitness)

    @property
    def _look_every(self) -> int:
        return _LOOK_EVERY_ON_GPU if self.engine == "gpu" else _LOOK_EVERY

    def _engine(self, setups: Sequence[Setup]) -> Engine:
        if self.engine == "gpu":
            from pathgene.host.planners.fpa.cuda import GpuEngine

            return GpuEngine(setups, self.two_opt_every, stride=self._look_every)
        (setup,) = setups
        threads = setup.evaluator.threads if self.engine == "threads" else 1
        return CpuEngine(setup, self.two_opt_every, threads)


def _pollinate(runs: Sequence[Run], engine: Engine, look_every: int) -> None:
    """Run the engine until each run has met a stop criterion; record its results."""
    options = runs[0].options
    before = [run.evaluations for run in runs]
    _, seen = engine.populations()
    iteration = 0
    # A target fitness is checked after each iteration; time and interrupts stop the engine.
    at_once = look_every if options.target_fitness is None else 1
    active = [at for at, run in enumerate(runs) if run.stopped_by() is None]
    while active:
        count = min(at_once, options.generations - iteration)
        with contextlib.ExitStack() as phases:
            for at in active:
                phases.enter_context(runs[at].phase("iterations"))
            leaders = engine.advance(
                iteration + 1,
                count,
                lambda: all(run.stopped_by() is not None for run in runs),
            )
        iteration += len(leaders[0])
        for at in active:
            run = runs[at]
            first = iteration - len(leaders[at]) + 1
            for number, leader in enumerate(leaders[at], first):
                run.evaluations = before[at] + leader.evaluated
                run.cut_short = leader.cut_short
                run.keep([leader.path], np.array([leader.fitness]))
                run.note(number, leader.mean)
        for at in active:
            runs[at].ended_by = runs[at].stopped_by()
        ended = [at for at in active if runs[at].ended_by is not None]
        if iteration % look_every == 0 or ended:
            paths, fitness = engine.populations()
            for at in active:
                new = fitness[at] > seen[at]
                runs[at].keep(paths[at][new], fitness[at][new])
            seen = fitness
        active = [at for at in active if at not in ended]


def _check_gpu() -> None:
    """Raise InputError unless there is a GPU that numba can use."""
    try:
        from pathgene.host.planners.fpa import cuda

        there = cuda.is_available()
    except ImportError:
        there = False
    if not there:
        raise InputError(
            "The engine gpu needs an NVIDIA GPU and CUDA for numba (the extra 'gpu'), "
            "which are not there; use another (--engine threads)."
        )
