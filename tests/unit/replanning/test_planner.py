"""Planners in flight: attempts, their virtual time, and a lost board."""

import dataclasses

import numpy as np
import pytest

from pathgene.host.device.boards import open_board
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.chip.problem_on_chip import ProblemOnChip
from pathgene.host.planners.chip.schedule import chip_time
from pathgene.host.planning import Plan
from pathgene.host.problem.changes import changed_problem
from pathgene.host.problem.zones import Circle, Zone
from pathgene.host.replanning.planner import (
    HOST_S,
    PATIENCE_S,
    REPAIR_S,
    ROUND_TRIP_S,
    InFlightPlanner,
    PlanningTime,
)


def changed(mission):
    """A zone on the straight path, and the aircraft on its way."""
    return changed_problem(
        mission, [Circle(4000.0, 4500.0, 300.0)], (2000.0, 4500.0, 250.0), heading=90.0
    )


def test_the_time_on_the_chip_follows_from_cycles_and_bytes(on_chip, mission):
    attempt = on_chip.attempt(changed(mission), 0)
    assert attempt.reason == ""
    assert attempt.plan.evaluation.feasible
    assert attempt.plan.path[0].tolist() == [2000.0, 4500.0, 250.0]
    taken = chip_time(attempt.plan.result.hardware)
    # For all commands up to RUN, and for BEST and STATUS, whose answer has 48 bytes.
    assert attempt.time.round_trips_s == pytest.approx(2 * ROUND_TRIP_S + 48 * 10 / 3e6)
    assert (attempt.time.chip_s, attempt.time.host_s) == (taken.whole_s, HOST_S)
    assert 0.001 < attempt.time.chip_s < 0.004
    assert attempt.time.total_s < 0.020
    # None of it depends on the clock of this machine.
    assert attempt.plan.result.hardware["runs"][0]["warm"]
    assert on_chip.budget_s == 0.125


def test_a_repair_takes_the_host_longer(on_chip, mission, monkeypatch):
    metres = ProblemOnChip.metres

    def too_low(task, packed):
        path = metres(task, packed)
        path[1:-1, 2] = 20.0
        return path

    monkeypatch.setattr(ProblemOnChip, "metres", too_low)
    attempt = on_chip.attempt(changed(mission), 0)
    assert attempt.plan.evaluation.feasible
    assert [run["repairs"] for run in attempt.plan.result.hardware["runs"]] == [1]
    assert attempt.time.host_s == HOST_S + REPAIR_S
    # It costs the chip and the line nothing.
    assert attempt.time.chip_s < 0.003


def test_a_search_for_a_zone_that_is_active_takes_another_share_of_the_host(on_chip, mission):
    zone = Circle(4000.0, 4500.0, 300.0, t0_s=60.0, t1_s=120.0)
    moved = changed_problem(mission, [zone], (2000.0, 4500.0, 250.0), heading=90.0)
    attempt = on_chip.attempt(moved, 0)
    hardware = attempt.plan.result.hardware
    assert hardware["searches"] == 2
    assert attempt.time.host_s == 2 * HOST_S
    assert attempt.time.chip_s == chip_time(hardware).whole_s
    assert attempt.time.chip_s > 1.5 * chip_time(hardware, 1).whole_s


def test_a_failed_attempt_lasts_until_its_zones_are_free(on_chip, mission, monkeypatch):
    traffic, finish, noted = on_chip.board.link.traffic, Plan.finish, []

    def noting(plan):
        before = dataclasses.replace(traffic)
        finish(plan)
        noted.append((chip_time(plan.result.hardware), traffic.since(before)))

    monkeypatch.setattr(Plan, "finish", noting)
    wall = Zone.polygon([(4000.0, -500.0), (4400.0, -500.0), (4400.0, 9500.0), (4000.0, 9500.0)])
    closed = changed_problem(mission, [wall], (2000.0, 4500.0, 250.0), heading=90.0)
    attempt = on_chip.attempt(closed, 0)
    assert attempt.plan is None
    ((taken, set_free),) = noted
    # All corners of the wall.
    assert set_free.bytes_to_board > 500
    line_s = (set_free.bytes_to_board + set_free.bytes_from_board) * 10 / 3e6
    assert attempt.time.chip_s == pytest.approx(taken.whole_s + line_s)
    trips_s = (taken.exchanges + set_free.exchanges) * ROUND_TRIP_S
    assert attempt.time.round_trips_s == pytest.approx(trips_s + taken.status_s)
    assert set_free.exchanges > 0


def test_another_attempt_has_another_seed(on_chip, mission):
    paths = {
        tuple(on_chip.attempt(changed(mission), number).plan.path.ravel()) for number in range(3)
    }
    assert len(paths) > 1


def test_a_planner_on_the_processor_takes_a_constant(on_processor, mission):
    planner = on_processor(0.25)
    attempt = planner.attempt(changed(mission), 0)
    assert attempt.plan.evaluation.feasible
    assert attempt.time == PlanningTime(host_s=0.25)
    assert planner.budget_s == pytest.approx(1.3 * 0.25)
    measured = InFlightPlanner("astar")
    measured.prepare(Evaluator(mission, threads=1))
    assert 0 < measured.constant_s < 60
    assert measured.attempt(changed(mission), 0).time.total_s == measured.constant_s


def test_where_there_is_no_path_the_reason_is_said(on_processor, mission):
    wall = Circle(4000.0, 4500.0, 60.0)
    closed = dataclasses.replace(
        mission,
        rules=dataclasses.replace(mission.rules, ceiling_m=260.0),
        zones=[Circle(4000.0, y, 400.0) for y in np.arange(0.0, 9001.0, 500.0)] + [wall],
    )
    attempt = on_processor(0.1).attempt(closed, 0)
    assert attempt.plan is None
    assert attempt.reason
    refused = attempt.refused("Too late.", hopeless=True)
    assert (refused.reason, refused.hopeless, refused.time) == ("Too late.", True, attempt.time)


def test_a_lost_board_costs_the_patience_of_the_host(mission):
    with open_board("model:?core=planner") as board:
        planner = InFlightPlanner("ga-chip", board=board)
        planner.prepare(Evaluator(mission, threads=1))
        planner.lose_board()
        attempt = planner.attempt(changed(mission), 0)
        assert attempt.plan is None
        assert (attempt.reason, attempt.time.total_s) == ("The board is lost.", PATIENCE_S)


def test_a_board_that_really_fails_is_noticed(mission, monkeypatch):
    with open_board("model:?core=planner") as board:
        planner = InFlightPlanner("ga-chip", board=board)
        planner.prepare(Evaluator(mission, threads=1))

        def fail(data):
            raise OSError("the cable is out")

        monkeypatch.setattr(board.link._transport, "write", fail)
        attempt = planner.attempt(changed(mission), 0)
        assert attempt.plan is None
        assert planner.lost == attempt.reason != ""
        assert planner.attempt(changed(mission), 1).reason == planner.lost


def test_the_time_of_chip_and_host_together(mission):
    with open_board("model:") as board:
        planner = InFlightPlanner("ga-fpga", board=board)
        plan = planner.prepare(Evaluator(mission, threads=1))
        attempt = planner.attempt(changed(mission), 0)
    assert attempt.time.round_trips_s == pytest.approx(
        ROUND_TRIP_S * (attempt.plan or plan).result.generations, rel=0.2
    )
    assert attempt.time.chip_s > 0.01
    assert 0 < attempt.time.host_s < 60
