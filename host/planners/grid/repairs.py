"""Repair of a path that breaks the strict rule: a new route at an end, or new altitudes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator


__all__ = ["load_repairs", "repair"]

Path = NDArray[np.float64]

# A limit broken within this many turn radii of an end suggests that the route there is at fault.
_NEAR_RADII = 2.0
_SLOPES = {"climb", "descent"}


def repair(evaluator: Evaluator, path: Path) -> Path | None:
    """Return an infeasible path repaired in the most promising way, or None if that fails.

    A path that meets a zone or has no room for a turn gets a new route at the nearer end, or else
    at the farther one: the shortest of :func:`~pathgene.host.planners.grid.detours.detours` that is
    feasible. The same applies to a path that breaks limits only within two turn radii of an end, or
    is only too steep from there on. Any other path, and every path with ``as_paper``, gets the
    cheapest altitudes at its waypoints, which may still break a limit.
    """
    if evaluator.problem.rules is None:
        evaluation = evaluator.evaluate(path)
        is_blocked = evaluation.impossible_arcs or evaluation.distance_in_nofly_m
        return None if is_blocked else _lowest(evaluator, path)
    stretches = evaluator.broken(path)
    if not stretches:
        return None
    length_m = evaluator.track(path).length_m
    near_m = _NEAR_RADII * evaluator.problem.limits.turn_radius_m
    begins_m = min(stretch.from_m for stretch in stretches)
    ends_m = max(stretch.to_m for stretch in stretches)
    limits = {stretch.limit for stretch in stretches}
    is_blocked = any(limit == "turn" or limit.startswith("zone ") for limit in limits)
    is_near = ends_m < near_m or begins_m > length_m - near_m
    # A longer route is less steep.
    is_steep = limits <= _SLOPES and (begins_m < near_m or ends_m > length_m - near_m)
    if not (is_blocked or is_near or is_steep):
        return _lowest(evaluator, path)
    at_goal = stretches[0].from_m + stretches[0].to_m > length_m
    return _detoured(evaluator, path, at_goal=at_goal)


def load_repairs(evaluator: Evaluator, path: Path) -> None:
    """Load the solver and the kernels, whose first use is slow.

    This repairs a path of the problem whose waypoints were moved below the ground.
    """
    from pathgene.host.planners.grid.detours import load_ways

    load_ways()
    sunk = np.insert(path, 1, path[:2].mean(axis=0), axis=0)
    sunk[1:-1, 2] = evaluator.problem.terrain.lowest - 1.0
    if evaluator.problem.rules is not None:
        evaluator.broken(sunk)
        _detoured(evaluator, sunk, at_goal=False)
    _lowest(evaluator, sunk)


def _detoured(evaluator: Evaluator, path: Path, *, at_goal: bool) -> Path | None:
    from pathgene.host.planners.grid.detours import detours

    for end in (at_goal, not at_goal):
        paths, lengths = detours(evaluator.problem, path, at_goal=end)
        found = evaluator.first_feasible(paths, lengths)
        if found is not None:
            # A copy, because a view would keep all of them in memory.
            return paths[found, : lengths[found]].copy()
    return None


def _lowest(evaluator: Evaluator, path: Path) -> Path | None:
    # They load HiGHS.
    from pathgene.host.planners.grid.altitudes import lowest_altitudes
    from pathgene.host.planners.grid.grid_search import Prices

    problem = evaluator.problem
    return lowest_altitudes(problem, Prices(problem), path[:, :2])
