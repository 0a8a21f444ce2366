"""Selections of few waypoints of a route, compared with an enumeration."""

import itertools
import math

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.planners.grid.grid_search import SearchGrid
from pathgene.host.planners.grid.polylines import (
    _chord_costs,
    leads,
    lengthened,
    polylines,
    thinned,
)
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


@pytest.fixture
def hilly():
    """Grid, its surface and a winding route of nine points."""
    rng = np.random.default_rng(3)
    problem = Problem(
        Terrain("hilly", 400 * rng.random((40, 60)), 100.0, 100.0),
        (0, 0, 500),
        (5900, 3900, 500),
        aircraft.load("silver-fox"),
        zones=(Circle(2000, 1900, 250),),
        as_paper=True,
    )
    grid = SearchGrid(problem)
    route = np.array(
        [
            (0, 0),
            (200, 0),
            (500, 700),
            (1500, 1500),
            (2500, 1600),
            (3400, 2600),
            (4200, 3000),
            (5600, 3700),
            (5900, 3900),
        ],
        dtype=float,
    )
    return grid, grid.surface(math.inf), route


def test_chords_cost_their_length_and_avoid_zones(hilly):
    grid, surface, route = hilly
    level = np.full_like(surface, 300.0)
    costs = _chord_costs(route, grid, level)
    price = 300 * grid.prices.area + grid.prices.glide * grid.prices.work
    run = np.hypot(*(route[:, None] - route[None]).transpose(2, 0, 1))
    # It leads through the zone.
    for one, other in ((2, 5), (3, 5), (3, 6)):
        assert math.isinf(costs[one, other])
    finite = np.isfinite(costs)
    assert not finite[~np.triu(np.ones((9, 9), dtype=bool), 1)].any()
    assert finite[[0, 0, 2, 4], [1, 8, 3, 5]].all()
    # The first chord is 200 m long: enough for one turn of 150 m.
    assert costs[finite] == pytest.approx(price * run[finite], rel=1e-12)
    short = route.copy()
    short[2] = 400, 0  # 200 m between two turns.
    assert math.isinf(_chord_costs(short, grid, level)[1, 2])


def test_chords_have_the_prices_of_the_nodes_below_them(hilly):
    grid, surface, route = hilly
    costs, prices = _chord_costs(route, grid, surface), grid.price_per_m(surface)
    for one, other in zip(*np.nonzero(np.isfinite(costs)), strict=True):
        run = float(np.hypot(*(route[other] - route[one])))
        parts = 2 * math.ceil(run / min(grid.dx_m, grid.dy_m))
        shares = (np.arange(parts) + 0.5) / parts
        places = route[one] + (route[other] - route[one]) * shares[:, None]
        mean = prices[grid.nodes(*places.T)].mean()
        assert costs[one, other] == pytest.approx(mean * run, rel=1e-12)


def test_polylines_are_the_cheapest_of_their_length(hilly):
    grid, surface, route = hilly
    costs = _chord_costs(route, grid, surface)
    found = polylines(route, grid, surface, 7)
    assert len(found) == 8
    for count, line in enumerate(found):
        best = min(
            sum(costs[pair] for pair in itertools.pairwise((0, *inner, 8)))
            for inner in itertools.combinations(range(1, 8), count)
        )
        if math.isinf(best):
            assert line is None
        else:
            assert len(line) == count + 2
            assert sum(costs[pair] for pair in itertools.pairwise(line)) == pytest.approx(best)
    assert sum(line is not None for line in found) >= 4


def test_thinned_routes_keep_their_ends():
    route = np.cumsum(np.full((331, 2), 7.3), axis=0)
    points = thinned(route)
    assert 80 <= len(points) <= 101
    assert np.array_equal(points[[0, -1]], route[[0, -1]])
    assert {tuple(point) for point in points} <= {tuple(point) for point in route}
    assert np.array_equal(thinned(route[:50]), route[:50])


def test_thinned_routes_on_a_lattice_visit_no_point_twice():
    route = np.cumsum(np.full((60, 2), 7.3), axis=0)
    points = thinned(route, (30.0, 40.0))
    assert np.array_equal(points[[0, -1]], route[[0, -1]])
    assert np.array_equal(points[1:-1] % (30.0, 40.0), np.zeros((len(points) - 2, 2)))
    assert (np.diff(points, axis=0) != 0).any(axis=1).all()
    near = np.abs(points[1:-1, None] - route[None]).max(axis=2).min(axis=1)
    assert near.max() <= 20


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


def test_more_waypoints_divide_straight_pieces_equally():
    """The arc at the corner uses 100 m of both segments, which are then 900 and 300 m long."""
    corner = np.array([(0.0, 0.0), (1000.0, 0.0), (1000.0, 400.0)])
    longer = lengthened(corner, 5, 100.0)
    expected = [(x, 0) for x in (0, 225, 450, 675, 1000)] + [(1000, y) for y in (250, 400)]
    assert longer == pytest.approx(np.array(expected))
    assert lengthened(longer, 5, 100.0) is longer
