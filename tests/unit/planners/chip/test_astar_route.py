"""The route of ``astar`` beside the chip's, on the software model."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.host import connection
from pathgene.host.planners.base import Options, Run, Stop
from pathgene.host.planners.chip import ga_chip, polish
from pathgene.host.planners.chip.astar_route import Routes
from pathgene.host.planners.chip.ga_chip import ChipGeneticPlanner
from pathgene.host.planners.chip.guide import guide_of
from pathgene.host.planners.chip.runs import ChipRuns
from pathgene.host.planners.grid import astar, further, refinement
from pathgene.host.planners.grid.astar import AstarPlanner
from pathgene.host.planning import Search
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Zone


CHIP = Config(core="planner")
#: A chip's search that hardly improves its first paths, and one that does.
SHORT, LONG = Options(generations=1, seed=3), Options(generations=4_000, seed=3)


@pytest.fixture
def calls(monkeypatch):
    """The options of all searches by astar, which take place."""
    seen, real = [], AstarPlanner.plan

    def plan(planner, evaluator, options, progress=None, stop=None):
        seen.append(options)
        return real(planner, evaluator, options, progress, stop)

    monkeypatch.setattr(AstarPlanner, "plan", plan)
    return seen


def planned(evaluator, options=SHORT, **own):
    return ChipGeneticPlanner(**own).plan(evaluator, options)


@pytest.fixture
def unrefined(monkeypatch):
    """No trial follows the routes."""
    monkeypatch.setattr(refinement, "TRIALS", 0)


def astar_plan(evaluator):
    return AstarPlanner().plan(evaluator, Options(generations=400))


@pytest.mark.usefixtures("unrefined")
def test_a_better_route_of_astar_is_reported(evaluator, calls):
    own, result = planned(evaluator, polish="chip"), planned(evaluator)
    assert len(calls) == 1
    other = astar_plan(evaluator)
    assert own.evaluation.fitness < other.evaluation.fitness - 1e-3
    assert result.hardware["route_from"] == "astar"
    assert result.hardware["routes"] == {
        "chip": own.evaluation.fitness,
        "astar": result.evaluation.fitness,
    }
    assert evaluator.evaluate(result.path) == result.evaluation
    # It has as many waypoints as a polished path of the chip.
    assert np.array_equal(result.path, other.path)
    assert len(result.path) - 2 == polish.POLISHED_WAYPOINTS
    # Record, history included, and counters are the chip's.
    assert (result.history, result.generations) == (own.history, own.generations)
    assert result.hardware["runs"] == own.hardware["runs"]
    further = Run(evaluator, Options())
    assert list(astar.fine_searches(further, polish.POLISHED_WAYPOINTS))
    # All routes are evaluated again, as candidates of the plan.
    more = further.evaluations
    assert result.evaluations == own.evaluations + other.evaluations + 2 * more + 1
    assert result.seconds["astar"] > 0
    assert "search" not in result.seconds


@pytest.mark.usefixtures("unrefined")
def test_a_better_route_of_the_chip_stays(make_evaluator, calls):
    evaluator = make_evaluator(zones=())
    own, result = planned(evaluator, LONG, polish="chip"), planned(evaluator, LONG)
    assert len(calls) == 1
    assert result.hardware["route_from"] == own.hardware["route_from"] == "chip"
    assert np.array_equal(result.path, own.path)
    routes = result.hardware["routes"]
    assert routes["chip"] == result.evaluation.fitness > routes["astar"]
    assert routes["astar"] == astar_plan(evaluator).evaluation.fitness
    assert own.hardware["routes"] == {"chip": own.evaluation.fitness, "astar": None}


@pytest.mark.parametrize("word", ["chip", "off"])
def test_without_the_polish_of_both_astar_does_not_search(evaluator, calls, word):
    result = planned(evaluator, polish=word)
    assert calls == []
    assert "astar" not in result.seconds
    assert ("polish" in result.seconds) == (word == "chip")
    assert result.hardware["route_from"] == "chip"


def test_a_replan_neither_searches_nor_polishes(evaluator, board, calls, monkeypatch):
    before = Search("ga-chip", board=board, generations=400, seed=3).run(evaluator)
    assert len(calls) == 1
    polishes = []
    monkeypatch.setattr(polish, "polished", lambda *arguments: polishes.append(arguments) or [])
    after = before.replan(zones=[Zone.circle(4300, 2600, 300)], start=before.path[:2].mean(axis=0))
    assert after.evaluation.feasible
    assert "searches" in after.result.hardware
    assert (len(calls), polishes) == (1, [])
    assert not {"astar", "polish"} & after.result.seconds.keys()
    assert "route_from" not in after.result.hardware


@pytest.mark.parametrize(
    ("reason", "limit"),
    [("target-fitness", {"target_fitness": 1.01}), ("time-limit", {"time_limit_s": 1e-6})],
)
def test_where_a_limit_has_ended_the_chip_astar_does_not_search(evaluator, calls, reason, limit):
    result = planned(evaluator, Options(generations=8_000, seed=3, **limit))
    assert result.evaluation.feasible
    assert result.stopped_by == reason
    assert calls == []
    assert result.hardware["routes"]["astar"] is None


def test_after_an_interrupt_astar_does_not_search(evaluator, calls):
    seen = []
    stop = Stop(lambda: any(generation > 0 for generation, *_ in seen))
    planner = ChipGeneticPlanner()
    result = planner.plan(evaluator, SHORT, lambda *row: seen.append(row), stop)
    assert result.interrupted
    assert calls == []


def test_an_interrupt_of_astar_keeps_the_path_of_the_chip(evaluator, monkeypatch):
    stop = Stop()

    def interrupt(*_, **_options):
        stop.request()
        raise KeyboardInterrupt

    monkeypatch.setattr(astar, "searches", interrupt)
    result = ChipGeneticPlanner().plan(evaluator, SHORT, stop=stop)
    own = planned(evaluator, polish="chip")
    assert result.interrupted
    assert result.hardware["route_from"] == "chip"
    assert np.array_equal(result.path, own.path)


def test_astar_has_the_rest_of_the_time_and_its_own_generations(evaluator, calls):
    limits = {"time_limit_s": 1000.0, "target_fitness": 1.9}
    planned(evaluator, Options(generations=5, seed=3, **limits), chip_ms=1)
    planned(evaluator)
    limited, free = calls
    assert 900 < limited.time_limit_s < 1000
    assert (limited.target_fitness, free.target_fitness) == (1.9, None)
    assert free.time_limit_s is None
    assert limited.generations == free.generations == 400


@pytest.mark.usefixtures("unrefined")
def test_where_astar_finds_nothing_nothing_changes(evaluator, monkeypatch):
    own = planned(evaluator, polish="chip")
    for name in ("searches", "narrow_searches"):
        monkeypatch.setattr(astar, name, lambda *_, **_options: iter(()))
    result = planned(evaluator)
    assert np.array_equal(result.path, own.path)
    assert result.hardware == own.hardware
    assert result.evaluations == own.evaluations + 1


@pytest.mark.usefixtures("unrefined")
@pytest.mark.parametrize("rules", [Rules(), None], ids=["safe", "paper"])
def test_without_a_path_of_the_chip_the_route_of_astar_is_the_result(
    make_evaluator, monkeypatch, rules
):
    monkeypatch.setattr(ChipRuns, "search", lambda *_: None)
    plan = Search("ga-chip", generations=1, fallback="astar").run(make_evaluator(rules=rules))
    hardware = plan.result.hardware
    assert plan.evaluation.feasible
    assert plan.fallback is None
    assert hardware["route_from"] == "astar"
    assert hardware["routes"] == {"chip": None, "astar": plan.evaluation.fitness}


def test_without_any_path_the_fallback_decides(make_evaluator, monkeypatch):
    monkeypatch.setattr(ChipRuns, "search", lambda *_: None)
    monkeypatch.setattr(Routes, "search", lambda *_: None)
    plan = Search("ga-chip", generations=1, fallback="astar").run(make_evaluator(rules=Rules()))
    assert plan.fallback == "astar"
    assert plan.result.hardware["route_from"] is None


@pytest.mark.usefixtures("unrefined")
def test_the_fallback_does_not_repeat_the_search_of_astar(make_evaluator, monkeypatch):
    asked = []

    def refused(evaluator, *, searchers, **_):
        asked.append(searchers)
        return connection.Connection(connection.diagnose(evaluator.problem))

    monkeypatch.setattr(connection, "connect", refused)
    monkeypatch.setattr(ChipRuns, "search", lambda *_: None)
    for name in ("searches", "narrow_searches"):
        monkeypatch.setattr(astar, name, lambda *_, **_options: iter(()))
    for own in ({}, {"polish": "chip"}):
        search = Search("ga-chip", generations=1, fallback="astar", **own)
        assert search.run(make_evaluator(rules=Rules())).reason is not None
    assert asked == [("fpa-2opt",), ("astar", "fpa-2opt")]


@pytest.mark.usefixtures("unrefined")
@pytest.mark.parametrize("heading_deg", [None, 40])
def test_a_run_along_the_route_of_astar_finds_a_path(make_evaluator, monkeypatch, heading_deg):
    evaluator = make_evaluator(rules=Rules(), start_heading_deg=heading_deg)
    monkeypatch.setattr(ga_chip, "UNGUIDED_RUNS", 0)
    result = planned(evaluator, LONG)
    first, *_ = result.hardware["runs"]
    assert first["guided"] == 24
    assert first["classes"][0] == "feasible"
    assert result.hardware["routes"]["chip"] > 1
    # A longer search leaves the guide.
    brief = planned(evaluator)
    assert brief.hardware["routes"]["chip"] < result.hardware["routes"]["chip"]


def test_a_guide_keeps_the_turns_of_a_longer_path(evaluator):
    problem = evaluator.problem
    grid = CornerMap(CHIP, problem)
    start, goal = np.array(problem.start), np.array(problem.goal)
    turns = [start, start + np.array((600, 900, 90)), start + np.array((2500, 1000, 300)), goal]
    inner = np.vstack([np.linspace(a, b, 15)[1:] for a, b in itertools.pairwise(turns)])[:-1]
    path = np.vstack((start, inner, goal))
    guide = guide_of(CHIP, problem, grid, path)
    assert len(guide) == CHIP.max_waypoints
    for turn in turns[1:-1]:
        x, y, altitude = grid.nearest_corner(tuple(turn))
        assert (x, y, altitude + 1) in guide
    assert (
        guide_of(CHIP, problem, grid, np.vstack((start, start + np.array((600, 900, 90)), goal)))
        == []
    )


def test_the_path_of_the_fallback_is_improved(make_evaluator, monkeypatch):
    monkeypatch.setattr(ChipRuns, "search", lambda *_: None)
    evaluator = make_evaluator(rules=Rules())
    search = Search("ga-chip", generations=1, fallback="astar", polish="chip")
    plan = search.run(evaluator)
    assert plan.fallback == "astar"
    assert plan.evaluation.feasible
    assert evaluator.evaluate(plan.path) == plan.evaluation
    alone = astar_plan(evaluator)
    assert plan.evaluation.fitness > alone.evaluation.fitness
    monkeypatch.setattr(further, "improved", lambda evaluator, found, seed, stop: found)
    before = search.run(evaluator)
    assert before.evaluation.fitness == alone.evaluation.fitness
    assert before.result.evaluations < plan.result.evaluations


@pytest.mark.parametrize("options", [SHORT, LONG])
def test_the_best_route_is_refined(evaluator, monkeypatch, options):
    """Its origin stays with it, and the fitness of both routes stays."""
    result = planned(evaluator, options)
    again = planned(evaluator, options)
    other = planned(evaluator, replace(options, seed=options.seed + 1))
    monkeypatch.setattr(refinement, "TRIALS", 0)
    before = planned(evaluator, options)
    assert result.evaluation.fitness > before.evaluation.fitness
    assert evaluator.evaluate(result.path).feasible
    assert np.array_equal(again.path, result.path)
    assert not np.array_equal(other.path, result.path)
    for key in ("route_from", "routes"):
        assert result.hardware[key] == before.hardware[key]
    assert len(result.path) - 2 <= polish.POLISHED_WAYPOINTS
    assert result.seconds["refinement"] > 0
    trials = result.evaluations - before.evaluations
    assert 0 < trials <= 80


@pytest.mark.parametrize("word", ["chip", "off"])
def test_without_the_polish_of_both_nothing_is_refined(evaluator, word):
    assert "refinement" not in planned(evaluator, polish=word).seconds


def test_the_time_limit_ends_the_trials(evaluator, monkeypatch):
    trials, real = [], refinement.lowest_altitudes

    def lowest(*arguments):
        trials.append(arguments)
        if len(trials) == 3:
            monkeypatch.setattr(Run, "out_of_time", property(lambda run: True))
        return real(*arguments)

    monkeypatch.setattr(refinement, "lowest_altitudes", lowest)
    result = planned(evaluator, replace(SHORT, time_limit_s=1000.0))
    assert len(trials) == 3
    assert result.evaluation.feasible


@pytest.mark.parametrize("headings", [(40, 120), (40, None), (None, 120)])
def test_the_turns_next_to_headings_stay(make_evaluator, headings):
    start_deg, goal_deg = headings
    evaluator = make_evaluator(
        rules=Rules(clearance_m=0), start_heading_deg=start_deg, goal_heading_deg=goal_deg, zones=()
    )
    result = planned(evaluator, LONG)
    assert result.evaluation.feasible
    assert result.seconds["refinement"] > 0
    for deg, leg in ((start_deg, result.path[:2]), (goal_deg, result.path[-2:])):
        if deg is not None and result.hardware["route_from"] == "chip":
            east, north = np.diff(leg[:, :2], axis=0)[0]
            assert np.degrees(np.arctan2(east, north)) == pytest.approx(deg)


def test_where_no_path_can_exist_astar_does_not_search(make_evaluator, calls):
    """The proof takes less time than searches in vain."""
    walls = [Zone.circle(3000, y, 400) for y in range(0, 12_001, 350)]
    plan = Search("ga-chip", generations=40, fallback="astar").run(
        make_evaluator(zones=walls, rules=Rules())
    )
    assert plan.reason is not None
    assert plan.reason.proven
    assert calls == []


def test_a_search_in_vain_is_not_made_again_by_the_fallback(make_evaluator, calls, monkeypatch):
    monkeypatch.setattr(ChipRuns, "search", lambda *_: None)
    for name in ("searches", "narrow_searches"):
        monkeypatch.setattr(astar, name, lambda *_, **_options: iter(()))
    plan = Search("ga-chip", generations=1, fallback="astar").run(make_evaluator(rules=Rules()))
    assert len(calls) == 1
    assert plan.fallback == "fpa-2opt"
