"""The yardstick of flights with replans: the best path of all planners, in no time."""

from __future__ import annotations

from typing import Any

from pathgene.host.device.chip import Chip
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planning import Search
from pathgene.host.problem.problem import Problem
from pathgene.host.replanning.planner import Attempt, InFlightPlanner, PlanningTime


__all__ = ["AMPLE_MS", "Yardstick"]

#: Chip time in milliseconds of a plan whose first run finds a path; up to eight first runs, each at
#: most a quarter of that time, search for one.
AMPLE_MS = 50


class Yardstick(InFlightPlanner):
    """Plans by the default with all its searches and fallbacks, whatever time they take.

    ``ga-chip`` with ample time also takes the better route of ``astar``; where it has no path,
    ``astar`` with its narrow searches and ``fpa-2opt`` follow. No planner of a campaign searches
    further, so a flight that the yardstick does not survive is not counted as one that can be
    survived. It is the same at every call, because it does not continue from its previous plan.

    Parameters
    ----------
    chip : Chip
        An open board with the planner core, which is never lost.
    seed : int
        Seed of the first plan.
    """

    def __init__(self, chip: Chip, *, seed: int = 0) -> None:
        super().__init__("astar", seed=seed, seconds=0.0)
        self._chip = chip

    def attempt(self, problem: Problem, number: int) -> Attempt:
        """Plan a changed problem; ``number`` counts the attempts since the change, from 0."""
        options: dict[str, Any] = {"board": self._chip, "chip_ms": AMPLE_MS}
        search = Search("ga-chip", seed=self.seed + number, fallback="astar", **options)
        try:
            plan = search.run(Evaluator(problem, threads=1))
        except InputError as error:
            # There may be a path from a different start.
            return Attempt(None, PlanningTime(), self.name, str(error))
        plan.finish()
        if not plan.evaluation.feasible:
            return Attempt(None, PlanningTime(), self.name, "No planner found a feasible path.")
        return Attempt(plan, PlanningTime(), self.name)
