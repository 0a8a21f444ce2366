"""Walk of a segment over the lattice of corners, compiled.

:func:`pathgene.sim.model.planner.definition.walk.walk` without a division per corner: x, y and the
altitude advance by steps with 32 more bits. Each step is a little too large, by at most 2**-32.
After at most 4095 steps x, y and the altitude are too large by less than 2**-20. The definition
rounds multiples of 1 / (2 n) down, where n is at most 4095: these are rounded down to the same
numbers.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pathgene.sim.model.planner.compiled import compiled


__all__ = ["Ground", "Integers", "walk"]

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
    # A segment of one corner is at its lower end.
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
        # Unsigned, or the compiler would count negative places from the end.
        height = int(np.int64(ground[np.uint64(y >> _FRACTION), np.uint64(x >> _FRACTION)]))
        above = max(z >> _FRACTION, low) - height
        is_blocked = height == blocked
        hits += is_blocked | (above < 0)
        margin = min(margin, blocked if is_blocked else above)
        x += step_x
        y += step_y
        z += step_z
    return hits, margin
