"""Compiled walk of a segment over the lattice of corners.

It is :func:`pathgene.sim.model.planner.definition.score.walk` without a division per corner: x, y
and the altitude advance by steps with 32 more bits. Each step is a little too large, by at most
2**-32. After at most 4095 steps x, y and the altitude are too large by less than 2**-20. The
definition rounds multiples of 1 / (2 n) down, where n is at most 4095: these are rounded down to
the same numbers.

The memo has hits and margins of previously walked segments, by their ends. It is a direct-mapped
table with full tags, which never answers for a different segment.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pathgene.sim.model.compiled import compiled, inlined


__all__ = [
    "HITS",
    "MARGIN",
    "NO_ROW",
    "START",
    "STOP",
    "Ground",
    "Integers",
    "empty_memo",
    "packed",
    "row_of",
    "walk",
]


Ground = npt.NDArray[np.uint16]
Integers = npt.NDArray[np.int64]

_FRACTION = 32
_HALF = 1 << _FRACTION - 1


@compiled
def walk(
    ground: Ground,
    blocked: int,
    x0: int,
    y0: int,
    z0: int,
    x1: int,
    y1: int,
    z1: int,
) -> tuple[int, int]:
    """Return colliding corners and minimum margin of a segment."""
    dx, dy, dz = x1 - x0, y1 - y0, z1 - z0
    low = min(z0, z1)
    last = max(abs(dx), abs(dy))
    # A segment of one corner has the altitude of its lower end.
    n, z0 = (last, z0) if last else (1, low)
    step_x, step_y, step_z = (
        (dx << _FRACTION) // n + 1,
        (dy << _FRACTION) // n + 1,
        (dz << _FRACTION) // n + 1,
    )
    # x and y go to the nearest corner; z is the lowest altitude within half a step.
    x, y = (x0 << _FRACTION) + _HALF, (y0 << _FRACTION) + _HALF
    z = (z0 << _FRACTION) - (abs(dz) << _FRACTION - 1) // n
    hits, margin = 0, blocked
    for _ in range(last + 1):
        # Unsigned, because the compiler would count negative indices from the end.
        height = int(np.int64(ground[np.uint64(y >> _FRACTION), np.uint64(x >> _FRACTION)]))
        above = max(z >> _FRACTION, low) - height
        is_blocked = height == blocked
        hits += is_blocked | (above < 0)
        margin = min(margin, blocked if is_blocked else above)
        x += step_x
        y += step_y
        z += step_z
    return hits, margin


#: Columns of a row: the two ends packed, hits, margin.
START, STOP, HITS, MARGIN = range(4)
#: Row of a memo of size 0.
NO_ROW = -1


def empty_memo(size: int) -> Integers:
    """Return an empty memo of ``size`` rows, 0 or a power of two: (size, 4) int64."""
    return np.full((size, 4), -1, dtype=np.int64)


@inlined
def packed(bits: int, x: int, y: int, z: int) -> int:
    """Return an end of a segment as one number; ``bits`` is the width of a coordinate."""
    return x | y << bits | z << 2 * bits


@inlined
def row_of(rows: int, width: int, start: int, stop: int) -> int:
    """Return the row of a segment in a memo of ``rows`` rows; :data:`NO_ROW` if there are none.

    ``width`` is the width of a row's number, ``start`` and ``stop`` are the ends, :func:`packed`.
    The row contains the segment if its first two columns equal the ends.
    """
    if rows == 0:
        return NO_ROW
    row = start ^ stop << 3
    # Exclusive or of parts of ``width`` bits: the upper half is folded onto the lower one,
    # repeatedly.
    for halving in range(5, -1, -1):
        shift = width << halving
        if shift < 63:
            row ^= row >> shift
    return row & rows - 1
