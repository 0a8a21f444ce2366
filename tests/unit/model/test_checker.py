"""The definition of the collision check: examples computed by hand, and properties.

The testing trajectory has the properties of the paper's (*allaire two-tier*, section 4).
"""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.feasibility import TESTING_TRAJECTORY, canyon_map
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.host.device.chip_map import padded_map
from pathgene.sim.model.checker import (
    TerrainModel,
    Verdict,
    check_path,
    check_points,
    paper_cycles,
    segment_cells,
    to_coarse,
    walk,
)
from pathgene.sim.model.checker_cycles import batch_cycles
from tests.support.gateware.checker_cases import BUILDS, FULL, TINY


TWO_TIER = Config(
    max_waypoints=4, map_size=16, coarse_factor=4, altitude_bits=6, checker="two-tier", lanes=1
)
PARALLEL = TWO_TIER.replace(checker=CheckerBuild.PARALLEL)

POINTS = st.tuples(st.integers(0, 511), st.integers(0, 511), st.integers(0, 4095))


def flat(config, height=0, **cells):
    """Return level ground, with altitudes of single cells given as ``x_y=altitude``."""
    terrain = TerrainModel(config)
    terrain.write(0, 0, np.full((config.map_size,) * 2, height))
    for cell, altitude in cells.items():
        x, y = map(int, cell.strip("c").split("_"))
        terrain.write(x, y, [[altitude]])
    return terrain


# --- Cells of a segment --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("start", "stop", "cells"),
    [
        ((3, 4, 9), (3, 4, 5), [(3, 4, 5)]),
        ((0, 0, 1), (2, 0, 2), [(0, 0, 1), (1, 0, Fraction(3, 2)), (2, 0, 2)]),
        # Halves are rounded up in both directions: 0.5 to 1, 1.5 to 2.
        ((0, 0, 0), (2, 1, 0), [(0, 0, 0), (1, 1, 0), (2, 1, 0)]),
        ((2, 1, 0), (0, 0, 0), [(2, 1, 0), (1, 1, 0), (0, 0, 0)]),
        ((0, 1, 0), (2, 0, 0), [(0, 1, 0), (1, 1, 0), (2, 0, 0)]),
        ((1, 4, 8), (2, 0, 0), [(1, 4, 8), (1, 3, 6), (2, 2, 4), (2, 1, 2), (2, 0, 0)]),
        ((2, 2, 0), (0, 0, 4), [(2, 2, 0), (1, 1, 2), (0, 0, 4)]),
        (
            (0, 0, 0),
            (3, 1, 1),
            [(0, 0, 0), (1, 0, Fraction(1, 3)), (2, 1, Fraction(2, 3)), (3, 1, 1)],
        ),
    ],
)
def test_cells_by_hand(start, stop, cells):
    assert list(walk(start, stop)) == cells
    assert segment_cells(start, stop) == len(cells)


@given(POINTS, POINTS)
def test_cells_are_nearest_to_the_straight_line(start, stop):
    cells = list(walk(start, stop))
    n = len(cells) - 1
    if n == 0:
        assert cells == [(*start[:2], min(start[2], stop[2]))]
        return
    assert (cells[0], cells[-1]) == (start, stop)
    for k, cell in enumerate(cells):
        exact = [a + Fraction(k * (b - a), n) for a, b in zip(start, stop, strict=True)]
        assert cell[2] == exact[2]
        for axis in (0, 1):
            assert -Fraction(1, 2) < cell[axis] - exact[axis] <= Fraction(1, 2)
    steps = [(abs(b[0] - a[0]), abs(b[1] - a[1])) for a, b in itertools.pairwise(cells)]
    assert all(max(step) == 1 for step in steps)


# --- Ground --------------------------------------------------------------------------------------


def test_unwritten_cells_are_blocked():
    terrain = TerrainModel(FULL)
    assert terrain.heights.shape == (512, 512)
    assert terrain.coarse.shape == (32, 32)
    assert {*terrain.heights.flat, *terrain.coarse.flat} == {4095}


