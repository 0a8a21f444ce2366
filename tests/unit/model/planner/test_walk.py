"""The walk of a segment: the compiled one against the definition, and both against exact lines."""

import itertools
from fractions import Fraction

import numpy as np
import pytest

from pathgene.sim.model.planner.definition.score import passed
from pathgene.sim.model.planner.definition.score import walk as defined
from pathgene.sim.model.planner.walk import walk
from tests.support.planner.cases import LARGE, SMALL, USUAL, ground, path


CORNERS = list(itertools.product(range(5), repeat=2))


def compiled(heights, blocked, start, stop):
    return walk(heights, blocked, *start, *stop)


@pytest.mark.parametrize("config", [SMALL, USUAL], ids=["small", "usual"])
def test_compiled_walk_is_the_defined_one(config):
    rng = np.random.default_rng(1)
    heights = ground(config, rng, blocked=0.1)
    for _ in range(1500):
        start, stop, *_ = path(config, rng, waypoints=2)
        expected = defined(heights, config.blocked_altitude, start, stop)
        assert compiled(heights, config.blocked_altitude, start, stop) == expected


def test_the_longest_segments_are_walked_alike():
    """The steps of x, y and altitude add up most here. Neighbouring corners differ in height."""
    rng = np.random.default_rng(4)
    size, top = LARGE.map_size, LARGE.blocked_altitude
    x, y = np.meshgrid(np.arange(size, dtype=np.uint32), np.arange(size, dtype=np.uint32))
    heights = ((x * 40_503 + y * 30_011) % (top + 1)).astype(np.uint16)
    edge = (0, size - 1)
    for _ in range(60):
        start, stop = (
            (int(rng.choice(edge)), int(rng.integers(size)), int(rng.integers(top + 1)))
            for _ in range(2)
        )
        if rng.random() < 0.5:
            start, stop = ((y, x, z) for x, y, z in (start, stop))
        assert compiled(heights, top, start, stop) == defined(heights, top, start, stop)


def test_every_small_segment_is_walked_alike():
    rng = np.random.default_rng(2)
    heights = rng.integers(0, 16, size=(5, 5)).astype(np.uint16)
    for (x0, y0), (x1, y1) in itertools.product(CORNERS, CORNERS):
        for z0, z1 in ((3, 12), (12, 3), (7, 7)):
            start, stop = (x0, y0, z0), (x1, y1, z1)
            assert compiled(heights, 15, start, stop) == defined(heights, 15, start, stop)


def test_a_segment_stays_within_the_cells_around_its_corners_and_above_its_altitudes():
    """The claim that makes one map of corners enough, on a fine cut of the exact line."""
    rng = np.random.default_rng(3)
    for _ in range(200):
        start, stop = (
            (*rng.integers(0, 12, size=2).tolist(), int(z)) for z in rng.integers(50, size=2)
        )
        walked = list(passed(start, stop))
        for i in range(241):
            share = Fraction(i, 240)
            x, y, z = (a + (b - a) * share for a, b in zip(start, stop, strict=True))
            # Corner c lies between the cells from c - 1 to c and from c to c + 1.
            nearest = [
                corner for corner in walked if abs(corner[0] - x) <= 1 and abs(corner[1] - y) <= 1
            ]
            assert nearest
            steps = max(abs(stop[0] - start[0]), abs(stop[1] - start[1]))
            at = (2 * i * steps + 240) // 480
            corner = walked[at]
            assert abs(corner[0] - x) <= 1
            assert abs(corner[1] - y) <= 1
            assert corner[2] <= z


def test_blocked_corners_count_and_have_no_margin():
    heights = np.full((8, 8), 15, dtype=np.uint16)
    assert defined(heights, 15, (0, 0, 9), (3, 0, 9)) == (4, 15)
    heights[0, 2] = 4
    assert defined(heights, 15, (0, 0, 9), (3, 0, 9)) == (3, 5)


def test_the_altitude_of_half_a_step_counts_but_none_below_the_lower_end():
    heights = np.full((8, 8), 9, dtype=np.uint16)
    assert defined(heights, 15, (0, 0, 11), (1, 0, 9)) == (0, 0)
    assert defined(heights, 15, (0, 0, 11), (2, 0, 7)) == (2, -2)
