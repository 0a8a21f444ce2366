"""The Verilated builds of the checker over real terrain: random and evolved paths."""

import pytest

from bench.scenarios import EMBEDDED, TILES, names
from bench.terrains import BUILDS, Ground, differing
from hdl.config import Config
from sim.harness import VerilatedChecker
from sim.model.checker_clocks import batch_clocks


pytestmark = [pytest.mark.cosim, pytest.mark.long]

PATHS = 1_000


@pytest.mark.parametrize("name", [EMBEDDED, *TILES])
def test_builds_say_what_the_model_says(name):
    if name not in names():
        pytest.skip(f"the elevation tile of {name} is not beside the repository")
    ground = Ground(name)
    evolved, _ = ground.evolved(PATHS)
    paths = ground.random(PATHS) + evolved
    assert len({tuple(map(tuple, path)) for path in paths}) == 2 * PATHS
    for build, lanes in BUILDS:
        config = Config(checker=build, lanes=lanes)
        terrain = ground.terrain(config)
        with VerilatedChecker(config) as checker:
            checker.write(ground.heights)
            for count in (False, True):
                batch = checker.check(paths, count=count)
                hits = sum(verdict["collision"] for verdict in batch.verdicts)
                # Most of the random ones; of the evolved ones, some.
                assert PATHS < hits < 2 * PATHS
                assert differing(batch, config, terrain, paths, count) == []
                clocks = [(verdict["cycles"], verdict["reads"]) for verdict in batch.verdicts]
                assert clocks == batch_clocks(config, terrain, paths, count)
