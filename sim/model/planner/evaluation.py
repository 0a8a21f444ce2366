"""Compiled evaluation of a path: score, then walk, then key."""

from __future__ import annotations

from pathgene.hdl.protocol.planner import HIT_BITS, VALUE_BITS, PathClass
from pathgene.sim.model.compiled import compiled
from pathgene.sim.model.planner.course import (
    BLOCKED,
    COORDINATE_BITS,
    HAS_ENTRY,
    HAS_EXIT,
    KEY_SHIFT,
    LANES,
    MEMO_BITS,
    Course,
    Scratch,
)
from pathgene.sim.model.planner.cycles import WALK
from pathgene.sim.model.planner.evaluator_cycles import MEMO_HIT, walking
from pathgene.sim.model.planner.score import (
    FROM_STEP,
    FROM_X,
    FROM_Y,
    HAS_CHORD,
    TO_STEP,
    TO_X,
    TO_Y,
    score,
)
from pathgene.sim.model.planner.walk import (
    HITS,
    MARGIN,
    START,
    STOP,
    Integers,
    packed,
    row_of,
    walk,
)


__all__ = ["GIVEN_UP", "NO_LIMIT", "evaluate"]

#: A key above all keys, so that no path is given up.
NO_LIMIT = 4 << VALUE_BITS
#: The keys of feasible paths are lower.
GIVEN_UP = PathClass.GIVEN_UP << VALUE_BITS
_INFEASIBLE = PathClass.INFEASIBLE << VALUE_BITS
_TOP = (1 << VALUE_BITS) - 1


@compiled
def evaluate(
    course: Course,
    scratch: Scratch,
    path: Integers,
    points: int,
    limit: int,
    first: bool,
) -> int:
    """Return the key of the first ``points`` rows x, y, step, margin of ``path``, with its ends.

    With ``first``, the best path is feasible: a path that is infeasible by its score, or whose
    value is not below ``limit``, is not walked, and its margins stay. All other paths are walked to
    their end, but with ``first`` no collision after the first colliding segment or chord counts.
    The margin of a waypoint becomes the minimum margin of its two segments and its chord.
    """
    problem, sizes, ground = course
    memo, counters, work = scratch.memo, scratch.counters, scratch.work
    has_entry, has_exit = problem[HAS_ENTRY], problem[HAS_EXIT]
    cost, penalty = score(problem, path, points, work, first)
    value: int = min(max(cost >> problem[KEY_SHIFT], 0), _TOP)
    if first and penalty:
        return _INFEASIBLE | min(penalty, _TOP)
    if first and value >= limit:
        return GIVEN_UP | value
    bits, width, rows = sizes[COORDINATE_BITS], sizes[MEMO_BITS], len(memo)
    blocked, lanes = sizes[BLOCKED], sizes[LANES]
    first_chord = 1 - has_entry
    last_chord = points - 2 + has_exit
    hits, before, counts, cycles = 0, blocked, True, 0
    # Each segment in order, followed by the chord at its end; there is none at the ends of the
    # path.
    for place in range(1, 2 * points):
        k = place >> 1
        if place & 1:
            at = k + has_entry
            if k < first_chord or k > last_chord or not work[HAS_CHORD, at]:
                continue
            x0, y0, z0 = work[FROM_X, at], work[FROM_Y, at], work[FROM_STEP, at]
            x1, y1, z1 = work[TO_X, at], work[TO_Y, at], work[TO_STEP, at]
        else:
            x0, y0, z0 = path[k - 1, 0], path[k - 1, 1], path[k - 1, 2]
            x1, y1, z1 = path[k, 0], path[k, 1], path[k, 2]
        start, stop = packed(bits, x0, y0, z0), packed(bits, x1, y1, z1)
        row = row_of(rows, width, start, stop)
        if row >= 0 and memo[row, START] == start and memo[row, STOP] == stop:
            cycles += MEMO_HIT
            found, margin = memo[row, HITS], memo[row, MARGIN]
        else:
            cycles += walking(max(abs(x1 - x0), abs(y1 - y0)) + 1, lanes)
            found, margin = walk(ground, blocked, x0, y0, z0, x1, y1, z1)
            if row >= 0:
                memo[row, START], memo[row, STOP] = start, stop
                memo[row, HITS], memo[row, MARGIN] = found, margin
        if counts:
            hits += found
            counts = not (first and found > 0)
        if place & 1:
            before = min(before, margin)
        else:
            path[k - 1, 3] = min(before, margin)
            before = margin
    counters[WALK] += cycles
    if hits or penalty:
        return _INFEASIBLE | min(penalty + (hits << HIT_BITS), _TOP)
    return value
