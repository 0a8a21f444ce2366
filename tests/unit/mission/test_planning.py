"""Legs planned in order, and the path of all of them."""

import json
from contextlib import nullcontext

import numpy as np
import pytest

from pathgene.host.device import boards
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.legs import MissionPlan, shortcoming
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.mission.plan import plan as plan_by_function
from pathgene.host.mission.planning import plan_mission
from pathgene.host.planners.base import Stop
from pathgene.host.planning import Plan, Search
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.report.read import read_run
from pathgene.host.report.write import scene
from pathgene.host.terrain import Terrain, load


START, GOAL, VIA = (500.0, 500.0, 480.0), (5500.0, 3500.0, 480.0), (3000.0, 3300.0, 620.0)


@pytest.fixture(scope="module")
def terrain():
    y, x = np.mgrid[:41, :61]
    return Terrain("hills", 300 + 150 * np.sin(x / 8) * np.cos(y / 6), 100, 100)


def mission(terrain, via=(VIA,), return_to_start=False, **options):
    return MissionProblem(Problem(terrain, START, GOAL, **options), via, return_to_start)


def search(generations=30, **options):
    return Search("ga-pc", seed=3, generations=generations, init="astar", **options)


@pytest.fixture(scope="module")
def planned(terrain):
    seen = []
    plan = plan_mission(
        mission(terrain, zones=[Circle(4200, 3300, 300, name="town")], return_to_start=True),
        search(),
        progress=lambda *row: seen.append(row),
        source={"source": "hills", "fill_voids": False, "cell_m": None},
    )
    return plan, seen


def test_the_path_passes_all_points_and_returns(planned):
    plan, _ = planned
    assert isinstance(plan, MissionPlan)
    waypoints = plan.path.tolist()
    places = [waypoints.index(list(point)) for point in (START, VIA, GOAL)]
    assert places == sorted(places)
    assert waypoints[0] == waypoints[-1] == list(START)
    assert len(plan.path) == sum(len(leg.path) for leg in plan.legs) - 2


@pytest.mark.ci
def test_an_observer_sees_the_legs_before_in_every_path(terrain):
    class Observer:
        def __init__(self):
            self.paths, self.generations = [], []

        def __call__(self, generation, best, mean):
            self.generations.append(generation)

        def improved(self, path):
            self.paths.append(path)

    observer = Observer()
    plan = plan_mission(mission(terrain, return_to_start=True), search(), progress=observer)
    assert observer.generations == [row[0] for row in plan.history]
    ends = [tuple(path[-1]) for path in observer.paths]
    assert set(ends) == {VIA, GOAL, START}
    assert all(tuple(path[0]) == START for path in observer.paths)
    for path in observer.paths:
        passed = {VIA: [], GOAL: [VIA], START: [VIA, GOAL]}[tuple(path[-1])]
        assert all(point in map(tuple, path.tolist()) for point in passed)
    # The last path shown is the path that is flown.
    assert np.array_equal(observer.paths[-1], plan.path)


def test_legs_join_with_turns_that_fit(planned):
    plan, _ = planned
    headings = [leg.plan.evaluator.problem.start_heading_deg for leg in plan.legs]
    assert headings[0] is None
    assert None not in headings[1:]
    assert plan.evaluation.impossible_arcs == 0


@pytest.mark.ci
@pytest.mark.parametrize("planner", ["ga-pc", "fpa-2opt"])
def test_a_return_comes_near_the_goal_and_is_feasible(planner):
    """The fallback plans a turn beyond the goal, which random planners do not find."""
    land = load("canyon")
    task = MissionProblem(
        Problem(land, (300.0, 300.0, 266.0), (4700.0, 4600.0, 243.0)), return_to_start=True
    )
    plan = plan_mission(task, Search(planner, generations=30, fallback="astar"))
    assert plan.evaluation.feasible
    assert all(leg.feasible for leg in plan.legs)
    assert shortcoming(plan.summary) is None
    (visit,) = plan.summary["visits"]
    assert not visit["missed"]
    radius_m = task.problem.limits.turn_radius_m
    assert visit["horizontal_m"] <= 0.4143 * radius_m


