"""Walk of a segment over the lattice of corners, and score of a path.

The score has the cost of a path, and everything except the ground that makes it unflyable. Lengths
are in units of 2**-8 of the longer side of a cell, altitudes in sixteenths of a step. Every root is
rounded down, except for the roots of lengths in the cost, which are rounded to nearest; otherwise
cutting a path into more pieces would shorten it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import isqrt

import numpy as np
import numpy.typing as npt

from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    EXCESS_BITS,
    MAX_HALF_TURN,
    POSITION_FRACTION,
    RISE_FRACTION,
    SCALE_FRACTION,
    SHARE_BITS,
    SHARPEST_BITS,
    SLOPE_FRACTION,
    STEEP,
    TURN_FRACTION,
    ProblemRecord,
    turn_table,
)


__all__ = [
    "Arc",
    "Corner",
    "Ground",
    "Point",
    "Score",
    "corner_of",
    "passed",
    "piece_cost",
    "scaled",
    "score",
    "walk",
]


#: Highest cells around each corner, [y, x].
Ground = npt.NDArray[np.uint16]
Corner = tuple[int, int]
#: Corner and altitude step.
Point = tuple[int, int, int]


def walk(ground: Ground, blocked: int, start: Point, stop: Point) -> tuple[int, int]:
    """Return the number of colliding corners of a segment, and its minimum margin.

    A corner collides if the segment is below its ground, or if it is blocked. The margin is the
    altitude above the ground, in steps; it ignores blocked corners, and is ``blocked`` if all
    corners are.
    """
    hits, margin = 0, blocked
    for x, y, altitude in passed(start, stop):
        height = int(ground[y, x])
        if height == blocked:
            hits += 1
            continue
        hits += altitude < height
        margin = min(margin, altitude - height)
    return hits, margin


def passed(start: Point, stop: Point) -> Iterator[tuple[int, int, int]]:
    """Yield the corners of a segment and its lowest altitude within half a step of each.

    The altitude is rounded down, and never below the lower end of the segment.
    """
    (x, y, z), (dx, dy, dz) = start, (b - a for a, b in zip(start, stop, strict=True))
    n = max(abs(dx), abs(dy))
    if n == 0:
        yield x, y, min(z, z + dz)
        return
    for k in range(n + 1):
        across, along = (2 * k * dx + n) // (2 * n), (2 * k * dy + n) // (2 * n)
        lowest = (2 * n * z + 2 * k * dz - abs(dz)) // (2 * n)
        yield x + across, y + along, max(lowest, min(z, z + dz))


#: A length of one cell: the chords of arcs with longer tangents are walked, and an arc that is too
#: steep counts at least this length.
CELL = 1 << POSITION_FRACTION
#: Tangent of half a turn from which no arc is possible, and the tangent length that stands for it.
_SHARPEST = 1 << SHARPEST_BITS
_INFINITE = 1 << 24
_HALF_SHARE = 1 << SHARE_BITS - 1
_TURNS = turn_table()


@dataclass(frozen=True)
class Arc:
    """An arc that fits.

    Attributes
    ----------
    tangent : int
        Length from the waypoint to either end of the arc.
    before, after : int
        Altitudes where the arc begins and ends.
    rise : int
        Their difference with 16 more bits, for the slope, because a short arc only rises by a few
        parts.
    chord : (Point, Point) or None
        The ends on the nearest corners, at whole steps below; None for a tangent of a cell or less.
    """

    tangent: int
    before: int
    after: int
    rise: int
    chord: tuple[Point, Point] | None


@dataclass(frozen=True)
class Score:
    """Score of a path.

    Attributes
    ----------
    cost : int
        Cost before its shift to a value.
    penalty : int
        For each segment that is too steep, a quarter of a cell plus 4 units per part of excess
        altitude; for each point whose arc does not fit, an eighth of the path's length; for each
        arc that is too steep, its length, but at least a cell.
    arcs : list of Arc or None
        One for each waypoint, for the start if there is an entry, and for the goal if there is an
        exit; None if the arc does not fit.
    """

    cost: int
    penalty: int
    arcs: list[Arc | None]


def corner_of(record: ProblemRecord, end: str) -> Point:
    """Return the corner nearest to an end, such as ``"start"``, and the step at or below it."""
    x, y, altitude = (getattr(record, f"{end}_{name}") for name in ("x", "y", "altitude"))
    half = CELL // 2
    return (
        min(x + half >> POSITION_FRACTION, record.x_limit),
        min(y + half >> POSITION_FRACTION, record.y_limit),
        altitude >> ALTITUDE_FRACTION,
    )


def scaled(difference: int, scale: int) -> int:
    """Return a difference of positions in units of length, rounding halves away from 0."""
    size = abs(difference) * scale + (1 << SCALE_FRACTION - 1) >> SCALE_FRACTION
    return -size if difference < 0 else size


def piece_cost(record: ProblemRecord, before: int, after: int, length: int) -> int:
    """Return the cost of a straight piece or an arc between two altitudes.

    The cost is altitude times length, plus fuel if the engine must pull.
    """
    pull = record.drag * length + record.rise * (after - before)
    fuel = max(pull, 0) * record.fuel >> record.fuel_shift
    return (before + after + record.base) * length + fuel


def score(record: ProblemRecord, path: Sequence[Point]) -> Score:
    """Return the score of ``path``: two or more points, including the corners of start and goal.

    The entry and the exit, if the record has them, count as points before and after them.
    """
    path, places, altitudes = _extended(record, path)
    sides = [
        (scaled(b[0] - a[0], record.x_scale), scaled(b[1] - a[1], record.y_scale))
        for a, b in itertools.pairwise(places)
    ]
    lengths = [isqrt(dx * dx + dy * dy) for dx, dy in sides]
    rises = [b - a for a, b in itertools.pairwise(altitudes)]
    excesses = [_excess(record, length, rise) for length, rise in zip(lengths, rises, strict=True)]
    steep = sum(
        STEEP + (excess >> SLOPE_FRACTION - EXCESS_BITS) for excess in excesses if excess > 0
    )

    turns = [
        _half_turn(sides[i], sides[i + 1], lengths[i], lengths[i + 1])
        for i in range(len(sides) - 1)
    ]
    tangents = [0, *(_tangent(record, turn) for turn in turns), 0]
    arcs: list[Arc | None] = []
    for i, tangent in enumerate(tangents[1:-1], 1):
        fits = (
            tangents[i - 1] + tangent <= lengths[i - 1] and tangent + tangents[i + 1] <= lengths[i]
        )
        arcs.append(_arc(path, altitudes, rises, lengths, i, tangent) if fits else None)

    cost = 0
    for i, arc in enumerate(arcs):
        if arc is None or arc.tangent == 0:
            continue
        length = record.radius * _turn(turns[i]) >> TURN_FRACTION
        if _excess(record, length << SHARE_BITS, arc.rise) > 0:
            steep += max(length, CELL)
        flown = _flown(record, length, arc.after - arc.before)
        cost += piece_cost(record, arc.before, arc.after, flown)
    for i, length in enumerate(lengths):
        first = arcs[i - 1] if i else None
        last = arcs[i] if i < len(arcs) else None
        before = altitudes[i] if first is None else first.after
        after = altitudes[i + 1] if last is None else last.before
        straight = length - sum(arc.tangent for arc in (first, last) if arc is not None)
        flown = _flown(record, straight, after - before)
        cost += piece_cost(record, before, after, flown)
    penalty = steep + (arcs.count(None) * sum(lengths) >> 3)
    return Score(cost, penalty, arcs)


def _extended(
    record: ProblemRecord, path: Sequence[Point]
) -> tuple[list[Point], list[tuple[int, int]], list[int]]:
    """Return the corners of entry, path and exit, with their places and altitudes in the score."""
    before, behind = ["entry"] * record.has_entry, ["exit"] * record.has_exit
    first, last = ([corner_of(record, end) for end in ends] for ends in (before, behind))
    points = [*first, *path, *last]
    places = [(x << POSITION_FRACTION, y << POSITION_FRACTION) for x, y, _ in points]
    altitudes = [z << ALTITUDE_FRACTION for _, _, z in points]
    ends = (
        *enumerate([*before, "start"]),
        *enumerate(["goal", *behind], -1 - len(behind)),
    )
    for i, end in ends:
        x, y, altitudes[i] = (getattr(record, f"{end}_{name}") for name in ("x", "y", "altitude"))
        places[i] = x, y
    return points, places, altitudes


def _excess(record: ProblemRecord, length: int, rise: int) -> int:
    """Return the excess of a rise over its limit, in parts with SLOPE_FRACTION fraction bits."""
    limit = record.climb if rise > 0 else record.descent
    return (abs(rise) << SLOPE_FRACTION) - limit * length


def _half_turn(
    before: tuple[int, int], after: tuple[int, int], length_before: int, length_after: int
) -> int | None:
    """Return the tangent of half the turn between two segments, rounded up; None if 16 or more."""
    cross = abs(before[0] * after[1] - before[1] * after[0])
    along = length_before * length_after + before[0] * after[0] + before[1] * after[1]
    if along <= 0 or cross >= _SHARPEST * along:
        return None
    return (cross << TURN_FRACTION) // along + 1 if cross else 0


def _tangent(record: ProblemRecord, turn: int | None) -> int:
    if turn is None:
        return _INFINITE
    return record.radius * turn + (1 << TURN_FRACTION) - 1 >> TURN_FRACTION


def _turn(half: int | None) -> int:
    """Return the turn for the tangent of its half, in radians rounded down, from the table."""
    assert half is not None
    half = min(half, MAX_HALF_TURN << TURN_FRACTION)
    at, rest = half >> 6, half & 63
    return _TURNS[at] + ((_TURNS[at + 1] - _TURNS[at]) * rest >> 6)


def _arc(
    path: Sequence[Point],
    altitudes: Sequence[int],
    rises: Sequence[int],
    lengths: Sequence[int],
    i: int,
    tangent: int,
) -> Arc:
    """Return the arc at point ``i``, whose tangent fits in both segments."""
    if tangent == 0:
        return Arc(0, altitudes[i], altitudes[i], 0, None)
    back, on = ((tangent << SHARE_BITS) // length for length in lengths[i - 1 : i + 1])
    fall, rise = rises[i - 1] * back, rises[i] * on
    before = altitudes[i] - (fall >> SHARE_BITS)
    after = altitudes[i] + (rise >> SHARE_BITS)
    chord = None
    if tangent > CELL:
        ends = []
        for other, share, altitude in ((i - 1, back, before), (i + 1, on, after)):
            x, y = (
                at + ((to - at) * share + _HALF_SHARE >> SHARE_BITS)
                for at, to in zip(path[i][:2], path[other][:2], strict=True)
            )
            ends.append((x, y, altitude >> ALTITUDE_FRACTION))
        chord = ends[0], ends[1]
    return Arc(tangent, before, after, fall + rise, chord)


def _flown(record: ProblemRecord, length: int, rise: int) -> int:
    """Return the length of a piece in three dimensions, rounded to nearest."""
    up = rise * record.rise >> RISE_FRACTION
    return isqrt(4 * (length * length + up * up)) + 1 >> 1
