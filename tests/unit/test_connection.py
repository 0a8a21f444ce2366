"""Connection of start and goal: the planner that finds the path, or the reason if there is none."""

import numpy as np
import pytest

from pathgene.host.connection import SEARCHERS, connect
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners.base import Options, Stop
from pathgene.host.planning import Search
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain, load
from tests.support.host.closed_problems import lane


WALL = Polygon(((1900, -50), (2100, -50), (2100, 5000), (1900, 5000)), name="border")


def flat(**options):
    terrain = Terrain("flat", np.full((40, 40), 100.0), 100.0, 100.0)
    return Problem(terrain, (500, 500, 250), (3000, 3000, 250), **options)


@pytest.fixture(scope="module")
def mountains():
    """A problem on real terrain, with ends much lower than the clearance."""
    terrain = load("jacksboro")
    (x0, x1), (y0, y1) = (
        (0.08 * size, 0.92 * size) for size in (terrain.width_m, terrain.height_m)
    )
    start, goal = (x0, y0, 20.0), (x1, y1, 20.0)
    return Problem(terrain, start, goal, rules=Rules(clearance_m=100.0), agl=True)


@pytest.fixture(scope="module")
def alone(mountains):
    """The result of each planner by itself, up to the first that finds a path."""
    results = {}
    for name in SEARCHERS:
        options = Options(generations=PLANNERS[name].generations)
        results[name] = make(name).plan(Evaluator(mountains), options)
        if results[name].evaluation.feasible:
            break
    return results


def test_names_the_first_planner_that_finds_a_path(mountains, alone):
    found = connect(Evaluator(mountains))
    finder = list(alone)[-1]
    assert (found.reason, found.planner) == (None, finder)
    np.testing.assert_array_equal(found.result.path, alone[finder].path)
    assert found.result.evaluations == sum(result.evaluations for result in alone.values())


@pytest.mark.ci
def test_a_planner_after_the_one_that_finds_a_path_is_not_asked(mountains):
    found = connect(Evaluator(mountains), searchers=("fpa-2opt", "astar"))
    options = Options(generations=PLANNERS["fpa-2opt"].generations)
    result = make("fpa-2opt").plan(Evaluator(mountains), options)
    assert result.evaluation.feasible
    assert (found.reason, found.planner) == (None, "fpa-2opt")
    assert found.result.evaluations == result.evaluations


def test_nothing_is_searched_where_the_reason_is_proven():
    found = connect(Evaluator(flat(zones=[WALL])))
    assert (found.reason.code, found.reason.proven) == ("closed", True)
    assert (found.result, found.planner) == (None, None)


def test_without_searchers_the_path_that_is_known_names_the_limit():
    problem = flat(zones=[Circle(1800, 1800, 200, name="K")])
    evaluator = Evaluator(problem)
    straight = evaluator.evaluate(np.array([problem.start, problem.goal]))
    reason = connect(evaluator, searchers=()).reason
    assert reason.code == "not-found"
    named = connect(evaluator, searchers=(), best=straight).reason
    assert named.sentence.startswith(reason.sentence.rstrip("."))
    assert "; the best path found breaks the limit zone K, " in named.sentence


def test_a_request_to_stop_ends_all_searches(mountains):
    stop = Stop()
    stop.request()
    found = connect(Evaluator(mountains), searchers=("fpa-2opt", "astar"), stop=stop)
    assert (found.planner, found.result.interrupted) == ("fpa-2opt", True)
    assert found.result.generations == 0


def test_the_second_opinion_is_asked_after_astar_by_itself(mountains):
    # The time limit is for the planner alone.
    search = Search("astar", generations=1, max_waypoints=1, time_limit_s=1e-3, fallback="astar")
    plan = search.run(Evaluator(mountains))
    assert plan.evaluation.feasible
    assert (plan.planner, plan.fallback, plan.reason) == ("astar", "fpa-2opt", None)
    assert plan.summary["fallback"] == "fpa-2opt"
    assert Evaluator(mountains).evaluate(plan.path).feasible
    assert plan.result.seconds["fallback"] <= plan.result.seconds["total"]


def test_no_fallback_searches_nothing(mountains):
    search = Search("astar", generations=1, max_waypoints=1, fallback="none")
    plan = search.run(Evaluator(mountains))
    assert (plan.evaluation.feasible, plan.fallback) == (False, None)
    assert (plan.reason.code, plan.reason.proven) == ("not-found", False)


def dead_ends(start_heading_deg, goal_heading_deg):
    """Return the way from one lane with a dead end into another."""
    terrain = Terrain("flat", np.full((80, 80), 100.0), 50.0, 50.0)
    return Problem(
        terrain,
        (300, 2000, 250),
        (3650, 2000, 250),
        zones=[*lane(-50, 1500), *lane(2450, 4000)],
        start_heading_deg=start_heading_deg,
        goal_heading_deg=goal_heading_deg,
    )


def test_names_the_heading_that_no_path_keeps_and_one_that_would_do():
    reason = connect(Evaluator(dead_ends(270, 90))).reason
    assert (reason.code, reason.proven, reason.end) == ("heading", False, "start")
    assert reason.place == (300, 2000)
    assert (reason.figure.limit, reason.figure.allowed) == ("start-heading", 270)
    assert reason.sentence == (
        "No path was found with the start heading of 270 degrees, and there is one without: at the "
        f"start it heads for {reason.figure.would_do:g} degrees."
    )
    assert connect(Evaluator(dead_ends(reason.figure.would_do, 90))).reason is None


@pytest.mark.ci
def test_names_the_heading_at_the_goal():
    reason = connect(Evaluator(dead_ends(90, 270))).reason
    assert (reason.code, reason.end, reason.place) == ("heading", "goal", (3650, 2000))
    assert (reason.figure.limit, reason.figure.allowed) == ("goal-heading", 270)
    assert connect(Evaluator(dead_ends(90, reason.figure.would_do))).reason is None


@pytest.mark.ci
def test_names_both_headings_where_each_is_one_too_many():
    reason = connect(Evaluator(dead_ends(270, 270))).reason
    assert [(end, fixed) for end, fixed, _ in reason.headings] == [("start", 270), ("goal", 270)]
    assert reason.sentence.startswith(
        "No path was found with the start heading of 270 degrees and the goal heading of 270 "
        "degrees, and there is one without: at the start it heads for "
    )


def test_headings_are_no_reason_where_there_is_no_path_without_them_either():
    assert connect(Evaluator(flat(zones=[WALL], start_heading_deg=90))).reason.code == "closed"


def test_cells_without_room_are_no_bad_input():
    """Every cell of a coarse terrain touches a zone, and the straight line passes between them."""
    terrain = Terrain("flat", np.zeros((3, 3)), 300.0, 300.0)
    zones = [
        Circle(x, y, radius)
        for x, y, radius in (
            (200.3, 448.1, 30.0),
            (492.1, 114.4, 72.0),
            (415.6, 477.3, 72.0),
            (110.9, 53.7, 30.0),
        )
    ]
    start, goal = (107.9, 428.2, 5.0), (280.6, 252.6, 40.0)
    evaluator = Evaluator(Problem(terrain, start, goal, zones=zones, rules=Rules()), threads=1)
    assert evaluator.evaluate(np.array((start, goal))).feasible
    with pytest.raises(InputError, match=r"^No flyable cell"):
        make("fpa-2opt").plan(evaluator, Options(generations=2))
    found = connect(evaluator, searchers=["fpa-2opt"])
    assert found.result is None
    assert found.reason is not None
