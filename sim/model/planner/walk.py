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
    ends: Integers,
    x0: int,
    y0: int,
    z0: int,
    x1: int,
    y1: int,
    z1: int,
) -> tuple[int, int]:
    """Return colliding corners and least margin of a segment.

    ``ends`` (4,) has x and y of the path's start, then of its goal.
    """
    dx, dy, dz = x1 - x0, y1 - y0, z1 - z0
    low = min(z0, z1)
    n = max(abs(dx), abs(dy))
    if n == 0:
        n, last, dz, z = 1, 0, 0, low
        rest = 0
    else:
        last = n
        # Floor division: the remainder is never negative.
        z = z0 + -abs(dz) // (2 * n)
        rest = -abs(dz) - -abs(dz) // (2 * n) * (2 * n)
    whole = dz // n
    part = 2 * (dz - whole * n)
    start_x, start_y, goal_x, goal_y = ends[0], ends[1], ends[2], ends[3]
    across = along = n
    x, y = x0, y0
    hits, margin = 0, blocked
    for _ in range(last + 1):
        at_start = abs(x - start_x) <= 1 and abs(y - start_y) <= 1
        if not at_start and not (abs(x - goal_x) <= 1 and abs(y - goal_y) <= 1):
            height = int(np.int64(ground[y, x]))
            if height == blocked:
                hits += 1
            else:
                above = max(z, low) - height
                hits += above < 0
                margin = min(margin, above)
        # Neither x nor y moves by more than a corner at a time.
        across += 2 * dx
        along += 2 * dy
        if across >= 2 * n:
            across -= 2 * n
            x += 1
        elif across < 0:
            across += 2 * n
            x -= 1
        if along >= 2 * n:
            along -= 2 * n
            y += 1
        elif along < 0:
            along += 2 * n
            y -= 1
        z += whole
        rest += part
        if rest >= 2 * n:
            rest -= 2 * n
            z += 1
    return hits, margin
