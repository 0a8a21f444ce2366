"""Joints of legs: evaluation of both legs together, and reasons at the via points."""

import dataclasses
import math

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.legs import JoinedEvaluator, reason_of_joint
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.mission.planning import _heading_deg, _joined_evaluator, plan_mission
from pathgene.host.planners.base import Stop
from pathgene.host.planning import Search
from pathgene.host.problem.aircraft import load
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.report.via import visits
from pathgene.host.terrain import Terrain
from tests.support.host.closed_problems import lane


START, VIA, GOAL = (500.0, 500.0, 300.0), (2000.0, 500.0, 300.0), (500.0, 2500.0, 300.0)
#: Backwards: the arc at the via point needs more room than 200 m.
SHARP = np.array([VIA, (1200.0, 900.0, 300.0), GOAL])
WIDE = np.array([VIA, (2100.0, 1500.0, 300.0), (1500.0, 2400.0, 300.0), GOAL])


@pytest.fixture(params=[False, True], ids=["rules", "paper"])
def evaluators(request):
    terrain = Terrain("flat", np.full((31, 41), 100.0), 100, 100)
    mission = MissionProblem(Problem(terrain, START, GOAL, as_paper=request.param), [VIA])
    ahead = np.array([START, (1800.0, 500.0, 300.0)])
    leg = mission.leg(1, start_heading_deg=90)
    joined = JoinedEvaluator(leg, ahead, mission.part((*map(tuple, ahead), VIA, GOAL)))
    return joined, Evaluator(mission.whole), ahead


def test_the_arc_at_the_via_point_needs_room_on_both_sides(evaluators):
    joined, whole, ahead = evaluators
    for path, feasible in ((SHARP, False), (WIDE, True)):
        together = whole.evaluate(np.concatenate((ahead, path)))
        assert together.feasible is feasible
        found = joined.evaluate(path)
        assert found.feasible is feasible
        assert found.impossible_arcs == together.impossible_arcs
        assert found.length_m == together.length_m


def test_a_leg_does_not_turn_back_at_the_via_point_by_one_arc():
    """The arc would have room, but would begin a kilometre ahead of the point."""
    terrain = Terrain("flat", np.full((31, 61), 100.0), 100, 100)
    start, via, goal = (500.0, 1500.0, 300.0), (5000.0, 1500.0, 300.0), (500.0, 2000.0, 300.0)
    mission = MissionProblem(Problem(terrain, start, goal), [via])
    ahead = np.array([start])
    leg = mission.leg(1, start_heading_deg=90)
    joined = JoinedEvaluator(leg, ahead, mission.part((start, via, goal)))
    whole = Evaluator(mission.whole)
    radius_m = leg.limits.turn_radius_m
    right = (5000.0, 1900.0, 300.0)
    for path, back_rad in (
        (np.array([via, goal]), 0.5 * math.pi - math.atan2(500, 4500)),
        (np.array([via, (4900.0, 2000.0, 300.0), goal]), math.atan2(100, 500)),
        (np.array([via, right, goal]), 0.0),
    ):
        together = whole.evaluate(np.concatenate((ahead, path)))
        assert together.feasible
        found = joined.evaluate(path)
        assert found.penalty == pytest.approx(radius_m * back_rad)
        assert found.feasible is (back_rad == 0)
        lengths = np.array([len(path)])
        for strict in (False, True):
            fitness = joined.fitness(path[None], lengths, strict=strict)
            assert fitness == pytest.approx([found.fitness])
        assert joined.penalty_cost(path[None], lengths, fine=True)[0] == pytest.approx(
            [found.penalty]
        )
        (visit,) = visits(whole, np.concatenate((ahead, path)))
        assert visit.missed is (back_rad > 0)
        if visit.missed:
            assert visit.horizontal_m > 0.42 * radius_m
            assert visit.sentence.startswith("The path turns back at via point 1 at (5000, 1500, 3")


