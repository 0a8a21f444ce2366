"""The AUV problem of *cheng* as a field of its planners."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.auv.landscape import HALF_SIDE
from pathgene.host.auv.measures import Counts, Floats, least_angle, measure, seabed
from pathgene.host.errors import InputError
from pathgene.host.planners.routes.field import READINGS, Graph, Route, check_reading
from pathgene.host.planners.routes.fine_steps import fine_steps
from pathgene.host.planners.routes.programming import best_by_sum, best_by_whole, segments_of
from pathgene.host.planners.routes.spline import equal_steps, sample


__all__ = [
    "ENDS",
    "PAPER_SAMPLES",
    "STEP",
    "WEIGHTS",
    "AuvField",
    "Base",
    "control_polygon",
    "delta",
    "route_terms",
    "whole_angle",
]

#: Start and goal (section V).
ENDS = (-0.25, -0.50), (0.25, 0.50)
#: w1, w2 and w3 of equation (3) (table II).
WEIGHTS = 1.0, 2.0, 4.0
#: Longest step between two samples, along the path. At the landscapes' shortest wave, 0.083, the
#: rate over such a step is at most 0.6 % below the slope at its midpoint.
STEP = 0.005
#: Samples of a segment under ``--as-paper``, where the paper gives no number; see docs/papers.md.
PAPER_SAMPLES = 21

# A short segment must not hide its slopes between a few samples.
_FEWEST_STEPS = 20
# Largest angle between a step and the path at its ends, radians.
_BEND = 0.1

_FEWEST_SAMPLES, _MOST_SAMPLES = 2, 100_001


class Base:
    """The square under the landscape, which has no obstacles."""

    low = np.full(2, -HALF_SIDE)
    high = np.full(2, HALF_SIDE)

    def is_free(self, points: Floats) -> NDArray[np.bool_]:
        """Return which ``points``, (n, 2), are in the square: (n,) bool."""
        inside: NDArray[np.bool_] = np.all((points >= self.low) & (points <= self.high), axis=1)
        return inside

    def draw(self, rng: np.random.Generator, count: int) -> Floats:
        """Draw ``count`` uniformly distributed points, (count, 2)."""
        return rng.uniform(self.low, self.high, (count, 2))


class AuvField:
    """One of the two landscapes, between the paper's start and goal.

    The terms of a segment are v1, v2 and v3 of equations (4) to (6). Its cost delta is their
    weighted mean, equation (3).

    Parameters
    ----------
    landscape : int
        1 or 2.
    reading : str
        How a route's cost is read. ``route``: delta of the whole route; its v1 is the sum over the
        segments, its v2 and v3 are maxima over them, and the dynamic programming keeps every route
        that is not dominated in all three. ``sum``: the sum of the segments' deltas, equation (8)
        as printed.
    samples : int, optional
        Points of a segment at which the seabed is read, 2 to 100,001, at equal steps of the
        spline's parameter, as in the paper. By default the points are even in arc length, in at
        least 20 steps no longer than :data:`STEP`, and more where the path bends; v3 is then the
        greatest of the steps' rates and the slopes at the points, along the path.
    in_space : bool
        v1 is the length over the seabed rather than the horizontal length.

    Attributes
    ----------
    evaluations : int
        Number of segments measured, at the samples of the search.

    Raises
    ------
    InputError
        If a parameter is outside its range.
    """

    def __init__(
        self,
        landscape: int,
        *,
        reading: str = READINGS[0],
        samples: int | None = None,
        in_space: bool = False,
    ) -> None:
        check_reading(reading)
        if samples is not None and not _FEWEST_SAMPLES <= samples <= _MOST_SAMPLES:
            raise InputError(
                f"The samples of a segment must be from {_FEWEST_SAMPLES} to "
                f"{_MOST_SAMPLES}, not {samples}."
            )
        self.landscape = landscape
        self.reading = reading
        self.samples = samples
        self.in_space = in_space
        self.ends: Floats = np.array(ENDS)
        self.evaluations = 0
        self._seabed = seabed(landscape)

    def points(
        self, control: Floats, counts: Counts, samples: int | None = None
    ) -> tuple[Floats, Counts, Floats]:
        """Return the points at which the seabed is read.

        Parameters
        ----------
        control : ndarray
            Control points of segments, (m, 10, 2) float64.
        counts : ndarray
            Number of control points of each segment, (m,) int64.
        samples : int, optional
            Points of each segment, 2 or more, spaced as in the search: even in arc length, or in
            the parameter where the field has ``samples``. By default the points of the search.

        Returns
        -------
        tuple
            Points of all segments, one segment after another, (p, 2) float64; the number of points
            of each segment, (m,) int64; and the unit tangents of the segments at the points, (p,
            2), or (0, 2) if the rates come from the steps only.
        """
        if self.samples is not None:
            number = self.samples if samples is None else samples
            points = sample(control, counts, number)
        elif samples is not None:
            number = samples
            points = equal_steps(control, counts, number - 1)
        else:
            points, directions, points_of = fine_steps(control, counts, STEP, _FEWEST_STEPS, _BEND)
            return points, points_of, directions
        return points.reshape(-1, 2), np.full(len(counts), number), np.empty((0, 2))

    def measure(self, control: Floats, counts: Counts, samples: int | None = None) -> Floats:
        """Return v1, v2 and v3 of segments, (m, 3); parameters as for :meth:`points`."""
        if samples is None:
            self.evaluations += len(counts)
        points, points_of, directions = self.points(control, counts, samples)
        terms: Floats = measure(
            control, counts, points, points_of, directions, self._seabed, self.in_space
        )
        return terms

    def costs(self, terms: Floats) -> Floats:
        """Return delta of each segment, (m,)."""
        return delta(terms)

    def best_routes(self, graph: Graph) -> list[Counts]:
        """Return the segments of the cheapest route: the deterministic crossover."""
        points, terms = len(graph.points), graph.segments.terms
        if self.reading == "sum":
            routes, _ = best_by_sum(graph.tails, graph.heads, delta(terms), points, 1)
            return [segments_of(routes[0])]
        route, _ = best_by_whole(graph.tails, graph.heads, terms, np.array(WEIGHTS), points)
        return [segments_of(route)]

    def cost(self, route: Route) -> float:
        """Return the cost of a route under the chosen reading."""
        terms = route.segments.terms
        return float(delta(terms).sum() if self.reading == "sum" else delta(route_terms(terms)))

    def worth(self, routes: Sequence[Route]) -> Floats:
        """Return the fitness of routes, (m,): the inverse of their cost."""
        return np.array([1 / self.cost(route) for route in routes])

    def whole_terms(self, route: Route, samples: int | None = None) -> Floats:
        """Return v1, v2 and v3 of a whole route, (3,), with ``samples`` as for :meth:`measure`."""
        segments = route.segments
        return route_terms(
            segments.terms
            if samples is None
            else self.measure(segments.control, segments.counts, samples)
        )


def delta(terms: Floats) -> Floats:
    """Return equation (3): the cost of v1, v2 and v3, (..., 3)."""
    weights = np.array(WEIGHTS)
    mean: Floats = terms @ weights / weights.sum()
    return mean


def route_terms(terms: Floats) -> Floats:
    """Return v1, v2 and v3 of a route, (3,): the sum of v1 and the greatest v2 and v3."""
    return np.array((terms[:, 0].sum(), terms[:, 1].max(), terms[:, 2].max()))


def whole_angle(route: Route) -> float:
    """Return the minimum angle of the control polygon in radians, including crossover points.

    By its definition v2 leaves out the angles at crossover points.
    """
    polygon = control_polygon(route)
    angle: float = least_angle(polygon, len(polygon))
    return angle


def control_polygon(route: Route) -> Floats:
    """Return the control points of a route in order, each crossover point once, (n, 2)."""
    segments = route.segments
    inner = (
        control[1:count] for control, count in zip(segments.control, segments.counts, strict=True)
    )
    return np.concatenate([route.points[:1], *inner])
