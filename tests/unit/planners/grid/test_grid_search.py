"""The coarse grid and its cheapest routes compared with exhaustive searches."""

import itertools
import math

import numpy as np
import pytest
from scipy import ndimage

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.grid.grid_search import Prices, SearchGrid, _widened
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


REACHED = {(0, 1), (1, 0), (1, 1), (1, 2), (2, 1)}
WIND = (4.0, -7.0)


def small(rows=6, columns=7, zones=(), wind=(0.0, 0.0), seed=1):
    """Return a problem over a few rough nodes at 400 m by 300 m."""
    rng = np.random.default_rng(seed)
    terrain = Terrain("small", 200 + 120 * rng.random((rows, columns)), 400.0, 300.0)
    start, goal = (0, 0, 500), ((columns - 1) * 400, (rows - 1) * 300, 500)
    return Problem(
        terrain, start, goal, aircraft.load("silver-fox"), zones=zones, wind=wind, as_paper=True
    )


def steps(problem):
    """Yield every pair of nodes that a route may join, and the nodes it passes."""
    nodes = list(itertools.product(*map(range, problem.terrain.shape)))
    for one, other in itertools.product(nodes, nodes):
        rise, run = other[0] - one[0], other[1] - one[1]
        if (abs(rise), abs(run)) in REACHED:
            passed = {
                (one[0] + half(rise / 2), one[1] + half(run / 2))
                for half in (math.floor, math.ceil)
            }
            yield one, other, passed | {other}


def cheapest(problem, price):
    """Return the minimum cost from the south-west node to every node, by Bellman-Ford."""
    cost = dict.fromkeys(itertools.product(*map(range, problem.terrain.shape)), math.inf)
    cost[0, 0] = 0.0
    every = [(one, other, price(one, other, passed)) for one, other, passed in steps(problem)]
    for _ in cost:
        for one, other, step in every:
            cost[other] = min(cost[other], cost[one] + step)
    return cost


def run_m(one, other):
    return math.hypot(400 * (other[1] - one[1]), 300 * (other[0] - one[0]))


@pytest.mark.parametrize("steepness", [0.02, 0.1, math.inf])
def test_surface_is_the_lowest_within_the_slope(steepness):
    problem = small()
    ground = problem.terrain.elevation
    surface = SearchGrid(problem).surface(steepness)
    nodes = list(itertools.product(*map(range, ground.shape)))
    ways = {}
    for node in nodes:
        way = dict.fromkeys(nodes, math.inf) | {node: 0.0}
        for _ in range(7):
            for one, other, _ in steps(problem):
                way[other] = min(way[other], way[one] + run_m(one, other))
        ways[node] = way
    for node in nodes:
        highest = max(
            ground[other] - (steepness * ways[other][node] if other != node else 0.0)
            for other in nodes
        )
        # Start and goal are too high to descend to the ground immediately.
        x, y = 400 * node[1], 300 * node[0]
        down = 500 - math.tan(math.radians(30)) * math.hypot(x, y)
        up = 500 - math.tan(math.radians(10)) * math.hypot(x - 2400, y - 1500)
        assert surface[node] == pytest.approx(max(highest, down, up), rel=1e-12)


@pytest.mark.parametrize("wind", [(0.0, 0.0), WIND])
def test_route_is_the_cheapest(wind):
    problem = small(zones=(Circle(800, 600, 450),), wind=wind)
    grid = SearchGrid(problem)
    surface = grid.surface(0.05)
    prices = Prices(problem)

    def price(one, other, passed):
        if any(problem.nofly_raster[node] for node in passed):
            return math.inf
        run, rise = run_m(one, other), surface[other] - surface[one]
        east, north = (400 * (other[1] - one[1]) / run, 300 * (other[0] - one[0]) / run)
        cross = wind[0] * north - wind[1] * east
        ground_speed = wind[0] * east + wind[1] * north + math.sqrt(23**2 - cross**2)
        thrust = max(0.0, prices.glide + rise / run)
        mean = 0.5 * (surface[one] + surface[other])
        return prices.area * mean * run + prices.work * thrust * run * 23 / ground_speed

    route = grid.route(surface)
    nodes = [(round(y / 300), round(x / 400)) for x, y in route]
    assert np.array_equal(route[[0, -1]], [problem.start[:2], problem.goal[:2]])
    passed = {(one, other): cells for one, other, cells in steps(problem)}
    flown = sum(price(one, other, passed[one, other]) for one, other in itertools.pairwise(nodes))
    assert flown == pytest.approx(cheapest(problem, price)[5, 6], rel=1e-12)