def test_partial_writes_keep_the_maxima():
    """A block has the maximum of its current cells, also after lower altitudes are written."""
    rng = np.random.default_rng(1)
    terrain, expected = TerrainModel(TINY), np.full((8, 8), 15)
    for _ in range(200):
        x, y = rng.integers(0, 8, 2)
        block = rng.integers(0, 16, (rng.integers(1, 9 - y), rng.integers(1, 9 - x)))
        terrain.write(int(x), int(y), block)
        expected[y : y + block.shape[0], x : x + block.shape[1]] = block
        assert np.array_equal(terrain.heights, expected)
        for cy, cx in np.ndindex(4, 4):
            assert (
                terrain.coarse[cy, cx] == expected[2 * cy : 2 * cy + 2, 2 * cx : 2 * cx + 2].max()
            )


def test_the_maps_are_read_only():
    terrain = TerrainModel(TINY)
    for array in (terrain.heights, terrain.coarse):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1


@pytest.mark.parametrize(
    ("x", "y", "block", "sentence"),
    [
        (0, 0, [1, 2], r"^A block must be .* two axes of integers, not of shape \(2,\) of int64$"),
        (0, 0, [[0.5]], r"^A block must be .*, not of shape \(1, 1\) of float64$"),
        (0, 0, np.empty((0, 2), int), r"^A block must be a filled array .*, not of shape \(0, 2\)"),
        (7, 0, [[1, 2]], r"^A block must lie within 0..7, not 2 x 1 cells at \(7, 0\)$"),
        (0, -1, [[1, 2]], r"^A block must lie within 0..7, not 2 x 1 cells at \(0, -1\)$"),
        (0, 6, [[1], [2], [3]], r"^A block must lie within 0..7, not 1 x 3 cells at \(0, 6\)$"),
        (0, 0, [[16]], r"^An altitude must be from 0 to 15, not 16 to 16$"),
        (0, 0, [[3, -1]], r"^An altitude must be from 0 to 15, not -1 to 3$"),
    ],
)
def test_refuses_bad_blocks(x, y, block, sentence):
    terrain = TerrainModel(TINY)
    with pytest.raises(ValueError, match=sentence):
        terrain.write(x, y, block)
    assert {*terrain.heights.flat} == {15}


# --- Verdicts ------------------------------------------------------------------------------------


@pytest.mark.parametrize("build", BUILDS)
def test_touching_the_ground_is_a_collision(build):
    """A path collides at exactly the ground's altitude; a fraction of a step above is clear."""
    config = TWO_TIER.replace(checker=build, lanes=1)
    # Altitudes 1, 4/3, 5/3, 2.
    path = [(0, 0, 1), (3, 0, 2)]
    free = Verdict(False, True, 0, 0, 0, False, cells=4)
    assert check_path(config, flat(config), path) == free
    assert check_path(config, flat(config, c1_0=1), path) == free
    for altitude, cell in ((1, (0, 0)), (2, (1, 0)), (2, (2, 0)), (2, (3, 0))):
        terrain = flat(config, **{f"c{cell[0]}_{cell[1]}": altitude})
        assert check_path(config, terrain, path) == Verdict(
            True, False, 0, *cell, False, cells=cell[0] + 1
        )


def test_first_collision_ends_the_check_unless_it_counts():
    path = [(0, 0, 9), (4, 0, 9), (4, 4, 9), (0, 4, 9)]
    terrain = flat(PARALLEL, c4_2=20, c4_3=20, c2_4=63)
    hit = {"segment": 1, "x": 4, "y": 2, "coarse": False, "cells": 5 + 3}
    assert check_path(PARALLEL, terrain, path) == Verdict(True, False, **hit)
    counted = check_path(PARALLEL, terrain, path, count=True)
    assert counted == Verdict(True, False, **hit, entries=((1, 2, 0), (2, 0, 1)))


