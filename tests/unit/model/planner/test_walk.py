"""The walk of a segment, and the memo of segments.

The compiled walk is compared with the definition, and both with exact lines. The memo answers only
for the segment that was last stored in a row.
"""

import itertools
from fractions import Fraction

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.sim.model.planner.definition.score import passed
from pathgene.sim.model.planner.definition.score import walk as defined
from pathgene.sim.model.planner.walk import walk
from tests.support.planner.cases import LARGE, SMALL, USUAL, ground, path
from tests.support.planner.plain import Memo


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
    """The claim that makes one map of corners sufficient, tested on finely divided exact lines."""
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


@pytest.mark.parametrize("size", [0, 2, 16, 512])
@pytest.mark.parametrize("config", [SMALL, USUAL], ids=["small", "usual"])
def test_a_memo_answers_for_the_segments_that_it_holds(config: Config, size):
    """A row holds one segment: the latest of all that share the row."""
    rng = np.random.default_rng(9)
    memo = Memo(config, size)
    values, holders = {}, {}
    points = path(config, rng, waypoints=5)
    hits = 0
    for number in range(3000):
        start, stop = (points[i] for i in rng.integers(len(points), size=2))
        found = memo.get(start, stop)
        row = row_of(config, size, start, stop)
        assert (found is not None) == (size > 0 and holders.get(row) == (start, stop))
        if found is not None:
            hits += 1
            assert found == values[start, stop]
        else:
            values[start, stop], holders[row] = (number, -number), (start, stop)
            memo.put(start, stop, values[start, stop])
    assert (hits > 0) == (size > 0)


def row_of(config, size, start, stop):
    """Return the row: the ends, one shifted, folded by exclusive or to the width of a row."""
    bits = config.coordinate_bits
    start, stop = (x | y << bits | z << 2 * bits for x, y, z in (start, stop))
    mixed, row = start ^ stop << 3, 0
    while size and mixed:
        row ^= mixed & size - 1
        mixed >>= size.bit_length() - 1
    return row
