"""Rows of the benchmark of flights, and a run of one."""

import math

import pytest

from bench import flight
from bench.flight import PLANNED, Row, rows, run
from bench.report import Options
from bench.scenarios import names
from host.errors import InputError
from host.planners import make


def test_rows_are_all_maps_aircraft_weathers_and_modes():
    every = rows()
    assert len(every) == (len(names()) + 2) * 2 * 3 * 2
    assert len({row.name for row in every}) == len(every)
    assert [row.name for row in rows("canyon c172p calm")] == [
        "canyon c172p calm safe",
        "canyon c172p calm as paper",
    ]
    for name, options in PLANNED.values():
        assert callable(make(name, **options).plan)


def test_problems_are_those_of_the_row():
    calm, along, across = (Row("river", "c172p", way, False) for way in flight.WEATHERS)
    assert calm.problem().wind == (0, 0)
    task = along.problem()
    way = [b - a for a, b in zip(task.start, task.goal, strict=True)][:2]
    assert math.hypot(*task.wind) == pytest.approx(8)
    assert math.atan2(*task.wind) == pytest.approx(math.atan2(*way))
    assert sum(map(math.prod, zip(across.problem().wind, way, strict=True))) == pytest.approx(0)
    assert task.aircraft.cruise_speed_m_s == 48
    assert task.rules.clearance_m == 30
    assert Row("river", "c172p", "calm", True).problem().rules is None


@pytest.fixture
def one(tmp_path, monkeypatch):
    """Keep results apart, and plan with astar alone."""
    monkeypatch.setattr(flight, "FOLDER", tmp_path / "flights")
    monkeypatch.setattr(flight, "PLANNED", {"astar": ("astar", {})})
    return Options(seeds=3, only="river silver-fox calm as paper")


@pytest.mark.ci  # Starts processes that compile.
def test_a_run_is_kept_and_not_repeated(one, monkeypatch):
    report = run(one)
    (row,) = report.rows
    assert row[:3] == ("river silver-fox calm as paper", "1/1", 1)
    (outcome,) = report.data["runs"][row[0]]
    assert outcome["arrived"]
    assert abs(outcome["clearance_flown_m"] - outcome["clearance_planned_m"]) < 3

    def fail(*_):
        raise AssertionError

    monkeypatch.setattr(flight, "_measure", fail)
    assert run(one).rows == report.rows
    monkeypatch.setattr(flight, "digest", lambda *_: "others")
    assert flight._lacks(Row("river", "silver-fox", "calm", True), "astar", 1)


def test_equal_paths_count_once_and_breaks_fail():
    base = {
        "feasible": True, "kept": True, "cross_track_rms_m": 1.0, "cross_track_max_m": 4.0,
        "height_error_max_m": 2.0, "clearance_planned_m": 30.0, "clearance_flown_m": 29.0,
        "clearance_share": 0.9, "zones_entered": [], "excess": 0.05,
    }  # fmt: skip
    outcomes = [
        base | {"path": "a"},
        base | {"path": "a"},
        base | {"path": "b", "kept": False, "clearance_flown_m": 9.0, "cross_track_max_m": 5.0},
        {"path": "c", "feasible": True, "kept": False, "excess": 0.0},  # Lost before the start.
        {"path": "d", "feasible": False},
    ]
    assert flight._cells(outcomes) == ("4/5", 3, 1, 1.0, 5.0, 2.0, 30.0, 9.0, 0.9, 0, 0.05)


def test_refuses_an_unknown_row():
    with pytest.raises(InputError, match=r"^No row has 'mars' in its name; one is 'canyon"):
        run(Options(only="mars"))
