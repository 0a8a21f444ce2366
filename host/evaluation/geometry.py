"""Smoothing of a path of waypoints to an exact list of straight and arc pieces.

Plain Python, written from the definition; :mod:`pathgene.host.evaluation.kernels` does the same in
compiled code. Source: Roberge and Tarbouchi, section 3.1 (after Labonte); the pair rule that
decides which arcs are possible and the altitude along an arc are settled in the evaluation page of
the project.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.constants import COLLINEAR_RAD, TURN_AT_END_RAD


__all__ = ["Arc", "Heading", "Piece", "Smoothed", "Straight", "smooth"]

# A shorter run counts as 0, as in the kernels, where its square is 0: its slope would overflow.
_SHORTEST_RUN_M = 1e-160


@dataclass(frozen=True)
class Straight:
    """A straight piece.

    Parameters
    ----------
    start, stop : tuple of float
        End points x, y, z, metres.
    heading : tuple of float
        Horizontal unit direction x, y; (0, 0) when vertical.
    run_m : float
        Horizontal length.
    rise_m : float
        Altitude gained, negative when descending. Heading, run and rise belong to the
        segment: on the sliver that two arcs may leave, the end points differ only by rounding.
    """

    start: tuple[float, float, float]
    stop: tuple[float, float, float]
    heading: tuple[float, float]
    run_m: float
    rise_m: float

    @property
    def length_m(self) -> float:
        """Length in three dimensions, metres."""
        return math.hypot(self.run_m, self.rise_m)

    def points(self, fractions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the points at ``fractions`` (k,) of the length, 0 to 1: (k, 3) float64 metres."""
        start, stop = np.array(self.start), np.array(self.stop)
        points: NDArray[np.float64] = start + (stop - start) * fractions[:, None]
        return points

    def directions(self) -> Iterator[tuple[float, float, float]]:
        """Yield the horizontal unit direction x, y and the run in metres; nothing if vertical."""
        if self.run_m > 0:
            yield *self.heading, self.run_m


