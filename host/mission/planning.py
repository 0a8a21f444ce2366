"""Planning of a mission: leg by leg, and then the path of all legs in one evaluation."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError, PathgeneError
from pathgene.host.evaluation import Evaluation, Evaluator
from pathgene.host.mission.legs import (
    JoinedEvaluator,
    Leg,
    MissionPlan,
    capitalised,
    reason_of_joint,
)
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.planners.base import Observer, Progress, Result, Stop
from pathgene.host.planning import Plan, Search
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem
from pathgene.host.stages import part


if TYPE_CHECKING:
    from pathgene.host.diagnosis import Reason

__all__ = ["plan_mission"]

# Number of waypoints of the previous leg that a leg is evaluated with, so that the arcs there have
# room.
_POINTS_BEFORE = 2
# A horizontal run below this has no heading.
_SHORTEST_RUN_M = 1e-6


def plan_mission(
    mission: MissionProblem,
    search: Search,
    *,
    progress: Progress | None = None,
    stop: Stop | None = None,
    source: Mapping[str, Any] | None = None,
    evaluator: Callable[..., Evaluator] = Evaluator,
) -> Plan:
    """Plan the legs of a mission in turn, each with the same search.

    A leg that has only an infeasible path is kept, and the next leg starts from its end. After a
    failure or an interrupt, the remaining legs are straight lines.

    A leg is searched together with the last two waypoints of the previous leg, so that the arc at
    the via point fits both legs, and on its own if that finds nothing. If the path of all legs is
    still infeasible, the legs at a via point are planned again: the first leg then arrives in the
    direction in which the second one leaves.

    Parameters
    ----------
    search : Search
        Planner and options; stop criteria count for each leg.
    progress : callable, optional
        Called after each generation with its number, counted over all legs.
    source : mapping, optional
        Origin of the terrain for the summary.

    Returns
    -------
    Plan
        A :class:`MissionPlan`, unless the mission has a single leg.

    Raises
    ------
    InputError, JobError
        If the first leg fails before it has a path.
    """
    if mission.legs == 1:
        return search.run(evaluator(mission.problem), progress=progress, stop=stop, source=source)
    with _one_board(search):
        legs = _plan_legs(mission, search, progress, stop, evaluator)
        whole = evaluator(mission.whole)
        evaluation = whole.evaluate(_joined(legs))
        are_done = all(leg.feasible and leg.failure is None for leg in legs)
        if not evaluation.feasible and are_done and not mission.whole.as_paper:
            legs, evaluation = _rejoined(mission, search, stop, evaluator, whole, legs, evaluation)
    plans = [leg.plan for leg in legs if leg.plan is not None]
    first = plans[0]
    return MissionPlan(
        whole,
        _combined(legs, evaluation),
        first.planner,
        first.board,
        first.seed,
        first.source if source is None else source,
        mission,
        tuple(legs),
        reason=_reason(legs, evaluation, search),
        fallback=next((plan.fallback for plan in plans if plan.fallback is not None), None),
    )


def _one_board(search: Search) -> AbstractContextManager[None]:
    """Return a context in which the board of all legs stays open."""
    if search.board is None:
        return nullcontext()
    # Loaded only with a planner that has a board.
    from pathgene.host.device.boards import kept_open

    return kept_open()


def _reason(legs: list[Leg], evaluation: Evaluation, search: Search) -> Reason | None:
    """Return why the first leg without a path has none, or that the legs do not join."""
    # Loaded only if a path is infeasible.
    from pathgene.host.diagnosis import Reason
    from pathgene.host.diagnosis.reason import broken_limit

    for leg in legs:
        if leg.plan is not None and leg.plan.reason is not None:
            return leg.plan.reason
    if evaluation.feasible or search.fallback is None or not all(leg.feasible for leg in legs):
        return None
    broken = broken_limit(evaluation.limits) or "is not feasible"
    return Reason(
        code="joint",
        sentence=f"Every leg has a feasible path, but the path of all legs {broken}; move a via "
        "point, or split the mission there.",
        proven=False,
    )


def _plan_legs(
    mission: MissionProblem,
    search: Search,
    progress: Progress | None,
    stop: Stop | None,
    evaluator: Callable[..., Evaluator],
) -> list[Leg]:
    legs: list[Leg] = []
    generations = 0
    ended = False
    for number in range(mission.legs):
        straight = np.array(mission.way[number : number + 2])
        name = mission.name_of(number)
        if ended:
            legs.append(Leg(name, straight))
            continue
        if stop is not None and not stop.requested:
            stop.heeded = False
        counted = _counted(progress, generations, legs)
        try:
            with part(name):
                leg = _plan_leg(mission, search, evaluator, legs, progress=counted, stop=stop)
        except (PathgeneError, KeyboardInterrupt) as error:
            # Without a first leg there is nothing to keep.
            if not legs:
                raise
            if isinstance(error, KeyboardInterrupt) and (stop is None or not stop.requested):
                raise
            legs.append(Leg(name, straight, failure=str(error) or "It was interrupted."))
            ended = True
            continue
        legs.append(leg)
        plan = leg.plan
        assert plan is not None
        ended = plan.interrupted or plan.failure is not None
        generations += plan.result.generations + 1
    return legs


def _plan_leg(
    mission: MissionProblem,
    search: Search,
    evaluator: Callable[..., Evaluator],
    before: Sequence[Leg],
    *,
    goal_heading_deg: float | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> Leg:
    """Plan the leg after the legs ``before``, together with the end of the last of these."""
    number = len(before)
    elapsed_s = sum(_seconds(leg.plan) for leg in before if leg.plan is not None)
    arrival_deg = (
        _heading_deg(mission.problem, before[-1].path[::-1], backwards=True) if before else None
    )
    problem = mission.leg(
        number,
        start_heading_deg=arrival_deg,
        goal_heading_deg=goal_heading_deg,
        elapsed_s=elapsed_s,
    )
    joints = {"start": mission.names[number]} if before else {}
    if goal_heading_deg is not None and number < mission.legs - 1:
        joints["goal"] = mission.names[number + 1]

    def run(own: Evaluator, progress: Progress | None = None) -> Plan:
        plan = search.run(own, progress=progress, stop=stop)
        if plan.reason is None:
            return plan
        return dataclasses.replace(plan, reason=reason_of_joint(plan.reason, joints))

    def leg(plan: Plan, joined: Evaluation | None = None) -> Leg:
        return Leg(mission.name_of(number), plan.path, plan, plan.failure, joined)

    alone = evaluator(problem)
    if not before or not before[-1].feasible:
        return leg(run(alone, progress))
    both = _joined_evaluator(mission, problem, before[-1].path, elapsed_s, alone)
    if both is None:
        return leg(run(alone, progress))
    plan = run(both, progress)
    if not (plan.evaluation.feasible or plan.interrupted or plan.failure):
        # A leg that is feasible on its own may still join the next one.
        single = run(alone)
        if single.evaluation.feasible:
            return leg(single)
    # The leg's own terms, for its report.
    result = dataclasses.replace(plan.result, evaluation=alone.evaluate(plan.path))
    return leg(dataclasses.replace(plan, evaluator=alone, result=result), plan.evaluation)


def _joined_evaluator(
    mission: MissionProblem,
    problem: Problem,
    before: NDArray[np.float64],
    elapsed_s: float,
    alone: Evaluator,
) -> JoinedEvaluator | None:
    """Return the evaluator of a leg together with the end of the path before it.

    None if costs have no reference, because a line there is a glide that burns no fuel.
    """
    ahead = before[max(0, len(before) - 1 - _POINTS_BEFORE) : -1]
    earlier = before[: len(before) - len(ahead)]
    aircraft = problem.aircraft
    run_m = float(np.linalg.norm(np.diff(before[-1 - len(ahead) :], axis=0), axis=1).sum())
    joined = mission.part(
        (*map(_point, ahead), problem.start, problem.goal),
        start_heading_deg=_heading_deg(problem, earlier[::-1], backwards=True)
        if len(earlier) > 1
        else None,
        goal_heading_deg=problem.goal_heading_deg,
        elapsed_s=max(0.0, elapsed_s - run_m / aircraft.cruise_speed_m_s),
    )
    options = {"ds_m": alone.ds_m, "threads": alone.threads}
    try:
        return JoinedEvaluator(problem, ahead, joined, **options)
    except InputError:
        return None


def _rejoined(
    mission: MissionProblem,
    search: Search,
    stop: Stop | None,
    evaluator: Callable[..., Evaluator],
    whole: Evaluator,
    legs: list[Leg],
    evaluation: Evaluation,
) -> tuple[list[Leg], Evaluation]:
    """Plan the legs at a via point again, so that the first arrives as the second leaves.

    Returns the better of the given and the new legs, and the terms of their path.
    """
    for number in range(mission.legs - 1):
        if evaluation.feasible or (stop is not None and stop.requested):
            break
        tried = list(legs)
        for again, heading_deg in (
            (number, _heading_deg(mission.problem, legs[number + 1].path)),
            (number + 1, None),
        ):
            tried[again] = _plan_leg(
                mission,
                search,
                evaluator,
                tried[:again],
                goal_heading_deg=heading_deg,
                stop=stop,
            )
            found = whole.evaluate(_joined(tried))
            if found.penalty < evaluation.penalty:
                legs, evaluation = list(tried), found
            if evaluation.feasible:
                break
    return legs, evaluation


def _joined(legs: list[Leg]) -> NDArray[np.float64]:
    """Return the path of all legs, each via point once."""
    return np.concatenate([legs[0].path, *(leg.path[1:] for leg in legs[1:])])


def _combined(legs: list[Leg], evaluation: Evaluation) -> Result:
    """Return the record of all legs as if they were one run."""
    results = [leg.plan.result for leg in legs if leg.plan is not None]
    history: list[list[float]] = []
    evaluations: list[int] = []
    seconds: dict[str, float] = {}
    for result in results:
        # Some planners do not record every generation.
        first = int(history[-1][0]) + 1 if history else 0
        done = evaluations[-1] if evaluations else 0
        history += [[first + row[0], *row[1:]] for row in result.history]
        evaluations += [done + count for count in result.history_evaluations]
        for phase, spent in result.seconds.items():
            seconds[phase] = seconds.get(phase, 0.0) + spent
    failed = [leg for leg in legs if leg.failure is not None]
    failure = f"{capitalised(failed[0].name)}: {failed[0].failure}" if failed else None
    interrupted = any(result.interrupted for result in results)
    stopped_by = results[-1].stopped_by
    if failed:
        stopped_by = "failure"
    return Result(
        _joined(legs),
        evaluation,
        history,
        sum(result.generations for result in results),
        sum(result.evaluations for result in results),
        "interrupt" if interrupted else stopped_by,
        None if interrupted else failure,
        seconds,
        None,
        [],
        evaluations,
        sum(result.cut_short for result in results),
    )


def _point(point: NDArray[np.float64]) -> Point:
    x, y, z = point.tolist()
    return x, y, z


def _counted(progress: Progress | None, before: int, legs: list[Leg]) -> Progress | None:
    """Return a progress callback that continues the generation count of the previous legs."""
    if progress is None:
        return None
    if isinstance(progress, Observer):
        return _LegObserver(progress, before, list(legs))
    return lambda generation, best, mean: progress(before + generation, best, mean)


@dataclass(frozen=True)
class _LegObserver:
    """Observer of a leg, which appends its paths to the paths of earlier legs."""

    observer: Observer
    before: int
    legs: list[Leg]

    def __call__(self, generation: int, best: float, mean: float) -> None:
        self.observer(self.before + generation, best, mean)

    def improved(self, path: NDArray[np.float64]) -> None:
        flown = [_joined(self.legs)[:-1]] if self.legs else []
        self.observer.improved(np.concatenate([*flown, path]))


def _heading_deg(
    problem: Problem, path: NDArray[np.float64], *, backwards: bool = False
) -> float | None:
    """Return the heading of the first segment of ``path`` that has one, degrees from true north.

    With ``backwards`` the path is given from its end, and flown towards its first point.
    """
    for start, stop in itertools.pairwise(path):
        east, north = (stop - start)[:2].tolist()
        if math.hypot(east, north) > _SHORTEST_RUN_M:
            heading_deg = problem.true_heading_deg(math.degrees(math.atan2(east, north)))
            return heading_deg % 360 - (180 if backwards else 0)
    return None


def _seconds(plan: Plan) -> float:
    """Return the flight time of a leg in seconds, without wind, as in the paper."""
    flown_s: float | None = getattr(plan.evaluation, "flight_time_s", None)
    if flown_s is not None:
        return flown_s
    return plan.evaluation.length_m / plan.evaluator.problem.aircraft.cruise_speed_m_s
