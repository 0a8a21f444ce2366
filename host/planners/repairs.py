"""Repairs: what the host changes in a path of the chip that the strict rule refuses."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from host.evaluation import Evaluator


__all__ = ["load_repairs", "repairs"]

Path = NDArray[np.float64]

# What is broken within so many turn radii of start or goal may be the way there.
_NEAR_RADII = 2.0


def repairs(evaluator: Evaluator, path: Path) -> Iterator[Path | None]:
    """Yield variants of a path that may keep what the path breaks; None where one cannot be made.

    A path that meets a zone, has no room for a turn, or is too low just beside an end, gets
    another way there: the shortest of :func:`~host.planners.detours.detours` that is feasible. A
    path that is only too low or too steep gets the altitudes of least cost over its waypoints,
    which may break a limit yet.

    Parameters
    ----------
    evaluator : Evaluator
        Of the problem.
    path : (n, 3) float64, metres
        A path that is not feasible.
    """
    evaluation = evaluator.evaluate(path)
    is_beside = evaluation.impossible_arcs > 0 or evaluation.distance_in_nofly_m > 0
    stretches = evaluator.broken(path)
    if stretches:
        first, last = stretches[0], stretches[-1]
        length_m = evaluation.length_m
        near_m = _NEAR_RADII * evaluator.problem.limits.turn_radius_m
        if is_beside or last.to_m < near_m or first.from_m > length_m - near_m:
            nearer = first.from_m + first.to_m > length_m
            ways = (_detoured(evaluator, path, at_goal=end) for end in (nearer, not nearer))
            yield next((way for way in ways if way is not None), None)
    if not is_beside:
        yield _lowest(evaluator, path)


def load_repairs(evaluator: Evaluator, path: Path) -> None:
    """Load solver and kernels, which are slow at first, by repairs of any path."""
    _lowest(evaluator, path)
    if evaluator.problem.rules is not None:
        _detoured(evaluator, path, at_goal=False)


def _detoured(evaluator: Evaluator, path: Path, *, at_goal: bool) -> Path | None:
    from host.planners.detours import detours

    paths, lengths = detours(evaluator.problem, path, at_goal=at_goal)
    found = evaluator.first_feasible(paths, lengths)
    return None if found is None else paths[found, : lengths[found]]


def _lowest(evaluator: Evaluator, path: Path) -> Path | None:
    # They load SciPy.
    from host.planners.altitudes import lowest_altitudes
    from host.planners.grid_search import Prices

    problem = evaluator.problem
    return lowest_altitudes(problem, Prices(problem), path[:, :2])
