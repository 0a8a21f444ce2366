"""The compiled check equals the definition, and both equal the formula over whole batches."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.sim.model.checker import TerrainModel, check_path
from pathgene.sim.model.checker_kernels import Batch, check_batch, check_paths
from tests.support.gateware.checker_cases import (
    BUILDS,
    FULL,
    TINY,
    assert_same,
    closed_form,
    ground,
    paths_of,
)
from tests.support.gateware.checker_cases import random_batch as drawn


#: Every pair of cells of the small map.
CELLS = list(itertools.product(range(8), repeat=2))
PAIRS = list(itertools.product(CELLS, repeat=2))


@st.composite
def checks(draw):
    """Draw a configuration, its ground, and up to four paths."""
    config = Config(
        max_waypoints=draw(st.integers(3, 6)),
        map_size=draw(st.sampled_from((8, 16, 32))),
        coarse_factor=draw(st.sampled_from((2, 4))),
        altitude_bits=draw(st.sampled_from((4, 5, 12))),
        checker=draw(st.sampled_from(BUILDS)),
        lanes=1,
    )
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    peaks = draw(st.sampled_from((0.0, 0.02, 0.3)))
    terrain = ground(config, rng, peaks=peaks, blocked=peaks / 2)
    cells = st.integers(0, config.map_size - 1)
    points = st.tuples(cells, cells, st.integers(0, config.blocked_altitude))
    path = st.lists(points, min_size=2, max_size=config.max_waypoints + 2)
    return config, terrain, draw(st.lists(path, max_size=4))


@given(checks(), st.booleans())
def test_matches_the_definition(case, count):
    config, terrain, paths = case
    expected = [check_path(config, terrain, path, count) for path in paths]
    assert check_paths(config, terrain, paths, count) == expected


@pytest.mark.parametrize("count", [False, True])
@pytest.mark.parametrize("tier", ["detailed", "coarse"])
def test_every_segment_of_a_small_map(tier, count):
    """Each is the first segment of a path, or the third, whose ends are coarse cells."""
    terrain = ground(TINY, np.random.default_rng(5), peaks=0.1, blocked=0.05)
    before = [] if tier == "detailed" else [(0, 0, 15), (0, 0, 15)]
    paths = [
        [*before, (*start, low), (*stop, high)]
        for (start, stop), (low, high) in itertools.product(PAIRS, [(9, 9), (4, 14), (13, 3)])
    ]
    verdicts = check_paths(TINY, terrain, paths, count)
    assert verdicts == [check_path(TINY, terrain, path, count) for path in paths]
    assert {verdict.collision for verdict in verdicts} == {False, True}
    assert any(verdict.coarse for verdict in verdicts) is (tier == "coarse")


@pytest.mark.parametrize("count", [False, True])
@pytest.mark.parametrize("build", BUILDS)
def test_random_paths_on_the_full_map(build, count):
    config = FULL.replace(checker=build)
    rng = np.random.default_rng(6)
    terrain = ground(config, rng)
    paths = paths_of(drawn(config, rng, 30))
    expected = [check_path(config, terrain, path, count) for path in paths]
    assert check_paths(config, terrain, paths, count) == expected
    assert {verdict.collision for verdict in expected} == {False, True}


def test_a_hundred_thousand_segments():
    """The paths have one segment on a map of 512, which every build checks in the detailed map."""
    rng = np.random.default_rng(7)
    terrain = ground(FULL, rng)
    for _ in range(5):
        batch = drawn(FULL, rng, 20_000, points=2)
        expected = closed_form(FULL, terrain, batch)
        assert_same(check_batch(FULL, terrain, batch, count=True), expected)
        assert_same(check_batch(FULL, terrain, batch), expected)
        # Both verdicts are frequent.
        assert 0.2 < expected.collision.mean() < 0.8


@pytest.mark.parametrize("build", BUILDS)
def test_the_formula_matches_on_whole_paths(build):
    config = FULL.replace(checker=build)
    rng = np.random.default_rng(8)
    terrain = ground(config, rng, peaks=2e-4, blocked=1e-4)
    batch = drawn(config, rng, 2_000)
    expected = closed_form(config, terrain, batch)
    assert_same(check_batch(config, terrain, batch, count=True), expected)
    assert expected.coarse.any() == (build is CheckerBuild.TWO_TIER)


def test_an_empty_batch_has_no_verdicts():
    assert check_paths(TINY, TerrainModel(TINY), []) == []


def test_refuses_bad_batches():
    terrain = TerrainModel(TINY)
    with pytest.raises(ValueError, match=r"^A path must have from 2 to 6 points, not 1$"):
        Batch.of(TINY, [[(0, 0, 1), (1, 1, 1)], [(0, 0, 1)]])
    with pytest.raises(ValueError, match=r"^A point must lie within .*, not \(0, 8, 1\)$"):
        check_paths(TINY, terrain, [[(0, 0, 1), (0, 8, 1)]])
    with pytest.raises(ValueError, match=r"^Config.checker must name a build, not 'none'$"):
        check_paths(Config(checker=CheckerBuild.NONE), TerrainModel(Config()), [])
