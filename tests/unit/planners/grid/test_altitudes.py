"""The lowest altitudes compared with scans of all altitudes and with the evaluation."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.grid.altitudes import lowest_altitudes
from pathgene.host.planners.grid.grid_search import Prices
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


def rough(seed, relief_m=120.0, height_m=150.0):
    """Return a problem across random heights at 100 m."""
    heights = 300 + relief_m * np.random.default_rng(seed).random((41, 61))
    terrain = Terrain("rough", heights, 100.0, 100.0)
    start, goal = (
        (x, y, float(terrain.ground(x, y)) + height_m) for x, y in ((300, 300), (5700, 3700))
    )
    return Problem(terrain, start, goal, aircraft.load("silver-fox"), as_paper=True)


def lowest(problem, inner, **step):
    places = np.array([problem.start[:2], *inner, problem.goal[:2]], dtype=float)
    return lowest_altitudes(problem, Prices(problem), places, **step)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 999), step_m=st.sampled_from((0.0, 0.25, 3.0)), turn=st.floats(-800, 800)
)
def test_the_path_is_flyable(seed, step_m, turn):
    problem = rough(seed)
    path = lowest(
        problem,
        [(1500, 1000 + turn), (2900, 2000 - turn), (4500, 3000 + turn)],
        base_m=250.0,
        step_m=step_m,
    )
    evaluation = Evaluator(problem, threads=1).evaluate(path)
    assert evaluation.feasible
    assert 0 < evaluation.minimum_clearance_m < 40
    if step_m:
        steps = (path[1:-1, 2] - 250.0) / step_m
        assert np.array_equal(steps, np.round(steps))


def test_altitudes_are_optimal():
    problem = rough(5)
    evaluator = Evaluator(problem, threads=1)
    path = lowest(problem, [(1800, 2300), (3900, 2500)])
    best = evaluator.evaluate(path)
    scan = np.arange(300, 700, 2.0)
    others = np.tile(path, (len(scan) ** 2, 1, 1))
    others[:, 1:3, 2] = list(itertools.product(scan, scan))
    penalty, cost = evaluator.penalty_cost(others, np.full(len(others), 4))
    flyable = penalty == 0
    assert flyable.sum() > 100
    # The linear program neglects the effect of slopes on length and drag.
    assert best.cost < cost[flyable].min() + 2e-4
    assert best.cost > cost[flyable].min() - 0.01


def test_steep_glides_are_not_free():
    # If only altitude counted, the path would descend as fast as allowed.
    terrain = Terrain("flat", np.zeros((41, 61)), 100.0, 100.0)
    problem = Problem(
        terrain, (300, 2000, 400), (5700, 2000, 400), aircraft.load("silver-fox"), as_paper=True
    )
    evaluator, prices = Evaluator(problem, threads=1), Prices(problem)
    places = np.array([(300, 2000), (1500, 2000), (4000, 2000), (5700, 2000)], dtype=float)
    free = Prices(problem)
    free.work = 0.0
    usual, steep = (lowest_altitudes(problem, price, places) for price in (prices, free))
    slopes = -np.diff(usual[:, 2]) / np.diff(usual[:, 0])
    assert slopes.max() == pytest.approx(prices.glide)
    assert steep[1, 2] < 1 < usual[1, 2]
    assert evaluator.evaluate(usual).cost < evaluator.evaluate(steep).cost


def test_a_spike_between_samples_is_cleared():
    heights = np.full((41, 61), 100.0)
    heights[20, 30] = 260.0
    problem = Problem(
        Terrain("spike", heights, 100.0, 100.0),
        (300, 1951, 150),
        (5700, 1951, 150),
        aircraft.load("silver-fox"),
        ds_m=900.0,
        as_paper=True,
    )
    path = lowest(problem, [(1500, 1951), (3000, 1951), (4500, 1951)])
    # 1 m north of the border of the spike's cell, from 2950 to 3050 m.
    evaluator = Evaluator(problem, ds_m=0.5, threads=1)
    assert evaluator.evaluate(path).feasible
    assert path[2, 2] == pytest.approx(260, abs=10)


# The climb is 28.2 steps high, so rounding alone makes it 29 for a fifth of the cases.
@pytest.mark.parametrize("base_m", [0.0, 0.8, 1.6, 2.4, 3.2, 4.0, 4.8])
def test_rounding_up_keeps_the_climb_limit(base_m):
    # The climb to the top of the wall determines the altitude of the waypoint before it.
    heights = np.full((41, 61), 100.0)
    heights[:, 20] = 400.0
    problem = Problem(
        Terrain("wall", heights, 100.0, 100.0),
        (300, 2000, 200),
        (5700, 2000, 150),
        aircraft.load("silver-fox"),
        as_paper=True,
    )
    evaluator = Evaluator(problem, threads=1)
    inner = [(1200, 2000), (2000, 2000), (4000, 2000)]
    exact, rounded = lowest(problem, inner), lowest(problem, inner, base_m=base_m, step_m=5.0)
    slope = (exact[2, 2] - exact[1, 2]) / 800
    assert slope == pytest.approx(math.tan(math.radians(10)), abs=1e-5)
    assert evaluator.evaluate(exact).feasible
    assert evaluator.evaluate(rounded).feasible
    assert (np.abs(rounded - exact)[:, 2] < 12).all()


def test_clears_an_arc_that_does_not_fit():
    assert lowest(rough(1), [(1500, 1500), (1550, 1500), (1550, 1600)]) is None


def test_clears_a_wall_too_steep_to_climb():
    problem = rough(2, relief_m=10.0)
    heights = problem.terrain.elevation.copy()
    heights[:, 10] = 700.0  # 400 m up in 700 m: 10 degrees are 123 m.
    wall = Problem(
        Terrain("wall", heights, 100.0, 100.0),
        problem.start,
        problem.goal,
        problem.aircraft,
        as_paper=True,
    )
    path = lowest(wall, [(1000, 1000), (3000, 2000)])
    evaluation = Evaluator(wall, threads=1).evaluate(path)
    assert evaluation.distance_under_terrain_m == 0
    assert evaluation.distance_too_steep_m > 0
    slopes = np.diff(path[:, 2]) / np.hypot(*np.diff(path[:, :2], axis=0).T)
    run = 1000 - 300 - 50
    assert slopes[0] < 1.3 * (700 - problem.start[2]) / math.hypot(run, run)


@pytest.mark.parametrize(
    ("wind_deg", "inner", "goal_m"),
    [
        (0, [(500, 2400), (3000, 2400)], 830),
        (45, [(2900, 1200), (3100, 2500)], 930),
        (90, [(500, 2400), (3000, 2400)], 920),
        (315, [(2900, 1200), (3100, 2500)], 1010),
    ],
)
def test_an_arc_in_wind_keeps_the_climb_limit_at_its_ends(wind_deg, inner, goal_m):
    """All of the path climbs nearly as steeply as the wind along each piece allows."""
    terrain = Terrain("flat", np.zeros((61, 61)), 100.0, 100.0)
    angle = math.radians(wind_deg)
    problem = Problem(
        terrain,
        (500, 900, 60),
        (3000, 5500, goal_m),
        aircraft.load("silver-fox"),
        wind=(8 * math.sin(angle), 8 * math.cos(angle)),
    )
    assert Evaluator(problem, threads=1).evaluate(lowest(problem, inner)).feasible
