"""Plan UAV paths over terrain, with a genetic algorithm that runs on an FPGA or on the PC.

A plan in five statements:

>>> from pathgene import Problem, Terrain, Zone, plan
>>> terrain = Terrain.load("canyon")
>>> problem = Problem(terrain, (300, 300, 60), (4700, 4600, 60), agl=True)
>>> best = plan(problem, seed=1, generations=30)
>>> best.evaluation.feasible
True

Lengths are metres, angles degrees, weights newtons. Positions are x to the east and y to the north
of the terrain's south-west node, altitudes are above the terrain's datum. Everything raised on
purpose is a :class:`PathgeneError`, whose message is one sentence for the user.

Importing this package is quick: numba, SciPy, matplotlib and rasterio are imported by what uses
them.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from host.errors import InputError, JobError, PathgeneError


if TYPE_CHECKING:
    from host.api import Terrain, check, planners
    from host.device.boards import open_board
    from host.device.chip import CheckReport, Chip, LinkMode, PathResult, Step
    from host.evaluation import Evaluation
    from host.flight.fly import fly
    from host.flight.report import FlightReport
    from host.mission.build import load_mission
    from host.mission.mission import Mission
    from host.mission.plan import plan, plan_together
    from host.planning import Plan
    from host.problem.aircraft import Aircraft
    from host.problem.problem import Problem
    from host.problem.rules import Rules
    from host.problem.zones import Zone

__all__ = [
    "Aircraft",
    "CheckReport",
    "Chip",
    "Evaluation",
    "FlightReport",
    "InputError",
    "JobError",
    "LinkMode",
    "Mission",
    "PathResult",
    "PathgeneError",
    "Plan",
    "Problem",
    "Rules",
    "Step",
    "Terrain",
    "Zone",
    "check",
    "fly",
    "load_mission",
    "open_board",
    "plan",
    "plan_together",
    "planners",
]

#: Module of each name that is imported when it is first used.
_HOMES = {
    "Aircraft": "host.problem.aircraft",
    "CheckReport": "host.device.chip",
    "Chip": "host.device.chip",
    "Evaluation": "host.evaluation",
    "FlightReport": "host.flight.report",
    "LinkMode": "host.device.chip",
    "PathResult": "host.device.chip",
    "Mission": "host.mission.mission",
    "Plan": "host.planning",
    "Problem": "host.problem.problem",
    "Rules": "host.problem.rules",
    "Step": "host.device.chip",
    "Terrain": "host.api",
    "Zone": "host.problem.zones",
    "check": "host.api",
    "fly": "host.flight.fly",
    "load_mission": "host.mission.build",
    "open_board": "host.device.boards",
    "plan": "host.mission.plan",
    "plan_together": "host.mission.plan",
    "planners": "host.api",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
