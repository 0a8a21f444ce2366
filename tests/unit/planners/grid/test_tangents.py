"""Routes along tangents of zones, through gaps narrower than the nodes of a search."""

import itertools
import math

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options, Run
from pathgene.host.planners.choice import choose
from pathgene.host.planners.grid.astar import AstarPlanner, fine_searches
from pathgene.host.planners.grid.fine_grid import fine_grid
from pathgene.host.planners.grid.tangents import _gaps, tangent_routes
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain


SIDE_M, NODES = 30.0, 401
WIDTH_M = (NODES - 1) * SIDE_M
MIDDLE_M = WIDTH_M / 2
START, GOAL = (1_000.0, MIDDLE_M, 150.0), (WIDTH_M - 1_000.0, MIDDLE_M, 150.0)


def level(zones, **rules):
    terrain = Terrain("level", np.zeros((NODES, NODES)), SIDE_M, SIDE_M)
    return Problem(terrain, START, GOAL, zones=zones, **(rules or {"as_paper": True}))


def wall(low, high):
    """A zone across the straight line, 300 m wide."""
    west, east = MIDDLE_M - 150.0, MIDDLE_M + 150.0
    return Polygon(((west, low), (east, low), (east, high), (west, high)))


def gapped(gap_m, **rules):
    """A wall with a gap, whose ends are too far away for a detour."""
    low = MIDDLE_M + 915.0
    return level((wall(-100.0, low), wall(low + gap_m, WIDTH_M - 500.0)), **rules)


def routes_of(problem, most=10):
    grid = fine_grid(problem, 256)
    surface = np.full(grid.shape, 100.0)
    ends = np.array((problem.start[:2], problem.goal[:2]))
    return grid, tangent_routes(problem, grid, surface, ends, most)


def length(route):
    return np.hypot(*np.diff(route, axis=0).T).sum()


def test_passes_a_circle_on_both_sides_along_tangents():
    radius_m = 800.0
    grid, routes = routes_of(level((Circle(MIDDLE_M, MIDDLE_M, radius_m),)))
    assert len(routes) == 10
    lengths = [length(route) for route in routes]
    # On level ground the cheapest route is the shortest.
    assert lengths == pytest.approx(sorted(lengths))
    half, angle = MIDDLE_M - START[0], math.acos(radius_m / (MIDDLE_M - START[0]))
    shortest = 2 * half * math.sin(angle) + radius_m * (math.pi - 2 * angle)
    assert shortest < lengths[0] < 1.005 * shortest
    sides = {np.sign(route[1:-1, 1].mean() - MIDDLE_M) for route in routes}
    assert sides == {-1, 1}
    for one, other in itertools.combinations(routes, 2):
        assert one.shape != other.shape or not np.array_equal(one, other)
    for route in routes:
        assert np.array_equal(route[[0, -1]], [START[:2], GOAL[:2]])
        shares = np.linspace(0, 1, 500)[:, None]
        for start, stop in itertools.pairwise(route):
            at = start + shares * (stop - start)
            assert not grid.blocked_cells[grid.problem.terrain.nearest_nodes(*at.T)].any()


def test_level_ground_without_zones_has_the_straight_line():
    _, routes = routes_of(level(()))
    assert len(routes) == 1
    assert np.array_equal(routes[0], [START[:2], GOAL[:2]])


def test_returns_no_more_routes_than_wanted():
    zones = (Circle(MIDDLE_M, MIDDLE_M, 800.0),)
    _, many = routes_of(level(zones))
    _, few = routes_of(level(zones), most=3)
    assert len(few) == 3
    for one, other in zip(few, many, strict=False):
        assert np.array_equal(one, other)


@pytest.mark.parametrize(
    "zones", [(wall(-100.0, WIDTH_M + 100.0),), (wall(500.0, WIDTH_M - 500.0),)]
)
def test_a_wall_without_a_gap_or_with_a_long_detour_has_no_route(zones):
    """The second leaves a way of 1.5 times the straight line."""
    assert routes_of(level(zones))[1] == []


@pytest.mark.parametrize("rules", [{}, {"rules": Rules(clearance_m=20, zone_margin_m=10)}])
def test_finds_a_gap_that_is_narrower_than_the_nodes_of_the_search(rules):
    problem = gapped(70.0, **rules)
    evaluator = Evaluator(problem, threads=1)
    grid, routes = routes_of(problem)
    assert routes
    column = grid.blocked[:, grid.blocked.shape[1] // 2]
    assert column[: int(0.9 * len(column))].all()
    quick = AstarPlanner().plan(evaluator, Options(generations=8))
    run = Run(evaluator, Options())
    assert all(len(path) - 2 <= 32 for _, path in next(fine_searches(run, 32)))
    path, evaluation = choose(evaluator, run.candidates)
    assert evaluation.feasible
    assert np.abs(path[:, 1] - MIDDLE_M).max() < 1_100.0
    assert not quick.evaluation.feasible


@pytest.mark.parametrize("gap_m", [45.0, 60.0])
def test_passes_between_two_large_circles(gap_m):
    """Tangents of a circle meet its neighbour at the gap, and points in the gap lead through."""
    half = 900.0 + gap_m / 2
    circles = [Circle(MIDDLE_M + 31.0, MIDDLE_M + side * half, 900.0) for side in (-1, 1)]
    _, routes = routes_of(level(tuple(circles)))
    assert length(routes[0]) < 1.001 * (GOAL[0] - START[0])
    assert np.abs(routes[0][:, 1] - MIDDLE_M).max() < gap_m


def test_a_gap_of_polygons_has_points_on_its_axis():
    left, right = (
        Polygon(((x, 100), (x + 400, 100), (x + 400, 900), (x, 900))).footprint for x in (0, 450)
    )
    points = _gaps([left, right], 20.0)
    assert points[:, 0] == pytest.approx(425.0)
    assert np.diff(np.sort(points[:, 1])) == pytest.approx([100, 60, 60, 100])
    assert len(_gaps([left, right], 9.0)) == 0
    assert len(_gaps([left], 20.0)) == len(_gaps([], 20.0)) == 0
