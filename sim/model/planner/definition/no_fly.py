"""BLOCK: the corners of a shape become blocked, drawn a corner a cycle."""

from __future__ import annotations

from pathgene.hdl.protocol.planner import NoFlyShape
from pathgene.sim.model.planner.definition.walk import Ground


__all__ = ["block", "drawn"]


def block(ground: Ground, blocked: int, shape: NoFlyShape) -> None:
    """Block the corners of ``ground`` that lie in ``shape``."""
    for x, y in drawn(shape):
        ground[y, x] = blocked


def drawn(shape: NoFlyShape) -> list[tuple[int, int]]:
    """Return the corners in ``shape``, by rows.

    The value of each edge goes on from corner to corner, and from row to row, by differences: two
    additions for an edge that bends, one for another one.
    """
    bends = [(shape.bend_x, shape.bend_y), *[(0, 0)] * (len(shape.edges) - 1)]
    inside = []
    firsts = [at for at, _, _ in shape.edges]
    for v in range(shape.last_y - shape.first_y + 1):
        values = list(firsts)
        for u in range(shape.last_x - shape.first_x + 1):
            if min(values, default=0) >= 0:
                inside.append((shape.first_x + u, shape.first_y + v))
            for i, (_, east, _) in enumerate(shape.edges):
                values[i] += east - (2 * u + 1) * bends[i][0]
        for i, (_, _, north) in enumerate(shape.edges):
            firsts[i] += north - (2 * v + 1) * bends[i][1]
    return inside
