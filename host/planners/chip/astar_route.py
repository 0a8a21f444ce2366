"""The routes of ``astar`` beside the chip's polished ones: the best one is reported."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluation
from pathgene.host.planners.base import Options, Result, Run
from pathgene.host.planners.choice import choose
from pathgene.host.planners.registry import PLANNERS


__all__ = ["Routes"]

Path = NDArray[np.float64]

_ASTAR = "astar"
# Time limit of the search where the import of SciPy has used the time up.
_LEAST_S = 1e-3


class Routes:
    """The best feasible paths of the chip and of ``astar`` in one plan.

    Parameters
    ----------
    run : Run
        The plan, whose candidates are the chip's until :meth:`add_astar`.
    """

    def __init__(self, run: Run) -> None:
        self._run = run
        self._chip: tuple[Path, Evaluation] | None = None
        self._astar: Evaluation | None = None
        # Paths that are the chip's, or were before they were refined.
        self._of_chip: list[Path] = []

    def add_astar(self) -> None:
        """Search with ``astar``, whose routes have as many waypoints as the chip's polished ones.

        If the route of ``astar`` is feasible, it becomes a candidate of the plan together with the
        routes over a finer grid (:func:`~pathgene.host.planners.grid.astar.fine_searches`).
        The time is the phase ``astar``.

        ``astar`` does not search after a stop criterion other than the generations has ended the
        chip's search, nor where the chip has no feasible path, except as paper: then the fallback
        decides. It has the rest of the time limit, and an interrupt ends its search, too.
        """
        run, problem = self._run, self._run.evaluator.problem
        with run.phase("choice"):
            self._chip = choose(run.evaluator, run.candidates)
            self._of_chip = [self._chip[0]]
        if self._is_stopped or not (self._chip[1].feasible or problem.as_paper):
            return
        # They load SciPy.
        from pathgene.host.planners.chip.polish import POLISHED_WAYPOINTS
        from pathgene.host.planners.grid.astar import AstarPlanner, fine_searches

        with run.phase("astar"):
            found = AstarPlanner().plan(run.evaluator, self._options(), stop=run.stop)
            run.evaluations += found.evaluations
            if not found.evaluation.feasible:
                return
            paths = [found.path]
            if not found.interrupted:
                finer = Run(run.evaluator, self._options(), stop=run.stop)
                for search in fine_searches(finer, POLISHED_WAYPOINTS):
                    paths += [path for _, path in search]
                    if finer.stopped_by() is not None:
                        break
                run.evaluations += finer.evaluations
        run.fitness(paths, strict=True)
        evaluations = [run.evaluator.evaluate(path) for path in paths]
        self._astar = max(
            (each for each in evaluations if each.feasible), key=lambda each: each.fitness
        )

    def refine(self) -> None:
        """Refine the best known path (:func:`~pathgene.host.planners.grid.refinement.refined`).

        The time is the phase ``refinement``. A path is not refined unless it is feasible and no
        stop criterion other than the generations has ended the search.
        """
        run = self._run
        with run.phase("choice"):
            path, evaluation = choose(run.evaluator, run.candidates)
        if self._is_stopped or not evaluation.feasible:
            return
        # It loads SciPy.
        from pathgene.host.planners.grid.refinement import refined

        better = refined(run, path, evaluation.fitness)
        if self._is_of_chip(path):
            self._of_chip += better

    @property
    def _is_stopped(self) -> bool:
        return self._run.stopped_by() not in (None, "generations") or self._run.out_of_time

    def _is_of_chip(self, path: Path) -> bool:
        return any(path.tobytes() == own.tobytes() for own in self._of_chip)

    def _options(self) -> Options:
        """Return the options of the search: astar's defaults, and the rest of the time limit."""
        remaining_s = self._run.remaining_s
        return Options(
            generations=PLANNERS[_ASTAR].generations,
            time_limit_s=None if remaining_s is None else max(remaining_s, _LEAST_S),
            target_fitness=self._run.options.target_fitness,
        )

    def describe(self, result: Result) -> dict[str, Any]:
        """Return the entries of ``hardware`` that say whose route a result has.

        ``route_from`` is ``chip`` or ``astar``, or None without a feasible path. ``routes`` has the
        fitness of the best feasible path of each before it is refined, or None.
        """
        _, chip = self._chip or (result.path, result.evaluation)
        is_chip = self._chip is None or self._is_of_chip(result.path)
        return {
            "route_from": ("chip" if is_chip else _ASTAR) if result.evaluation.feasible else None,
            "routes": {
                "chip": chip.fitness if chip.feasible else None,
                "astar": None if self._astar is None else self._astar.fitness,
            },
        }
