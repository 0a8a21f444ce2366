"""The Verilated builds of the checker over real terrain: random and evolved paths."""

import itertools

import pytest

from bench.scenarios import EMBEDDED, TILES, names
from bench.terrains import BUILDS, Ground, differing
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.sim.harness import VerilatedChecker
from pathgene.sim.model.checker_cycles import batch_cycles


pytestmark = [pytest.mark.cosim, pytest.mark.long]

PATHS = 1_000
#: Number of paths whose cycles and reads are compared, because the model computes these slowly.
WITH_CYCLES = 200


@pytest.mark.parametrize("name", [EMBEDDED, *TILES])
def test_builds_match_the_model(name):
    if name not in names():
        # The project includes only the embedded terrain.
        pytest.skip(f"the elevation tile of {name} is not beside the repository")
    ground = Ground(name)
    evolved, _ = ground.evolved(PATHS)
    paths = list(itertools.chain(*zip(ground.random(PATHS), evolved, strict=True)))
    assert len({tuple(map(tuple, path)) for path in paths}) == 2 * PATHS
    for build, lanes in BUILDS:
        config = Config(checker=build, lanes=lanes)
        terrain = ground.terrain(config)
        with VerilatedChecker(config) as checker:
            checker.write(ground.heights)
            for count in (False, True):
                batch = checker.check(paths, count=count)
                hits = sum(verdict["collision"] for verdict in batch.verdicts)
                # Nearly all random paths collide. All evolved ones may collide with the coarse map.
                assert PATHS < hits <= 2 * PATHS
                assert hits < 2 * PATHS or build is CheckerBuild.TWO_TIER
                assert differing(batch, config, terrain, paths, count) == []
                costs = [(verdict["cycles"], verdict["reads"]) for verdict in batch.verdicts]
                first = paths[:WITH_CYCLES]
                assert costs[:WITH_CYCLES] == batch_cycles(config, terrain, first, count)
