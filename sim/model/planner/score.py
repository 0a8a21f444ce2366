"""Score of a path, compiled: :func:`sim.model.planner.definition.score.score`.

Every number fits 64 bits with its sign. For the largest configuration (map of 4096 cells, 16 bits
of altitude, 64 waypoints) and the greatest value in every field: a segment is shorter than 2**21
and rises by less than 2**20 parts or 2**24 units, so its flown length is below 2**25, and four
times its square, the greatest that is rooted, below 2**52. The dividend of a half turn has 54 bits.
The segments of a path with their arcs, from an entry to an exit, sum up to less than 1.2 * 67 *
2**24, their climbs to less than 34 * 2**20 parts: the pulls to less than 2**47, the fuel to less
than 2**63.
"""

from __future__ import annotations

import math

import numpy as np

from hdl.protocol.planner import (
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
from sim.model.planner.compiled import compiled, inlined
from sim.model.planner.problem import (
    BASE,
    CLIMB,
    DESCENT,
    DRAG,
    ENTRY_ALTITUDE,
    ENTRY_X,
    ENTRY_Y,
    EXIT_ALTITUDE,
    EXIT_X,
    EXIT_Y,
    FUEL,
    FUEL_SHIFT,
    GOAL_ALTITUDE,
    GOAL_X,
    GOAL_Y,
    HAS_ENTRY,
    HAS_EXIT,
    RADIUS,
    START_ALTITUDE,
    START_X,
    START_Y,
    X_LIMIT,
    X_SCALE,
    Y_LIMIT,
    Y_SCALE,
)
from sim.model.planner.problem import RISE as RISE_FIELD
from sim.model.planner.walk import Integers


__all__ = ["CELL", "CHORD", "WORK_ROWS", "piece_cost", "scaled", "score"]

#: Rows of the work space of :func:`score`; a column is a point, or the segment that begins there.
_LENGTH, _RISE, _HALF_TURN, _USED, _ALTITUDE = range(5)
#: First of six rows with the ends of the chord at a point, x, y and step each, and a row that is 1
#: where there is a chord.
CHORD = 5
WORK_ROWS = 12

CELL = 1 << POSITION_FRACTION
_SHARPEST = 1 << SHARPEST_BITS
_INFINITE = 1 << 24
_HALF_SHARE = 1 << SHARE_BITS - 1
_HALF_SCALE = 1 << SCALE_FRACTION - 1
_ALMOST_ONE = (1 << TURN_FRACTION) - 1
_TURNS = np.array(turn_table(), dtype=np.int64)


@inlined
def scaled(difference: int, scale: int) -> int:
    """Return a difference of positions in units of length, halves away from 0."""
    # The shift of a negative number by 63 bits is -1.
    return difference * scale + _HALF_SCALE + (difference >> 63) >> SCALE_FRACTION


@inlined
def _root(square: int) -> int:
    """Return the square root of ``square``, 0..2**52 - 1, rounded down.

    See :func:`sim.model.planner.root.root`.
    """
    return int(math.sqrt(square))


@inlined
def piece_cost(problem: Integers, before: int, after: int, length: int) -> int:
    """Return the cost of a straight piece or an arc between two altitudes."""
    burnt = _burnt(
        problem[DRAG] * length + problem[RISE_FIELD] * (after - before),
        problem[FUEL],
        problem[FUEL_SHIFT],
    )
    cost: int = (before + after + problem[BASE]) * length + burnt
    return cost


@inlined
def _burnt(pull: int, fuel: int, fuel_shift: int) -> int:
    """Return the part of a cost that is fuel."""
    return max(pull, 0) * fuel >> fuel_shift


@compiled
def score(
    problem: Integers, path: Integers, points: int, work: Integers, first: bool
) -> tuple[int, int]:
    """Return cost and penalty of the first ``points`` rows x, y, step, ... of ``path``.

    With ``first``, the cost of a path with a steep segment or a missing arc is 0. ``work``,
    (WORK_ROWS, points or more) int64, gets the chords. A point more in it counts before the others
    where there is an entry, and another one behind them where there is an exit.
    """
    if problem[HAS_ENTRY] or problem[HAS_EXIT]:
        path = _extended(problem, path, points)
        points = len(path)
    last = points - 1
    penalty = _measure_segments(problem, path, last, work)
    is_lost = first and penalty > 0

    # An inlined function gets numbers: an array would cost two counts of references.
    climb, descent, radius = problem[CLIMB], problem[DESCENT], problem[RADIUS]
    drag, weight, base = problem[DRAG], problem[RISE_FIELD], problem[BASE]
    fuel, fuel_shift = problem[FUEL], problem[FUEL_SHIFT]
    cost = 0
    # Where the piece before ends: altitude, and length of its segment that an arc has taken.
    altitude, taken = work[_ALTITUDE, 0], 0
    for k in range(1, points):
        before = after = work[_ALTITUDE, k]
        tangent = work[_USED, k]
        work[CHORD + 6, k] = 0
        if tangent:
            # The quotients have so few bits that rounding them before they are cut changes none.
            back = int((tangent << SHARE_BITS) / work[_LENGTH, k - 1])
            on = int((tangent << SHARE_BITS) / work[_LENGTH, k])
            fall, rise = work[_RISE, k - 1] * back, work[_RISE, k] * on
            before -= fall >> SHARE_BITS
            after += rise >> SHARE_BITS
            if tangent > CELL and not is_lost:
                for axis in range(2):
                    at = path[k, axis]
                    away = (path[k - 1, axis] - at) * back + _HALF_SHARE >> SHARE_BITS
                    work[CHORD + axis, k] = at + away
                    away = (path[k + 1, axis] - at) * on + _HALF_SHARE >> SHARE_BITS
                    work[CHORD + 3 + axis, k] = at + away
                work[CHORD + 2, k] = before >> ALTITUDE_FRACTION
                work[CHORD + 5, k] = after >> ALTITUDE_FRACTION
                work[CHORD + 6, k] = 1
            half = min(work[_HALF_TURN, k], MAX_HALF_TURN << TURN_FRACTION)
            entry = half >> 6
            turn = _TURNS[entry] + ((_TURNS[entry + 1] - _TURNS[entry]) * (half & 63) >> 6)
            length = radius * turn >> TURN_FRACTION
            if _excess(climb, descent, length << SHARE_BITS, fall + rise) > 0:
                penalty += max(length, CELL)
            if is_lost:
                continue
            flown = _flown(weight, length, after - before)
            cost += (before + after + base) * flown
            cost += _burnt(drag * flown + weight * (after - before), fuel, fuel_shift)
        elif is_lost:
            continue
        flown = _flown(weight, work[_LENGTH, k - 1] - taken - tangent, before - altitude)
        cost += (altitude + before + base) * flown
        cost += _burnt(drag * flown + weight * (before - altitude), fuel, fuel_shift)
        altitude, taken = after, tangent
    return cost, penalty


@compiled
def _extended(problem: Integers, path: Integers, points: int) -> Integers:
    """Return ``path`` with the corners of the entry before it and of the exit behind it."""
    has_entry, has_exit = problem[HAS_ENTRY], problem[HAS_EXIT]
    extended = np.zeros((points + has_entry + has_exit, path.shape[1]), dtype=np.int64)
    for k in range(points):
        for i in range(3):
            extended[k + has_entry, i] = path[k, i]
    half = CELL // 2
    if has_entry:
        extended[0, 0] = min(problem[ENTRY_X] + half >> POSITION_FRACTION, problem[X_LIMIT])
        extended[0, 1] = min(problem[ENTRY_Y] + half >> POSITION_FRACTION, problem[Y_LIMIT])
    if has_exit:
        extended[-1, 0] = min(problem[EXIT_X] + half >> POSITION_FRACTION, problem[X_LIMIT])
        extended[-1, 1] = min(problem[EXIT_Y] + half >> POSITION_FRACTION, problem[Y_LIMIT])
    return extended


@inlined
def _place(problem: Integers, path: Integers, k: int, last: int) -> tuple[int, int, int]:
    """Return x, y and altitude of a point: of an end as the record has them."""
    if k == last and problem[HAS_EXIT]:
        return problem[EXIT_X], problem[EXIT_Y], problem[EXIT_ALTITUDE]
    if k == 0 and problem[HAS_ENTRY]:
        return problem[ENTRY_X], problem[ENTRY_Y], problem[ENTRY_ALTITUDE]
    if k == problem[HAS_ENTRY]:
        return problem[START_X], problem[START_Y], problem[START_ALTITUDE]
    if k == last - problem[HAS_EXIT]:
        return problem[GOAL_X], problem[GOAL_Y], problem[GOAL_ALTITUDE]
    return (
        path[k, 0] << POSITION_FRACTION,
        path[k, 1] << POSITION_FRACTION,
        path[k, 2] << ALTITUDE_FRACTION,
    )


@compiled
def _measure_segments(problem: Integers, path: Integers, last: int, work: Integers) -> int:
    """Write altitudes, lengths, rises, half turns and the tangents that fit; return the penalty."""
    x_scale, y_scale, radius = problem[X_SCALE], problem[Y_SCALE], problem[RADIUS]
    climb, descent = problem[CLIMB], problem[DESCENT]
    # Points between start and goal.
    inner_first, inner_last = problem[HAS_ENTRY] + 1, last - problem[HAS_EXIT] - 1
    x, y, altitude = _place(problem, path, 0, last)
    work[_ALTITUDE, 0] = altitude
    steep = total = sharp = 0
    # Of the segment before, and of the point at its end.
    dx = dy = length = tangent = 0
    has_room = True
    for k in range(last):
        if inner_first <= k + 1 <= inner_last:
            next_x = path[k + 1, 0] << POSITION_FRACTION
            next_y = path[k + 1, 1] << POSITION_FRACTION
            next_altitude = path[k + 1, 2] << ALTITUDE_FRACTION
        else:
            next_x, next_y, next_altitude = _place(problem, path, k + 1, last)
        work[_ALTITUDE, k + 1] = next_altitude
        next_dx, next_dy = scaled(next_x - x, x_scale), scaled(next_y - y, y_scale)
        next_length = _root(next_dx * next_dx + next_dy * next_dy)
        rise = next_altitude - altitude
        work[_LENGTH, k], work[_RISE, k] = next_length, rise
        total += next_length
        excess = _excess(climb, descent, next_length, rise)
        if excess > 0:
            steep += STEEP + (excess >> SLOPE_FRACTION - EXCESS_BITS)
        if k:
            next_tangent = 0
            cross = abs(dx * next_dy - dy * next_dx)
            along = length * next_length + dx * next_dx + dy * next_dy
            if along <= 0 or cross >= _SHARPEST * along:
                next_tangent = _INFINITE
            elif cross:
                # Neither is negative, which the compiler does not know.
                half = int(np.uint64(cross << TURN_FRACTION) // np.uint64(along)) + 1
                work[_HALF_TURN, k] = half
                next_tangent = radius * half + _ALMOST_ONE >> TURN_FRACTION
            # The arcs at both ends of the segment before leave it a length of 0 or more.
            still_has_room = tangent + next_tangent <= length
            if k > 1:
                fits = has_room and still_has_room
                sharp += not fits
                work[_USED, k - 1] = tangent if fits else 0
            has_room, tangent = still_has_room, next_tangent
        x, y, altitude = next_x, next_y, next_altitude
        dx, dy, length = next_dx, next_dy, next_length
    if last > 1:
        fits = has_room and tangent <= length
        sharp += not fits
        work[_USED, last - 1] = tangent if fits else 0
    work[_USED, last] = 0
    return steep + (sharp * total >> 3)


@inlined
def _excess(climb: int, descent: int, length: int, rise: int) -> int:
    """Return by how many parts, with SLOPE_FRACTION bits below, a rise exceeds its limit."""
    limit = climb if rise > 0 else descent
    return (abs(rise) << SLOPE_FRACTION) - limit * length


@inlined
def _flown(weight: int, length: int, rise: int) -> int:
    """Return the length of a piece in three dimensions, to the nearest."""
    up = rise * weight >> RISE_FRACTION
    return _root(4 * (length * length + up * up)) + 1 >> 1
