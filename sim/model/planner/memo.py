"""Memo of segments, compiled: :class:`sim.model.planner.definition.memo.Memo`."""

from __future__ import annotations

import numpy as np

from sim.model.planner.compiled import inlined
from sim.model.planner.walk import Integers


__all__ = ["HITS", "MARGIN", "NO_ROW", "empty_memo", "find"]

#: Columns of a row: the two ends packed, hits, margin.
_START, _STOP, HITS, MARGIN = range(4)
#: Row of a memo of size 0.
NO_ROW = -1


def empty_memo(size: int) -> Integers:
    """Return an empty memo of ``size`` rows, 0 or a power of two: (size, 4) int64."""
    return np.full((size, 4), -1, dtype=np.int64)


@inlined
def find(
    memo: Integers, width: int, bits: int, x0: int, y0: int, z0: int, x1: int, y1: int, z1: int
) -> tuple[int, bool]:
    """Return the row of a segment, and whether the row is the segment's; else it becomes so.

    The caller fills in hits and margin then. ``width`` and ``bits`` are the widths of a row's
    number and of a coordinate.
    """
    size = len(memo)
    if size == 0:
        return NO_ROW, False
    start = x0 | y0 << bits | z0 << 2 * bits
    stop = x1 | y1 << bits | z1 << 2 * bits
    mixed = start ^ stop << 3
    row = 0
    while mixed:
        row ^= mixed & size - 1
        mixed >>= width
    if memo[row, _START] == start and memo[row, _STOP] == stop:
        return row, True
    memo[row, _START], memo[row, _STOP] = start, stop
    return row, False
