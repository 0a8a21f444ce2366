"""Repairs make paths feasible that break the strict rule."""

import dataclasses

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.grid.repairs import load_repairs, repair
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


HEIGHTS = np.full((61, 61), 100.0)
START, GOAL = (1000.0, 3000.0, 300.0), (5000.0, 3000.0, 300.0)
STRAIGHT = np.array([START, (3000.0, 3000, 300), GOAL])
RULES = Rules(clearance_m=30, corridor_m=20, zone_margin_m=25, reserve=0)


def evaluator_of(heights=HEIGHTS, rules=RULES, **options):
    options.setdefault("start_heading_deg", 90.0)
    terrain = Terrain("flat", heights, 100.0, 100.0)
    return Evaluator(Problem(terrain, START, GOAL, rules=rules, **options), threads=1)


def check(evaluator, path):
    """Repair a path; return the repaired one, which is feasible."""
    assert not evaluator.evaluate(path).feasible
    mended = repair(evaluator, path)
    assert mended is not None
    assert evaluator.evaluate(mended).feasible
    assert (mended[[0, -1]] == path[[0, -1]]).all()
    return mended


@pytest.mark.parametrize("ahead_m", [180, 300, 600])
def test_a_zone_right_ahead(ahead_m):
    zone = Zone.circle(START[0] + ahead_m + 250, 3020, 250)
    evaluator = evaluator_of(zones=(zone,))
    mended = check(evaluator, STRAIGHT)
    assert mended[1, 1] == 3000.0
    assert mended[1, 0] > START[0]


def test_a_zone_before_the_goal():
    zone = Zone.circle(GOAL[0] - 500, 3020, 250)
    evaluator = evaluator_of(zones=(zone,))
    ahead = np.insert(STRAIGHT, 1, (1500.0, 3000, 300), axis=0)
    mended = check(evaluator, ahead)
    assert (mended[:2] == ahead[:2]).all()


@pytest.mark.parametrize("at_goal", [False, True])
def test_the_nearer_end_comes_first(at_goal):
    zone = Zone.circle(4000 if at_goal else 2000, 3000, 40)
    evaluator = evaluator_of(zones=(zone,), goal_heading_deg=90.0)
    path = np.array([START, (1300, 3000, 300), (2700, 3000, 300), (3300, 3000, 300), GOAL])
    path = np.insert(path, 4, (4700, 3000, 300), axis=0)
    mended = check(evaluator, path)
    kept = mended[:2] == path[:2] if at_goal else mended[-2:] == path[-2:]
    assert kept.all()


def test_what_the_other_end_alone_can_mend():
    """The zone is nearer to the start, but beyond all waypoints that its routes can join."""
    evaluator = evaluator_of(zones=(Zone.circle(2600, 3000, 40),))
    before = [(START[0] + 150 * number, 3000, 300) for number in range(1, 8)]
    path = np.array([START, *before, GOAL])
    (stretch,) = evaluator.broken(path)
    assert stretch.to_m < 2000
    mended = check(evaluator, path)
    assert (mended[:2] == path[:2]).all()


def test_a_goal_behind():
    evaluator = evaluator_of(start_heading_deg=270.0)
    ahead = np.array([START, (START[0] - 160, 3000, 300), (3000.0, 3000, 300), GOAL])
    assert evaluator.evaluate(ahead).impossible_arcs == 1
    check(evaluator, ahead)


def test_ground_beside_the_goal():
    """A hill blocks the way to the goal, which is reached from the far side."""
    heights = HEIGHTS.copy()
    heights[26:35, 49] = 290.0
    evaluator = evaluator_of(heights)
    (stretch,) = evaluator.broken(STRAIGHT)
    assert stretch.limit == "clearance"
    assert stretch.from_m > 3700
    mended = check(evaluator, STRAIGHT)
    # Another route, at the same altitude.
    assert (mended[:, 2] == 300).all()


def test_too_low_on_the_way():
    low = STRAIGHT.copy()
    low[1, 2] = 110.0
    evaluator = evaluator_of()
    mended = check(evaluator, low)
    assert (mended[:, :2] == low[:, :2]).all()


def test_as_paper_only_altitudes():
    evaluator = evaluator_of(rules=None, as_paper=True, start_heading_deg=None)
    low = STRAIGHT.copy()
    low[1, 2] = 50.0
    check(evaluator, low)
    zone = Zone.circle(1500, 3000, 250)
    blocked = evaluator_of(rules=None, as_paper=True, start_heading_deg=None, zones=(zone,))
    assert repair(blocked, STRAIGHT) is None


def test_no_fuel_for_any_way():
    evaluator = evaluator_of(rules=dataclasses.replace(RULES, reserve=0.999))
    assert evaluator.broken(STRAIGHT)[0].limit == "fuel"
    mended = repair(evaluator, STRAIGHT)
    assert mended is not None
    assert not evaluator.evaluate(mended).feasible


def test_a_feasible_path_needs_no_repair():
    assert repair(evaluator_of(), STRAIGHT) is None


def test_where_there_is_no_way():
    wall = Zone.polygon([(2000, -100), (2100, -100), (2100, 6200), (2000, 6200)])
    assert repair(evaluator_of(zones=(wall,)), STRAIGHT) is None


@pytest.mark.parametrize("rules", [None, RULES])
def test_loading_needs_no_broken_path(rules):
    load_repairs(
        evaluator_of(rules=rules, as_paper=rules is None, start_heading_deg=None), STRAIGHT
    )


def test_a_climb_that_is_too_steep_from_the_start_on():
    """The limit is violated far beyond two turn radii, but from the start on."""
    heights = HEIGHTS.copy()
    heights[27:34, 17:20] = 500.0
    evaluator = evaluator_of(heights)
    steep = np.array([START, (1600.0, 3000, 560), (2100.0, 3000, 560), (4500.0, 3000, 300), GOAL])
    (climb,) = evaluator.broken(steep)
    assert climb.limit == "climb"
    radius_m = evaluator.problem.limits.turn_radius_m
    assert climb.from_m < radius_m
    assert climb.to_m > 3 * radius_m
    mended = check(evaluator, steep)
    # It is a route around the hill.
    assert np.abs(mended[1:-1, 1] - 3000).max() > 300
