"""Scenarios of replans, and the table of a few of them."""

import dataclasses
import math

import numpy as np
import pytest

from bench import pages, replan, replan_scenarios
from bench.replan import ROWS, YARDSTICK, _first_plan, fly_row, run
from bench.replan_report import MODEL, report
from bench.replan_scenarios import KINDS, draw_mission, draw_scenario, terrain_of
from bench.report import Options
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planning import Search
from pathgene.host.replanning.planner import InFlightPlanner


@pytest.fixture
def canyon(monkeypatch):
    """All scenarios over one map."""
    monkeypatch.setattr(replan_scenarios, "terrains", lambda: ["canyon"])


def test_every_kind_comes_on_every_map_in_turn():
    numbers = range(9 * len(KINDS))
    pairs = {(KINDS[number % len(KINDS)], terrain_of(number)) for number in numbers}
    maps = {terrain for _, terrain in pairs}
    assert len(pairs) == len(KINDS) * len(maps)


def test_scenarios_follow_from_their_number(canyon):
    for number in range(len(KINDS)):
        mission = draw_mission(number)
        way = math.dist(mission.start[:2], mission.goal[:2])
        assert 3_000 <= way <= 7_000
        drawn = draw_scenario(number, mission, 250.0)
        again = draw_scenario(number, draw_mission(number), 250.0)
        assert (drawn.kind, drawn.scenario) == (again.kind, again.scenario)
        first = drawn.scenario.events[0]
        assert 25 <= first.at_s <= 150
        dataclasses.replace(mission, goal=first.goal or mission.goal, zones=())
    others = {draw_mission(number).start for number in range(5)}
    assert len(others) == 5


@pytest.mark.ci  # Starts processes that fly.
def test_a_run_is_kept_and_pasted(canyon, tmp_path, monkeypatch):
    page = tmp_path / "page.md"
    page.write_text("<!-- tables of BENCH=replan -->\n<!-- end of BENCH=replan -->\n")
    monkeypatch.setattr(replan, "_STORE", tmp_path / "replans.json")
    monkeypatch.setattr(pages, "FIGURES", tmp_path / "figures")
    monkeypatch.setattr(pages, "PAGES", tmp_path)
    rows = {name: ROWS[name] for name in (YARDSTICK, "ga-chip, model:")}
    monkeypatch.setattr(replan, "ROWS", rows)
    monkeypatch.setattr(replan, "measure_host_s", lambda mission: 0.007)
    report = run(Options(seeds=1))
    assert [row[:2] for row in report.rows] == [(YARDSTICK, 1), ("ga-chip, model:", 1)]
    assert report.text(level=3).rstrip() in page.read_text()
    chip = report.rows[1]
    assert chip[2].startswith("1 of 1")
    p50, _, _, most = (float(each) for each in chip[3].split(" / "))
    assert 5 < p50 <= most < 25
    monkeypatch.setattr(replan, "fly_row", lambda *task: pytest.fail("measured again"))
    monkeypatch.setattr(replan, "measure_host_s", lambda mission: pytest.fail("measured again"))
    assert run(Options(seeds=1)).rows == report.rows


@pytest.mark.long  # Flies.
def test_the_verilog_flies_as_its_model_does(canyon):
    """In the same scenario, all figures are equal, including the virtual time."""
    model, verilog = (fly_row(name, [3])[0] for name in ("ga-chip, model:", "ga-chip, sim:"))
    for change in (*model["changes"], *verilog["changes"]):
        assert change.pop("measured_ms") > 0
    assert model == verilog
    assert model["alive"]
    assert np.isfinite([change["active_ms"] for change in model["changes"]]).all()


@pytest.mark.ci  # Flies.
def test_a_flight_does_not_depend_on_the_flights_before_on_its_board(canyon):
    """A map new to the chip costs cycles and generations, so the first path would differ."""
    alone, after = (fly_row("ga-chip, model:", numbers)[-1] for numbers in ([3], [2, 3]))
    for change in (*alone["changes"], *after["changes"]):
        change.pop("measured_ms")
    assert alone == after


def test_where_the_chip_has_no_first_plan_astars_is_flown(canyon, monkeypatch):
    infeasible = Search("ga-pc", generations=1, fallback="none")
    monkeypatch.setattr(InFlightPlanner, "prepare", lambda _, evaluator: infeasible.run(evaluator))
    evaluator = Evaluator(draw_mission(3), threads=1)
    assert not infeasible.run(evaluator).evaluation.feasible
    assert _first_plan(evaluator, None, 3).evaluation.feasible


def test_a_row_that_is_none_is_refused():
    with pytest.raises(InputError, match="No row has 'none' in its name"):
        run(Options(only="none"))


