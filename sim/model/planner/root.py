"""Square root of an integer, compiled."""

from __future__ import annotations

import math

from pathgene.sim.model.planner.compiled import inlined


__all__ = ["root"]


@inlined
def root(square: int) -> int:
    """Return the square root of ``square``, 0..2**60, rounded down.

    A processor's root is rounded to the nearest, on every machine alike: below 2**52 its whole part
    is the root already, above it may be one off.
    """
    whole = int(math.sqrt(square))
    while whole * whole > square:
        whole -= 1
    while (whole + 1) * (whole + 1) <= square:
        whole += 1
    return whole
