"""Rows of the flight benchmark, and a run of one row."""

import math

import pytest

from bench import flight, pages
from bench.flight import PLANNED, rows, run
from bench.flight_rows import WEATHERS, Row
from bench.report import Options
from bench.scenarios import names
from bench.store import Store
from pathgene.host.errors import InputError
from pathgene.host.planners import make


def test_rows_are_all_maps_aircraft_weathers_and_modes():
    every = rows()
    assert len(every) == (len(names()) + 2) * 2 * 3 * 2
    assert len({row.name for row in every}) == len(every)
    assert [row.name for row in rows("canyon c172p calm")] == [
        "canyon c172p calm safe",
        "canyon c172p calm paper mode",
    ]
    for name, options in PLANNED.values():
        assert callable(make(name, **options).plan)


def test_problems_are_those_of_the_row():
    calm, along, across = (Row("river", "c172p", way, False) for way in WEATHERS)
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
    """Keep results and tables separate, and only plan with astar."""
    monkeypatch.setattr(flight, "STORE", tmp_path / "flights.json")
    monkeypatch.setattr(pages, "FIGURES", tmp_path / "figures")
    monkeypatch.setattr(pages, "PAGES", tmp_path)
    monkeypatch.setattr(flight, "PLANNED", {"astar": ("astar", {})})
    page = tmp_path / "page.md"
    page.write_text("<!-- tables of BENCH=flight -->\n<!-- end of BENCH=flight -->\n")
    return Options(seeds=3, only="river silver-fox calm paper mode")


@pytest.mark.ci  # Starts processes that compile.
def test_a_run_is_kept_and_not_repeated(one, tmp_path, monkeypatch):
    report = run(one)
    assert report.rows == []
    (table,) = report.further
    (row,) = table.rows
    assert row[:3] == ("river silver-fox calm", "1/1", 1)
    (part,) = report.data["flights"][one.only]
    assert abs(part["flown, m"] - part["clearance planned, m"]) < 3
    assert table.text(level=3) in (tmp_path / "page.md").read_text()

    def fail(*_):
        raise AssertionError

    monkeypatch.setattr(flight, "_measure", fail)
    assert run(one).further[0].rows == table.rows


FLOWN = {
    "feasible": True, "kept": True, "cross_track_rms_m": 1.0, "cross_track_max_m": 4.0,
    "height_error_max_m": 2.0, "clearance_planned_m": 30.0, "clearance_flown_m": 29.0,
    "clearance_share": 0.9, "zones_entered": [], "excess": 0.05, "breaks": [],
    "plan_seconds": 1.0,
}  # fmt: skip


def test_equal_paths_count_once_and_the_worst_of_all_is_told():
    part = flight._worst(
        [
            FLOWN | {"path": "a"},
            FLOWN | {"path": "a"},
            FLOWN
            | {"path": "b", "kept": False, "clearance_flown_m": 9.0, "cross_track_max_m": 5.0}
            | {"zones_entered": ["storm"], "breaks": ["It entered storm."]},
            # Lost before the start.
            {"path": "c", "feasible": True, "kept": False, "excess": 0.0, "breaks": ["Lost."]},
            {"path": "d", "feasible": False},
        ]
    )
    assert (part["runs"], part["found"], part["flown"], part["kept"]) == (5, 4, 3, 1)
    assert part["breaks"] == ["It entered storm.", "Lost."]
    none = flight._worst([{"path": "d", "feasible": False}])
    assert flight._cells([part, none]) == (
        "4/6", 3, 1, "1.0", "5.0", "2.0", "30.0", "9.0", "0.90", 1, "0.05",
    )  # fmt: skip


def test_a_flight_by_the_rules_that_breaks_them_fails_the_run(one):
    row = Row("river", "silver-fox", "calm", False)
    bad = {"kept": {"kept": False}, "excess": {"excess": 0.06}}
    for outcome, failed in (({}, False), (bad["kept"], True), (bad["excess"], True)):
        kept = Store(flight.STORE, "bench/scenarios.py")
        kept.keep(row.name, "astar", flight._worst([FLOWN | {"path": "a"} | outcome]))
        assert flight._report(kept, [row]).failed is failed


def test_refuses_an_unknown_row():
    with pytest.raises(InputError, match=r"^No row has 'mars' in its name; one is 'canyon"):
        run(Options(only="mars"))
