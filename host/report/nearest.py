"""The place of a track that is nearest to a point.

A straight piece has a formula. So has an arc in the plane; its altitude moves the nearest place in
three dimensions, which is found by bisection, for all arcs at once, between the places where the
square of the distance changes from convex to concave. Two bounds from the plane exclude most arcs.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.geometry import Arc, Straight
from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.problem.ends import Point


__all__ = ["NearTrack", "Place"]

Floats = NDArray[np.float64]

# Halvings of an interval: the place is exact to the rounding of its angle.
_HALVINGS = 50


class Place(NamedTuple):
    """A place of a track, as seen from a point; the lesser of two places is nearer or earlier."""

    #: Distance from the point.
    distance_m: float
    #: Horizontal distance from the point.
    level_m: float
    #: Metres flown to the place.
    at_m: float


class NearTrack:
    """A track with the nearest place of each point."""

    def __init__(self, track: SmoothedTrack) -> None:
        lengths_m = [piece.length_m for piece in track.pieces]
        placed = list(zip(track.pieces, itertools.accumulate(lengths_m, initial=0.0), strict=False))
        self._lines = _Lines([(p, begin) for p, begin in placed if isinstance(p, Straight)])
        self._arcs = _Arcs([(p, begin) for p, begin in placed if isinstance(p, Arc)])
        self._found: dict[tuple[Point, int], Place] = {}

    def nearest(self, point: Point, axes: int = 3) -> Place:
        """Return the nearest place; with two ``axes``, the horizontally nearest one."""
        # A mission may visit a point many times.
        if (point, axes) not in self._found:
            best = self._lines.nearest(point, axes)
            self._found[point, axes] = min(best, self._arcs.nearest(point, axes, best.distance_m))
        return self._found[point, axes]


class _Lines:
    """The straight pieces of a track, each with the metres flown to it."""

    def __init__(self, placed: list[tuple[Straight, float]]) -> None:
        self._begins_m = np.array([begin for _, begin in placed])
        self._lengths_m = np.array([piece.length_m for piece, _ in placed])
        self._starts = np.array([piece.start for piece, _ in placed]).reshape(-1, 3)
        self._steps = np.array([piece.stop for piece, _ in placed]).reshape(-1, 3) - self._starts

    def nearest(self, point: Point, axes: int) -> Place:
        """Return the nearest place; its distances are infinite if there are no pieces."""
        steps, offsets = self._steps[:, :axes], point - self._starts
        square = (steps**2).sum(axis=1)
        along = (offsets[:, :axes] * steps).sum(axis=1) / np.where(square > 0, square, 1)
        part = np.clip(along, 0, 1)
        offsets -= part[:, None] * self._steps
        distance = np.linalg.norm(offsets[:, :axes], axis=1)
        level = np.hypot(offsets[:, 0], offsets[:, 1])
        return _least(distance, level, self._begins_m + part * self._lengths_m)


class _Arcs:
    """The arcs of a track, each with the metres flown to it.

    A place of an arc is an angle from its entry. Points are seen from the entry: ``ahead`` along
    the heading there, ``aside`` towards the centre of the turn, and ``up``.
    """

    def __init__(self, placed: list[tuple[Arc, float]]) -> None:
        arcs = [arc for arc, _ in placed]
        self._begins_m = np.array([begin for _, begin in placed])
        self._lengths_m = np.array([arc.length_m for arc in arcs])
        self._starts = np.array([arc.start for arc in arcs]).reshape(-1, 3)
        self._headings = np.array([arc.heading for arc in arcs]).reshape(-1, 2)
        self._radius_m = np.array([arc.radius_m for arc in arcs])
        turns = np.array([arc.turn_rad for arc in arcs])
        self._sides, self._turns = np.copysign(1.0, turns), np.abs(turns)
        self._climbs = np.array([arc.rise_m for arc in arcs]) / self._turns  # A radian.

    def nearest(self, point: Point, axes: int, limit_m: float) -> Place:
        """Return the nearest place if it is within ``limit_m``, else any place or none.

        The distances of no place are infinite.
        """
        offsets = point - self._starts
        (east, north), (x, y) = self._headings.T, offsets[:, :2].T
        seen = np.stack((x * east + y * north, self._sides * (y * east - x * north), offsets[:, 2]))
        arcs = np.arange(len(offsets))
        # In the plane: the direction of the point from the centre, or an end of the arc.
        level = np.arctan2(seen[0], self._radius_m - seen[1])
        inside = np.where(level < self._turns, np.maximum(level, 0), 0)
        places = np.stack((inside, np.zeros_like(level), self._turns))
        distances, levels = self._distances(arcs, seen, places, axes)
        if axes == 3:
            rises = self._climbs * self._turns
            beyond = np.maximum(np.minimum(rises, 0) - seen[2], seen[2] - np.maximum(rises, 0))
            bounds = np.hypot(levels.min(axis=0), np.maximum(beyond, 0))
            arcs = np.flatnonzero(bounds <= distances.min(initial=limit_m))
            places = self._solved(arcs, seen[:, arcs])
            distances, levels = self._distances(arcs, seen[:, arcs], places, axes)
        at_m = self._begins_m[arcs] + (places / self._turns[arcs] * self._lengths_m[arcs])
        return _least(distances.ravel(), levels.ravel(), at_m.ravel())

    def _distances(
        self, arcs: NDArray[np.intp], seen: Floats, places: Floats, axes: int
    ) -> tuple[Floats, Floats]:
        """Return distances and horizontal distances of some places, (k, n), of ``arcs`` (n,)."""
        radius_m = self._radius_m[arcs]
        ahead = radius_m * np.sin(places) - seen[0]
        # 1 - cos as 2 sin^2 keeps its digits on a short arc.
        aside = radius_m * 2 * np.sin(0.5 * places) ** 2 - seen[1]
        level = np.hypot(ahead, aside)
        if axes == 2:
            return level, level
        return np.hypot(level, self._climbs[arcs] * places - seen[2]), level

    def _solved(self, arcs: NDArray[np.intp], seen: Floats) -> Floats:
        """Return places (7, n), one of which is the nearest of each of ``arcs``."""
        radius_m, climbs, turns = self._radius_m[arcs], self._climbs[arcs], self._turns[arcs]
        ahead, aside, up = seen
        inward = radius_m - aside
        # The square of the distance is convex where the cosine of the angle from the direction of
        # the point is above this ratio.
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = -(climbs**2) / (radius_m * np.hypot(ahead, inward))
            opening = np.arccos(np.where(ratio > -1, ratio, -1))
        level = np.arctan2(ahead, inward)
        changes = np.stack((level - opening, level + opening)) % (2 * math.pi)
        ends = np.stack((np.zeros_like(turns), *np.minimum(changes, turns), turns))
        ends.sort(axis=0)
        low, high = ends[:-1], ends[1:]
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            slope = radius_m * (inward * np.sin(middle) - ahead * np.cos(middle))
            slope += climbs * (climbs * middle - up)
            low, high = np.where(slope > 0, low, middle), np.where(slope > 0, middle, high)
        return np.concatenate((ends, low))


def _least(distance_m: Floats, level_m: Floats, at_m: Floats) -> Place:
    if not len(distance_m):
        return Place(math.inf, math.inf, math.inf)
    best = np.lexsort((at_m, level_m, distance_m))[0]
    return Place(float(distance_m[best]), float(level_m[best]), float(at_m[best]))
