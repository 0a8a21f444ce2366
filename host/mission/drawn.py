"""The mission that an autopilot would get, for pictures and pages."""

from __future__ import annotations

from pathgene.host.errors import PathgeneError
from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.hand_over import USUAL, HandOver
from pathgene.host.planning import Plan
from pathgene.host.problem.problem import Problem
from pathgene.host.report.handed_over import HandedOver, handed_over


__all__ = ["drawn_mission", "mission_of_plan"]


def drawn_mission(
    problem: Problem, track: SmoothedTrack, wanted: HandOver = USUAL
) -> HandedOver | None:
    """Return the mission of a path, or None if it has none.

    A path has no mission on a map without a place on Earth, or where the export refuses it because
    the end has no room.
    """
    if problem.terrain.crs is None or problem.terrain.origin is None:
        return None
    try:
        return handed_over(flight_plan(problem, track, wanted=wanted), problem.terrain)
    except PathgeneError:
        return None


def mission_of_plan(plan: Plan, wanted: HandOver = USUAL) -> HandedOver | None:
    """Return the mission of a plan, or None if it has none or is not feasible."""
    if not plan.evaluation.feasible:
        return None
    return drawn_mission(plan.evaluator.problem, plan.evaluator.track(plan.path), wanted)
