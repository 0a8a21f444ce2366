"""The Verilated parallel checker over the embedded terrain.

For all builds over all terrains see ``tests/long/test_checker_terrains.py``.
"""

import pytest

from bench.scenarios import EMBEDDED
from bench.terrains import Ground, differing
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.sim.harness import VerilatedChecker


pytestmark = [pytest.mark.cosim, pytest.mark.ci]

#: The chip of test_parallel_checker.py, so that it is built once.
FULL = Config(checker=CheckerBuild.PARALLEL)
PATHS = 300


def test_random_and_evolved_paths():
    ground = Ground(EMBEDDED)
    evolved, _ = ground.evolved(PATHS)
    terrain = ground.terrain(FULL)
    with VerilatedChecker(FULL) as checker:
        checker.write(ground.heights)
        for paths in (ground.random(PATHS), evolved):
            for count in (False, True):
                batch = checker.check(paths, count=count)
                hits = sum(verdict["collision"] for verdict in batch.verdicts)
                assert 0 < hits <= PATHS
                assert differing(batch, FULL, terrain, paths, count) == []
                assert any(batch.entries) == count
