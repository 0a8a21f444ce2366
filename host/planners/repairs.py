"""Repairs of a path that breaks the strict rule: another way at an end, or other altitudes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from host.evaluation import Evaluator


__all__ = ["load_repairs", "repairs"]

Path = NDArray[np.float64]

# Limits broken within so many turn radii of an end point to the way there.
_NEAR_RADII = 2.0


def repairs(evaluator: Evaluator, path: Path) -> Iterator[Path | None]:
    """Yield the repairs of an infeasible path, the likeliest first; None for one that fails.

    A path that meets a zone, or has no room for a turn, gets another way at the nearer end, or else
    at the other: the shortest of :func:`~host.planners.detours.detours` that is feasible. Any other
    path also gets the altitudes of least cost over its waypoints, which may still break a limit;
    they come first unless all broken limits lie within two turn radii of an end. As paper, a path
    gets other altitudes only.

    Parameters
    ----------
    evaluator : Evaluator
        Of the problem.
    path : (n, 3) float64, metres
        A path that is not feasible; others have no repairs.
    """
    if evaluator.problem.rules is None:
        evaluation = evaluator.evaluate(path)
        if not evaluation.impossible_arcs and not evaluation.distance_in_nofly_m:
            yield _lowest(evaluator, path)
        return
    stretches = evaluator.broken(path)
    if not stretches:
        return
    # Other altitudes mend neither.
    is_blocked = any(
        stretch.limit == "turn" or stretch.limit.startswith("zone ") for stretch in stretches
    )
    length_m = evaluator.track(path).length_m
    near_m = _NEAR_RADII * evaluator.problem.limits.turn_radius_m
    begins_m = min(stretch.from_m for stretch in stretches)
    ends_m = max(stretch.to_m for stretch in stretches)
    is_near = ends_m < near_m or begins_m > length_m - near_m
    at_goal = stretches[0].from_m + stretches[0].to_m > length_m
    if is_blocked or is_near:
        yield _detoured(evaluator, path, at_goal=at_goal)
    if not is_blocked:
        yield _lowest(evaluator, path)
        if not is_near:
            yield _detoured(evaluator, path, at_goal=at_goal)


def load_repairs(evaluator: Evaluator, path: Path) -> None:
    """Load the solver and the kernels, which are slow at first.

    To do so, repair a path of the problem whose waypoints were moved below the ground.
    """
    from host.planners.detours import load_ways

    load_ways()
    sunk = np.insert(path, 1, path[:2].mean(axis=0), axis=0)
    sunk[1:-1, 2] = evaluator.problem.terrain.lowest - 1.0
    for _ in repairs(evaluator, sunk):
        pass


def _detoured(evaluator: Evaluator, path: Path, *, at_goal: bool) -> Path | None:
    from host.planners.detours import detours

    for end in (at_goal, not at_goal):
        paths, lengths = detours(evaluator.problem, path, at_goal=end)
        found = evaluator.first_feasible(paths, lengths)
        if found is not None:
            # Not a view, which would keep all of them.
            return paths[found, : lengths[found]].copy()
    return None


def _lowest(evaluator: Evaluator, path: Path) -> Path | None:
    # They load SciPy.
    from host.planners.altitudes import lowest_altitudes
    from host.planners.grid_search import Prices

    problem = evaluator.problem
    return lowest_altitudes(problem, Prices(problem), path[:, :2])
