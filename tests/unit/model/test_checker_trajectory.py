"""The testing trajectory has the properties of the paper's (*allaire two-tier*, section 4)."""

import itertools

import numpy as np
import pytest

from bench.testing_trajectory import TESTING_TRAJECTORY, canyon_map
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.host.device.map_frames import padded_map
from pathgene.sim.model.checker import (
    TerrainModel,
    Verdict,
    check_path,
    paper_cycles,
    segment_cells,
    to_coarse,
    walk,
)
from pathgene.sim.model.checker_cycles import batch_cycles
from tests.support.gateware.checker_cases import FULL


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
