"""Evaluation of a path, compiled: :class:`sim.model.planner.definition.evaluation.Evaluator`."""

from __future__ import annotations

from hdl.protocol.planner import POSITION_FRACTION, VALUE_BITS, PathClass
from sim.model.planner.compiled import compiled, inlined
from sim.model.planner.cycles import MEMO_HIT, overlapped, walking
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


__all__ = [
    "CYCLES",
    "GENERATIONS",
    "GIVEN_UP",
    "NO_LIMIT",
    "PLACES",
    "evaluate",
    "segment",
    "settle",
]

NO_LIMIT = 4 << VALUE_BITS
GIVEN_UP = PathClass.GIVEN_UP << VALUE_BITS
_INFEASIBLE = PathClass.INFEASIBLE << VALUE_BITS
_TOP = (1 << VALUE_BITS) - 1
_UNITS_PER_HIT = 4 << POSITION_FRACTION

#: Places of the counters: cycles of the run, its generations, and since :func:`settle` segments
#: scored and cycles of the walker.
CYCLES, GENERATIONS, _SEGMENTS, _WALKER = range(4)
PLACES = 4


@compiled
def evaluate(
    problem: Integers,
    sizes: Integers,
    ground: Ground,
    ends: Integers,
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
    counters[_SEGMENTS] += points - 1 + has_entry + has_exit
    cost, penalty = score(problem, path, points, work, first)
    value: int = min(max(cost >> problem[KEY_SHIFT], 0), _TOP)
    if first and penalty:
        return _INFEASIBLE | min(penalty, _TOP)
    if first and value >= limit:
        return GIVEN_UP | value
    hits, before = 0, sizes[BLOCKED]
    for k in range(points):
        if k:
            found, margin = segment(
                sizes, ground, ends, memo, counters,
                path[k - 1, 0], path[k - 1, 1], path[k - 1, 2], path[k, 0], path[k, 1], path[k, 2],
            )  # fmt: skip
            hits += found
            path[k - 1, 3] = min(before, margin)
            before = margin
            if first and found:
                break
        if (k or has_entry) and (k + 1 < points or has_exit) and work[CHORD + 6, k + has_entry]:
            chord = work[CHORD : CHORD + 6, k + has_entry]
            found, margin = segment(
                sizes, ground, ends, memo, counters,
                chord[0], chord[1], chord[2], chord[3], chord[4], chord[5],
            )  # fmt: skip
            hits += found
            before = min(before, margin)
            if first and found:
                break
    if hits or penalty:
        return _INFEASIBLE | min(penalty + hits * _UNITS_PER_HIT, _TOP)
    return value


@inlined
def segment(
    sizes: Integers,
    ground: Ground,
    ends: Integers,
    memo: Integers,
    counters: Integers,
    x0: int,
    y0: int,
    z0: int,
    x1: int,
    y1: int,
    z1: int,
) -> tuple[int, int]:
    """Return hits and margin of a segment, from the memo or by a walk."""
    row, known = find(memo, sizes[MEMO_BITS], sizes[COORDINATE_BITS], x0, y0, z0, x1, y1, z1)
    if known:
        counters[_WALKER] += MEMO_HIT
        return memo[row, HITS], memo[row, MARGIN]
    hits, margin = walk(ground, sizes[BLOCKED], x0, y0, z0, x1, y1, z1)
    counters[_WALKER] += walking(max(abs(x1 - x0), abs(y1 - y0)) + 1, sizes[LANES])
    if row >= 0:
        memo[row, HITS], memo[row, MARGIN] = hits, margin
    return hits, margin


@compiled
def settle(counters: Integers) -> None:
    """Add the cycles of what has been evaluated since the last call to those of the run."""
    counters[CYCLES] += overlapped(counters[_SEGMENTS], counters[_WALKER])
    counters[_SEGMENTS] = counters[_WALKER] = 0
