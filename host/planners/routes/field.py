"""Crossover points, segments between them, and routes of segments: *cheng*, section IV.

A :class:`Field` is everything that the planners of that paper know about a problem: the terms of
segments and the fitness of routes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError


__all__ = [
    "FEWEST_CONTROL_POINTS",
    "GOAL",
    "MOST_CONTROL_POINTS",
    "MOST_POINTS",
    "READINGS",
    "START",
    "Field",
    "Graph",
    "Route",
    "Segments",
    "check_reading",
]

#: Maximum number of crossover points of a path, start and goal included (table II).
MOST_POINTS = 10
#: Control points of a segment, including its ends (our reading of table II).
FEWEST_CONTROL_POINTS, MOST_CONTROL_POINTS = 4, 10
#: Numbers of start and goal among the points of a graph.
START, GOAL = 0, 1
#: Cost of a route in the deterministic crossover: the cost of the whole route, or the sum of the
#: costs of its segments, as in equation (8). The field defines both.
READINGS = ("route", "sum")

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Segments:
    """B-splines between crossover points.

    Parameters
    ----------
    control : ndarray
        Control points, both ends included, (m, 10, d) float64; rows at ``counts`` and beyond are
        zero.
    counts : ndarray
        Number of control points of each segment, (m,) int64.
    terms : ndarray
        Terms of each segment, (m, t) float64; smaller is better, and the field defines them.
    """

    control: Floats
    counts: Ints
    terms: Floats

    def __len__(self) -> int:
        return len(self.counts)

    @staticmethod
    def joined(one: Segments, other: Segments) -> Segments:
        """Return the segments of ``one``, then the segments of ``other``."""
        return Segments(
            np.concatenate((one.control, other.control)),
            np.concatenate((one.counts, other.counts)),
            np.concatenate((one.terms, other.terms)),
        )

    def take(self, which: Sequence[int] | Ints) -> Segments:
        """Return the segments at some indices."""
        rows = np.asarray(which, dtype=np.int64)
        return Segments(self.control[rows], self.counts[rows], self.terms[rows])


@dataclass(frozen=True)
class Route:
    """A path: crossover points, each once, and the segments between them.

    Parameters
    ----------
    points : ndarray
        From the start to the goal, (k + 1, d) float64.
    segments : Segments
        The k segments in flying order.
    """

    points: Floats
    segments: Segments


@dataclass(frozen=True)
class Graph:
    """Every segment of a generation: the fitness matrix of section IV as a list.

    Start and goal are the points 0 and 1. No segment leads to the start, leaves the goal or has no
    displacement. A kept segment competes with new ones between the same points; a route takes the
    fittest.

    Parameters
    ----------
    points : ndarray
        Crossover points, (n, d) float64.
    tails, heads : ndarray
        Points that each segment leaves and reaches, (m,) int64.
    segments : Segments
        The segments, in the same order.
    """

    points: Floats
    tails: Ints
    heads: Ints
    segments: Segments

    def extended(self, tails: Ints, heads: Ints, segments: Segments) -> Graph:
        """Return the graph with further segments."""
        return Graph(
            self.points,
            np.concatenate((self.tails, tails)),
            np.concatenate((self.heads, heads)),
            Segments.joined(self.segments, segments),
        )

    def route(self, edges: Sequence[int] | Ints) -> Route:
        """Return the route along some segments, beginning with one that leaves the start."""
        order = np.asarray(edges, dtype=np.int64)
        at = np.concatenate(([START], self.heads[order]))
        return Route(self.points[at], self.segments.take(order))


class Field(Protocol):
    """A problem of the planners of section IV."""

    @property
    def ends(self) -> Floats:
        """Start and goal, (2, d) float64."""

    def measure(self, control: Floats, counts: Ints) -> Floats:
        """Return the terms of segments, (m, t), given control points (m, 10, d) and counts (m,)."""

    def costs(self, terms: Floats) -> Floats:
        """Return the costs of single segments with these terms, (m, t): (m,), smaller is better."""

    def best_routes(self, graph: Graph) -> list[Ints]:
        """Return the segments of the best route, or of a few candidates (crossover)."""

    def worth(self, routes: Sequence[Route]) -> Floats:
        """Return the fitness of whole routes, (m,) float64 above 0, larger is better."""


def check_reading(reading: str) -> None:
    """Raise :class:`InputError` if there is no such reading."""
    if reading not in READINGS:
        raise InputError(f"The reading must be one of {', '.join(READINGS)}, not {reading!r}.")
