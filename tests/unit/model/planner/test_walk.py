"""The walk of a segment: the compiled one against the definition, and both against exact lines."""

import itertools
from fractions import Fraction

import numpy as np
import pytest

from sim.model.planner.definition.walk import passed
from sim.model.planner.definition.walk import walk as defined
from sim.model.planner.walk import walk
from tests.planner_cases import SMALL, USUAL, ground, path


CORNERS = list(itertools.product(range(5), repeat=2))


def compiled(heights, blocked, ends, start, stop):
    return walk(heights, blocked, np.array(ends, dtype=np.int64).ravel(), *start, *stop)


@pytest.mark.parametrize("config", [SMALL, USUAL], ids=["small", "usual"])
def test_compiled_walk_is_the_defined_one(config):
    rng = np.random.default_rng(1)
    heights = ground(config, rng, blocked=0.1)
    for _ in range(1500):
        start, stop, *ends = path(config, rng, waypoints=2)
        expected = defined(heights, config.blocked_altitude, ends, start, stop)
        assert compiled(heights, config.blocked_altitude, ends, start, stop) == expected


def test_every_small_segment_is_walked_alike():
    rng = np.random.default_rng(2)
    heights = rng.integers(0, 16, size=(5, 5)).astype(np.uint16)
    for (x0, y0), (x1, y1) in itertools.product(CORNERS, CORNERS):
        for z0, z1 in ((3, 12), (12, 3), (7, 7)):
            start, stop = (x0, y0, z0), (x1, y1, z1)
            ends = [(0, 0, 5), (4, 4, 9)]
            assert compiled(heights, 15, ends, start, stop) == defined(
                heights, 15, ends, start, stop
            )


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
    far = [(7, 7, 0), (7, 7, 0)]
    assert defined(heights, 15, far, (0, 0, 9), (3, 0, 9)) == (4, 15)
    heights[0, 2] = 4
    assert defined(heights, 15, far, (0, 0, 9), (3, 0, 9)) == (3, 5)


def test_around_start_and_goal_the_ground_is_no_higher_than_they_are():
    heights = np.full((8, 8), 12, dtype=np.uint16)
    ends = [(0, 0, 9), (7, 0, 9)]
    assert defined(heights, 15, ends, (0, 0, 9), (7, 0, 9)) == (4, -3)
    # Down from the start: the altitude of a half step is below it.
    assert defined(heights, 15, ends, (0, 0, 9), (1, 0, 8)) == (2, -1)
    assert defined(heights, 15, ends, (1, 0, 10), (0, 0, 9)) == (0, 0)
