"""BLOCK: the corners of a shape become blocked."""

from __future__ import annotations

import numpy as np

from pathgene.hdl.protocol.planner import NoFlyShape
from pathgene.sim.model.planner.walk import Ground


__all__ = ["block"]


def block(ground: Ground, blocked: int, shape: NoFlyShape) -> None:
    """Block the corners of ``ground`` that lie in ``shape``."""
    rows = slice(shape.first_y, shape.last_y + 1)
    columns = slice(shape.first_x, shape.last_x + 1)
    box = ground[rows, columns]
    v, u = np.indices(box.shape)
    is_inside = np.ones(box.shape, dtype=bool)
    for i, (at, east, north) in enumerate(shape.edges):
        bend_x, bend_y = (0, 0) if i else (shape.bend_x, shape.bend_y)
        is_inside &= at + (east - bend_x * u) * u + (north - bend_y * v) * v >= 0
    box[is_inside] = blocked