def test_the_whole_path_is_evaluated_as_one(planned):
    plan, _ = planned
    whole = plan.mission.whole
    assert plan.evaluation == Evaluator(whole).evaluate(plan.path)
    summary = plan.summary
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    assert summary["waypoints"] == plan.path.tolist()
    assert (summary["via"], summary["return"]) == ([list(VIA)], True)
    assert summary["terrain"]["source"] == "hills"
    assert [leg["index"] for leg in summary["legs"]] == [1, 2, 3]
    assert [(leg["from"], leg["to"]) for leg in summary["legs"]] == [
        (list(START), list(VIA)),
        (list(VIA), list(GOAL)),
        (list(GOAL), list(START)),
    ]
    for leg, made in zip(summary["legs"], plan.legs, strict=True):
        assert leg["feasible"] is made.plan.evaluation.feasible
        assert leg["length_m"] == made.plan.evaluation.length_m
        assert leg["planned"]
        assert leg["failure"] is None


def test_history_and_progress_count_all_generations(planned):
    plan, seen = planned
    generations = [row[0] for row in plan.history]
    assert generations == list(range(3 * 31))
    assert plan.result.generations == 3 * 30
    assert [row[0] for row in seen][: len(generations)] == generations
    assert plan.result.history_evaluations == sorted(plan.result.history_evaluations)
    assert plan.result.evaluations == sum(leg.plan.result.evaluations for leg in plan.legs)
    assert plan.result.seconds["total"] == pytest.approx(
        sum(leg.plan.result.seconds["total"] for leg in plan.legs)
    )


def test_saves_and_draws_all_legs(planned, tmp_path):
    plan, _ = planned
    names = [file.name for file in plan.save(tmp_path)]
    assert names == ["summary.json", "terrain.npz", "path.geojson", "path.png"]
    assert json.loads((tmp_path / "summary.json").read_text())["legs"] == plan.summary["legs"]
    run = read_run(tmp_path / "summary.json")
    assert run.problem.way == plan.mission.way
    assert Evaluator(run.problem).evaluate(run.path) == plan.evaluation


def test_legs_of_few_rows_are_counted_and_drawn(terrain, tmp_path):
    """Not every generation of ga-chip has a row."""
    plan = plan_mission(mission(terrain), Search("ga-chip", generations=200, polish="off"))
    assert [row[0] for row in plan.history] == [0, 200, 201, 401]
    assert [file.name for file in plan.save(tmp_path, warn=pytest.fail)][-1] == "path.png"
    legs = scene(plan.evaluator, plan.result, plan.summary).legs
    assert legs == [
        (0, plan.summary["legs"][0]["fitness"]),
        (2, plan.summary["legs"][1]["fitness"]),
    ]


def test_the_same_seed_gives_the_same_path(terrain):
    options = {"seed": 3, "generations": 5, "init": "astar", "fallback": "none"}
    by_function = plan_by_function(mission(terrain), "ga-pc", **options)
    assert [leg.name for leg in by_function.legs] == [
        mission(terrain).name_of(leg) for leg in (0, 1)
    ]
    np.testing.assert_array_equal(plan_mission(mission(terrain), search(5)).path, by_function.path)


def test_a_mission_as_paper_is_evaluated_by_the_papers(terrain):
    as_paper = mission(terrain, as_paper=True)
    plan = plan_mission(as_paper, search(2))
    assert plan.evaluation == Evaluator(as_paper.whole).evaluate(plan.path)
    assert all(leg.plan.evaluation.flight_time_s is None for leg in plan.legs)
    assert plan.summary["as_paper"]


def test_a_mission_is_not_replanned_as_one(planned):
    with pytest.raises(InputError, match=r"^A plan of several legs cannot be replanned as one; "):
        planned[0].replan()


