"""Shapes that become blocked, against the formula of their record."""

import itertools

import numpy as np
import pytest

from pathgene.hdl.protocol.planner import NoFlyShape
from pathgene.sim.model.run_commands import block
from tests.support.planner.cases import SMALL, USUAL, shape
from tests.support.planner.plain import drawn


def is_inside(shape, x, y):
    """The formula of the record."""
    u, v = x - shape.first_x, y - shape.first_y
    if u < 0 or x > shape.last_x or v < 0 or y > shape.last_y:
        return False
    bends = itertools.chain([shape.bend_x * u * u + shape.bend_y * v * v], itertools.repeat(0))
    return all(
        at + east * u + north * v - bend >= 0
        for (at, east, north), bend in zip(shape.edges, bends, strict=False)
    )


@pytest.mark.parametrize("config", [SMALL, USUAL], ids=["small", "usual"])
def test_shapes_are_drawn_as_their_formula_says(config):
    rng = np.random.default_rng(21)
    sizes = []
    for _ in range(60 if config is SMALL else 3):
        some = shape(config, rng)
        before = rng.integers(9, size=(config.map_size,) * 2).astype(np.uint16)
        after = before.copy()
        block(after, config.blocked_altitude, some)
        inside = [(x, y) for y, x in np.ndindex(before.shape) if is_inside(some, x, y)]
        assert drawn(some) == inside
        changed = after != before
        assert changed.sum() == len(inside)
        assert (after[changed] == config.blocked_altitude).all()
        sizes.append(len(inside))
    assert min(sizes) == 0 or config is USUAL
    assert max(sizes) > config.map_size


def test_a_disc_and_a_triangle():
    disc = NoFlyShape(
        first_x=2, first_y=3, last_x=6, last_y=7, edges=((-4, 4, 4),), bend_x=1, bend_y=1
    )
    rows = ["  #  ", " ### ", "#####", " ### ", "  #  "]
    assert drawn(disc) == [
        (2 + u, 3 + v) for v, row in enumerate(rows) for u, mark in enumerate(row) if mark == "#"
    ]
    triangle = NoFlyShape(
        first_x=0, first_y=0, last_x=3, last_y=3, edges=((0, 1, 0), (0, 0, 1), (2, -1, -1))
    )
    assert drawn(triangle) == [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (0, 2)]


def test_a_box_is_a_shape_without_edges():
    box = NoFlyShape(first_x=1, first_y=2, last_x=2, last_y=2, edges=())
    assert drawn(box) == [(1, 2), (2, 2)]
