"""Waypoints that turn a path from a fixed heading onto its route."""

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.planners.grid.turns_at_ends import leads
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.terrain import Terrain


FLAT = Terrain("flat", np.full((61, 61), 100.0), 100.0, 100.0)
START, GOAL = (2000.0, 3000.0, 300.0), (5000.0, 3000.0, 300.0)


def flight(**headings):
    return Problem(FLAT, START, GOAL, rules=Rules(), **headings)


def test_free_ends_have_no_turn():
    ((first, last),) = leads(flight())
    assert len(first) == len(last) == 0


def test_ways_by_the_size_of_the_turn():
    """East is along the line: ahead, aside, and back by either side."""
    counts = {
        heading: [len(first) for first, _ in leads(flight(start_heading_deg=heading))]
        for heading in (90, 30, 0, 270)
    }
    assert counts == {90: [0, 1], 30: [1, 2], 0: [1, 2], 270: [2, 2]}
    (_, (ahead, aside)) = [first for first, _ in leads(flight(start_heading_deg=0))]
    assert ahead == pytest.approx((2000, 3150))
    assert aside == pytest.approx((2300, 3150))


def test_the_goal_mirrors_the_start():
    way = [last for _, last in leads(flight(goal_heading_deg=0))]
    assert way[0] == pytest.approx(np.array([(5000, 2850)]))
    assert way[1] == pytest.approx(np.array([(4700, 2850), (5000, 2850)]))


def test_no_waypoint_off_the_map():
    problem = Problem(FLAT, (50, 3000, 300), GOAL, rules=Rules(), start_heading_deg=270)
    assert list(leads(problem)) == []


@pytest.mark.parametrize("start", [0, 90, 180, 270])
@pytest.mark.parametrize("goal", [None, 45, 270])
def test_astar_keeps_the_headings(start, goal):
    problem = flight(start_heading_deg=start, goal_heading_deg=goal)
    result = make("astar").plan(Evaluator(problem, threads=1), Options(generations=8))
    assert result.evaluation.feasible
