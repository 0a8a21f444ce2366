"""Runs of the planners of *cheng* on the AUV problem, and their summaries."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from pathgene.host.auv import PLANNERS
from pathgene.host.auv.field import AuvField, Base, delta, whole_angle
from pathgene.host.errors import InputError
from pathgene.host.planners.routes.field import Route
from pathgene.host.planners.routes.point_sampler import KINDS, PointSampler
from pathgene.host.planners.routes.search import (
    ADDED_POINTS,
    ConventionalSearch,
    DeterministicSearch,
    Generation,
    Search,
)


__all__ = ["GENERATIONS", "REPORT_SAMPLES", "describe", "evolve", "history", "terms"]

#: Table II.
GENERATIONS = 100
#: Samples of a segment for the additional terms of a report, spaced as in the search.
REPORT_SAMPLES = 1001


def evolve(
    field: AuvField,
    planner: str,
    *,
    draws: str = KINDS[0],
    added: int = ADDED_POINTS,
    seed: int = 0,
) -> Iterator[Generation]:
    """Yield every generation, beginning with the first; the iterator never ends.

    Parameters
    ----------
    planner : str
        ``ga-dp`` or ``ga-auv``.
    draws : str
        See :class:`pathgene.host.planners.routes.point_sampler.PointSampler`.
    added : int
        Crossover points added per generation.
    seed : int
        0..2**64 - 1. It determines all random draws.

    Raises
    ------
    InputError
        If there is no such planner, or a parameter is outside its range.
    """
    kinds: dict[str, type[DeterministicSearch | ConventionalSearch]] = dict(
        zip(PLANNERS, (DeterministicSearch, ConventionalSearch), strict=True)
    )
    if planner not in kinds:
        raise InputError(
            f"The planner of the AUV problem must be one of {', '.join(kinds)}, not {planner!r}."
        )
    if not 0 <= seed < 1 << 64:
        raise InputError(f"The seed must be from 0 to 2**64 - 1, not {seed}.")
    search: Search = kinds[planner](
        field, PointSampler(Base(), draws), np.random.default_rng(seed), added=added
    )
    return (search.step() for _ in itertools.count())


def terms(field: AuvField, route: Route, samples: int | None = None) -> dict[str, float]:
    """Return delta of a whole route and its terms, with ``samples`` per segment if given."""
    whole = field.whole_terms(route, samples)
    length, turning, rate = whole.tolist()
    return {
        "delta": float(delta(whole)),
        "path_length": length,
        "elevation_rate": rate,
        "minimum_turn_deg": 180 * (1 - turning),
    }


def history(field: AuvField, routes: Sequence[Route]) -> list[list[float]]:
    """Return the number of each generation, counted from 1, and the terms of its route."""
    return [
        [generation, *terms(field, route).values()] for generation, route in enumerate(routes, 1)
    ]


def describe(field: AuvField, routes: Sequence[Route]) -> dict[str, Any]:
    """Return the summary of a run whose generations kept ``routes``, at least one.

    ``minimum_turn_deg`` is the minimum angle inside a segment, as in v2;
    ``minimum_turn_at_crossover_deg`` also counts the angles at crossover points. ``cost`` belongs
    to the reading. ``as_paper`` says that the samples are even in the spline's parameter,
    ``samples`` a segment; otherwise ``samples`` is null. ``segment_samples`` has the number of
    samples that the search read on each segment.
    """
    best = routes[-1]
    segments = best.segments
    _, points_of, _ = field.points(segments.control, segments.counts)
    return {
        "landscape": field.landscape,
        "reading": field.reading,
        "as_paper": field.samples is not None,
        "samples": field.samples,
        "segment_samples": points_of.tolist(),
        "length": "3d" if field.in_space else "2d",
        "cost": field.cost(best),
        **terms(field, best),
        "minimum_turn_at_crossover_deg": math.degrees(whole_angle(best)),
        f"at_{REPORT_SAMPLES}_samples": terms(field, best, REPORT_SAMPLES),
        "crossover_points": best.points.tolist(),
        "control_points": [
            control[:count].tolist()
            for control, count in zip(segments.control, segments.counts, strict=True)
        ],
        "history": history(field, routes),
    }
