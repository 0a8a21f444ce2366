"""The default planner, ``astar`` and peers over maps."""

import pytest

from bench import real_maps, untuned


@pytest.mark.ci
def test_a_map_is_planned_by_every_column():
    found = real_maps.plan("river", 30.0, False, generations=30)
    assert list(found.fitness) == list(untuned.VARIANTS)
    # The clearance costs: as paper, F is higher.
    as_paper = real_maps.plan("river", None, False, generations=30)
    assert 1 < found.fitness["astar"] < as_paper.fitness["astar"]
