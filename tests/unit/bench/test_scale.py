"""The benchmark of scale: rows in processes of their own, over ground from a seed."""

import subprocess
import sys

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


def test_a_long_plan_is_not_repeated_and_one_that_takes_too_long_has_no_row(monkeypatch, tmp_path):
    file = tmp_path / "land.npz"
    np.savez(file, elevation=scale.land(200).astype(np.float32), dx_m=60.0, dy_m=60.0)
    monkeypatch.setattr(scale, "_LONG_S", 0.0)
    row = scale.measure(str(file), "astar", 0, 0)
    assert row["second_s"] is None
    assert scale._cells(row)[1] == "-"
    monkeypatch.setattr(scale, "_MOST_S", 0.01)
    assert scale._cells(scale._alone(file, "astar", 0, 0)) == ("-",) * 4


def test_the_peak_is_of_the_process_alone():
    peak = "from bench.scale import _peak_mb; print(_peak_mb())"
    large = np.ones(50_000_000)
    done = subprocess.run(
        [sys.executable, "-c", peak], stdout=subprocess.PIPE, text=True, check=True
    )
    assert float(done.stdout) < 1e-6 * large.nbytes
