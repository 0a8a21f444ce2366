"""Memo of segments, compiled: hits and margins of segments walked before, by their ends.

A direct-mapped table with whole tags, which never answers for another segment.
"""

from __future__ import annotations

import numpy as np

from pathgene.sim.model.planner.compiled import inlined
from pathgene.sim.model.planner.walk import Integers


__all__ = ["HITS", "MARGIN", "NO_ROW", "START", "STOP", "empty_memo", "packed", "row_of"]

#: Columns of a row: the two ends packed, hits, margin.
START, STOP, HITS, MARGIN = range(4)
#: Row of a memo of size 0.
NO_ROW = -1


def empty_memo(size: int) -> Integers:
    """Return an empty memo of ``size`` rows, 0 or a power of two: (size, 4) int64."""
    return np.full((size, 4), -1, dtype=np.int64)


@inlined
def packed(bits: int, x: int, y: int, z: int) -> int:
    """Return an end of a segment in one number; ``bits`` is the width of a coordinate."""
    return x | y << bits | z << 2 * bits


@inlined
def row_of(rows: int, width: int, start: int, stop: int) -> int:
    """Return the row of a segment in a memo of ``rows`` rows; :data:`NO_ROW` if there are none.

    ``width`` is the width of a row's number, ``start`` and ``stop`` are the ends, :func:`packed`.
    The row holds the segment if its first two columns equal the ends.
    """
    if rows == 0:
        return NO_ROW
    row = start ^ stop << 3
    # The exclusive or of parts of ``width`` bits: the upper half on the lower one, and again.
    for halving in range(5, -1, -1):
        shift = width << halving
        if shift < 63:
            row ^= row >> shift
    return row & rows - 1
