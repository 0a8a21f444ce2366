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
    from numpy.typing import ArrayLike

    from host.device.boards import open_board
    from host.device.chip import Chip
    from host.evaluation import Evaluation
    from host.planners import Entry
    from host.planning import Plan, plan
    from host.problem.aircraft import Aircraft
    from host.problem.problem import Problem
    from host.problem.zones import Zone
    from pathgene.terrain import Terrain

__all__ = [
    "Aircraft",
    "Chip",
    "Evaluation",
    "InputError",
    "JobError",
    "PathgeneError",
    "Plan",
    "Problem",
    "Terrain",
    "Zone",
    "check",
    "open_board",
    "plan",
    "planners",
]

#: Module of each name that is imported when it is first used.
_HOMES = {
    "Aircraft": "host.problem.aircraft",
    "Chip": "host.device.chip",
    "Evaluation": "host.evaluation",
    "Plan": "host.planning",
    "Problem": "host.problem.problem",
    "Terrain": "pathgene.terrain",
    "Zone": "host.problem.zones",
    "open_board": "host.device.boards",
    "plan": "host.planning",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def check(problem: Problem, path: ArrayLike) -> Evaluation:
    """Evaluate a path that is given.

    Parameters
    ----------
    problem : Problem
        Terrain, ends, aircraft, zones and wind.
    path : array_like
        Waypoints, (n, 3) metres, from the start to the goal of the problem, both included.

    Returns
    -------
    Evaluation
        Feasibility, fitness and every term of them.

    Raises
    ------
    InputError
        If the path has another shape or other ends than the problem, or a coordinate is not finite
        or too large.
    """
    from host.planning import check

    return check(problem, path).evaluation


def planners() -> dict[str, Entry]:
    """Return the planners by name, the default first.

    Each entry has a ``description``, the ``paper`` it is from, the most ``generations`` it runs by
    default, the names of the ``options`` that it alone has, and the ``engines`` it can run on.
    """
    from host.planners import PLANNERS

    return dict(PLANNERS)
