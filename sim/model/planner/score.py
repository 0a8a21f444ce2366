"""Compiled score of a path: :func:`pathgene.sim.model.planner.definition.score.score`.

Every signed number fits into 64 bits. For the largest configuration (map of 4096 cells, 16 bits of
altitude, 64 waypoints) and the maximum value of every field: a segment is shorter than 2**21 and
rises by less than 2**20 parts or 2**24 units, so its flown length is below 2**25, and four times
its square, the greatest radicand, below 2**52. The dividend of a half turn has 54 bits. The
segments of a path with their arcs, from an entry to an exit, sum up to less than 1.2 * 67 * 2**24,
their climbs to less than 34 * 2**20 parts: the pulls to less than 2**47, the fuel to less than
2**63.
"""

from __future__ import annotations

import math

import numpy as np

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
    turn_table,
)
from pathgene.sim.model.compiled import compiled, inlined
from pathgene.sim.model.planner.course import (
    BASE,
    CLIMB,
    DESCENT,
    DRAG,
    ENTRY_X,
    EXIT_X,
    FUEL,
    FUEL_SHIFT,
    GOAL_X,
    HAS_ENTRY,
    HAS_EXIT,
    RADIUS,
    START_X,
    X_LIMIT,
    X_SCALE,
    Y_LIMIT,
    Y_SCALE,
)
from pathgene.sim.model.planner.course import RISE as RISE_FIELD
from pathgene.sim.model.planner.walk import Integers


__all__ = [
    "CELL",
    "FROM_STEP",
    "FROM_X",
    "FROM_Y",
    "HAS_CHORD",
    "TO_STEP",
    "TO_X",
    "TO_Y",
    "WORK_ROWS",
    "scaled",
    "score",
]

#: Rows of the work space of :func:`score`; a column is a point or the segment that begins there.
#: Corner; x, y and altitude in the score; sides, length and rise of the segment; tangent of half
#: the turn; tangent length; the same if it fits, otherwise 0; its shares of the segments before and
#: after; altitudes at the ends of the arc; its length.
(
    _CORNER_X, _CORNER_Y, _X, _Y, _ALTITUDE, _DX, _DY, _LENGTH, _RISE, _HALF_TURN, _TANGENT, _USED,
    _BACK, _ON, _BEFORE, _AFTER, _ARC,
) = range(17)  # fmt: skip
#: The ends of the chord at a point, x, y and step each, and 1 where there is a chord.
FROM_X, FROM_Y, FROM_STEP, TO_X, TO_Y, TO_STEP, HAS_CHORD = range(_ARC + 1, _ARC + 8)
WORK_ROWS = HAS_CHORD + 1

CELL = 1 << POSITION_FRACTION
_SHARPEST = 1 << SHARPEST_BITS
_INFINITE = 1 << 24
_HALF_SHARE = 1 << SHARE_BITS - 1
_HALF_SCALE = 1 << SCALE_FRACTION - 1
_ALMOST_ONE = (1 << TURN_FRACTION) - 1
_TURNS = np.array(turn_table(), dtype=np.int64)


@inlined
def scaled(difference: int, scale: int) -> int:
    """Return a difference of positions in units of length, rounding halves away from 0."""
    # A negative number shifted by 63 bits is -1.
    return difference * scale + _HALF_SCALE + (difference >> 63) >> SCALE_FRACTION


@inlined
def _root(square: int) -> int:
    """Return the square root of ``square``, 0..2**52 - 1, rounded down.

    See :func:`pathgene.sim.model.planner.wavefront.root`.
    """
    return int(math.sqrt(square))


@compiled
def score(
    problem: Integers, path: Integers, points: int, work: Integers, first: bool
) -> tuple[int, int]:
    """Return cost and penalty of the first ``points`` rows x, y, step, ... of ``path``.

    With ``first``, a path with a penalty has the cost 0, and its chords are not written. ``work``,
    (WORK_ROWS, n or more) int64, gets the chords of every other path; n is the number of its
    points, including the entry and the exit if the record has them.
    """
    last = _lay_out(problem, path, points, work)
    penalty = _measure_segments(problem, last, work) + _measure_arcs(problem, last, work)
    if first and penalty > 0:
        return 0, penalty
    _lay_chords(last, work)
    return _price(problem, last, work), penalty