def test_a_waypoint_in_the_ground_counts_in_both_its_segments():
    path = [(0, 0, 9), (4, 0, 9), (4, 4, 9)]
    terrain = flat(PARALLEL, c4_0=9)
    assert check_path(PARALLEL, terrain, path).cells == 5
    assert check_path(PARALLEL, terrain, path, count=True).entries == ((0, 1, 0), (1, 1, 0))


def test_blocked_cells_differ_from_terrain():
    """The top altitude blocks paths at any height; one step below is terrain."""
    path = [(0, 0, 63), (7, 0, 63)]
    terrain = flat(PARALLEL, c2_0=63, c3_0=62, c5_0=63)
    assert check_path(PARALLEL, terrain, path, count=True).entries == ((0, 0, 2),)
    lower = [(x, y, 62) for x, y, _ in path]
    assert check_path(PARALLEL, terrain, lower, count=True).entries == ((0, 1, 2),)


def test_third_segment_uses_the_coarse_map():
    """The segment is clear in every detailed cell but collides with the peak of its block."""
    path = [(0, 0, 9), (1, 0, 9), (2, 0, 9), (9, 0, 9), (15, 0, 9)]
    terrain = flat(TWO_TIER, c10_3=30, c1_1=30)
    assert check_path(PARALLEL, terrain, path) == Verdict(
        False, True, 0, 0, 0, False, cells=2 + 2 + 8 + 7
    )
    # The third segment starts in the block of c1_1.
    assert check_path(TWO_TIER, terrain, path) == Verdict(
        True, False, 2, 0, 0, coarse=True, cells=2 + 2 + 1
    )
    terrain.write(1, 1, [[0]])
    assert check_path(TWO_TIER, terrain, path) == Verdict(
        True, False, 2, 2, 0, coarse=True, cells=2 + 2 + 3
    )
    counted = check_path(TWO_TIER, terrain, path, count=True)
    assert counted.entries == ((2, 1, 0), (3, 1, 0))
    assert counted.cells == 2 + 2 + 3
    terrain.write(10, 3, [[0]])
    assert check_path(TWO_TIER, terrain, path) == Verdict(
        False, True, 0, 0, 0, False, cells=2 + 2 + 3 + 2
    )


def test_a_coarse_segment_in_one_block_has_its_lower_altitude():
    path = [(0, 0, 9), (1, 0, 9), (4, 0, 9), (7, 3, 5)]
    assert to_coarse(TWO_TIER, path[2]) == (1, 0, 9)
    assert check_path(TWO_TIER, flat(TWO_TIER, c5_2=4), path).clear
    hit = check_path(TWO_TIER, flat(TWO_TIER, c5_2=5), path)
    assert hit == Verdict(True, False, 2, 1, 0, True, cells=2 + 4 + 1)


@pytest.mark.parametrize(
    ("points", "sentence"),
    [
        ([(0, 0, 0)], r"^A path must have from 2 to 6 points, not 1$"),
        ([(0, 0, 0)] * 7, r"^A path must have from 2 to 6 points, not 7$"),
        ([(0, 0, 0), (8, 0, 0)], r"^A point must lie within 0..7, 0..7, 0..15, not \(8, 0, 0\)$"),
        ([(0, -1, 0), (0, 0, 0)], r"^A point must lie within .*, not \(0, -1, 0\)$"),
        ([(0, 0, 0), (0, 0, 16)], r"^A point must lie within .*, not \(0, 0, 16\)$"),
    ],
)
def test_refuses_bad_paths(points, sentence):
    with pytest.raises(ValueError, match=sentence):
        check_points(TINY, points)
    with pytest.raises(ValueError, match=sentence):
        check_path(TINY, TerrainModel(TINY), points)


def test_refuses_a_chip_without_a_checker():
    config = Config(checker=CheckerBuild.NONE)
    with pytest.raises(ValueError, match=r"^Config.checker must name a build, not 'none'$"):
        check_path(config, TerrainModel(config), [(0, 0, 0), (1, 1, 1)])


# --- Cycles of the paper -------------------------------------------------------------------------


