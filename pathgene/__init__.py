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

Importing this package is quick: numba, SciPy, matplotlib and rasterio are imported where they are
used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from pathgene.host.api import Terrain, check, planners
    from pathgene.host.device.boards import open_board
    from pathgene.host.device.chip import CheckReport, Chip, LinkMode, PathResult, Step
    from pathgene.host.errors import InputError, JobError, PathgeneError
    from pathgene.host.evaluation import Evaluation
    from pathgene.host.flight.fly import fly
    from pathgene.host.flight.report import FlightReport
    from pathgene.host.mission.build import load_problem
    from pathgene.host.mission.foreign.loaded import Mission
    from pathgene.host.mission.mission import MissionProblem
    from pathgene.host.mission.plan import plan, plan_together
    from pathgene.host.planning import Plan
    from pathgene.host.problem.aircraft import Aircraft
    from pathgene.host.problem.problem import Problem
    from pathgene.host.problem.rules import Rules
    from pathgene.host.problem.zones import Zone

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
    "MissionProblem",
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
    "load_problem",
    "open_board",
    "plan",
    "plan_together",
    "planners",
]

#: Module of each name, imported at the first use of the name: Ctrl-C in an import ends the command
#: without a traceback only once :mod:`pathgene.__main__` runs.
_HOMES = {
    "Aircraft": "pathgene.host.problem.aircraft",
    "CheckReport": "pathgene.host.device.chip",
    "Chip": "pathgene.host.device.chip",
    "Evaluation": "pathgene.host.evaluation",
    "FlightReport": "pathgene.host.flight.report",
    "InputError": "pathgene.host.errors",
    "JobError": "pathgene.host.errors",
    "LinkMode": "pathgene.host.device.chip",
    "PathResult": "pathgene.host.device.chip",
    "PathgeneError": "pathgene.host.errors",
    "Mission": "pathgene.host.mission.foreign.loaded",
    "MissionProblem": "pathgene.host.mission.mission",
    "Plan": "pathgene.host.planning",
    "Problem": "pathgene.host.problem.problem",
    "Rules": "pathgene.host.problem.rules",
    "Step": "pathgene.host.device.chip",
    "Terrain": "pathgene.host.api",
    "Zone": "pathgene.host.problem.zones",
    "check": "pathgene.host.api",
    "fly": "pathgene.host.flight.fly",
    "load_problem": "pathgene.host.mission.build",
    "open_board": "pathgene.host.device.boards",
    "plan": "pathgene.host.mission.plan",
    "plan_together": "pathgene.host.mission.plan",
    "planners": "pathgene.host.api",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*(name for name in globals() if name.startswith("__")), *__all__})