@compiled
def _lay_out(problem: Integers, path: Integers, points: int, work: Integers) -> int:
    """Write the corners and places of all points; return the column of the last one."""
    has_entry, has_exit = problem[HAS_ENTRY], problem[HAS_EXIT]
    for i in range(points):
        k = i + has_entry
        work[_CORNER_X, k], work[_CORNER_Y, k] = path[i, 0], path[i, 1]
        work[_X, k] = path[i, 0] << POSITION_FRACTION
        work[_Y, k] = path[i, 1] << POSITION_FRACTION
        work[_ALTITUDE, k] = path[i, 2] << ALTITUDE_FRACTION
    goal = points - 1 + has_entry
    last: int = goal + has_exit
    _put_end(problem, START_X, has_entry, work)
    _put_end(problem, GOAL_X, goal, work)
    if has_entry:
        _put_end(problem, ENTRY_X, 0, work)
        _put_corner(problem, 0, work)
    if has_exit:
        _put_end(problem, EXIT_X, last, work)
        _put_corner(problem, last, work)
    return last


@inlined
def _put_end(problem: Integers, field: int, k: int, work: Integers) -> None:
    """Write the place of an end, x, y and altitude, from the record, starting at a field."""
    work[_X, k], work[_Y, k] = problem[field], problem[field + 1]
    work[_ALTITUDE, k] = problem[field + 2]


@inlined
def _put_corner(problem: Integers, k: int, work: Integers) -> None:
    """Write the corner nearest to the place of a point."""
    half = CELL // 2
    work[_CORNER_X, k] = min(work[_X, k] + half >> POSITION_FRACTION, problem[X_LIMIT])
    work[_CORNER_Y, k] = min(work[_Y, k] + half >> POSITION_FRACTION, problem[Y_LIMIT])


