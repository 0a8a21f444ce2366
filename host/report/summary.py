"""``summary.json``: everything about a run, in plain numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pathgene.host.evaluation import Evaluation, Evaluator
from pathgene.host.planners.base import Result
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import wholes
from pathgene.host.remarks import Reading
from pathgene.host.version import version


__all__ = [
    "describe_problem",
    "describe_reading",
    "describe_readings",
    "describe_run",
    "finite",
    "summarise",
    "terms",
    "version",
]

#: Phases that every summary has, even if they took 0 seconds.
_PHASES = ("total", "compiling", "evaluation", "sort", "link", "board")


def finite(value: Any) -> Any:
    """Return ``value`` with None for every number that JSON cannot express, also nested ones."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return value


def terms(evaluation: Evaluation) -> dict[str, Any]:
    """The terms of a path under the keys of a summary."""
    return {key: finite(value) for key, value in evaluation.to_dict().items()}


def describe_problem(evaluator: Evaluator, source: Mapping[str, Any]) -> dict[str, Any]:
    """Return the terrain, aircraft, zones, wind, sampling step and rules of a problem.

    Parameters
    ----------
    evaluator : Evaluator
        Holds the problem and the sampling step.
    source : mapping
        Origin of the terrain, added to its description.
    """
    problem = evaluator.problem
    return {
        "terrain": {**finite(problem.terrain.describe()), **source},
        "read": describe_reading(problem),
        "uav": problem.aircraft.to_dict(),
        "nofly": [zone.to_dict() for zone in wholes(problem.zones)],
        "wind": list(problem.wind),
        "ds_m": evaluator.ds_m,
        "as_paper": problem.as_paper,
        "rules": None if problem.rules is None else problem.rules.to_dict(),
        "start_heading_deg": problem.start_heading_deg,
        "goal_heading_deg": problem.goal_heading_deg,
    }


def describe_reading(problem: Problem) -> dict[str, Any]:
    """Return facts and remarks on the files of the terrain and of the zones."""
    return describe_readings(problem.terrain.reading, problem.zones_reading)


def describe_readings(terrain: Reading, zones: Reading) -> dict[str, Any]:
    """Return facts and remarks on a terrain and on zones, as in ``summary.json``."""
    return {"terrain": finite(terrain.to_dict()), "zones": finite(zones.to_dict())}


def describe_run(result: Result) -> dict[str, Any]:
    """Return the result and the record of a planner; every number is finite."""
    described = {
        **result.evaluation.to_dict(),
        "waypoints": result.path.tolist(),
        "generations": result.generations,
        "evaluations": result.evaluations,
        "cut_short": result.cut_short,
        "stopped_by": result.stopped_by,
        "interrupted": result.interrupted,
        "failure": result.failure,
        "seconds": dict.fromkeys(_PHASES, 0.0) | result.seconds,
        "hardware": result.hardware,
        "history": result.history,
        "history_evaluations": result.history_evaluations,
    }
    return {key: finite(value) for key, value in described.items()}


def summarise(
    evaluator: Evaluator,
    result: Result,
    *,
    planner: str,
    board: str | None,
    seed: int,
    source: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the summary of a run; every number in it is finite.

    Parameters
    ----------
    board : str or None
        URL of the board, if the planner used one.
    """
    return {
        "pathgene": version(),
        "planner": planner,
        "board": board,
        "seed": seed,
        **describe_problem(evaluator, source),
        **describe_run(result),
    }