def test_wind_changes_the_route():
    flat = np.full((9, 30), 100.0)
    flat[4, 5:25] = 180.0
    ends = (0, 1600, 200), (11600, 1600, 200)
    routes = []
    for wind in (WIND, (WIND[0], -WIND[1])):
        problem = Problem(
            Terrain("flat", flat, 400.0, 400.0),
            *ends,
            aircraft.load("silver-fox"),
            wind=wind,
            as_paper=True,
        )
        grid = SearchGrid(problem)
        routes.append(grid.route(grid.surface(math.inf)))
    assert not np.array_equal(*routes)


def test_prices_match_the_evaluation():
    problem = small()
    evaluator, prices = Evaluator(problem, threads=1), Prices(problem)
    low, high = (
        np.array([problem.start, (0, 1500, 500), (0, 1500, z), problem.goal])
        for z in (500.0, 501.0)
    )
    level = evaluator.evaluate(np.array([problem.start, problem.goal]))
    run = math.hypot(2400, 1500)
    assert level.cost == pytest.approx(
        prices.area * 500 * run + prices.work * prices.glide * run, rel=1e-3
    )
    climb = evaluator.evaluate(high).fuel_N - evaluator.evaluate(low).fuel_N
    assert climb > 0
    # To a higher goal: a climb costs as much as its height.
    up = Problem(problem.terrain, problem.start, (2400, 1500, 700), problem.aircraft, as_paper=True)
    flown = Evaluator(up, threads=1).evaluate(np.array([up.start, up.goal]))
    prices = Prices(up)
    assert prices.work * (prices.glide * run + 200) == pytest.approx(0.5, rel=0.02)
    assert flown.cost == pytest.approx(1.0)


def test_large_terrain_keeps_its_highest_nodes_zones_and_voids():
    heights = np.full((450, 700), 50.0)
    heights[101, 202] = 90.0
    heights[300, 4] = np.nan
    problem = Problem(
        Terrain("large", heights, 10.0, 10.0),
        (0, 0, 100),
        (6990, 4490, 100),
        aircraft.load("silver-fox"),
        zones=(Circle(5000, 2000, 4),),
        as_paper=True,
    )
    grid = SearchGrid(problem)
    assert grid.shape == (113, 175)
    assert (grid.dx_m, grid.dy_m) == (40.0, 40.0)
    assert np.argwhere(grid.ground == 90).tolist() == [[25, 50]]
    assert np.argwhere(grid.blocked).tolist() == [[50, 125], [75, 1]]


def test_routes_keep_their_margin():
    terrain = Terrain("plain", np.full((61, 61), 10.0), 100.0, 100.0)
    problem = Problem(
        terrain,
        (0, 3000, 100),
        (6000, 3000, 100),
        aircraft.load("silver-fox"),
        zones=(Circle(3000, 2900, 600),),
        as_paper=True,
    )
    for margin_m in (0.0, 300.0):
        grid = SearchGrid(problem, margin_m)
        assert grid.blocked.sum() == problem.nofly_raster.sum()
        x, y = grid.route(grid.surface(math.inf)).T
        nearest = np.hypot(x - 3000, y - 2900).min()
        assert 600 + margin_m < nearest < 600 + margin_m + 150


def test_leaves_out_ground_out_of_reach():
    # 10 degrees of climb over 3 km are 529 m, 30 degrees of descent 1732 m.
    heights = np.full((5, 61), 100.0)
    heights[:, 30] = 1000.0
    terrain = Terrain("wall", heights, 100.0, 100.0)
    far, near = (
        SearchGrid(
            Problem(terrain, start, (6000, 200, 700), aircraft.load("silver-fox"), as_paper=True)
        )
        for start in ((0, 200, 700), (0, 200, 200))
    )
    assert far.route(far.surface(math.inf)) is not None
    assert near.route(near.surface(math.inf)) is None
    assert near.blocked[:, 30].all()


@pytest.mark.parametrize("seed", range(40))
def test_nodes_within_a_margin_are_those_by_distance(seed):
    random = np.random.default_rng(seed)
    raster = random.random(random.integers(1, 50, 2)) < random.choice([0.002, 0.05, 0.5])
    raster.flat[random.integers(raster.size)] = True
    dy_m, dx_m = (30.0, 40.0) if seed % 2 else random.uniform(10, 100, 2)
    away = ndimage.distance_transform_edt(~raster, sampling=(dy_m, dx_m))
    # The distance of 50 m is met exactly.
    for margin_m in (1.0, 50.0, random.uniform(100, 800), 9000.0):
        assert np.array_equal(_widened(raster, dy_m, dx_m, margin_m), away <= margin_m)