def test_cycles_of_the_papers_tables_and_text():
    assert paper_cycles(cells=55 + 100 + 6, segments=3) == 171
    # Section 5.1.3: 392 cells in 14 further segments take the remaining 3.5 of 5 us, 8 ns each.
    further = paper_cycles(cells=55 + 100 + 6 + 392, segments=17) - paper_cycles(161, 3)
    assert further == 392 + 14 * 3
    assert further <= 3.5e-6 / 8e-9


FIRST, SECOND, THIRD = SEGMENTS = list(itertools.pairwise(TESTING_TRAJECTORY))


@pytest.fixture(scope="module")
def terrain():
    terrain = TerrainModel(FULL)
    terrain.write(0, 0, padded_map(canyon_map(), FULL))
    return terrain


def clearances(ground, segment):
    return [float(altitude - int(ground[y, x])) for x, y, altitude in walk(*segment)]


def coarse_clearances(terrain, segment):
    ends = tuple(to_coarse(FULL, point) for point in segment)
    return clearances(terrain.coarse, ends)


def test_the_map_is_the_canyon_with_a_blocked_border(terrain):
    canyon = terrain.heights[:500, :500]
    assert (canyon.min(), canyon.max()) == (0, 3500)
    assert (terrain.heights[500:] == 4095).all()
    assert (terrain.heights[:, 500:] == 4095).all()
    assert np.array_equal(canyon, canyon_map())


def test_segments_have_the_papers_cells():
    assert [segment_cells(*segment) for segment in SEGMENTS] == [55, 100, 94]
    assert segment_cells(*(to_coarse(FULL, point) for point in THIRD)) == 6
    # The first two cover about 2,500 m of cells of 16 m.
    lengths = [np.hypot(b[0] - a[0], b[1] - a[1]) for a, b in (FIRST, SECOND)]
    assert sum(lengths) * 16 == pytest.approx(2500, rel=0.2)


def test_is_clear_in_every_detailed_cell(terrain):
    """It passes close to the ground, but not so close that rounding could matter."""
    lowest = min(min(clearances(terrain.heights, segment)) for segment in SEGMENTS)
    assert 20 < lowest < 30
    parallel = FULL.replace(checker=CheckerBuild.PARALLEL)
    verdict = check_path(parallel, terrain, TESTING_TRAJECTORY)
    assert verdict == Verdict(False, True, 0, 0, 0, False, cells=55 + 100 + 94)


def test_third_segment_hits_the_mountain_in_its_sixth_coarse_cell(terrain):
    *before, at_the_goal = coarse_clearances(terrain, THIRD)
    assert len(before) == 5
    assert min(before) > 20
    assert at_the_goal < -20
    verdict = check_path(FULL, terrain, TESTING_TRAJECTORY)
    assert verdict == Verdict(True, False, 2, 10, 10, True, cells=55 + 100 + 6)
    counted = check_path(FULL, terrain, TESTING_TRAJECTORY, count=True)
    assert counted.entries == ((2, 1, 0),)


@pytest.mark.parametrize(
    ("build", "lanes", "most"),
    [("two-tier", 1, 171), ("parallel", 8, 44), ("parallel", 16, 30)],
)
def test_no_build_exceeds_its_cycles(terrain, build, lanes, most):
    config = FULL.replace(checker=build, lanes=lanes)
    [(cycles, reads)] = batch_cycles(config, terrain, [TESTING_TRAJECTORY])
    assert cycles <= most
    assert reads == check_path(config, terrain, TESTING_TRAJECTORY).cells


def test_a_chip_without_a_checker_has_no_cycles(terrain):
    with pytest.raises(ValueError, match=r"^Config.checker must name a build, not 'none'$"):
        batch_cycles(Config(checker=CheckerBuild.NONE), terrain, [TESTING_TRAJECTORY])


def test_takes_the_papers_cycles(terrain):
    verdict = check_path(FULL, terrain, TESTING_TRAJECTORY)
    assert paper_cycles(verdict.cells, segments=verdict.segment + 1) == 171
