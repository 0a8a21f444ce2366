"""Square root of an integer, compiled."""

from __future__ import annotations

from math import isqrt

import numpy as np

from sim.model.planner.compiled import inlined


__all__ = ["root"]

#: Roots of the numbers to 4096 with 10 fraction bits, above them.
_ROOTS = np.array([isqrt(i + 1 << 20) + 1 for i in range(4096)], dtype=np.int64)


@inlined
def root(square: int) -> int:
    """Return the square root of ``square``, 0..2**60, rounded down.

    Newton's step never falls below the root. From the root of the leading 11 or 12 bits, one step
    is mostly enough.
    """
    shift = 0
    while square >> shift >= 1 << 20:
        shift += 8
    while square >> shift >= 1 << 12:
        shift += 2
    guess: int = (_ROOTS[square >> shift] << (shift >> 1) >> 10) + 1
    while True:
        guess = guess + square // guess >> 1
        if guess * guess <= square:
            return guess
