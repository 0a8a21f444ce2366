"""Connection of start and goal: a path that a search finds, or the reason why there is none."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

from host.diagnosis import Figure, Reason, diagnose
from host.evaluation import Evaluation, Evaluator
from host.planners import PLANNERS, make
from host.planners.base import Options, Result, Stop
from host.problem.problem import Problem


__all__ = ["SEARCHERS", "Connection", "connect", "interrupted", "with_path_of"]

#: The planners that search, in order: the quick one, then one that finds ways out of valleys where
#: the other finds none. Each runs as by default, with seed 0.
SEARCHERS = ("astar", "fpa-2opt")

# Limits that a value must not be below; zones besides.
_LEAST = ("clearance", "turn", "stall")


@dataclass(frozen=True)
class Connection:
    """The answer to whether a problem has a path.

    Parameters
    ----------
    reason : Reason or None
        The reason why none is known; None if there is one.
    result : Result or None
        The path that was found, or the best of those that break a limit; None if nothing searched.
    planner : str or None
        The planner whose path it is.
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

    Where the reason is proven, nothing is searched.

    Parameters
    ----------
    evaluator : Evaluator
        Evaluates paths of the problem.
    searchers : sequence of str
        Names of planners; each searches if those before it have found no feasible path.
    best : Evaluation, optional
        Evaluation of the best path known so far, which breaks a limit.
    stop : Stop, optional
        Ends the search when requested.
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
    """Return the first feasible path, else the best one, with its planner; the work is of all."""
    found: list[tuple[str, Result]] = []
    for name in searchers:
        if found and (found[-1][1].evaluation.feasible or (stop is not None and stop.requested)):
            break
        options = Options(generations=PLANNERS[name].generations)
        found.append((name, make(name).plan(evaluator, options, stop=stop)))
    if not found:
        return None
    name, result = max(found, key=lambda each: each[1].evaluation.fitness)
    results = [each for _, each in found]
    seconds = {**result.seconds, "total": sum(each.seconds["total"] for each in results)}
    evaluations = sum(each.evaluations for each in results)
    return name, dataclasses.replace(result, seconds=seconds, evaluations=evaluations)


def _by_headings(evaluator: Evaluator, stop: Stop | None) -> Reason | None:
    """Return that the headings are the reason, if there is a path without them."""
    problem = evaluator.problem
    fixed = {
        end: heading
        for end, heading in (
            ("start", problem.start_heading_deg),
            ("goal", problem.goal_heading_deg),
        )
        if heading is not None
    }
    if not fixed:
        return None
    free = Problem(
        problem.terrain,
        problem.start,
        problem.goal,
        problem.aircraft,
        problem.zones,
        problem.wind,
        problem.ds_m,
        rules=problem.rules,
    )
    searched = _searched(Evaluator(free, threads=evaluator.threads), SEARCHERS, stop)
    if searched is None or not searched[1].evaluation.feasible:
        return None
    found = searched[1]
    headings = {"start": found.path[1] - found.path[0], "goal": found.path[-1] - found.path[-2]}
    named = " and ".join(f"the {end} heading of {deg:g} degrees" for end, deg in fixed.items())
    end = next(iter(fixed))
    flown = math.degrees(math.atan2(headings[end][0], headings[end][1])) % 360
    return Reason(
        code="heading",
        sentence=f"No path was found with {named}, and there is one without: at the {end} it heads "
        f"for {flown:.0f} degrees.",
        proven=False,
        place=getattr(problem, end)[:2],
        figure=Figure(f"{end}-heading", fixed[end], round(flown, 1), "deg"),
        end=end,
    )


def _with_limit(reason: Reason, best: Evaluation | None) -> Reason:
    """Return the reason with the limit that the best path breaks, where no other is known."""
    if reason.code != "not-found" or reason.zones or best is None or not best.limits:
        return reason
    limit = best.limits[0]
    name, worst, allowed = str(limit["limit"]), limit["worst"], limit["allowed"]
    least = name in _LEAST or name.startswith("zone ")
    if not (worst < allowed if least else worst > allowed):
        return reason
    return dataclasses.replace(
        reason,
        sentence=f"{reason.sentence.rstrip('.')}; the best path found breaks the limit {name}, "
        f"{worst:.3g} where {allowed:.3g} is allowed, {limit['at_m']:.0f} m from the start.",
    )