def test_populations_are_evaluated_the_same_way(evaluators):
    joined, _, _ = evaluators
    paths = np.zeros((2, 4, 3))
    paths[0, :3], paths[1] = SHARP, WIDE
    lengths = np.array([3, 4])
    fitness = joined.fitness(paths, lengths)
    for value, path in zip(fitness, (SHARP, WIDE), strict=True):
        assert value == pytest.approx(joined.evaluate(path).fitness)
    penalty, _ = joined.penalty_cost(paths, lengths, fine=True)
    assert penalty[0] > 0
    assert penalty[1] == 0
    counted = joined.fitness_counted(paths, lengths, np.zeros(2))
    assert (counted > 1).tolist() == [False, True]


def test_an_aircraft_that_stalls_in_its_turns_gets_no_penalty_for_a_joint():
    """The turn radius is infinite, and the penalty of each path stays finite."""
    terrain = Terrain("flat", np.full((31, 41), 100.0), 100, 100)
    weak = dataclasses.replace(load("silver-fox"), lift_coefficient_max=0.1)
    mission = MissionProblem(Problem(terrain, START, GOAL, weak), [VIA])
    joined = JoinedEvaluator(mission.leg(1), np.array([START]), mission.whole)
    back = np.array([VIA, (600.0, 600.0, 300.0), GOAL])
    together = Evaluator(mission.whole).evaluate(np.array([START, *back]))
    assert not together.feasible
    assert joined.evaluate(back).penalty == together.penalty


#: A lane from the west edge of the map.
LANE = lane(-50, 2500)
EAST, END_OF_LANE = (3500.0, 2000.0, 250.0), (300.0, 2000.0, 250.0)


@pytest.fixture(scope="module")
def terrain():
    return Terrain("flat", np.full((80, 80), 100.0), 50.0, 50.0)


@pytest.fixture(scope="module")
def dead_end(terrain):
    """The plan of a mission into a dead end and back."""
    problem = Problem(terrain, EAST, (3500.0, 2500.0, 250.0), zones=LANE)
    return plan_mission(MissionProblem(problem, [END_OF_LANE]), Search("astar", fallback="astar"))


def test_the_leg_that_cannot_turn_back_speaks_of_the_via_point(dead_end):
    assert [leg.feasible for leg in dead_end.legs] == [True, False]
    reason = dead_end.reason
    assert (reason.code, reason.proven, reason.place) == ("joint", False, END_OF_LANE[:2])
    assert reason.figure is None
    ((end, arrival, flown),) = reason.headings
    assert end == "start"
    assert reason.sentence == (
        f"No path was found that leaves via point 1 heading for {arrival:.0f} degrees, as the leg "
        "before arrives; there is one that leaves via point 1 heading for "
        f"{flown:.0f} degrees. Move via point 1, or give it a neighbour from which the turn is "
        "gentler."
    )
    assert abs(arrival - 270) < 20
    assert abs(flown - 90) < 20
    assert dead_end.summary["legs"][1]["reason"]["code"] == "joint"


def test_following_the_advice_mends_it(terrain, dead_end):
    """The via point moves out of the lane, where there is room to turn."""
    problem = dead_end.mission.problem
    mended = MissionProblem(problem, [(2900.0, 2000.0, 250.0)])
    assert plan_mission(mended, Search("astar", fallback="astar")).evaluation.feasible


def test_headings_of_the_mission_itself_are_left_alone(dead_end):
    reason = dead_end.reason
    assert reason_of_joint(reason, {}) is reason
    assert reason_of_joint(reason, {"goal": "via point 2"}) is reason


def test_a_heading_of_the_mission_beside_a_joint(dead_end):
    both = dataclasses.replace(
        dead_end.reason, headings=(("start", 90.0, 10.0), ("goal", 180.0, 200.0))
    )
    assert reason_of_joint(both, {"start": "via point 2"}).sentence == (
        "No path was found that leaves via point 2 heading for 90 degrees, as the leg before "
        "arrives and reaches the goal heading for 180 degrees; there is one that leaves via point "
        "2 heading for 10 degrees and reaches the goal heading for 200 degrees. Move via point 2, "
        "or give it a neighbour from which the turn is gentler."
    )


