"""Sampler of crossover and control points: anywhere, as in *cheng*, or near the best route."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.planners.routes.field import (
    FEWEST_CONTROL_POINTS,
    MOST_CONTROL_POINTS,
    Floats,
    Ints,
    Route,
    Segments,
)
from pathgene.host.planners.routes.spline import sample


__all__ = ["KINDS", "PointSampler", "Space"]

#: ``uniform`` is the paper's.
KINDS = ("near", "uniform")

# Range of the spread of a near draw, as powers of ten with uniform exponent: a share of the
# segment's length for control points, a share of the space for crossover points.
_OFF_LINE = -2.0, -0.3
_OFF_ROUTE = -2.5, -0.5
_OFF_KEPT = -3.0, -0.5
_NEAR_SHARE = 0.75  # Share of new crossover points; the rest are drawn anywhere.
_ONE_POINT_SHARE = 0.5  # Share of variants in which one control point moves instead of all.
_COUNT_SHARE = 0.1  # Share of variants with a control point more or less.
_CURVE_SAMPLES = 101


class Space(Protocol):
    """The space of the points."""

    @property
    def low(self) -> Floats:
        """The lowest corner of its box, (d,)."""

    @property
    def high(self) -> Floats:
        """The highest corner of its box, (d,)."""

    def is_free(self, points: Floats) -> NDArray[np.bool_]:
        """Return which ``points``, (n, d), are free: (n,) bool."""

    def draw(self, rng: np.random.Generator, count: int) -> Floats:
        """Draw ``count`` free points anywhere, (count, d)."""


class PointSampler:
    """Draws the points that a generation adds.

    ``uniform``, as in the paper: crossover points and control points lie anywhere in the space.
    Nearly all such segments wander, and the search never matches a direct optimizer.

    ``near``: the control points of a segment lie around the straight line between its ends, three
    in four new crossover points lie around the kept route, and kept segments have variants. Every
    spread is drawn again, with all orders of magnitude equally likely, so no schedule has to reduce
    it.

    Parameters
    ----------
    kind : str
        ``near`` or ``uniform``.

    Attributes
    ----------
    near : bool
        True for ``near``.

    Raises
    ------
    InputError
        If ``kind`` is neither of these.
    """

    def __init__(self, space: Space, kind: str = KINDS[0]) -> None:
        if kind not in KINDS:
            raise InputError(f"The draws must be one of {', '.join(KINDS)}, not {kind!r}.")
        self._space = space
        self._side = space.high - space.low
        self.near = kind == "near"

    def points(self, rng: np.random.Generator, count: int, kept: Route | None) -> Floats:
        """Draw crossover points, (count, d); ``kept`` is None in the first generation."""
        points = self._space.draw(rng, count)
        if kept is None or not self.near:
            return points
        curves = sample(kept.segments.control, kept.segments.counts, _CURVE_SAMPLES)
        along = curves.reshape(-1, curves.shape[2])
        spread = 10 ** rng.uniform(*_OFF_ROUTE, (count, 1)) * self._side
        near = self._inside(
            along[rng.integers(len(along), size=count)] + spread * rng.standard_normal(points.shape)
        )
        taken = (rng.random(count) < _NEAR_SHARE) & self._space.is_free(near)
        points[taken] = near[taken]
        return points

    def segments(
        self, rng: np.random.Generator, tails: Floats, heads: Floats
    ) -> tuple[Floats, Ints]:
        """Draw a segment from each of ``tails`` to each of ``heads``, (m, d).

        Returns
        -------
        tuple
            Control points, (m, 10, d) float64 with zeros beyond the last one of a segment, and the
            number of each segment's control points, (m,) int64, uniform from 4 to 10.
        """
        m, dimensions = tails.shape
        counts = rng.integers(FEWEST_CONTROL_POINTS, MOST_CONTROL_POINTS, size=(m,), endpoint=True)
        shape = m, MOST_CONTROL_POINTS, dimensions
        if self.near:
            bridged = heads - tails
            part = np.arange(MOST_CONTROL_POINTS) / (counts[:, None] - 1)
            distance = np.sqrt(((bridged / self._side) ** 2).sum(axis=1))
            spread = 10 ** rng.uniform(*_OFF_LINE, m) * distance
            control = self._inside(
                tails[:, None]
                + part[:, :, None] * bridged[:, None]
                + spread[:, None, None] * self._side * rng.standard_normal(shape)
            )
        else:
            control = self._space.draw(rng, m * MOST_CONTROL_POINTS).reshape(shape)
        control[:, 0] = tails
        control[np.arange(m), counts - 1] = heads
        control[np.arange(MOST_CONTROL_POINTS) >= counts[:, None]] = 0.0
        return control, counts

    def variants(self, rng: np.random.Generator, segments: Segments) -> tuple[Floats, Ints]:
        """Draw a variant of each of some segments, with the same ends.

        Sometimes an inner control point is first added or removed; then one or all are moved.
        Control points and their numbers are returned as by :meth:`segments`.
        """
        m = len(segments)
        control, counts = _resized(rng, segments.control, segments.counts)
        place = np.arange(MOST_CONTROL_POINTS)
        inner = (place > 0) & (place < counts[:, None] - 1)
        one = 1 + rng.integers(counts - 2)
        alone = rng.random(m) < _ONE_POINT_SHARE
        moved = inner & ~(alone[:, None] & (place != one[:, None]))
        spread = 10 ** rng.uniform(*_OFF_KEPT, (m, 1, 1)) * self._side
        noisy = self._inside(control + spread * rng.standard_normal(control.shape))
        return np.where(moved[:, :, None], noisy, control), counts

    def _inside(self, points: Floats) -> Floats:
        clipped: Floats = np.clip(points, self._space.low, self._space.high)
        return clipped


def _resized(rng: np.random.Generator, control: Floats, counts: Ints) -> tuple[Floats, Ints]:
    """Add an inner control point halfway between two, or remove one, in some segments."""
    place = np.arange(MOST_CONTROL_POINTS)
    change = rng.choice((-1, 1), size=len(counts)) * (rng.random(len(counts)) < _COUNT_SHARE)
    resized = np.clip(counts + change, FEWEST_CONTROL_POINTS, MOST_CONTROL_POINTS)
    change = resized - counts
    at = 1 + rng.integers(counts - 2)  # Add before this point, or remove it.
    source = place - change[:, None] * (place >= at[:, None] + (change > 0)[:, None])
    source = np.minimum(source, MOST_CONTROL_POINTS - 1)
    moved = np.take_along_axis(control, source[:, :, None], axis=1)
    new = (change > 0)[:, None] & (place == at[:, None])
    halves = (np.roll(control, 1, axis=1) + control) / 2
    moved = np.where(new[:, :, None], halves, moved)
    moved[place >= resized[:, None]] = 0.0
    return moved, resized