def test_a_single_leg_is_a_plain_plan(terrain):
    single = mission(terrain, via=())
    plan = plan_mission(single, search(5))
    assert type(plan) is Plan
    np.testing.assert_array_equal(plan.path, search(5).run(Evaluator(single.problem)).path)


def test_an_infeasible_leg_is_kept_and_the_others_planned(terrain):
    """A wall of zones lies across the second leg."""
    wall = [Circle(4300, y, 300) for y in range(0, 4001, 400)]
    plan = plan_mission(mission(terrain, zones=wall), search(3))
    assert [leg.feasible for leg in plan.legs] == [True, False]
    assert plan.legs[1].name == "leg 2, from via point 1 to the goal"
    assert not plan.evaluation.feasible
    assert plan.evaluation.distance_in_nofly_m > 0
    assert plan.failure is None


class FailsFrom:
    """A search whose runs fail, starting with a given leg."""

    board = None

    def __init__(self, first):
        self.real, self.left = search(5), first

    def run(self, *arguments, **options):
        self.left -= 1
        if self.left < 0:
            raise JobError("The board is lost.")
        return self.real.run(*arguments, **options)


def test_a_leg_that_fails_leaves_those_planned_before(terrain):
    plan = plan_mission(mission(terrain, return_to_start=True), FailsFrom(1))
    assert plan.failure == "Leg 2, from via point 1 to the goal: The board is lost."
    assert [leg["planned"] for leg in plan.summary["legs"]] == [True, False, False]
    assert [leg.feasible for leg in plan.legs[:2]] == [True, False]
    assert plan.path[-3:].tolist() == [list(VIA), list(GOAL), list(START)]
    np.testing.assert_array_equal(plan.path[:-2], plan.legs[0].path)
    assert plan.summary["stopped_by"] == "failure"


def test_a_first_leg_that_fails_leaves_nothing(terrain):
    with pytest.raises(JobError, match=r"^The board is lost\.$"):
        plan_mission(mission(terrain), FailsFrom(0))


def test_an_interrupt_that_nobody_catches_ends_the_mission(terrain):
    def progress(generation, best, mean):
        if generation == 8:  # In the second leg.
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        plan_mission(mission(terrain), search(5), progress=progress)


def test_a_stop_in_the_second_leg_keeps_the_first(terrain):
    stop = Stop()

    def progress(generation, best, mean):
        if generation == 8:
            stop.request()

    plan = plan_mission(
        mission(terrain, return_to_start=True), search(5), progress=progress, stop=stop
    )
    assert plan.interrupted
    assert plan.failure is None
    assert [leg.plan and leg.plan.interrupted for leg in plan.legs] == [False, True, None]
    assert plan.result.generations == 5 + 2


def test_the_legs_share_a_board(terrain, monkeypatch):
    """It gets the map once, and the paths are as if each leg had opened a board."""
    opened, real = [], boards.open_board

    def open_board(url):
        opened.append(real(url))
        return opened[-1]

    monkeypatch.setattr(boards, "open_board", open_board)
    own = {"board": "model:", "generations": 200, "polish": "off"}
    shared = plan_mission(mission(terrain, return_to_start=True), Search("ga-chip", **own))
    assert len(opened) == 1
    assert opened[0].closed
    monkeypatch.setattr(boards, "kept_open", nullcontext)
    apart = plan_mission(mission(terrain, return_to_start=True), Search("ga-chip", **own))
    assert len(opened) == 1 + len(apart.legs) == 4
    for one, other in zip(shared.legs, apart.legs, strict=True):
        assert np.array_equal(one.path, other.path)
    sent = [
        [leg.plan.result.hardware["bytes"]["to_board"] for leg in plan.legs]
        for plan in (shared, apart)
    ]
    assert sent[0][0] == sent[1][0]
    assert sent[0][2] < 0.2 * sent[1][2]
