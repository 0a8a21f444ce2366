"""Evaluation of a path, compiled: :class:`sim.model.planner.definition.evaluation.Evaluator`."""

from __future__ import annotations

from hdl.protocol.planner import POSITION_FRACTION, VALUE_BITS, PathClass
from sim.model.planner.compiled import compiled, inlined
from sim.model.planner.cycles import WALK
from sim.model.planner.memo import HITS, MARGIN, find
from sim.model.planner.problem import (
    BLOCKED,
    COORDINATE_BITS,
    HAS_ENTRY,
    HAS_EXIT,
    KEY_SHIFT,
    LANES,
    MEMO_BITS,
)
from sim.model.planner.score import CHORD, score
from sim.model.planner.walk import Ground, Integers, walk
from sim.model.planner.walker_cycles import MEMO_HIT, walking


__all__ = ["GIVEN_UP", "NO_LIMIT", "evaluate"]

NO_LIMIT = 4 << VALUE_BITS
GIVEN_UP = PathClass.GIVEN_UP << VALUE_BITS
_INFEASIBLE = PathClass.INFEASIBLE << VALUE_BITS
_TOP = (1 << VALUE_BITS) - 1
_UNITS_PER_HIT = 4 << POSITION_FRACTION


@compiled
def evaluate(
    problem: Integers,
    sizes: Integers,
    ground: Ground,
    memo: Integers,
    counters: Integers,
    work: Integers,
    path: Integers,
    points: int,
    limit: int,
    first: bool,
) -> int:
    """Return the key of the first ``points`` rows x, y, step, margin of ``path``.

    The margins are written as far as the path is walked.
    """
    has_entry, has_exit = problem[HAS_ENTRY], problem[HAS_EXIT]
    cost, penalty = score(problem, path, points, work, first)
    value: int = min(max(cost >> problem[KEY_SHIFT], 0), _TOP)
    if first and penalty:
        return _INFEASIBLE | min(penalty, _TOP)
    if first and value >= limit:
        return GIVEN_UP | value
    hits, before, counts = 0, sizes[BLOCKED], True
    for k in range(points):
        if k:
            found, margin = _segment(
                sizes, ground, memo, counters, counts,
                path[k - 1, 0], path[k - 1, 1], path[k - 1, 2], path[k, 0], path[k, 1], path[k, 2],
            )  # fmt: skip
            if counts:
                hits += found
                path[k - 1, 3] = min(before, margin)
            before = margin
            counts &= not (first and found > 0)
        if (k or has_entry) and (k + 1 < points or has_exit) and work[CHORD + 6, k + has_entry]:
            chord = work[CHORD : CHORD + 6, k + has_entry]
            found, margin = _segment(
                sizes, ground, memo, counters, counts,
                chord[0], chord[1], chord[2], chord[3], chord[4], chord[5],
            )  # fmt: skip
            if counts:
                hits += found
            before = min(before, margin)
            counts &= not (first and found > 0)
    if hits or penalty:
        return _INFEASIBLE | min(penalty + hits * _UNITS_PER_HIT, _TOP)
    return value


@inlined
def _segment(
    sizes: Integers,
    ground: Ground,
    memo: Integers,
    counters: Integers,
    counts: bool,
    x0: int,
    y0: int,
    z0: int,
    x1: int,
    y1: int,
    z1: int,
) -> tuple[int, int]:
    """Return hits and margin of a segment, from the memo or by a walk.

    Where nothing ``counts`` any more, only the cycles do: a row of the memo that gets the segment
    then is filled in by the next look-up that needs it.
    """
    row, known = find(memo, sizes[MEMO_BITS], sizes[COORDINATE_BITS], x0, y0, z0, x1, y1, z1)
    corners = max(abs(x1 - x0), abs(y1 - y0)) + 1
    counters[WALK] += MEMO_HIT if known else walking(corners, sizes[LANES])
    if known and memo[row, HITS] >= 0:
        return memo[row, HITS], memo[row, MARGIN]
    hits, margin = -1, 0
    if counts:
        hits, margin = walk(ground, sizes[BLOCKED], x0, y0, z0, x1, y1, z1)
    if row >= 0:
        memo[row, HITS], memo[row, MARGIN] = hits, margin
    return hits, margin