@compiled
def _measure_segments(problem: Integers, last: int, work: Integers) -> int:
    """Write sides, lengths, rises, half turns and fitting tangents; return the penalty."""
    x_scale, y_scale, radius = problem[X_SCALE], problem[Y_SCALE], problem[RADIUS]
    climb, descent = problem[CLIMB], problem[DESCENT]
    steep = total = 0
    for k in range(last):
        dx = scaled(work[_X, k + 1] - work[_X, k], x_scale)
        dy = scaled(work[_Y, k + 1] - work[_Y, k], y_scale)
        length, rise = _root(dx * dx + dy * dy), work[_ALTITUDE, k + 1] - work[_ALTITUDE, k]
        work[_DX, k], work[_DY, k], work[_LENGTH, k], work[_RISE, k] = dx, dy, length, rise
        total += length
        excess = _excess(climb, descent, length, rise)
        steep += STEEP + (excess >> SLOPE_FRACTION - EXCESS_BITS) if excess > 0 else 0
    work[_TANGENT, 0] = work[_TANGENT, last] = 0
    for k in range(1, last):
        dx, dy, next_dx, next_dy = (
            work[_DX, k - 1], work[_DY, k - 1], work[_DX, k], work[_DY, k],
        )  # fmt: skip
        cross = abs(dx * next_dy - dy * next_dx)
        along = work[_LENGTH, k - 1] * work[_LENGTH, k] + dx * next_dx + dy * next_dy
        is_sharp = (along <= 0) | (cross >= _SHARPEST * along)
        # Neither is negative, but the compiler does not know that.
        half = int(np.uint64(cross << TURN_FRACTION) // np.uint64(max(along, 1))) + 1
        half = 0 if is_sharp | (cross == 0) else half
        work[_HALF_TURN, k] = half
        tangent = radius * half + _ALMOST_ONE >> TURN_FRACTION
        work[_TANGENT, k] = _INFINITE if is_sharp else tangent
    sharp = 0
    for k in range(1, last):
        before, tangent, after = (
            work[_TANGENT, k - 1], work[_TANGENT, k], work[_TANGENT, k + 1],
        )  # fmt: skip
        # The arcs at both ends of a segment leave it a length of 0 or more.
        fits = (before + tangent <= work[_LENGTH, k - 1]) & (tangent + after <= work[_LENGTH, k])
        sharp += 0 if fits else 1
        work[_USED, k] = tangent if fits else 0
    return steep + (sharp * total >> 3)


@compiled
def _measure_arcs(problem: Integers, last: int, work: Integers) -> int:
    """Write lengths of arcs, altitudes at their ends, and shares; return the penalty."""
    climb, descent, radius = problem[CLIMB], problem[DESCENT], problem[RADIUS]
    work[_USED, 0] = work[_USED, last] = 0
    for k in (0, last):
        work[_BEFORE, k] = work[_AFTER, k] = work[_ALTITUDE, k]
    penalty = 0
    for k in range(1, last):
        tangent = work[_USED, k]
        # The quotients are short enough that rounding them before truncation changes none.
        share = float(tangent << SHARE_BITS)
        back = int(share / max(work[_LENGTH, k - 1], 1))
        on = int(share / max(work[_LENGTH, k], 1))
        fall, rise = work[_RISE, k - 1] * back, work[_RISE, k] * on
        work[_BACK, k], work[_ON, k] = back, on
        work[_BEFORE, k] = work[_ALTITUDE, k] - (fall >> SHARE_BITS)
        work[_AFTER, k] = work[_ALTITUDE, k] + (rise >> SHARE_BITS)
        half = min(work[_HALF_TURN, k], MAX_HALF_TURN << TURN_FRACTION)
        entry = np.uint64(half >> 6)
        low, high = _TURNS[entry], _TURNS[entry + np.uint64(1)]
        length = radius * (low + ((high - low) * (half & 63) >> 6)) >> TURN_FRACTION
        work[_ARC, k] = length if tangent > 0 else 0
        excess = _excess(climb, descent, length << SHARE_BITS, fall + rise)
        # Without an arc nothing rises.
        penalty += max(length, CELL) if excess > 0 else 0
    return penalty


@compiled
def _lay_chords(last: int, work: Integers) -> None:
    """Write the chords of the arcs."""
    for k in range(1, last):
        x, y, back, on = work[_CORNER_X, k], work[_CORNER_Y, k], work[_BACK, k], work[_ON, k]
        work[FROM_X, k] = _toward(x, work[_CORNER_X, k - 1], back)
        work[FROM_Y, k] = _toward(y, work[_CORNER_Y, k - 1], back)
        work[FROM_STEP, k] = work[_BEFORE, k] >> ALTITUDE_FRACTION
        work[TO_X, k] = _toward(x, work[_CORNER_X, k + 1], on)
        work[TO_Y, k] = _toward(y, work[_CORNER_Y, k + 1], on)
        work[TO_STEP, k] = work[_AFTER, k] >> ALTITUDE_FRACTION
        work[HAS_CHORD, k] = 1 if work[_USED, k] > CELL else 0


@inlined
def _toward(at: int, other: int, share: int) -> int:
    """Return the coordinate of the corner nearest to a fraction of the way to another."""
    return at + ((other - at) * share + _HALF_SHARE >> SHARE_BITS)


@compiled
def _price(problem: Integers, last: int, work: Integers) -> int:
    """Return the cost of all straight pieces and arcs."""
    cost = 0
    for k in range(last):
        straight = work[_LENGTH, k] - work[_USED, k] - work[_USED, k + 1]
        cost += _piece_cost(problem, work[_AFTER, k], work[_BEFORE, k + 1], straight)
    for k in range(1, last):
        cost += _piece_cost(problem, work[_BEFORE, k], work[_AFTER, k], work[_ARC, k])
    return cost


@inlined
def _piece_cost(problem: Integers, before: int, after: int, length: int) -> int:
    """Return the cost of a straight piece or an arc between two altitudes."""
    flown = _flown(problem[RISE_FIELD], length, after - before)
    pull = problem[DRAG] * flown + problem[RISE_FIELD] * (after - before)
    fuel = max(pull, 0) * problem[FUEL] >> problem[FUEL_SHIFT]
    cost: int = (before + after + problem[BASE]) * flown + fuel
    return cost


@inlined
def _excess(climb: int, descent: int, length: int, rise: int) -> int:
    """Return the excess of a rise over its limit, in parts with SLOPE_FRACTION fraction bits."""
    limit = climb if rise > 0 else descent
    return (abs(rise) << SLOPE_FRACTION) - limit * length


@inlined
def _flown(weight: int, length: int, rise: int) -> int:
    """Return the length of a piece in three dimensions, rounded to nearest."""
    up = rise * weight >> RISE_FRACTION
    return _root(4 * (length * length + up * up)) + 1 >> 1
