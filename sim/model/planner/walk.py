"""Walk of a segment over the lattice of corners, compiled.

:func:`sim.model.planner.definition.walk.walk` without a division per corner: x, y and the altitude
advance by their remainders.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim.model.planner.compiled import compiled


__all__ = ["Ground", "Integers", "walk"]

Ground = npt.NDArray[np.uint16]
Integers = npt.NDArray[np.int64]


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
    """Return colliding corners and least margin of a segment."""
    dx, dy, dz = x1 - x0, y1 - y0, z1 - z0
    low = min(z0, z1)
    is_wide = abs(dx) >= abs(dy)
    n = abs(dx) if is_wide else abs(dy)
    last = n
    if n == 0:
        n, dz, z, rest = 1, 0, low, 0
    else:
        # Floor division: the remainder is never negative.
        z = z0 + -abs(dz) // (2 * n)
        rest = -abs(dz) % (2 * n)
    whole = dz // n
    part = 2 * (dz - whole * n)
    # A step along the longer side, and one across with the remainder that it needs.
    along_x, along_y, across_x, across_y = np.sign(dx), 0, 0, np.sign(dy)
    slant = 2 * abs(dy)
    if not is_wide:
        along_x, along_y, across_x, across_y = 0, np.sign(dy), np.sign(dx), 0
        slant = 2 * abs(dx)
    # Halves go up: backwards a half is not yet a step.
    aside = n if across_x + across_y > 0 else n - 1
    x, y = x0, y0
    hits, margin = 0, blocked
    for _ in range(last + 1):
        height = int(np.int64(ground[y, x]))
        if height == blocked:
            hits += 1
        else:
            above = max(z, low) - height
            hits += above < 0
            margin = min(margin, above)
        x += along_x
        y += along_y
        aside += slant
        if aside >= 2 * n:
            aside -= 2 * n
            x += across_x
            y += across_y
        z += whole
        rest += part
        if rest >= 2 * n:
            rest -= 2 * n
            z += 1
    return hits, margin
