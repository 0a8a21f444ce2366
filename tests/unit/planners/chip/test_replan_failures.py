"""Replans where the first run finds no feasible path, or the board has changed."""

import dataclasses
import itertools

import numpy as np
import pytest

from pathgene.host.device.boards import open_board
from pathgene.host.device.link import LinkError
from pathgene.host.device.runs import Runs
from pathgene.host.planners.chip.problem_on_chip import ProblemOnChip
from pathgene.host.planners.grid import further
from pathgene.host.planning import Search
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.zones import Zone
from tests.unit.planners.chip.test_replanner import BEHIND, IN_THE_GAP, NO_MARGINS, WALL, runs_of


@pytest.fixture
def altered(monkeypatch):
    """Function that applies a function to the chip's paths on their way to the host."""
    metres = ProblemOnChip.metres

    def alter(change):
        monkeypatch.setattr(
            ProblemOnChip, "metres", lambda task, packed: change(metres(task, packed))
        )

    return alter


def too_low(path):
    """Return a path whose inner waypoints are in the ground."""
    low = path.copy()
    low[1:-1, 2] = 20.0
    return low


@pytest.mark.parametrize("rules", [None, NO_MARGINS], ids=["as paper", "by the rules"])
def test_other_altitudes_mend_a_path(make_evaluator, search, altered, rules):
    before = search.run(make_evaluator(**({} if rules is None else {"rules": rules})))
    right = before.replan(zones=[BEHIND])
    assert [run["repairs"] for run in runs_of(right)] == [0]
    altered(too_low)
    again = search.run(before.evaluator).replan(zones=[BEHIND])
    assert again.evaluation.feasible
    assert [run["repairs"] for run in runs_of(again)] == [1]
    assert again.fallback is None
    assert 0 < again.result.seconds["repair"] < again.result.seconds["total"]


def test_another_way_at_an_end_mends_a_path_through_a_zone(make_evaluator, search, altered):
    before = search.run(make_evaluator(rules=NO_MARGINS))
    zone = Zone.circle(1000, 2000, 300)
    altered(lambda path: np.insert(path, 1, (zone.x_m, zone.y_m, 300.0), axis=0))
    after = before.replan(zones=[zone])
    assert after.evaluation.feasible
    assert [run["repairs"] for run in runs_of(after)] == [1]
    assert after.fallback is None


def test_the_second_path_is_mended_where_the_best_is_not(make_evaluator, search, altered):
    before = search.run(make_evaluator(rules=NO_MARGINS))
    number = itertools.count()

    def broken(path):
        if next(number) % 4 == 0:
            return np.vstack((path[:1], [(BEHIND.x_m, BEHIND.y_m, 240.0)], path[-1:]))
        return too_low(path)

    altered(broken)
    after = before.replan(zones=[BEHIND])
    assert after.evaluation.feasible
    assert [run["repairs"] for run in runs_of(after)] == [2]
    assert after.fallback is None


def test_no_repair_of_a_path_into_a_zone_behind_the_ridge(make_evaluator, search, altered):
    before = search.run(make_evaluator(rules=NO_MARGINS))

    def into_the_zone(path):
        return np.vstack((path[:1], [(BEHIND.x_m, BEHIND.y_m, 240.0)], path[-1:]))

    altered(into_the_zone)
    after = before.replan(zones=[BEHIND])
    assert [run["repairs"] for run in runs_of(after)] == [2, *[1] * 7]
    assert after.fallback == "astar"


def test_where_there_is_no_way_seven_more_runs_follow_and_the_reason(make_evaluator, search):
    before = search.run(make_evaluator(rules=NO_MARGINS))
    after = before.replan(zones=[WALL])
    assert not after.evaluation.feasible
    assert [run["seed"] for run in runs_of(after)] == list(range(3, 11))
    assert [run["ease"] for run in runs_of(after)] == [0, 1, 2, 2, 2, 2, 2, 2]
    assert after.reason.proven
    # The chip is still ready.
    assert after.result.replanner.is_ready


def two_gates():
    """Return a ridge with only two gates, and a zone in each."""
    elevation = np.full((41, 61), 100.0)
    elevation[:, 28:33] = 3000.0
    for row in (10, 30):
        elevation[row - 2 : row + 3, 28:33] = 100.0
    return elevation, Zone.circle(3000, 1000, 400), Zone.circle(3000, 3000, 400)


def test_after_a_failed_search_a_zone_that_has_moved_is_free(make_evaluator, board, monkeypatch):
    # The host knows that the second gate is open.
    monkeypatch.setattr("pathgene.host.planners.chip.runs.repair", lambda evaluator, path: None)
    elevation, south, north = two_gates()
    search = Search("ga-chip", board=board, chip_ms=4, polish="off", seed=1)
    plan = search.run(make_evaluator(elevation, zones=(north,), rules=NO_MARGINS))
    assert plan.evaluation.feasible
    # The first search has both gates blocked.
    plan = plan.replan(zones=[south], gone=[north])
    assert not plan.evaluation.feasible
    plan.finish()
    plan = plan.replan()
    assert plan.evaluation.feasible
    assert len(runs_of(plan)) == 1


