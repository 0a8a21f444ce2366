"""Further routes and the refinement of a path that a planner has found."""

from __future__ import annotations

import dataclasses

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options, Result, Run, Stop
from pathgene.host.planners.choice import choose
from pathgene.host.planners.grid.astar import DEFAULT_MAX_WAYPOINTS, fine_searches
from pathgene.host.planners.grid.refinement import refined


__all__ = ["improved"]


def improved(evaluator: Evaluator, found: Result, seed: int, stop: Stop | None = None) -> Result:
    """Return a result with the best of its path and further ones, as ``ga-chip`` makes them.

    :func:`~pathgene.host.planners.grid.astar.fine_searches` follow, and the best path is refined
    (:func:`~pathgene.host.planners.grid.refinement.refined`). An interrupt ends both, and the best
    path until then counts.

    Parameters
    ----------
    evaluator : Evaluator
        Evaluates paths of the problem.
    found : Result
        The result with a feasible path. Evaluations and seconds of the new one include its own.
    seed : int
        Determines the trials of the refinement.
    """
    run = Run(evaluator, Options(seed=seed), stop=stop)
    run.record(0, run.fitness([found.path], strict=True))
    with run.search():
        for _ in fine_searches(run, DEFAULT_MAX_WAYPOINTS):
            if run.stopped_by() is not None:
                break
        path, evaluation = choose(evaluator, run.candidates)
        if evaluation.feasible:
            refined(run, path, evaluation.fitness)
    best = run.result()
    is_better = best.evaluation.feasible and best.evaluation.fitness > found.evaluation.fitness
    return dataclasses.replace(
        found,
        path=best.path if is_better else found.path,
        evaluation=best.evaluation if is_better else found.evaluation,
        archive=best.archive if is_better else found.archive,
        evaluations=found.evaluations + best.evaluations,
        seconds={**found.seconds, "total": found.seconds["total"] + best.seconds["total"]},
    )
