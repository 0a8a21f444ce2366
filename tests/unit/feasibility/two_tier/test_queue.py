"""The two-tier build at full speed, under Verilator: every segment, long queues."""

import itertools

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.sim.harness import VerilatedChecker
from pathgene.sim.model.checker import TerrainModel, check_path
from pathgene.sim.model.checker_cycles import batch_cycles
from tests.support.gateware.checker_cases import TINY, ground, paths_of, random_batch
from tests.unit.feasibility.checker_driver import summary


pytestmark = pytest.mark.cosim


def check(checker, terrain, paths, *, count=False, stall=0):
    """Compare a queue with the model, cycles and reads included; return the verdicts."""
    config = checker.config
    batch = checker.check(paths, count=count, stall=stall)
    found = []
    for verdict, entries in zip(batch.verdicts, batch.entries, strict=True):
        fields = ("segment", "x", "y", "coarse", "cells")
        segment, x, y, coarse, cells = (verdict[field] for field in fields)
        entries = tuple((entry["segment"], entry["terrain"], entry["nofly"]) for entry in entries)
        found.append((bool(verdict["collision"]), segment, x, y, bool(coarse), cells, entries))
    assert found == [summary(check_path(config, terrain, path, count)) for path in paths]
    if not stall:
        costs = [(verdict["cycles"], verdict["reads"]) for verdict in batch.verdicts]
        assert costs == batch_cycles(config, terrain, paths, count)
    return batch.verdicts


def load(checker, terrain):
    checker.write(terrain.heights)


@pytest.mark.ci
def test_every_segment_of_a_tiny_map():
    """All pairs of cells as first, second and third segment of a path: both tiers, all slopes."""
    config = TINY
    rng = np.random.default_rng(1)
    cells = list(itertools.product(range(config.map_size), repeat=2))
    with VerilatedChecker(config) as checker:
        terrain = ground(config, rng, peaks=0.1, blocked=0.03)
        load(checker, terrain)
        for before in range(3):
            paths = []
            for start, stop in itertools.product(cells, repeat=2):
                z = rng.integers(4, 15, 2)
                paths.append([(*start, 15)] * before + [(*start, int(z[0])), (*stop, int(z[1]))])
            verdicts = check(checker, terrain, paths)
            assert 0.2 < np.mean([verdict["collision"] for verdict in verdicts]) < 0.9


@pytest.mark.parametrize(
    ("latency", "turns"),
    [
        pytest.param(1, 8, marks=pytest.mark.ci),
        pytest.param(1, 20, marks=pytest.mark.long),
        pytest.param(2, 20, marks=pytest.mark.long),
    ],
)
def test_queues_over_a_changing_map(latency, turns):
    """Queues, counted and not, stalled and not, between partial uploads that raise and lower."""
    config = Config(
        map_size=64, altitude_bits=8, checker="two-tier", lanes=1, memory_latency=latency
    )
    rng = np.random.default_rng(1)
    edge, top = config.map_size, config.blocked_altitude
    terrain = TerrainModel(config)
    with VerilatedChecker(config) as checker:
        terrain.write(0, 0, rng.integers(0, top // 4, (edge, edge)))
        load(checker, terrain)
        for turn in range(turns):
            x, y = rng.integers(0, edge - 1, 2).tolist()
            width, height = rng.integers(1, 20, 2).tolist()
            altitudes = rng.integers(0, top // 4, (min(height, edge - y), min(width, edge - x)))
            if turn % 3:
                altitudes[rng.random(altitudes.shape) < 0.1 * (turn % 3)] = rng.integers(
                    top // 2, top
                )
                altitudes[rng.random(altitudes.shape) < 0.02] = top
            terrain.write(x, y, altitudes)
            checker.write(altitudes, x, y)
            paths = paths_of(random_batch(config, rng, 60))
            check(checker, terrain, paths)
            check(checker, terrain, paths, count=True)
            check(checker, terrain, paths, count=bool(turn % 2), stall=2 + turn)
            for path in paths[:5]:
                check(checker, terrain, [path], count=bool(turn % 2))
