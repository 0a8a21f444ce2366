"""The points of a mission, the problems of its legs and of the whole."""

import math
import pickle

import numpy as np
import pytest

from pathgene.host.errors import InputError, NoPathError
from pathgene.host.evaluation import Evaluator, problem_utopia, utopia
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


START, GOAL, VIA = (500.0, 500.0, 200.0), (3500.0, 1000.0, 220.0), (2000.0, 2500.0, 240.0)


def problem(zones=(), **options):
    heights = np.full((31, 41), 100.0)
    heights[4, 4] = np.nan
    return Problem(Terrain("flat", heights, 100, 100), START, GOAL, zones=zones, **options)


def refusal(*arguments, **options):
    with pytest.raises(InputError) as error:
        MissionProblem(*arguments, **options)
    return str(error.value)


def test_the_points_of_a_mission_have_names():
    mission = MissionProblem(problem(), [VIA], return_to_start=True)
    assert mission.way == (START, VIA, GOAL, START)
    assert mission.names == ("the start", "via point 1", "the goal", "the start")
    assert mission.legs == 3
    assert mission.name_of(1) == "leg 2, from via point 1 to the goal"
    assert (mission.whole.start, mission.whole.goal) == (START, START)


def test_a_mission_of_one_leg_is_its_problem():
    made = problem()
    mission = MissionProblem(made)
    assert mission.whole is made
    assert mission.leg(0) is made


def test_via_points_above_the_ground():
    assert MissionProblem(problem(), [(2000, 2500, 60)], agl=True).via == ((2000.0, 2500.0, 160.0),)


@pytest.mark.parametrize(
    ("via", "sentence"),
    [
        (
            (5000, 500, 300),
            "The via point 1 at (5000, 500) is outside the map, which reaches from ",
        ),
        (
            (2000, 2500, 50),
            "The via point 1 at an altitude of 50 m is inside the ground, which is ",
        ),
        ((400, 400, 300), "The via point 1 at (400, 400) is over a void of the terrain; "),
        ((2000, 2000), "The via point 1 must be 3 finite numbers, not (2000, 2000)."),
        (
            (2000, 2500, 120),
            "Via point 1 is 20.0 m above the ground, less than the clearance of 30 m; raise it or "
            "reduce the clearance.",
        ),
        (
            (2000, 18, 300),
            "Via point 1 is 18.0 m from the edge of the map, less than the corridor of 25 m; move "
            "it 7 m into the map or give --corridor 18.",
        ),
        (START, "The start and via point 1 are one point; leave one out."),
        (GOAL, "Via point 1 and the goal are one point; leave one out."),
        (
            (1000, 2000, 200),
            "Via point 1 at (1000, 2000) is inside a no-fly zone; move it or the zone.",
        ),
    ],
)
def test_refuses_bad_via_points(via, sentence):
    assert refusal(problem([Circle(1000, 2000, 200)]), [via]).startswith(sentence)


def test_the_goal_of_a_return_keeps_the_clearance():
    low = Problem(problem().terrain, START, (3500, 1000, 110))
    assert MissionProblem(low).legs == 1
    assert refusal(low, return_to_start=True).startswith("The goal is 10.0 m above the ground, ")
    as_paper = Problem(low.terrain, START, low.goal, as_paper=True)
    assert MissionProblem(as_paper, return_to_start=True).legs == 2


def test_names_a_leg_that_is_no_reference():
    """A steep glide burns no fuel; under the rules, the reason that forbids it comes first."""
    assert refusal(problem(as_paper=True), [(800, 600, 4000)]).startswith(
        "Leg 2, from via point 1 to the goal: The straight line from start to goal is so steep a "
        "glide that it burns no fuel"
    )
    with pytest.raises(NoPathError) as error:
        MissionProblem(problem(), [(800, 600, 4000)])
    assert str(error.value).startswith(
        "Leg 2, from via point 1 to the goal: Every short way down to the goal is too steep"
    )
    assert (error.value.leg, error.value.reason.code) == (2, "descent")


def test_costs_of_the_whole_are_relative_to_the_lines_of_all_legs():
    mission = MissionProblem(problem(), [VIA], return_to_start=True)
    lines = [
        utopia(*ends, mission.problem.aircraft, (0.0, 0.0))
        for ends in ((START, VIA), (VIA, GOAL), (GOAL, START))
    ]
    whole = problem_utopia(mission.whole)
    assert whole.length_m == pytest.approx(sum(line.length_m for line in lines))
    assert whole.fuel_N == pytest.approx(sum(line.fuel_N for line in lines))
    assert whole.altitude_m * whole.length_m == pytest.approx(
        sum(line.altitude_m * line.length_m for line in lines)
    )


def test_a_path_may_end_where_it_starts():
    mission = MissionProblem(problem(), [VIA], return_to_start=True)
    for whole in (mission.whole, pickle.loads(pickle.dumps(mission.whole))):
        evaluation = Evaluator(whole).evaluate(np.array(mission.way))
        assert evaluation.feasible
        # The arcs cut the corners, so the cost is a little less than 1.
        assert 0.9 < evaluation.cost < 1


def test_legs_take_headings_and_the_ends_their_own():
    mission = MissionProblem(problem(start_heading_deg=10, goal_heading_deg=20), [VIA])
    first = mission.leg(0, start_heading_deg=77, goal_heading_deg=88)
    last = mission.leg(1, start_heading_deg=77, goal_heading_deg=88)
    assert (first.start_heading_deg, first.goal_heading_deg) == (10, 88)
    assert (last.start_heading_deg, last.goal_heading_deg) == (77, 20)
    assert (first.start, first.goal, last.goal) == (START, VIA, GOAL)
    assert first.rules == mission.problem.rules


def test_legs_as_paper_have_no_headings():
    leg = MissionProblem(problem(as_paper=True), [VIA]).leg(1, start_heading_deg=77)
    assert (leg.as_paper, leg.start_heading_deg) == (True, None)


def test_times_of_zones_count_from_the_start_of_the_leg():
    zones = [
        Circle(3000, 2500, 100, t0_s=10, t1_s=100),
        Circle(3000, 2500, 100, t0_s=60, t1_s=100),
        Circle(3000, 2500, 100, t1_s=50),
        Circle(3000, 2500, 100, t0_s=40),
        Circle(3000, 2500, 100),
    ]
    mission = MissionProblem(problem(zones), [VIA])
    assert mission.leg(0).zones == tuple(zones)
    times = [(zone.t0_s, zone.t1_s) for zone in mission.leg(1, elapsed_s=50).zones]
    assert times == [(None, 50), (10, 50), (None, None), (None, None)]


def test_a_short_leg_is_sampled_no_longer_than_it_is():
    mission = MissionProblem(problem(ds_m=400, rules=Rules(clearance_m=0)), [(600, 500, 200)])
    assert mission.leg(0).ds_m == 100
    assert mission.leg(1).ds_m == 400
    assert math.isclose(mission.whole.ds_m, 400)
