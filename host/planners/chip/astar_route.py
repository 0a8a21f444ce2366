"""The routes of ``astar`` beside the chip's polished ones: the best one is reported."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluation
from pathgene.host.planners.base import Options, Result, Run
from pathgene.host.planners.choice import choose
from pathgene.host.planners.registry import PLANNERS
from pathgene.host.stages import stage


__all__ = ["Routes"]

Path = NDArray[np.float64]

_ASTAR = "astar"
# Time limit of the search where the import of HiGHS has used the time up.
_LEAST_S = 1e-3


class Routes:
    """The best feasible paths of the chip and of ``astar`` in one plan.

    Parameters
    ----------
    run : Run
        The plan, whose candidates are the chip's until :meth:`add`.
    """

    def __init__(self, run: Run) -> None:
        self._run = run
        self._chip: tuple[Path, Evaluation] | None = None
        self._astar: tuple[Path, Evaluation] | None = None
        # Paths of ``astar`` that are no candidates yet.
        self._found: list[Path] = []
        # Paths that are the chip's, or were before they were refined.
        self._of_chip: list[Path] = []

    @property
    def path(self) -> Path | None:
        """The best feasible path of ``astar``, or None."""
        return None if self._astar is None else self._astar[0]

    def search(self) -> None:
        """Search with ``astar``, whose routes have as many waypoints as the chip's polished ones.

        If its route is feasible, routes along tangents and over a finer grid follow
        (:func:`~pathgene.host.planners.grid.astar.fine_searches`). The time is the phase ``astar``.

        ``astar`` does not search after a stop criterion other than the generations has ended the
        chip's search. It has the rest of the time limit, and an interrupt ends its search, too.
        """
        run = self._run
        if self._is_stopped:
            return
        # They load HiGHS.
        from pathgene.host.planners.chip.polish import POLISHED_WAYPOINTS
        from pathgene.host.planners.grid.astar import AstarPlanner, fine_searches

        stage("searching with astar")
        with run.phase("astar"):
            found = AstarPlanner().plan(run.evaluator, self._options(), stop=run.stop)
            run.evaluations += found.evaluations
            if not found.evaluation.feasible:
                return
            self._found = [found.path]
            if not found.interrupted:
                finer = Run(run.evaluator, self._options(), stop=run.stop)
                for search in fine_searches(finer, POLISHED_WAYPOINTS):
                    self._found += [path for _, path in search]
                    if finer.stopped_by() is not None:
                        break
                run.evaluations += finer.evaluations
            evaluated = [(path, run.evaluator.evaluate(path)) for path in self._found]
            feasible = [each for each in evaluated if each[1].feasible]
            self._astar = max(feasible, key=lambda each: each[1].fitness)

    def add(self) -> None:
        """Make the paths of ``astar`` candidates of the plan, after the last run of the chip."""
        run = self._run
        with run.phase("choice"):
            self._chip = choose(run.evaluator, run.candidates)
            self._of_chip = [self._chip[0]]
        if self._found:
            run.fitness(self._found, strict=True)

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
        # It loads HiGHS.
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
                "astar": None if self._astar is None else self._astar[1].fitness,
            },
        }