def test_one_of_two_zones_without_a_way_goes(make_evaluator, board):
    elevation, south, north = two_gates()
    search = Search("ga-chip", board=board, chip_ms=4, polish="off", seed=3)
    plan = search.run(make_evaluator(elevation, zones=(), rules=NO_MARGINS))
    for _ in range(2):
        plan = plan.replan(zones=[south, north])
        assert not plan.evaluation.feasible
        plan.finish()
    plan = plan.replan(gone=[north])
    assert plan.evaluation.feasible
    assert len(runs_of(plan)) == 1
    # Both are drawn, and nothing is cleared.
    waits = runs_of(plan)[0]["waits"]
    assert waits["commands"] < 250


def test_a_failed_search_without_a_new_zone_sends_nothing_back(make_evaluator, board):
    wall = Zone.polygon([(3400, -100), (3600, -100), (3600, 4100), (3400, 4100)])
    search = Search("ga-chip", board=board, chip_ms=4, polish="off", seed=3)
    plan = search.run(make_evaluator(zones=(BEHIND, wall), rules=NO_MARGINS))
    plan = plan.replan(gone=[BEHIND])
    assert not plan.evaluation.feasible
    before = dataclasses.replace(board.link.traffic)
    plan.finish()
    assert board.link.traffic == before


def test_where_the_chip_finds_none_the_fallback_does(make_evaluator, search, monkeypatch):
    before = search.run(make_evaluator(rules=NO_MARGINS))
    flight = before.evaluator.problem
    straight = np.array([flight.start, flight.goal])
    monkeypatch.setattr(ProblemOnChip, "metres", lambda task, packed: straight)
    # In flight there is no time for it.
    monkeypatch.setattr(further, "improved", lambda *_: pytest.fail("The path is improved."))
    after = before.replan(zones=[BEHIND])
    assert len(runs_of(after)) == 8
    assert after.evaluation.feasible
    assert after.fallback == after.summary["fallback"] == "astar"
    monkeypatch.undo()
    assert after.replan(zones=[IN_THE_GAP]).evaluation.feasible


def test_the_retry_may_find_one(evaluator, search, monkeypatch):
    before = search.run(evaluator)
    straight = np.array([evaluator.problem.start, evaluator.problem.goal])
    run, metres, seeds, warm = ProblemOnChip.run, ProblemOnChip.metres, [], []

    def noted(task, options, *others):
        seeds.append(options.seed)
        warm.append(options.warm)
        return run(task, options, *others)

    # All paths of the first run are the straight line.
    monkeypatch.setattr(ProblemOnChip, "run", noted)
    monkeypatch.setattr(
        ProblemOnChip,
        "metres",
        lambda task, packed: straight if len(seeds) == 1 else metres(task, packed),
    )
    after = before.replan(zones=[BEHIND])
    assert seeds == [3, 4]
    assert warm == [True, False]
    assert after.evaluation.feasible
    assert after.fallback is None


def test_without_the_population_the_problem_is_planned_anew(evaluator, make_evaluator, search):
    before = search.run(evaluator)
    assert before.result.replanner.is_ready
    search.run(make_evaluator(goal=(5500, 3500, 220)))
    assert not before.result.replanner.is_ready
    after = before.replan(zones=[BEHIND])
    assert after.evaluation.feasible
    assert [run["warm"] for run in runs_of(after)] == [False]
    # That run left its own population.
    assert after.replan(zones=[IN_THE_GAP]).result.hardware["runs"][0]["warm"]


def test_a_closed_board_is_opened_anew(evaluator):
    with open_board("model:?core=planner") as board:
        before = Search("ga-chip", board=board, chip_ms=4).run(evaluator)
        assert before.board == "model:?core=planner"
    assert not before.result.replanner.is_ready
    after = before.replan(zones=[BEHIND])
    assert after.evaluation.feasible
    assert [run["warm"] for run in runs_of(after)] == [False]


def test_a_board_of_a_url_is_opened_for_each_plan(evaluator):
    before = Search("ga-chip", chip_ms=4).run(evaluator)
    assert before.result.replanner is None
    after = before.replan(zones=[BEHIND])
    assert after.evaluation.feasible
    assert [run["warm"] for run in runs_of(after)] == [False]


def test_a_lost_board_costs_no_path(evaluator, search, monkeypatch):
    before = search.run(evaluator)

    def lost(runs):
        raise LinkError("The board was lost: unplugged.")

    monkeypatch.setattr(Runs, "poll", lost)
    after = before.replan(zones=[BEHIND])
    assert after.failure == "The board was lost: unplugged."
    assert after.result.replanner is None
    monkeypatch.undo()
    # The map has arrived, but the population is not the plan's.
    assert after.replan().evaluation.feasible


def test_a_start_off_the_steps_of_the_map_is_planned_from_new_seeds(evaluator, search, monkeypatch):
    """The earlier waypoints are on the steps of another map."""
    before = search.run(evaluator)
    monkeypatch.setattr(CornerMap, "of_problem", lambda grid, problem: None)
    after = before.replan(zones=[BEHIND])
    assert runs_of(after)[0]["warm"] is False
    assert after.evaluation.feasible
    monkeypatch.undo()
    # It left its own population.
    assert runs_of(after.replan(zones=[IN_THE_GAP]))[0]["warm"]
