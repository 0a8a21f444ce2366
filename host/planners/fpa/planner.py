"""The flower pollination algorithm with or without 2-opt: *roberge*, sections 3.3 and 3.4."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from host.errors import InputError
from host.evaluation import Evaluator
from host.planners.airspace import Airspace
from host.planners.astar import DEFAULT_MAX_WAYPOINTS
from host.planners.base import Options, Progress, Result, Run, Stop
from host.planners.fpa.engines import CpuEngine, Engine
from host.planners.fpa.first import first_population
from host.planners.fpa.steps import Pollination
from host.planners.initial import astar_paths, check_init
from host.planners.options import ENGINES


__all__ = ["FlowerPollinationPlanner"]

Path = NDArray[np.float64]

#: Solutions by default (table 3), and free waypoints, which the paper does not give.
POPULATION = 512
WAYPOINTS = 6
#: Iterations from one 2-opt to the next (table 3).
TWO_OPT_EVERY = 20

_SWITCH = 0.5  # Probability of a global step (table 3).
_FIRST_EPSILON, _LAST_EPSILON = 0.25, 0.02
_FEWEST, _MOST = 4, 100_000  # Solutions.
_MOST_WAYPOINTS = 100
# Iterations between two readings of the whole population, for the final choice.
_LOOK_EVERY = 20


class FlowerPollinationPlanner:
    """Flower pollination: each solution steps relative to the best or to two others.

    In an iteration each solution has a candidate, made by a Levy flight relative to the best
    (equation 4) or by a share of the difference of two others (equation 5). A better candidate
    replaces the solution. At regular intervals the 2-opt operator reverses parts of all solutions
    as long as that improves them.

    Source: *roberge*, sections 3.3 and 3.4, table 3; :mod:`host.planners.fpa.steps` settles what
    the paper leaves open. The first waypoints are drawn uniformly over free ground and the height
    above it; candidates are clipped to the box of :class:`~host.planners.airspace.Airspace`. The
    2-opt operator follows iterations 20, 40 and so on.

    Parameters
    ----------
    two_opt_every : int
        Iterations from one 2-opt to the next, 1 or more; 0 for the algorithm without it.
    waypoints : int, optional
        Free waypoints of a path, 1 to 100; by default 6, or 16 with ``astar``, whose best paths
        need them; 6 if the grid search finds no route.
    engine : str
        ``cores``, all threads of the evaluator; ``sequential``, one; or ``gpu``. The first two give
        the same result to the last bit, the third rounds differently.
    init : str
        ``random``, or ``astar``: the first population is of
        :func:`host.planners.initial.astar_paths`.
    give_up : bool
        Give up a candidate once it cannot be better; the paths found do not depend on this.

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
        """Search; see :class:`host.planners.base.Planner`.

        Candidates that are given up because they cannot replace their solution are not counted as
        evaluations. A time limit or an interrupt ends the search within an iteration, which is
        discarded; on the GPU, after 20 iterations at most.

        Raises
        ------
        InputError
            If the population is not from 4 to 100,000, the map has no flyable cell, or there is no
            GPU for the engine ``gpu``.
        """
        count = POPULATION if options.population is None else options.population
        if not _FEWEST <= count <= _MOST:
            raise InputError(
                f"The population of fpa must be from {_FEWEST} to {_MOST}, not {count}."
            )
        make_engine = _engine_maker(self.engine, evaluator.threads)
        space = Airspace(evaluator.problem)
        rng = np.random.default_rng(options.seed)

        run = Run(evaluator, options, progress, stop)
        found = None
        if self.from_astar:
            waypoints = self.waypoints or DEFAULT_MAX_WAYPOINTS
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
        with (
            contextlib.closing(
                make_engine(evaluator, parameters, self.two_opt_every, box, paths, fitness)
            ) as engine,
            run.search(),
        ):
            _pollinate(run, engine)
        return run.result()


def _pollinate(run: Run, engine: Engine) -> None:
    """Run the engine until a stop criterion is met; record its results."""
    before = run.evaluations
    iteration = 0
    # A target fitness is checked after each iteration; time and interrupts stop the engine.
    at_once = _LOOK_EVERY if run.options.target_fitness is None else 1
    while run.stopped_by() is None:
        count = min(at_once, run.options.generations - iteration)
        with run.phase("iterations"):
            leaders = engine.advance(iteration + 1, count, lambda: run.stopped_by() is not None)
        for leader in leaders:
            iteration += 1
            run.evaluations, run.cut_short = before + leader.evaluated, leader.cut_short
            run.keep([leader.path], np.array([leader.fitness]))
            run.note(iteration, leader.mean)
        if iteration % _LOOK_EVERY == 0 or run.stopped_by() is not None:
            run.keep(*engine.population())


def _engine_maker(name: str, threads: int) -> Callable[..., Engine]:
    """Return the constructor of an engine.

    Raises
    ------
    InputError
        If it is ``gpu`` and there is none.
    """
    if name != "gpu":
        return partial(CpuEngine, threads=threads if name == "cores" else 1)
    try:
        from host.planners.fpa import cuda

        there = cuda.is_available()
    except ImportError:
        there = False
    if not there:
        raise InputError(
            "The engine gpu needs an NVIDIA GPU and CUDA for numba (the extra 'gpu'), "
            "which are not there; use another (--engine cores)."
        )
    return partial(cuda.GpuEngine, stride=_LOOK_EVERY)
