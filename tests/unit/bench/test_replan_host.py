"""The host's share of a replan is the sum of its parts."""

from statistics import median

import pytest

from bench.replan_host import PARTS, Stopwatch
from bench.replan_scenarios import draw_mission
from pathgene.host.planners.base import Run
from pathgene.host.replanning.calibration import measure_host_s


@pytest.mark.ci
def test_parts_make_up_the_share():
    stopwatch, fitness = Stopwatch(), Run.fitness
    with stopwatch.installed():
        share_s = measure_host_s(draw_mission(3), stopwatch.watch)
    assert Run.fitness is fitness
    assert len(stopwatch.replans) == 13
    assert all(replan[part] > 0 for replan in stopwatch.replans for part in PARTS)
    # The first two replans do not count.
    wholes = [sum(replan.values()) for replan in stopwatch.replans[2:]]
    assert median(wholes) == pytest.approx(share_s, rel=0.3)