TOLD = {
    "flown": True,
    "alive": True,
    "ended": "arrived",
    "zone": None,
    "clearance": 30.0,
    "changes": [],
}


def change(active_ms, *attempts, at_once=True, needed=True, held=False):
    """Return a change; an attempt is a planner and its milliseconds on chip and line."""
    return {
        "at_s": 50.0,
        "what": "a zone appears",
        "needed": needed,
        "active_ms": active_ms,
        "flown_m": 0.3,
        "held": held,
        "fitness": 1.4,
        "measured_ms": 7.0,
        "at_once": at_once,
        "attempts": [[*attempt, 3.0, 7.0, 0.0, None] for attempt in attempts],
    }


def cells(flights, yardstick):
    table = report({"chip": flights}, yardstick, len(flights))
    return dict(zip(table.columns, table.rows[0], strict=True)), table.data["failures"]


def test_what_cannot_be_survived_does_not_count():
    arrived, holding, dead = TOLD, TOLD | {"ended": "holding"}, TOLD | {"alive": False}
    yardstick = {0: arrived, 1: holding, 2: dead, 3: arrived, 5: dead}
    flights = {0: arrived, 1: holding, 2: dead, 3: holding, 4: arrived, 5: holding}
    row, failures = cells(flights, yardstick)
    # The yardstick need not fly where the flight arrives.
    assert row["survived, of those that can be"] == "3 of 4 (75.0 %)"
    assert [failure["scenario"] for failure in failures] == [3]


def test_the_yardstick_flies_where_a_row_does_not_arrive(canyon, tmp_path, monkeypatch):
    monkeypatch.setattr(replan, "_STORE", tmp_path / "replans.json")
    monkeypatch.setattr(replan, "measure_host_s", lambda mission: 0.007)
    monkeypatch.setattr(replan, "_draw_worst", lambda *rest: None)
    monkeypatch.setattr(pages, "keep", lambda *rest: None)
    chip, count = "ga-chip, model:", 2 * len(KINDS)
    monkeypatch.setattr(replan, "ROWS", {name: ROWS[name] for name in (YARDSTICK, chip)})
    ends = {13: {"ended": "holding"}, 15: {"alive": False}}

    def measure(bench, tasks, work, *, name, keep):
        for task in tasks:
            keep(task, [TOLD | ends.get(number, {}) for number in task[1]])

    monkeypatch.setattr(replan, "measure", measure)
    report = run(Options(seeds=count))
    flown = {row[0]: row[1] for row in report.rows}
    assert flown == {YARDSTICK: len(KINDS) + len(ends), chip: count}


def test_where_there_is_a_path_at_once():
    changes = [
        change(12.0, ("ga-chip", 2.0)),
        change(30.0, ("ga-chip", 4.0), ("ga-chip", 1.0)),
        # No ample search finds one at that instant; the board is lost; not needed.
        change(99.0, ("ga-chip", 90.0), at_once=False),
        change(300.0, ("ga-chip", 0.0), ("astar", 0.0)),
        change(99.0, ("ga-chip", 90.0), needed=False),
        # The aircraft waits on a circle, or there never is a path.
        change(700.0, ("ga-chip", 80.0), held=True),
        change(None, ("ga-chip", 3.0), held=True),
    ]
    row, _ = cells({0: TOLD | {"changes": changes}}, {0: TOLD})
    assert row["where there is a path at once"] == "4 of 6"
    assert row["chip and line ms there"] == "5.00 / never / never / never"
    assert row["new path there after ms"] == "30.0 / never / never / never"


def test_answers_name_the_flights_of_exceptions():
    changes = [
        change(12.0, ("ga-chip", 2.0)),
        change(8.0, ("ga-chip", 2.5), ("ga-chip", 1.0)),
        change(None, ("ga-chip", 3.0), held=True),
    ]
    flights = {
        7: TOLD | {"changes": changes, "share": 0.98, "ready": 1.0},
        2: TOLD | {"alive": False, "share": 1.2, "ready": 0.9, "changes": changes[:1]},
    }
    table = report({MODEL: flights}, {2: TOLD}, 2)
    (answers,) = table.further
    assert [row[1:] for row in answers.rows] == [
        ("1 of 2; arrived: 1", "2"),
        ("1", "2"),
        ("0.98", "-"),
        ("2 of 3 (66.7 %)", "7"),
        ("1 of 4 (25.0 %)", "2, 7"),
        ("3 of 4 (75.0 %)", "7"),
        ("3 of 3 (100.0 %)", "-"),
        ("1 of 2", "-"),
    ]
    assert not report({"chip": flights}, {}, 2).further
