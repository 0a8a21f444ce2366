"""Square root of an integer, compiled."""

from __future__ import annotations

from math import isqrt

import numpy as np

from sim.model.planner.compiled import compiled


__all__ = ["root"]

_BITS = 12
#: Roots at the upper ends of the first 4096 intervals of 2**20, rounded up: 11 correct bits or more
#: in the upper three quarters.
_GUESSES = np.array([isqrt(i + 1 << 20) + 1 for i in range(1 << _BITS)], dtype=np.int64)


@compiled
def root(square: int) -> int:
    """Return the square root of ``square``, 0..2**60, rounded down.

    Newton's step never falls below the root; one is enough up to 2**44, more follow where not.
    """
    shift = 0
    while square >> shift >= 1 << _BITS + 8:
        shift += 8
    while square >> shift >= 1 << _BITS:
        shift += 2
    # The guess is the root of the leading bits, in units of 2**-10, brought to the number's size.
    guess: int = (_GUESSES[square >> shift] << (shift >> 1) >> 10) + 1
    while True:
        guess = guess + square // guess >> 1
        if guess * guess <= square:
            return guess
