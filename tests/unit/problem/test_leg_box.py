import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pathgene.host.problem.leg_box import leg_box
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


def problem(shape, start, goal, *, side_m=100.0):
    terrain = Terrain("t", np.zeros(shape), side_m, side_m)
    return Problem(terrain, (*start, 100.0), (*goal, 100.0), as_paper=True)


def test_a_short_leg_has_a_box_of_the_maps_size_around_it():
    # The middle of the leg is node (300, 205).
    rows, columns = leg_box(problem((600, 400), (20_000, 29_000), (21_000, 31_000)), 64)
    assert (rows.stop - rows.start, columns.stop - columns.start) == (64, 64)
    assert rows.start <= 300 - 31 <= 300 + 31 < rows.stop
    assert columns.start <= 205 - 31 <= 205 + 31 < columns.stop


def test_a_long_leg_has_room_on_every_side():
    # 10 km long, so 2.5 km of room: 150 nodes along the leg; across it, the map's own size.
    rows, columns = leg_box(problem((600, 400), (20_000, 20_000), (20_000, 30_000)), 64)
    assert (rows, columns) == (slice(175, 326), slice(168, 232))


@pytest.mark.parametrize("shape", [(64, 64), (40, 64), (20, 30)])
def test_a_terrain_that_fits_is_whole(shape):
    assert leg_box(problem(shape, (500, 500), (900, 1500)), 64) is None


def test_an_axis_that_fits_is_whole():
    rows, columns = leg_box(problem((600, 50), (500, 500), (900, 1500)), 64)
    assert (rows, columns) == (slice(0, 64), slice(0, 50))


@given(st.data())
@settings(max_examples=200, deadline=None)
def test_the_box_holds_the_leg_and_lies_on_the_terrain(data):
    shape = data.draw(st.tuples(st.integers(5, 300), st.integers(5, 300)))
    size = data.draw(st.sampled_from((8, 32, 64)))
    side_m = data.draw(st.floats(1, 100))
    across = [
        st.tuples(*(st.floats(0, (nodes - 1) * side_m) for nodes in reversed(shape)))
        for _ in range(2)
    ]
    start, goal = (data.draw(each) for each in across)
    if math.dist(start, goal) < side_m:
        return
    asked = problem(shape, start, goal, side_m=side_m)
    box = leg_box(asked, size)
    if box is None:
        return
    rows, columns = box
    for part, nodes in zip(box, shape, strict=True):
        assert 0 <= part.start < part.stop <= nodes
        assert part.stop - part.start >= min(size, nodes)
    room_m = max(0.25 * math.dist(start, goal), 8 * asked.limits.turn_radius_m)
    for axis, part in ((0, columns), (1, rows)):
        most_m = (shape[1 - axis] - 1) * side_m
        for end in (start, goal):
            assert part.start * side_m <= max(end[axis] - room_m, 0) + 1e-6
            assert (part.stop - 1) * side_m >= min(end[axis] + room_m, most_m) - 1e-6
