"""The benchmark of scale: rows in processes of their own, over ground from a seed."""

import numpy as np

from bench import scale
from bench.report import Options
from pathgene.host.terrain import Terrain


def test_measures_each_case_with_each_planner(monkeypatch):
    monkeypatch.setattr(scale, "CASES", ((400, 20, 1),))
    monkeypatch.setattr(scale, "PLANNERS", ("astar",))
    report = scale.run(Options())
    ((nodes, zones, via, planner, first_s, second_s, peak, fitness),) = report.rows
    assert (nodes, zones, via, planner) == (400, 20, 1, "astar")
    assert 0 < second_s < first_s
    assert peak > 50
    assert 1 < fitness < 2


def test_missions_have_their_zones_and_points():
    terrain = Terrain("land", scale.land(400), 30.0, 30.0)
    again = scale.land(400)
    np.testing.assert_array_equal(terrain.elevation, again)
    assert 0 <= terrain.lowest < terrain.highest <= 900
    whole = scale.mission(terrain, 100, 5)
    assert len(whole.problem.zones) == 100
    assert whole.legs == 6
    assert scale.mission(terrain, 0, 0).legs == 1
