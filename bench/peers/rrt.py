"""The sampling-based planners of OMPL: free straight paths within given seconds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.jit import compiled
from pathgene.host.planners.airspace import Airspace


__all__ = ["PLANNERS", "solve"]

#: Names of the planners in ``ompl.geometric``.
PLANNERS = ("RRTConnect", "AORRTC", "RRTstar", "BITstar")

# Unit of length for OMPL, because AORRTC of OMPL 2.0.1 fails at costs in the thousands.
_UNIT_M = 1000.0
# Margin over the ground and around zones: the checker tests points, the evaluation whole segments.
_CLEARANCE_M = 5.0


@compiled
def _is_free(
    floor: NDArray[np.float64], dx: float, dy: float, x: float, y: float, z: float
) -> bool:
    """Return whether a point of the map is above its nearest node's ``floor``."""
    rows, columns = floor.shape
    row, column = min(int(y / dy + 0.5), rows - 1), min(int(x / dx + 0.5), columns - 1)
    return bool(z >= floor[row, column])


def solve(
    evaluator: Evaluator, planner: str, seed: int, seconds: float
) -> NDArray[np.float64] | None:
    """Return a path (n, 3), including start and goal, or None if none was found.

    The planner knows the airspace and minimizes the length; it does not know turns, climbs and
    fuel. OMPL simplifies the path found within the same seconds.
    """
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed + 1)  # 0 is not a valid seed.
    problem = evaluator.problem
    airspace = Airspace(problem)
    floor, dx, dy = airspace.floor, float(problem.terrain.dx_m), float(problem.terrain.dy_m)
    _is_free(floor, dx, dy, *problem.start)  # Compiles.
    space = base.RealVectorStateSpace(3)
    bounds = base.RealVectorBounds(3)
    for axis in range(3):
        bounds.setLow(axis, float(airspace.low[axis]) / _UNIT_M)
        bounds.setHigh(axis, float(airspace.high[axis]) / _UNIT_M)
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)

    def is_free(state: Sequence[float]) -> bool:
        x, y, z = (_UNIT_M * state[axis] for axis in range(3))
        return _is_free(floor, dx, dy, x, y, z - _CLEARANCE_M)

    setup.setStateValidityChecker(is_free)
    information = setup.getSpaceInformation()
    step = evaluator.ds_m / _UNIT_M / space.getMaximumExtent()
    information.setStateValidityCheckingResolution(step)
    ends = []
    for point in (problem.start, problem.goal):
        end = space.allocState()
        for axis in range(3):
            end[axis] = float(point[axis]) / _UNIT_M
        ends.append(end)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(getattr(geometric, planner)(information))
    setup.solve(seconds)
    if not setup.haveExactSolutionPath():
        return None
    left = seconds - setup.getLastPlanComputationTime()
    if left > 0:
        setup.simplifySolution(left)
    states = setup.getSolutionPath().getStates()
    return _UNIT_M * np.array([[state[axis] for axis in range(3)] for state in states])
