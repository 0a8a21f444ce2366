"""Plan a problem or a mission: the function of the Python API."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from pathgene.host.checking import evaluator_of
from pathgene.host.errors import InputError
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.mission.planning import plan_mission
from pathgene.host.options.arguments import require_functions
from pathgene.host.planners.base import Progress, Stop
from pathgene.host.planning import Plan, Search
from pathgene.host.problem.problem import Problem


__all__ = ["plan", "plan_together"]


def plan(
    problem: Problem | MissionProblem,
    planner: str | None = None,
    *,
    seed: int = 0,
    generations: int | None = None,
    time_limit_s: float | None = None,
    target_fitness: float | None = None,
    population: int | None = None,
    progress: Progress | None = None,
    cancel: Callable[[], bool] | None = None,
    fallback: str = "astar",
    **options: Any,
) -> Plan:
    """Plan a path; print and write nothing.

    The defaults are the same as in ``pathgene plan``, and the same seed gives the same path.

    Parameters
    ----------
    problem : Problem or MissionProblem
        Terrain, ends, aircraft, zones and wind; a mission has several legs, and each is planned
        with the same options.
    planner : str, optional
        Name of a planner: ``ga-chip``, ``ga-fpga``, ``ga-pc``, ``astar``, ``fpa``, ``fpa-2opt``,
        ``ga-dp`` or ``ga-auv``. By default ``ga-chip``, but ``ga-fpga`` on a board with the paper
        core; an open board ``model:`` has that core unless its URL sets ``core=planner``.
    seed : int
        0 to 2**64 - 1. It determines all random numbers.
    generations : int, optional
        Maximum number of generations; by default the planner's own.
    time_limit_s : float, optional
        Maximum seconds of planning.
    target_fitness : float, optional
        Fitness that ends the search; the fitness of feasible paths exceeds 1.
    population : int, optional
        Paths in the population; the planner's own number by default. A chip's is fixed.
    progress : callable, optional
        Called after each generation with its number, the best fitness found and the mean fitness
        of the population. A mission counts the generations of all legs.
    cancel : callable, optional
        Called between generations. Once it returns True, the search ends, and the plan has the
        best path found and ``interrupted`` true. The wait for generation 0 is usually the longest:
        the first plan on a machine compiles for up to a minute, and ``sim:`` builds its board.
    fallback : str
        ``astar`` or ``none``. With ``astar``, if the chosen planner finds no feasible path, and it
        is not proven that none exists, ``astar`` searches, and then ``fpa-2opt``. ``plan.fallback``
        names the planner that found the path; ``plan.reason`` says why there is no path. Not with
        ``as_paper``.
    **options
        The planner's own options, ``board="sim:"`` for example, named as in ``pathgene plan`` with
        underscores. None stands for the default. A ``board`` may also be an open board from
        :func:`pathgene.open_board`, on which a plan of ``ga-chip`` is quick to change in flight:
        see :meth:`Plan.replan`.

    Returns
    -------
    Plan
        The best path found, which may not be feasible: see ``plan.evaluation``. The plan of a
        mission of several legs has ``plan.legs``, each with its own ``plan``.

    Raises
    ------
    InputError
        If there is no such planner, the planner has no such option, or a value is out of range.
    JobError
        If the search fails before it has a path, for example because no board answers. After a
        later failure, the plan has the best path found, and ``plan.failure`` says what happened.
    """
    require_functions(progress=progress, cancel=cancel)
    search = Search(
        planner,
        seed=seed,
        generations=generations,
        time_limit_s=time_limit_s,
        target_fitness=target_fitness,
        population=population,
        fallback=fallback,
        **options,
    )
    stop = Stop(cancel)
    if isinstance(problem, MissionProblem):
        return plan_mission(problem, search, progress=progress, stop=stop)
    return search.run(evaluator_of(problem), progress=progress, stop=stop)


def plan_together(
    problems: Sequence[Problem],
    planner: str = "fpa-2opt",
    *,
    seeds: Sequence[int] | None = None,
    generations: int | None = None,
    time_limit_s: float | None = None,
    target_fitness: float | None = None,
    population: int | None = None,
    cancel: Callable[[], bool] | None = None,
    fallback: str = "astar",
    **options: Any,
) -> list[Plan]:
    """Plan several problems at once on an NVIDIA GPU; print and write nothing.

    A GPU that plans one problem is mostly idle; a few dozen problems take little longer. Without a
    time limit, which applies to all together, each plan is the one that :func:`plan` with
    ``engine="gpu"`` returns. A problem may be given several times with different seeds.

    Parameters
    ----------
    problems : sequence of Problem
        One or more, over the same terrain or several. All their maps and populations must fit into
        the GPU's memory.
    planner : str
        ``fpa`` or ``fpa-2opt``.
    seeds : sequence of int, optional
        The seed of each problem, 0 to 2**64 - 1; 0 by default.
    generations, time_limit_s, target_fitness, population, cancel, fallback, **options
        Options of each plan, as for :func:`plan`.

    Returns
    -------
    list of Plan
        Plans in the order of the problems. The times of each plan cover all problems together.

    Raises
    ------
    InputError
        If there is no GPU, the planner does not run on one, a value is out of range or a problem
        cannot be planned.
    JobError
        If the GPU fails before it has a path, or has too little memory.
    """
    require_functions(cancel=cancel)
    if not isinstance(problems, Sequence) or not all(
        isinstance(problem, Problem) for problem in problems
    ):
        raise InputError("The problems must be a list of problems, each of one leg.")
    if "seed" in options:
        raise InputError("Problems planned together have a seed each; give seeds, not seed.")
    if not problems:
        raise InputError("There is no problem to plan; give one or more.")
    seeds = [0] * len(problems) if seeds is None else list(seeds)
    if len(seeds) != len(problems):
        raise InputError(
            f"There are {len(problems)} problems and {len(seeds)} seeds; give as many seeds."
        )
    search = Search(
        planner,
        generations=generations,
        time_limit_s=time_limit_s,
        target_fitness=target_fitness,
        population=population,
        fallback=fallback,
        **{"engine": "gpu", **options},
    )
    evaluators = {id(problem): evaluator_of(problem) for problem in problems}
    return search.run_together(
        [evaluators[id(problem)] for problem in problems], seeds, Stop(cancel)
    )
