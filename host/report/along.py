"""Facts along a track for picture and page: surface, lowest altitude, broken limits, reason."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator, Samples
from pathgene.host.evaluation.broken import Stretch
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.surface import Demand


__all__ = ["broken_limits", "broken_samples", "surface_and_demand", "why"]

Floats = NDArray[np.float64]

# Lines along which the corridor is sampled, as shares of its half width; the verdict covers the
# whole corridor.
_LINES = (-1.0, -0.5, 0.0, 0.5, 1.0)


def surface_and_demand(
    problem: Problem, samples: Samples, demand: Demand | None = None
) -> tuple[Floats, Floats, Floats]:
    """Return the surface below a track, the highest within the corridor, and the required altitude.

    Parameters
    ----------
    demand : Demand, optional
        The clearance that is required along the track; by default the demand of the problem.

    Returns
    -------
    tuple of ndarray
        The surface below; the highest surface within the corridor, along five lines; the lowest
        altitude that the rules allow. All (k,) float64 metres, NaN over a void; the last two are
        NaN where the corridor leaves the map, too. With ``as_paper`` the first two are the ground
        of the samples, and nothing is required: NaN.
    """
    if problem.rules is None:
        return samples.ground, samples.ground, np.full(len(samples.s), np.nan)
    from pathgene.host.terrain.surface import is_beyond, surface_below

    dx, dy = np.gradient(samples.x), np.gradient(samples.y)
    run = np.maximum(np.hypot(dx, dy), 1e-9)
    highest = np.full(len(samples.x), -np.inf)
    for share in _LINES:
        aside = share * problem.rules.corridor_m
        x, y = samples.x - aside * dy / run, samples.y + aside * dx / run
        beside = surface_below(problem.terrain, x, y)
        beside[is_beyond(problem.terrain, x, y) & (problem.rules.corridor_m > 0)] = np.inf
        highest = np.maximum(highest, beside)
    surface = surface_below(problem.terrain, samples.x, samples.y)
    required = (demand or problem.demand).required_m(samples.x, samples.y)
    return (
        np.where(np.isfinite(surface), surface, np.nan),
        np.where(np.isfinite(highest), highest, np.nan),
        np.where(np.isfinite(highest), highest + required, np.nan),
    )


def broken_samples(
    evaluator: Evaluator, samples: Samples, stretches: Sequence[Stretch]
) -> NDArray[np.bool_]:
    """Return which samples break a limit or, with ``as_paper``, are in ground, a void or a zone."""
    problem = evaluator.problem
    if not problem.as_paper:
        broken = np.zeros(len(samples.s), dtype=bool)
        for each in stretches:
            broken |= (samples.s >= each.from_m) & (samples.s <= each.to_m)
            middle = np.searchsorted(samples.s, 0.5 * (each.from_m + each.to_m))
            broken[min(int(middle), len(broken) - 1)] = True
        return broken
    zone = problem.nofly_raster[problem.terrain.nearest_nodes(samples.x, samples.y)]
    trouble: NDArray[np.bool_] = np.isnan(samples.ground) | (samples.clearance < 0) | zone
    return trouble


def broken_limits(evaluator: Evaluator, path: Floats, samples: Samples) -> list[Stretch]:
    """Return the stretches of a path that break a limit, with or without rules.

    With ``as_paper``, they are the runs of samples in the ground, a void or a zone, as one limit
    ``safety``.
    """
    if not evaluator.problem.as_paper:
        return evaluator.broken(path)
    broken = broken_samples(evaluator, samples, ())
    edges = np.flatnonzero(np.diff(np.concatenate(([False], broken, [False])).astype(np.int8)))
    return [
        Stretch("safety", float(samples.s[first]), float(samples.s[last - 1]))
        for first, last in edges.reshape(-1, 2).tolist()
    ]


def why(reason: Mapping[str, Any], limits: Sequence[Mapping[str, Any]] | None) -> str:
    """Return why a path is not feasible; empty for a given path with ``as_paper``.

    Parameters
    ----------
    reason : mapping
        The ``reason`` of a summary: why a planner found no path; empty for a given path.
    limits : sequence of mapping or None
        The ``limits`` of a summary, the closest to violation first; None with ``as_paper``.
    """
    if sentence := reason.get("sentence"):
        return f"No path: {sentence}"
    if not limits:
        return ""
    # Loads the kernels.
    from pathgene.host.diagnosis.reason import is_unknown
    from pathgene.host.evaluation.aircraft_limits import unit_of

    worst = limits[0]
    name, unit = worst["limit"], unit_of(worst["limit"])
    after = f"after {worst['at_m'] / 1000:.2f} km"
    if is_unknown(worst["worst"]):
        return f"Not feasible: {name} is unknown over a void, {after}"
    if name == "map":
        return f"Not feasible: the corridor leaves the map by {-worst['worst']:,.1f} m, {after}"
    return (
        f"Not feasible: {name} is {worst['worst']:,.1f} {unit}, "
        f"allowed {worst['allowed']:,.1f} {unit}, {after}"
    )
