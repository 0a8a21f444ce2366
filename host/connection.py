"""Connection of start and goal: a path found by a search, or the reason why there is none."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.diagnosis import Figure, Reason, diagnose
from pathgene.host.diagnosis.reason import broken_limit
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluation, Evaluator
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners.base import Options, Result, Stop
from pathgene.host.planners.timed import plan_in_time
from pathgene.host.problem.problem import Problem
from pathgene.host.stages import stage


__all__ = ["SEARCHERS", "Connection", "connect", "interrupted", "with_path_of"]

#: The planners that search, in order: first the quick one, then one that also finds ways out of
#: valleys. Each runs with its defaults and seed 0.
SEARCHERS = ("astar", "fpa-2opt")


@dataclass(frozen=True)
class Connection:
    """The answer to whether a problem has a path.

    Parameters
    ----------
    reason : Reason or None
        The reason why no feasible path is known; None if one is.
    result : Result or None
        The feasible path, or the best path that breaks a limit; None if no planner has searched.
    """

    reason: Reason | None
    result: Result | None = None
    planner: str | None = None


def connect(
    evaluator: Evaluator,
    *,
    searchers: Sequence[str] = SEARCHERS,
    best: Evaluation | None = None,
    stop: Stop | None = None,
) -> Connection:
    """Return a feasible path, or the reason why there is none.

    If the reason is proven, no planner searches.

    Parameters
    ----------
    searchers : sequence of str
        Names of planners; each one searches only if no earlier one has found a feasible path.
    best : Evaluation, optional
        Evaluation of the best path known, which breaks a limit.
    """
    reason = diagnose(evaluator.problem)
    if reason.proven:
        return Connection(reason)
    found = _searched(evaluator, searchers, stop)
    if found is not None:
        if found[1].evaluation.feasible:
            return Connection(None, found[1], found[0])
        best = best or found[1].evaluation
    planner, result = found or (None, None)
    reason = _by_headings(evaluator, stop) or _with_limit(reason, best)
    return Connection(reason, result, planner)


def with_path_of(result: Result, found: Result) -> Result:
    """Return the record of a run with the path of the fallback."""
    spent = found.seconds["total"]
    return dataclasses.replace(
        result,
        path=found.path,
        evaluation=found.evaluation,
        evaluations=result.evaluations + found.evaluations,
        seconds={
            **result.seconds,
            "fallback": spent,
            "total": result.seconds.get("total", 0.0) + spent,
        },
        archive=found.archive,
    )


def interrupted(result: Result) -> Result:
    """Return the record of a run that the user ended."""
    return dataclasses.replace(result, stopped_by="interrupt")


def _searched(
    evaluator: Evaluator, searchers: Sequence[str], stop: Stop | None
) -> tuple[str, Result] | None:
    """Return the first feasible path, or the best path, with its planner and the total work."""
    found: list[tuple[str, Result]] = []
    for name in searchers:
        if found and (found[-1][1].evaluation.feasible or (stop is not None and stop.requested)):
            break
        options = Options(generations=PLANNERS[name].generations)
        stage(f"searching with {name}")
        # A planner that draws in free cells refuses a problem without any.
        with contextlib.suppress(InputError):
            found.append((name, plan_in_time(make(name), evaluator, options, stop=stop)))
    if not found:
        return None
    name, result = max(found, key=lambda each: each[1].evaluation.fitness)
    results = [each for _, each in found]
    seconds = {**result.seconds, "total": sum(each.seconds["total"] for each in results)}
    evaluations = sum(each.evaluations for each in results)
    return name, dataclasses.replace(result, seconds=seconds, evaluations=evaluations)


def _by_headings(evaluator: Evaluator, stop: Stop | None) -> Reason | None:
    """Return the headings as the reason if a path exists without one or both of them."""
    problem = evaluator.problem
    fixed = {
        end: deg
        for end, deg in (
            ("start", problem.start_heading_deg),
            ("goal", problem.goal_heading_deg),
        )
        if deg is not None
    }
    # Single headings come first: the reason must not name a heading that a path can keep.
    for freed in itertools.chain.from_iterable(
        itertools.combinations(fixed, count) for count in range(1, len(fixed) + 1)
    ):
        if stop is not None and stop.requested:
            break
        free = Evaluator(_without_headings(problem, freed), threads=evaluator.threads)
        found = _searched(free, SEARCHERS, stop)
        if found is not None and found[1].evaluation.feasible:
            return _heading_reason(problem, fixed, freed, found[1].path)
    return None


def _without_headings(problem: Problem, freed: Collection[str]) -> Problem:
    return Problem(
        problem.terrain,
        problem.start,
        problem.goal,
        problem.aircraft,
        problem.zones,
        problem.wind,
        problem.ds_m,
        rules=problem.rules,
        start_heading_deg=None if "start" in freed else problem.start_heading_deg,
        goal_heading_deg=None if "goal" in freed else problem.goal_heading_deg,
    )


def _heading_reason(
    problem: Problem, fixed: Mapping[str, float], freed: Sequence[str], path: NDArray[np.float64]
) -> Reason:
    """Return headings as the reason; ``path`` has no fixed heading at the ``freed`` ends."""
    runs = {"start": path[1] - path[0], "goal": path[-1] - path[-2]}
    headings = []
    for end in freed:
        flown = problem.true_heading_deg(math.degrees(math.atan2(runs[end][0], runs[end][1])))
        headings.append((end, fixed[end], round(flown, 1) % 360))
    named = " and ".join(f"the {end} heading of {deg:g} degrees" for end, deg, _ in headings)
    heads = " and ".join(
        f"at the {end} it heads for {flown:g} degrees" for end, _, flown in headings
    )
    end, deg, flown = headings[0]
    return Reason(
        code="heading",
        sentence=f"No path was found with {named}, and there is one without: {heads}.",
        proven=False,
        place=getattr(problem, end)[:2],
        figure=Figure(f"{end}-heading", deg, flown, "deg"),
        end=end,
        headings=tuple(headings),
    )


def _with_limit(reason: Reason, best: Evaluation | None) -> Reason:
    """Return the reason with the limit that the best path breaks, if no other limit is known."""
    if reason.code != "not-found" or reason.zones or best is None:
        return reason
    broken = broken_limit(best.limits)
    if broken is None:
        return reason
    sentence = f"{reason.sentence.rstrip('.')}; the best path found {broken}."
    return dataclasses.replace(reason, sentence=sentence)
