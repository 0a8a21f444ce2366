"""The place where a plan leaves a track, and the problem for the rest of a flight."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bench import replan
from bench.replan import Question, is_there_a_path
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator, problem_utopia, utopia
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.replanning.departure import Departure
from pathgene.host.replanning.present import Present
from pathgene.host.replanning.tracks import end_of, is_smooth
from pathgene.host.terrain import Terrain


def rest(mission, z, *, away_m=5000.0, goal_z=250.0):
    """Return the problem from an altitude ``z`` to a goal at ``goal_z`` west of it."""
    return Problem(
        mission.terrain,
        (1500.0 + away_m, 4500.0, z),
        (1500.0, 4500.0, goal_z),
        mission.aircraft,
        rules=mission.rules,
        start_heading_deg=270.0,
    )


@pytest.mark.parametrize("z", [200.0, 250.0, 400.0])
def test_costs_of_a_usual_rest_are_relative_to_the_straight_line(mission, z):
    problem = rest(mission, z)
    assert problem_utopia(problem) == utopia(
        problem.start, problem.goal, mission.aircraft, (0.0, 0.0)
    )


@pytest.mark.parametrize(
    ("planner", "away_m"),
    [("ga-chip", 650.0), ("ga-chip", 450.0), ("astar", 450.0), ("astar", 5e3)],
)
def test_a_glide_that_burns_no_fuel_is_planned(mission, board, planner, away_m):
    z = 250.0 + 0.2 * away_m
    problem = rest(mission, z, away_m=away_m)
    with pytest.raises(InputError, match="so steep a glide"):
        utopia(problem.start, problem.goal, mission.aircraft, (0.0, 0.0))
    level = problem_utopia(problem)
    assert (level.altitude_m, level.length_m) == (250.0 + 0.1 * away_m, away_m)
    assert level.fuel_N > 0
    options = {"board": board, "chip_ms": 5} if planner == "ga-chip" else {}
    evaluator = Evaluator(problem, threads=1)
    result = make(planner, **options).plan(evaluator, Options(generations=1000))
    assert result.evaluation.feasible
    assert 1 < result.evaluation.fitness < 2
    assert math.isfinite(result.evaluation.cost)


def test_a_glide_to_the_datum_has_costs(mission):
    terrain = Terrain("sea", np.zeros((151, 151)), dx_m=60.0, dy_m=60.0)
    problem = Problem(
        terrain, (1500.0, 4500.0, 300.0), (2500.0, 4500.0, 0.0), mission.aircraft, rules=Rules()
    )
    assert problem_utopia(problem).altitude_m == 150.0


def test_costs_of_a_start_above_its_goal_are_relative_to_its_height(mission):
    best = problem_utopia(rest(mission, 600.0, away_m=0.0))
    assert (best.altitude_m, best.length_m) == (425.0, 350.0)
    assert best.fuel_N > 0


def test_the_straight_line_of_a_replan_leaves_along_the_heading(board, mission):
    """The straight line itself would turn at the start, where the aircraft is already flying."""
    planner = make("ga-chip", board=board, chip_ms=2, polish="off")
    evaluator = Evaluator(mission, threads=1)
    before = planner.plan(evaluator, Options(generations=1000))
    for heading_deg in (80.0, 88.0, 93.0, 120.0):
        problem = Problem(
            mission.terrain,
            (2000.0, 4500.0, 250.0),
            mission.goal,
            mission.aircraft,
            rules=mission.rules,
            start_heading_deg=heading_deg,
        )
        changed = Evaluator(problem, threads=1)
        after = before.replanner.replan(changed, Options())
        before = after
        assert after.evaluation.feasible
        first = changed.track(after.path).pieces[0]
        assert np.allclose(first.start, problem.start)
        assert first.heading == pytest.approx(problem.headings[0], abs=1e-6)
        assert is_smooth(changed.track(after.path).pieces)
        assert end_of(first).z >= 250.0


LEAVES_M = 1000.0
# Centre of the zone ahead, east of where the plan begins.
AHEAD = 1500.0 + LEAVES_M, 4500.0


@pytest.fixture
def asked(mission, straight):
    """Function that returns a question: a zone at a distance ahead of the aircraft."""
    track = Evaluator(mission, threads=1).track(straight).pieces

    def question(zones, goal=mission.goal):
        present = Present(mission, zones, goal, (0.0, 0.0))
        departure = Departure(track, LEAVES_M, None)
        return Question(departure, present, mission.aircraft, LEAVES_M - 5.0)

    return question


def test_a_way_around_a_zone_is_found(asked, board):
    x, y = AHEAD
    assert is_there_a_path(asked([Circle(x + 1000.0, y, 300.0)]), board)


def test_a_zone_that_no_turn_avoids_leaves_no_path(asked, board):
    x, y = AHEAD
    assert not is_there_a_path(asked([Circle(x + 325.0, y, 280.0)]), board)


def test_a_goal_in_a_zone_has_no_path(asked, board, mission):
    x, y = mission.goal[:2]
    assert not is_there_a_path(asked([Circle(x, y, 200.0)]), board)


def test_a_path_that_cannot_be_joined_is_none(asked, board, monkeypatch):
    monkeypatch.setattr(replan, "fault_of", lambda *_: "The path turns too sharply.")
    assert not is_there_a_path(asked([]), board)


def test_times_of_zones_count_from_the_start_of_the_plan(mission, on_processor):
    """A wall opens 100 s from now; a plan that begins in 60 s gets there later than that."""
    zones = [Polygon([(4000, 0), (4200, 0), (4200, 9000), (4000, 9000)], name="wall", t1_s=100.0)]
    present = Present(mission, zones, mission.goal, (0.0, 0.0))
    track = Evaluator(mission, threads=1).track(np.array([mission.start, mission.goal])).pieces
    departure = Departure(track, 500.0, None)
    (now,) = departure.problem(present, mission.aircraft).zones
    (then,) = departure.problem(present, mission.aircraft, 60.0).zones
    assert (now.t1_s, then.t1_s) == (100.0, 40.0)
    assert departure.problem(present, mission.aircraft, 100.0).zones == ()
    attempt = on_processor(0.5).attempt(departure.problem(present, mission.aircraft, 60.0), 0)
    assert attempt.plan is not None
    # Active from now on, the wall leaves no way.
    always = Present(mission, [replace(zones[0], t1_s=None)], mission.goal, (0.0, 0.0))
    attempt = on_processor(0.5).attempt(departure.problem(always, mission.aircraft), 0)
    assert attempt.plan is None
