"""Search among zones that are active at certain times, for every planner.

The map of a search does not know the time. The first search ignores the zones with times. The
strict rule then checks its path at the times of passage, and zones that the path enters while they
are active are always active in the next search, until a path passes.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Generator, Sequence

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options, Planner, Progress, Result, Stop
from pathgene.host.problem.zones import Zone


__all__ = ["plan_in_time", "plan_together_in_time"]

# Time limit of the last search where another problem has used the time up.
_LEAST_S = 1e-3

#: Plans several problems at once, each with its own options.
Together = Callable[[Sequence[Evaluator], Sequence[Options]], list[Result]]
# The searches of a problem: receives the result of each, and returns the final one.
_Searches = Generator[Evaluator, Result, Result]


def plan_in_time(
    planner: Planner,
    evaluator: Evaluator,
    options: Options,
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> Result:
    """Plan with a planner; a zone with times forbids flight only while it is active.

    The result is the record of the last search, with the seconds of all of them. If no path passes,
    it is the path of a search in which all zones with times are always active.

    Parameters
    ----------
    planner, evaluator, options, progress, stop
        See :class:`pathgene.host.planners.base.Planner`. ``options.time_limit_s`` applies to all
        searches together.

    Raises
    ------
    InputError, JobError
        As for the planner.
    """

    def alone(evaluators: Sequence[Evaluator], options: Sequence[Options]) -> list[Result]:
        return [planner.plan(evaluators[0], options[0], progress, stop)]

    return plan_together_in_time(alone, [evaluator], [options])[0]


def plan_together_in_time(
    plan: Together, evaluators: Sequence[Evaluator], options: Sequence[Options]
) -> list[Result]:
    """Plan several problems at once as :func:`plan_in_time` plans one.

    Problems that need another search are searched again together, without those that are done.

    Parameters
    ----------
    plan : callable
        Plans problems at once.
    evaluators, options : sequences
        One of each per problem. A time limit applies to all searches of all problems together.

    Raises
    ------
    InputError, JobError
        As for ``plan``.
    """
    limit_s = options[0].time_limit_s
    spent_s = 0.0
    searches = [_searches(evaluator, limit_s) for evaluator in evaluators]
    results: dict[int, Result] = {}
    waiting = {number: next(search) for number, search in enumerate(searches)}
    while waiting:
        found = plan(
            list(waiting.values()), [_remaining(options[number], spent_s) for number in waiting]
        )
        spent_s += max((result.seconds.get("total", 0.0) for result in found), default=0.0)
        for number, result in zip(list(waiting), found, strict=True):
            try:
                waiting[number] = searches[number].send(result)
            except StopIteration as end:
                results[number] = end.value
                del waiting[number]
    return [results[number] for number in range(len(searches))]


def _searches(evaluator: Evaluator, limit_s: float | None) -> _Searches:
    """Yield the evaluator of each search of a problem; return the result of the last."""
    timed = _timed(evaluator)
    blocked: tuple[Zone, ...] = ()
    spent: dict[str, float] = {}
    while timed and (blocked != timed or not spent):
        searched = _without_times(evaluator, timed, blocked)
        if searched is None:
            break
        result = yield searched
        spent = _summed(spent, result.seconds)
        judged = dataclasses.replace(
            result, evaluation=evaluator.evaluate(result.path), seconds=spent
        )
        known = {_whole(zone) for zone in (*blocked, *evaluator.entered(result.path))}
        more = tuple(zone for zone in timed if _whole(zone) in known)
        is_late = limit_s is not None and spent["total"] >= limit_s
        is_over = judged.interrupted or judged.failure is not None or is_late
        if judged.evaluation.feasible or more == blocked or is_over:
            return judged
        blocked = more
    result = yield evaluator
    return dataclasses.replace(result, seconds=_summed(spent, result.seconds))


def _timed(evaluator: Evaluator) -> tuple[Zone, ...]:
    """Return the zones that are active at certain times; none with ``as_paper``."""
    problem = evaluator.problem
    return () if problem.as_paper else tuple(filter(_has_times, problem.zones))


def _has_times(zone: Zone) -> bool:
    return zone.t0_s is not None or zone.t1_s is not None


def _whole(zone: Zone) -> int:
    """Return a key that the tiles of a zone over steep ground share."""
    return id(zone if zone.part_of is None else zone.part_of)


def _without_times(
    evaluator: Evaluator, timed: tuple[Zone, ...], blocked: tuple[Zone, ...]
) -> Evaluator | None:
    """Return the evaluator with zones always or never active; None if an end is in a zone."""
    always = set(map(id, blocked))
    zones = tuple(
        dataclasses.replace(zone, t0_s=None, t1_s=None) if id(zone) in always else zone
        for zone in evaluator.problem.zones
        if not _has_times(zone) or id(zone) in always
    )
    try:
        return evaluator.among(zones)
    except InputError:
        return None


def _remaining(options: Options, spent_s: float) -> Options:
    """Return the options of the next search."""
    if options.time_limit_s is None or not spent_s:
        return options
    left_s = max(options.time_limit_s - spent_s, _LEAST_S)
    return dataclasses.replace(options, time_limit_s=left_s)


def _summed(spent: dict[str, float], seconds: dict[str, float]) -> dict[str, float]:
    return {name: spent.get(name, 0.0) + seconds.get(name, 0.0) for name in {**spent, **seconds}}
