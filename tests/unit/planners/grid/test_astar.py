"""Grid search as a planner."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from bench.scenarios import EMBEDDED, problem
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import PLANNERS
from pathgene.host.planners.base import Options, Stop
from pathgene.host.planners.grid.astar import QUICK_SEARCHES, AstarPlanner
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import surface_below


# Searches of two margins and four slopes, and of two distances around both ends.
MOST_SEARCHES = 2 * 4 + 2 * 2 * 8


ALL = Options(generations=MOST_SEARCHES)


def test_finds_the_gap_and_repeats_it(evaluator, record):
    first, again = (
        AstarPlanner().plan(evaluator, Options(generations=8, seed=seed), progress)
        for seed, progress in ((1, record), (2, None))
    )
    assert first.evaluation.feasible
    assert evaluator.evaluate(first.path) == first.evaluation
    assert np.array_equal(first.path, again.path)
    assert first.history == again.history == record.seen
    # The straight line, then four surfaces; low surfaces lead around the wall.
    assert [generation for generation, _, _ in first.history] == [0, 1, 2, 3, 4]
    assert (first.generations, first.stopped_by, first.hardware) == (4, "generations", None)
    assert 1 + 4 <= first.evaluations <= 1 + 4 * 5
    best = [best for _, best, _ in first.history]
    assert best == sorted(best)
    assert best[0] < 1 < best[1]
    assert set(first.seconds) == {"search", "evaluation", "choice", "compiling", "total"}


def test_beats_the_genetic_algorithm_on_the_embedded_terrain():
    evaluator = Evaluator(problem(EMBEDDED), threads=1)
    result = AstarPlanner().plan(evaluator, ALL)
    assert result.evaluation.feasible
    # The means of ga-fpga and ga-pc are 1.481 and 1.460.
    assert result.evaluation.fitness > 1.505


def hills(seed, **options):
    """Return a flight from 10 m above rough ground, which only few directions can leave."""
    rng = np.random.default_rng(seed)
    heights = gaussian_filter(rng.standard_normal((80, 80)), 6)
    terrain = Terrain("hills", 400 * (heights - heights.min()) / np.ptp(heights), 50.0, 50.0)
    places = rng.uniform(800, 3100, (2, 2))
    ground = surface_below(terrain, *places.T)
    start, goal = np.column_stack((places, ground + 10.0)).tolist()
    return Problem(terrain, tuple(start), tuple(goal), aircraft.load("silver-fox"), **options)


@pytest.mark.parametrize("seed", [2, 16, 37])
def test_climbs_out_of_low_ground_in_the_direction_that_allows_it(seed):
    evaluator = Evaluator(hills(seed), threads=1)
    few = AstarPlanner().plan(evaluator, Options(generations=8))
    result = AstarPlanner().plan(evaluator, ALL)
    assert not few.evaluation.feasible
    assert result.evaluation.feasible
    assert 8 < result.generations <= MOST_SEARCHES


def test_keeps_fixed_headings_while_it_tries_directions():
    problem = hills(16, goal_heading_deg=40.0)
    result = AstarPlanner().plan(Evaluator(problem, threads=1), ALL)
    assert result.evaluation.feasible
    assert result.generations > 8


def test_tries_no_directions_as_paper():
    # A wall that cannot be climbed.
    heights = np.zeros((20, 20))
    heights[:, 10] = 5000.0
    wall = Terrain("wall", heights, 100.0, 100.0)
    ends = (300.0, 1000.0, 50.0), (1600.0, 1000.0, 50.0)
    problem = Problem(wall, *ends, aircraft.load("silver-fox"), as_paper=True)
    result = AstarPlanner().plan(Evaluator(problem, threads=1), ALL)
    assert not result.evaluation.feasible
    assert result.generations <= 8


def test_keeps_the_maximum_of_waypoints(evaluator):
    for most in (1, 3, 16):
        result = AstarPlanner(max_waypoints=most).plan(evaluator, ALL)
        assert max(len(path) - 2 for _, path in result.archive) <= most


def test_more_waypoints_than_turns_lower_the_path():
    evaluator = Evaluator(problem(EMBEDDED), threads=1)
    found = {most: AstarPlanner(max_waypoints=most).plan(evaluator, ALL) for most in (None, 16)}
    assert {most: len(result.path) - 2 for most, result in found.items()} == {None: 32, 16: 16}
    assert found[None].evaluation.fitness > found[16].evaluation.fitness + 0.005
    # Every path of the first has up to 16 turns.
    for _, path in found[None].archive:
        way = np.diff(path[:, :2], axis=0)
        turns = np.abs(np.diff(np.unwrap(np.arctan2(way[:, 1], way[:, 0])))) > 1e-6
        assert turns.sum() <= 16


@pytest.mark.parametrize("count", [0, 101])
def test_refuses_bad_numbers_of_waypoints(count):
    with pytest.raises(InputError) as caught:
        AstarPlanner(max_waypoints=count)
    assert str(caught.value) == (
        f"The most waypoints of a path must be from 1 to 100, not {count}."
    )


def test_refuses_a_population(evaluator):
    with pytest.raises(InputError) as caught:
        AstarPlanner().plan(evaluator, Options(population=32))
    assert str(caught.value) == (
        "The planner astar has no population; leave it out (--population)."
    )


def test_flies_straight_over_level_ground(make_evaluator):
    evaluator = make_evaluator(
        np.full((41, 61), 100.0), zones=(), start=(500, 700, 200), goal=(5500, 700, 200)
    )
    result = AstarPlanner().plan(evaluator, ALL)
    run = 5000 / result.evaluation.length_m
    assert 0.99 < run <= 1
    assert (
        result.evaluation.fitness
        > evaluator.evaluate(np.array([evaluator.problem.start, evaluator.problem.goal])).fitness
    )


def test_plans_to_a_goal_five_degrees_below_the_start():
    level = Terrain("level", np.full((41, 61), 100.0), 100.0, 100.0)
    evaluator = Evaluator(Problem(level, (500, 700, 600), (5500, 700, 163)), threads=1)
    result = AstarPlanner().plan(evaluator, ALL)
    assert result.evaluation.feasible
    assert 1 < result.evaluation.fitness < 2


def test_has_no_route_to_a_goal_straight_above_the_start():
    level = Terrain("level", np.full((41, 61), 100.0), 100.0, 100.0)
    evaluator = Evaluator(Problem(level, (3000, 2000, 200), (3000, 2000, 320)), threads=1)
    result = AstarPlanner().plan(evaluator, ALL)
    assert not result.evaluation.feasible


def test_returns_the_straight_line_without_a_way(make_evaluator):
    walls = tuple(Circle(3000, y, 300) for y in range(0, 4001, 400))
    evaluator = make_evaluator(zones=walls)
    result = AstarPlanner().plan(evaluator, ALL)
    assert (result.generations, result.evaluations) == (0, 1)
    assert np.array_equal(result.path, [evaluator.problem.start, evaluator.problem.goal])
    assert not result.evaluation.feasible


def test_keeps_away_from_zones_when_hugging_them_fails():
    # A wall of one node with sharp turns around its end.
    terrain = Terrain("plain", np.zeros((201, 201)), 10.0, 10.0)
    wall = Polygon(((995, 0), (1005, 0), (1005, 1100), (995, 1100)))
    evaluator = Evaluator(
        Problem(
            terrain,
            (200, 200, 50),
            (1800, 200, 50),
            aircraft.load("silver-fox"),
            zones=(wall,),
            as_paper=True,
        ),
        threads=1,
    )
    near, far = (AstarPlanner().plan(evaluator, Options(generations=count)) for count in (4, 8))
    assert not near.evaluation.feasible
    assert far.generations > 4
    assert far.evaluation.feasible


def test_stop_criteria(evaluator):
    planner = AstarPlanner()
    target = planner.plan(evaluator, Options(generations=8, target_fitness=1.01))
    assert (target.generations, target.stopped_by) == (1, "target-fitness")
    few = planner.plan(evaluator, Options(generations=2))
    assert (few.generations, few.stopped_by) == (2, "generations")
    late = planner.plan(evaluator, Options(generations=8, time_limit_s=1e-9))
    assert (late.generations, late.stopped_by) == (0, "time-limit")


def test_interrupt_returns_the_best_so_far(evaluator):
    stop = Stop()

    def progress(generation, best, mean):
        if generation == 2:
            stop.request()

    result = AstarPlanner().plan(evaluator, ALL, progress, stop)
    assert (result.interrupted, result.generations, stop.heeded) == (True, 2, True)
    assert result.evaluation.feasible


def test_registry_leaves_room_for_narrow_searches():
    assert QUICK_SEARCHES == MOST_SEARCHES < PLANNERS["astar"].generations


def test_flies_around_voids(make_evaluator):
    elevation = np.full((41, 61), 100.0)
    elevation[:25, 28:33] = np.nan
    result = AstarPlanner().plan(make_evaluator(elevation), ALL)
    assert result.evaluation.feasible
    assert result.path[:, 1].max() > 2450
