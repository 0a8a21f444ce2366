"""The compiled collision check on a million segments and a hundred thousand paths."""

import numpy as np
import pytest

from pathgene.sim.model.checker import check_path
from pathgene.sim.model.checker_kernels import check_batch, check_paths
from tests.support.gateware.checker_cases import (
    BUILDS,
    FULL,
    assert_same,
    closed_form,
    ground,
    paths_of,
    random_batch,
)


pytestmark = pytest.mark.long


def test_a_million_segments():
    rng = np.random.default_rng(2011)
    collisions = 0
    for _ in range(20):
        terrain = ground(FULL, rng)
        for _ in range(5):
            batch = random_batch(FULL, rng, 10_000, points=2)
            expected = closed_form(FULL, terrain, batch)
            assert_same(check_batch(FULL, terrain, batch, count=True), expected)
            assert_same(check_batch(FULL, terrain, batch), expected)
            collisions += int(expected.collision.sum())
    assert 200_000 < collisions < 800_000


@pytest.mark.parametrize("build", BUILDS)
def test_many_paths(build):
    """Batches are compared with the formula, and a sample of them with the definition."""
    config = FULL.replace(checker=build)
    rng = np.random.default_rng(2012)
    for _ in range(20):
        terrain = ground(config, rng, peaks=2e-4, blocked=1e-4)
        batch = random_batch(config, rng, 2_000)
        expected = closed_form(config, terrain, batch)
        assert_same(check_batch(config, terrain, batch, count=True), expected)
        paths = paths_of(batch)[:50]
        for count in (False, True):
            verdicts = [check_path(config, terrain, path, count) for path in paths]
            assert check_paths(config, terrain, paths, count) == verdicts
