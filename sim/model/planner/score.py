"""Score of a path, compiled: :func:`sim.model.planner.definition.score.score`.

Greatest values, for the largest configuration (map of 4096 cells, 16 bits of altitude): positions
20 bits, lengths of segments 21 bits, products of sides 41 bits, so the dividend of a half turn has
54 bits and the sum of squares of a flown length, at most 2**42 + 2**40, times 4 stays below 2**45.
A flown length is below 2**22; an altitude's sum with the base below 2**26 and the pull, 2**38 +
2**36, times the fuel below 2**55. A path has at most 129 pieces: below 2**63.
"""

from __future__ import annotations

import numpy as np

from hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    MAX_HALF_TURN,
    POSITION_FRACTION,
    RISE_FRACTION,
    SCALE_FRACTION,
    SLOPE_FRACTION,
    TURN_FRACTION,
    turn_table,
)
from sim.model.planner.compiled import compiled
from sim.model.planner.problem import (
    BASE,
    CLIMB,
    DESCENT,
    DRAG,
    FUEL,
    FUEL_SHIFT,
    GOAL_ALTITUDE,
    GOAL_X,
    GOAL_Y,
    RADIUS,
    START_ALTITUDE,
    START_X,
    START_Y,
    X_SCALE,
    Y_SCALE,
)
from sim.model.planner.problem import RISE as RISE_FIELD
from sim.model.planner.root import root
from sim.model.planner.walk import Integers


__all__ = ["CELL", "CHORD", "WORK_ROWS", "piece_cost", "scaled", "score"]

#: Rows of the work space of :func:`score`; a column is a point, or the segment that begins there.
(
    _X,
    _Y,
    _ALTITUDE,
    _SIDE_X,
    _SIDE_Y,
    _RISE,
    _LENGTH,
    _HALF_TURN,
    _TANGENT,
    _USED,
    _BEFORE,
    _AFTER,
) = range(12)
#: First of six rows with the ends of the chord at a point, x, y and step each, and a row that is 1
#: where there is a chord.
CHORD = 12
WORK_ROWS = 19

CELL = 1 << POSITION_FRACTION
_SHARPEST = 16
_INFINITE = 1 << 24
_TURNS = np.array(turn_table(), dtype=np.int64)


@compiled
def scaled(difference: int, scale: int) -> int:
    """Return a difference of positions in units of length, halves away from 0."""
    size = abs(difference) * scale + (1 << SCALE_FRACTION - 1) >> SCALE_FRACTION
    return -size if difference < 0 else size


@compiled
def piece_cost(problem: Integers, before: int, after: int, length: int) -> int:
    """Return the cost of a straight piece or an arc between two altitudes."""
    pull: int = problem[DRAG] * length + problem[RISE_FIELD] * (after - before)
    cost: int = (before + after + problem[BASE]) * length
    if pull > 0:
        cost += pull * problem[FUEL] >> problem[FUEL_SHIFT]
    return cost


