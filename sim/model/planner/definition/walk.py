"""Walk of a segment over the lattice of corners."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt


__all__ = ["Corner", "Ground", "Point", "passed", "walk"]

#: Highest cells around each corner, [y, x].
Ground = npt.NDArray[np.uint16]
Corner = tuple[int, int]
#: Corner and altitude step.
Point = tuple[int, int, int]


def walk(ground: Ground, blocked: int, start: Point, stop: Point) -> tuple[int, int]:
    """Return how many corners of a segment collide, and the segment's least margin.

    A corner collides where the segment is below its ground, or where it is blocked. The margin is
    the altitude above the ground, in steps; blocked corners do not count in it, and a segment over
    nothing else has ``blocked``.
    """
    hits, margin = 0, blocked
    for x, y, altitude in passed(start, stop):
        height = int(ground[y, x])
        if height == blocked:
            hits += 1
            continue
        hits += altitude < height
        margin = min(margin, altitude - height)
    return hits, margin


def passed(start: Point, stop: Point) -> Iterator[tuple[int, int, int]]:
    """Yield the corners of a segment and its lowest altitude within half a step of each.

    The altitude is rounded down, and never below the lower end of the segment.
    """
    (x, y, z), (dx, dy, dz) = start, (b - a for a, b in zip(start, stop, strict=True))
    n = max(abs(dx), abs(dy))
    if n == 0:
        yield x, y, min(z, z + dz)
        return
    for k in range(n + 1):
        across, along = (2 * k * dx + n) // (2 * n), (2 * k * dy + n) // (2 * n)
        lowest = (2 * n * z + 2 * k * dz - abs(dz)) // (2 * n)
        yield x + across, y + along, max(lowest, min(z, z + dz))
