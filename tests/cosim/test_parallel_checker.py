"""The exported parallel checker, compiled by Verilator: every segment, and full sizes."""

import itertools

import numpy as np
import pytest

from bench.feasibility import TESTING_TRAJECTORY, canyon_map
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.host.device.chip_map import padded_map
from pathgene.sim.harness import VerilatedChecker
from pathgene.sim.model.checker import TerrainModel, check_path
from tests.support.gateware.checker_cases import (
    TINY,
    check_verilated,
    ground,
    paths_of,
    random_batch,
)


pytestmark = pytest.mark.cosim

FOUR = TINY.replace(checker=CheckerBuild.PARALLEL, lanes=4)
FULL = Config(checker=CheckerBuild.PARALLEL)


@pytest.mark.ci
def test_every_segment_of_a_tiny_map():
    """All pairs of cells on three maps are queued, at random altitudes."""
    rng = np.random.default_rng(1)
    cells = list(itertools.product(range(FOUR.map_size), repeat=2))
    ends = np.array(list(itertools.product(cells, repeat=2)))
    hits = 0
    with VerilatedChecker(FOUR) as chip:
        for _ in range(3):
            terrain = ground(FOUR, rng, peaks=0.05, blocked=0.02)
            chip.write(terrain.heights)
            altitudes = rng.integers(3, 16, (len(ends), 2, 1))
            paths = np.concatenate([ends, altitudes], axis=2).tolist()
            batch = check_verilated(chip, terrain, paths)
            hits += sum(verdict["collision"] for verdict in batch.verdicts)
            check_verilated(chip, terrain, paths, count=True)
    assert 2_000 < hits < 9_000


@pytest.mark.long
@pytest.mark.parametrize(
    ("lanes", "latency", "bits"), [(8, 1, 16), (8, 2, 6), (16, 1, 6), (16, 2, 14)]
)
def test_many_lanes_on_a_small_map(lanes, latency, bits):
    """The rows of a segment are mostly empty; there are single and queued paths, and look-ups."""
    config = FOUR.replace(map_size=16, lanes=lanes, memory_latency=latency, altitude_bits=bits)
    rng = np.random.default_rng(lanes + bits)
    with VerilatedChecker(config) as chip:
        for peaks in (0.02, 0.2):
            terrain = ground(config, rng, peaks=peaks, blocked=peaks / 2)
            chip.write(terrain.heights)
            paths = paths_of(random_batch(config, rng, 2_000))
            for count in (False, True):
                batch = check_verilated(chip, terrain, paths, count)
                assert 0 < sum(verdict["collision"] for verdict in batch.verdicts) < len(paths)
            check_verilated(chip, terrain, paths, count=True, stall=50)
            for path in paths[:20]:
                check_verilated(chip, terrain, [path])
        cells = [(int(x), int(y)) for x, y in rng.integers(0, config.map_size, (200, 2))]
        found = chip.look_up(cells, config.lookup_latency)
        assert found == [terrain.heights[y, x] for x, y in cells]


def check_full_size(config, paths, limit):
    """Check the testing trajectory, and random paths over a changing rectangle."""
    rng = np.random.default_rng(config.lanes)
    terrain = TerrainModel(config)
    terrain.write(0, 0, padded_map(canyon_map(), config))
    with VerilatedChecker(config) as chip:
        chip.write(terrain.heights)
        (verdict,) = check_verilated(chip, terrain, [TESTING_TRAJECTORY]).verdicts
        assert not verdict["collision"]
        assert verdict["cycles"] <= limit

        terrain = ground(config, rng, peaks=2e-4, blocked=1e-4)
        chip.write(terrain.heights)
        for altitude in (config.blocked_altitude, 0):
            block = np.full((40, 30), altitude)
            terrain.write(201, 333, block)
            chip.write(block, 201, 333)
            drawn = paths_of(random_batch(config, rng, paths))
            batch = check_verilated(chip, terrain, drawn)
            assert 0 < sum(verdict["collision"] for verdict in batch.verdicts) < paths
            batch = check_verilated(chip, terrain, drawn, count=True)
            # Counting reads every cell of every path, without gaps.
            reads = sum(verdict["reads"] for verdict in batch.verdicts)
            assert reads >= 0.8 * config.lanes * batch.cycles
            check_verilated(chip, terrain, drawn[: paths // 4], count=True, stall=50)

        cells = [(int(x), int(y)) for x, y in rng.integers(0, config.map_size, (500, 2))]
        found = chip.look_up(cells, config.lookup_latency)
        assert found == [terrain.heights[y, x] for x, y in cells]


@pytest.mark.ci
def test_full_size():
    check_full_size(FULL, 200, limit=44)


@pytest.mark.long
def test_full_size_with_16_lanes():
    check_full_size(FULL.replace(lanes=16), 5_000, limit=30)


@pytest.mark.long
def test_many_paths():
    check_full_size(FULL, 20_000, limit=44)


def test_limits_are_those_of_the_trajectory():
    """It has 55 and 100 cells, then at most 96: 32 cycles of 8 lanes."""
    terrain = TerrainModel(FULL)
    terrain.write(0, 0, padded_map(canyon_map(), FULL))
    verdict = check_path(FULL, terrain, TESTING_TRAJECTORY)
    assert verdict.clear
    assert 55 + 100 < verdict.cells <= 55 + 100 + 96