@compiled
def score(problem: Integers, path: Integers, points: int, work: Integers) -> tuple[int, int]:
    """Return cost and penalty of the first ``points`` rows x, y, step, ... of ``path``.

    ``work``, (WORK_ROWS, points or more) int64, gets the chords.
    """
    for k in range(points):
        work[_X, k] = path[k, 0] << POSITION_FRACTION
        work[_Y, k] = path[k, 1] << POSITION_FRACTION
        work[_ALTITUDE, k] = path[k, 2] << ALTITUDE_FRACTION
        work[_TANGENT, k] = work[_USED, k] = work[CHORD + 6, k] = 0
    last = points - 1
    work[_X, 0], work[_Y, 0] = problem[START_X], problem[START_Y]
    work[_ALTITUDE, 0] = problem[START_ALTITUDE]
    work[_X, last], work[_Y, last] = problem[GOAL_X], problem[GOAL_Y]
    work[_ALTITUDE, last] = problem[GOAL_ALTITUDE]

    steep = 0
    for k in range(last):
        dx = scaled(work[_X, k + 1] - work[_X, k], problem[X_SCALE])
        dy = scaled(work[_Y, k + 1] - work[_Y, k], problem[Y_SCALE])
        rise = work[_ALTITUDE, k + 1] - work[_ALTITUDE, k]
        length = root(dx * dx + dy * dy)
        work[_SIDE_X, k], work[_SIDE_Y, k] = dx, dy
        work[_RISE, k], work[_LENGTH, k] = rise, length
        if _is_steep(problem, length, rise):
            steep += max(length, CELL)
    for k in range(1, last):
        _measure_turn(problem, work, k)

    sharp = cost = total = 0
    for k in range(points):
        work[_BEFORE, k] = work[_AFTER, k] = work[_ALTITUDE, k]
    for k in range(1, last):
        tangent = work[_TANGENT, k]
        if (
            work[_TANGENT, k - 1] + tangent > work[_LENGTH, k - 1]
            or tangent + work[_TANGENT, k + 1] > work[_LENGTH, k]
        ):
            sharp += 1
        elif tangent:
            _lay_arc(path, work, k)
            before, after = work[_BEFORE, k], work[_AFTER, k]
            half = min(work[_HALF_TURN, k], MAX_HALF_TURN << TURN_FRACTION)
            at = half >> 6
            turn = _TURNS[at] + ((_TURNS[at + 1] - _TURNS[at]) * (half & 63) >> 6)
            length = problem[RADIUS] * turn >> TURN_FRACTION
            if _is_steep(problem, length, after - before):
                steep += max(length, CELL)
            flown = _flown(problem, length, after - before)
            cost += piece_cost(problem, before, after, flown)
            total += flown
    for k in range(last):
        before, after = work[_AFTER, k], work[_BEFORE, k + 1]
        straight = work[_LENGTH, k] - work[_USED, k] - work[_USED, k + 1]
        flown = _flown(problem, straight, after - before)
        cost += piece_cost(problem, before, after, flown)
        total += flown
    return cost, steep + (sharp * total >> 3)


@compiled
def _is_steep(problem: Integers, length: int, rise: int) -> bool:
    scaled_rise = rise << SLOPE_FRACTION
    return bool(scaled_rise > problem[CLIMB] * length or -scaled_rise > problem[DESCENT] * length)


@compiled
def _flown(problem: Integers, length: int, rise: int) -> int:
    """Return the length of a piece in three dimensions, to the nearest."""
    up = rise * problem[RISE_FIELD] >> RISE_FRACTION
    return root(4 * (length * length + up * up)) + 1 >> 1


@compiled
def _measure_turn(problem: Integers, work: Integers, k: int) -> None:
    """Write half turn and tangent length at point ``k``."""
    dx, dy, next_dx, next_dy = (
        work[_SIDE_X, k - 1],
        work[_SIDE_Y, k - 1],
        work[_SIDE_X, k],
        work[_SIDE_Y, k],
    )
    cross = abs(dx * next_dy - dy * next_dx)
    along = work[_LENGTH, k - 1] * work[_LENGTH, k] + dx * next_dx + dy * next_dy
    if along <= 0 or cross >= _SHARPEST * along:
        work[_TANGENT, k] = _INFINITE
    elif cross:
        half = (cross << TURN_FRACTION) // along + 1
        work[_HALF_TURN, k] = half
        rounding = (1 << TURN_FRACTION) - 1
        work[_TANGENT, k] = problem[RADIUS] * half + rounding >> TURN_FRACTION


@compiled
def _lay_arc(path: Integers, work: Integers, k: int) -> None:
    """Write altitudes and chord of the arc at point ``k``, which fits."""
    tangent = work[_TANGENT, k]
    back = (tangent << 16) // work[_LENGTH, k - 1]
    on = (tangent << 16) // work[_LENGTH, k]
    before = work[_ALTITUDE, k] - (work[_RISE, k - 1] * back >> 16)
    after = work[_ALTITUDE, k] + (work[_RISE, k] * on >> 16)
    work[_USED, k], work[_BEFORE, k], work[_AFTER, k] = tangent, before, after
    if tangent > CELL:
        for axis in range(2):
            at = path[k, axis]
            work[CHORD + axis, k] = at + ((path[k - 1, axis] - at) * back + 0x8000 >> 16)
            work[CHORD + 3 + axis, k] = at + ((path[k + 1, axis] - at) * on + 0x8000 >> 16)
        work[CHORD + 2, k] = before >> ALTITUDE_FRACTION
        work[CHORD + 5, k] = after >> ALTITUDE_FRACTION
        work[CHORD + 6, k] = 1