@dataclass(frozen=True)
class Arc:
    """A circular arc in the horizontal plane; altitude is linear in its length.

    Parameters
    ----------
    start : tuple of float
        Entry point x, y, z, metres.
    heading : tuple of float
        Horizontal unit direction at the entry, x, y.
    radius_m : float
        Radius of the turn.
    turn_rad : float
        Turn angle, positive to the left, -pi to pi.
    rise_m : float
        Altitude gained, negative when descending.
    """

    start: tuple[float, float, float]
    heading: tuple[float, float]
    radius_m: float
    turn_rad: float
    rise_m: float

    PARTS_IN_WIND = 8

    @property
    def run_m(self) -> float:
        """Horizontal length, metres."""
        return self.radius_m * abs(self.turn_rad)

    @property
    def length_m(self) -> float:
        """Length in three dimensions, metres."""
        return math.hypot(self.run_m, self.rise_m)

    def points(self, fractions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the points at ``fractions`` (k,) of the length, 0 to 1: (k, 3) float64 metres."""
        x, y, z = self.start
        east, north = self.heading
        side = math.copysign(1.0, self.turn_rad)
        angle = abs(self.turn_rad) * fractions
        # 1 - cos as 2 sin^2 keeps its digits on a short arc.
        ahead = self.radius_m * np.sin(angle)
        aside = side * self.radius_m * 2 * np.sin(0.5 * angle) ** 2
        return np.column_stack(
            (
                x + (ahead * east - aside * north),
                y + (ahead * north + aside * east),
                z + self.rise_m * fractions,
            )
        )

    def directions(self) -> Iterator[tuple[float, float, float]]:
        """Yield the mid directions x, y of eight equal parts and the run of a part in metres."""
        east, north = self.heading
        for part in range(self.PARTS_IN_WIND):
            angle = self.turn_rad * (part + 0.5) / self.PARTS_IN_WIND
            cos, sin = math.cos(angle), math.sin(angle)
            run = self.run_m / self.PARTS_IN_WIND
            yield east * cos - north * sin, east * sin + north * cos, run


Piece = Straight | Arc
Heading = tuple[float, float]


@dataclass(frozen=True)
class Smoothed:
    """A smoothed path: ``pieces`` in flying order, number of arcs, number that do not fit.

    Pieces of length 0 are left out. ``arcs`` is the number of interior waypoints.
    """

    pieces: tuple[Piece, ...]
    arcs: int
    impossible_arcs: int


def smooth(
    path: NDArray[np.float64],
    radius_m: float,
    headings: tuple[Heading | None, Heading | None] = (None, None),
) -> Smoothed:
    """Round the corners of ``path``, (n, 3) float64 metres as x, y, z with n >= 2.

    With a heading at the start or goal, the turn between it and the segment next to it is an arc
    like any other: the track begins before the start, or ends beyond the goal, by its tangent
    length. The turn must not exceed a right angle, and its tangent must fit into that segment. The
    lead-in and the lead-out are level.

    A waypoint whose turn is below 1e-12 rad has no arc: it is never impossible.
    A waypoint at either end of a segment without horizontal length, and one where the path
    reverses, needs an infinite tangent, so it and its neighbours with a turn keep their corners.
    """
    points = [(float(x), float(y), float(z)) for x, y, z in path]
    deltas = [tuple(b - a for a, b in zip(p, q, strict=True)) for p, q in pairwise(points)]
    runs = [_run(east, north) for east, north, _ in deltas]
    # The lead-in and the lead-out: level, and long enough for any turn.
    start, goal = ((*heading, 0.0) if heading else None for heading in headings)
    ways = [(start, math.inf), *zip(deltas, runs, strict=True), (goal, math.inf)]

    turns = [0.0] * len(points)  # Signed turn angle at each waypoint.
    tangents = [0.0] * len(points)  # Tangent length its arc needs; 0 at a free start or goal.
    for i, ((before, run_before), (after, run_after)) in enumerate(pairwise(ways)):
        if before is not None and after is not None:
            turns[i], tangents[i] = _turn(before, after, run_before, run_after, radius_m)
    beside = [0.0, *tangents, 0.0]
    possible = [
        tangent == 0
        or (
            beside[i] + tangent <= ways[i][1]
            and tangent + beside[i + 2] <= ways[i + 1][1]
            and (0 < i < len(points) - 1 or abs(turns[i]) <= TURN_AT_END_RAD)
        )
        for i, tangent in enumerate(tangents)
    ]
    used = [tangent if fits else 0.0 for tangent, fits in zip(tangents, possible, strict=True)]

    pieces: list[Piece] = []
    if used[0] > 0:
        assert start is not None
        x, y, z = points[0]
        entry = x - used[0] * start[0], y - used[0] * start[1], z
        climb = deltas[0][2] / runs[0]
        pieces.append(Arc(entry, start[:2], radius_m, turns[0], used[0] * climb))
    for i, (delta, run) in enumerate(zip(deltas, runs, strict=True)):
        straight = _shortened(points[i], points[i + 1], run, used[i], used[i + 1])
        if straight.length_m > 0:
            pieces.append(straight)
        if used[i + 1] > 0:
            climb = delta[2] / run
            if i + 2 < len(points):
                climb += deltas[i + 1][2] / runs[i + 1]
            pieces.append(
                Arc(
                    straight.stop,
                    (delta[0] / run, delta[1] / run),
                    radius_m,
                    turns[i + 1],
                    used[i + 1] * climb,
                )
            )
    arcs = len(points) - 2 + sum(heading is not None for heading in headings)
    return Smoothed(tuple(pieces), arcs, possible.count(False))


def _run(east: float, north: float) -> float:
    run = math.hypot(east, north)
    return run if run >= _SHORTEST_RUN_M else 0.0


def _turn(
    before: tuple[float, ...],
    after: tuple[float, ...],
    run_before: float,
    run_after: float,
    radius_m: float,
) -> tuple[float, float]:
    """Return the signed turn angle and tangent length of a waypoint between two segments."""
    if run_before == 0 or run_after == 0:
        return 0.0, math.inf
    cross = before[0] * after[1] - before[1] * after[0]
    dot = before[0] * after[0] + before[1] * after[1]
    angle = math.atan2(abs(cross), dot)
    if angle <= COLLINEAR_RAD:
        return 0.0, 0.0
    if cross == 0:
        return math.pi, math.inf
    return math.copysign(angle, cross), radius_m * math.tan(0.5 * angle)


def _shortened(
    start: tuple[float, float, float],
    stop: tuple[float, float, float],
    run: float,
    cut_start: float,
    cut_stop: float,
) -> Straight:
    """Return the segment from ``start`` to ``stop`` less a horizontal length at each end."""
    rise = stop[2] - start[2]
    if run == 0:
        return Straight(start, stop, (0.0, 0.0), 0.0, rise)
    left = max(run - cut_start - cut_stop, 0.0)
    east, north, climb = (stop[0] - start[0]) / run, (stop[1] - start[1]) / run, rise / run
    return Straight(
        (start[0] + east * cut_start, start[1] + north * cut_start, start[2] + climb * cut_start),
        (stop[0] - east * cut_stop, stop[1] - north * cut_stop, stop[2] - climb * cut_stop),
        (east, north),
        left,
        climb * left,
    )