def test_legs_with_fuel_enough_for_each_alone(terrain):
    """The tank lasts for each leg, and not for both."""
    fox = load("silver-fox")
    start, goal = (300.0, 500.0, 250.0), (3600.0, 500.0, 250.0)
    whole = plan_mission(MissionProblem(Problem(terrain, start, goal, fox)), Search("astar"))
    small = dataclasses.replace(fox, fuel_weight_N=0.8 * whole.evaluation.fuel_N / 0.9)
    mission = MissionProblem(Problem(terrain, start, goal, small), [(1950.0, 500.0, 250.0)])
    plan = plan_mission(mission, Search("astar", fallback="astar"))
    assert [leg.feasible for leg in plan.legs] == [True, True]
    assert plan.reason is not None
    assert (plan.reason.code, plan.reason.proven) == ("joint", False)
    assert plan.reason.sentence.startswith(
        "Every leg has a feasible path, but the path of all legs breaks the limit fuel, "
    )
    assert plan.reason.sentence.endswith("; move a via point, or split the mission there.")


def test_a_stop_after_the_last_leg_plans_no_leg_again(terrain):
    fox = load("silver-fox")
    start, goal = (300.0, 500.0, 250.0), (3600.0, 500.0, 250.0)
    straight = Evaluator(Problem(terrain, start, goal, fox)).evaluate(np.array([start, goal]))
    small = dataclasses.replace(fox, fuel_weight_N=0.8 * straight.fuel_N / 0.9)
    mission = MissionProblem(Problem(terrain, start, goal, small), [(1950.0, 500.0, 250.0)])

    def legs_planned(is_stopped):
        stop, made = Stop(), []

        def evaluator(problem):
            made.append(problem)
            if problem is mission.whole and is_stopped:
                stop.request()
            return Evaluator(problem)

        plan = plan_mission(mission, Search("astar"), stop=stop, evaluator=evaluator)
        assert [leg.feasible for leg in plan.legs] == [True, True]
        assert not plan.evaluation.feasible
        return len(made) - 1

    assert legs_planned(is_stopped=False) == 4
    assert legs_planned(is_stopped=True) == 2


def test_a_leg_is_planned_alone_after_a_glide_that_burns_no_fuel(terrain):
    """The costs of both together would have no reference."""
    start, via, goal = (500.0, 500.0, 250.0), (2000.0, 500.0, 250.0), (3500.0, 500.0, 250.0)
    mission = MissionProblem(Problem(terrain, start, goal, as_paper=True), [via])
    leg = mission.leg(1)
    for height_m, has_reference in ((250.0, True), (900.0, False)):
        before = np.array([start, (1500.0, 500.0, height_m), via])
        found = _joined_evaluator(mission, leg, before, 60.0, Evaluator(leg))
        assert (found is not None) is has_reference


def test_the_heading_of_a_path_is_that_of_its_first_level_run(terrain):
    problem = Problem(terrain, EAST, END_OF_LANE)
    upwards = [(500.0, 500.0, 200.0), (500.0, 500.0, 300.0)]
    assert _heading_deg(problem, np.array(upwards)) is None
    assert _heading_deg(problem, np.array([*upwards, (900.0, 500.0, 300.0)])) == 90
    assert _heading_deg(problem, np.array([*upwards, (900.0, 500.0, 300.0)]), backwards=True) == -90


@pytest.mark.parametrize("planner", ["astar", "ga-pc"])
def test_a_zone_that_is_never_active_leaves_the_joints_as_they_are(planner):
    terrain = Terrain("flat", np.full((31, 41), 100.0), 100, 100)
    late = Zone.circle(3500.0, 2500.0, 100.0, t0_s=50_000.0)
    paths = []
    for zones in ((), (late,)):
        mission = MissionProblem(Problem(terrain, START, GOAL, zones=zones), [VIA])
        options = {} if planner == "astar" else {"generations": 40}
        paths.append(plan_mission(mission, Search(planner, **options)).path)
    assert np.array_equal(*paths)
