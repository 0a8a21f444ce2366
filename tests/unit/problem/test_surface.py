"""The raised raster compared with dense samples of the heights that its cells require."""

import numpy as np
import pytest
from scipy.ndimage import maximum_filter1d

from pathgene.host.errors import InputError
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.surroundings import _spread
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain
from tests.support.host.flight_oracle import surface


FOX = aircraft.load("silver-fox")


def land(elevation, dx_m, dy_m):
    return Terrain(
        name="land", elevation=elevation, dx_m=dx_m, dy_m=dy_m, crs=None, origin=(0.0, 0.0)
    )


def random_land(rng):
    shape = rng.integers(3, 20, 2)
    return land(rng.uniform(0, 60, shape), *rng.uniform(5, 80, 2).tolist())


@pytest.mark.parametrize("corridor_m", [0.0, 25.0, 90.0])
def test_no_node_lies_below_what_its_square_demands(corridor_m):
    rng = np.random.default_rng(2)
    for _ in range(40):
        terrain = random_land(rng)
        ends = (0.0, 0.0, 200.0), (terrain.width_m, terrain.height_m, 200.0)
        problem = Problem(terrain, *ends, FOX, rules=Rules(corridor_m=corridor_m))
        rows, columns = terrain.shape
        iy, ix = rng.integers(rows, size=400), rng.integers(columns, size=400)
        # Any point of the corridor around any point of the node's square.
        angle = rng.uniform(0, 2 * np.pi, 400)
        aside = corridor_m * rng.uniform(0, 1, 400)
        x = (ix + rng.uniform(-0.5, 0.5, 400)) * terrain.dx_m + aside * np.cos(angle)
        y = (iy + rng.uniform(-0.5, 0.5, 400)) * terrain.dy_m + aside * np.sin(angle)
        floor = problem.surface.elevation[iy, ix]
        blocked = np.isnan(floor)
        assert (blocked | (floor >= surface(terrain, x, y) + 30.0 - 1e-9)).all()


def test_spread_is_the_maximum_of_a_window():
    rng = np.random.default_rng(3)
    for nodes in range(12):
        for axis in (0, 1):
            raster = rng.random(rng.integers(1, 9, 2))
            expected = maximum_filter1d(raster, 2 * nodes + 1, axis=axis, mode="nearest")
            np.testing.assert_array_equal(_spread(raster, axis, nodes), expected)


def test_flat_land_is_raised_by_the_clearance_and_zones_by_their_tops():
    flat = land(np.full((41, 41), 10.0), 50.0, 50.0)
    zones = [Circle(1000.0, 1000.0, 100.0, upper_m=150.0), Circle(1000.0, 500.0, 60.0)]
    problem = Problem(flat, (0, 0, 100), (2000, 2000, 100), FOX, zones, rules=Rules())
    floor = problem.surface.elevation
    assert floor[2, 20] == 40
    assert floor[20, 20] == 175
    assert not problem.nofly_raster[20, 20]
    assert problem.nofly_raster[10, 20]
    assert problem.roof is None


def test_voids_spread_by_the_corridor():
    elevation = np.full((11, 11), 10.0)
    elevation[5, 5] = np.nan
    problem = Problem(land(elevation, 50.0, 50.0), (0, 0, 100), (500, 500, 100), FOX, rules=Rules())
    floor = problem.surface.elevation
    assert np.isnan(floor[4:7, 4:7]).all()
    assert np.isfinite(floor[5, 1:3]).all()


@pytest.mark.parametrize("cells", [(30.0, 30.0), (30.0, 12.5), (100.0, 50.0), (7.0, 20.0)])
def test_nodes_are_blocked_where_the_corridor_of_their_square_leaves_the_map(cells):
    """At 50 m, the square of the second node begins 25 m from the edge: exactly the corridor."""
    dx_m, dy_m = cells
    flat = land(np.full((61, 61), 10.0), dx_m, dy_m)
    ends = (0.4 * flat.width_m, 0.5 * flat.height_m, 100), (0.6 * flat.width_m, 30 * dy_m, 100)
    floor = Problem(flat, *ends, FOX, rules=Rules()).surface.elevation
    share = np.linspace(-0.5, 0.5, 201)
    for heights, side in ((floor[30], dx_m), (floor[:, 30], dy_m)):
        places = np.clip((np.arange(61)[:, None] + share) * side, 0, 60 * side)
        nearest = np.minimum(places, 60 * side - places).min(axis=1)
        np.testing.assert_array_equal(np.isnan(heights), nearest < 25 - 1e-6)
    bare = Problem(flat, *ends, FOX, rules=Rules(corridor_m=0.0)).surface.elevation
    assert np.isfinite(bare).all()


@pytest.mark.parametrize("cell_m", [10.0, 30.0, 60.0, 90.0])
@pytest.mark.parametrize("away_m", [0.0, 20.0, 25.0, 26.0, 30.0, 44.0])
def test_a_path_can_leave_an_end_near_the_edge(cell_m, away_m):
    flat = land(np.full((61, 61), 10.0), cell_m, cell_m)
    far_m = 60 * cell_m - away_m
    start, goal = (away_m, 0.4 * far_m, 100), (0.6 * far_m, far_m, 100)
    problem = Problem(flat, start, goal, FOX, rules=Rules())
    free = np.isfinite(problem.surface.elevation)
    # The chip looks at the four nodes around the corner nearest to an end.
    columns = int(away_m // cell_m) + np.arange(2)
    rows = int(start[1] // cell_m) + np.arange(2)
    assert free[np.ix_(rows, columns)].all()
    # From there, nodes are free up to the middle of the map.
    assert free[rows[0], columns[0] : 31].all()
    assert free[30 : 61 - columns[0], int(goal[0] // cell_m)].all()
    # Whole squares that are nearer to the edge than the end and the corridor stay blocked.
    beyond = int(min(away_m, 25.0) // cell_m)
    assert not free[:, :beyond].any()
    assert not free[45, : int(25 // cell_m)].any()


def test_unknown_ground_beyond_the_edge_lowers_no_demand():
    flat = land(np.full((41, 41), 10.0), 50.0, 50.0)
    for x in (0.0, 10.0, 25.0, 500.0):
        problem = Problem(flat, (x, 1000, 60), (1900, 1000, 60), FOX, rules=Rules())
        assert problem.demand.heights_beside_m == pytest.approx((50, 50), abs=0.01)
        places = np.linspace(x, 1900, 100)
        assert problem.demand.required_m(places, np.full(100, 1000.0), beside=True).min() == 30


def test_demand_grows_from_low_ends():
    flat = land(np.full((41, 41), 10.0), 50.0, 50.0)
    problem = Problem(flat, (0, 1000, 15), (2000, 1000, 20), FOX, rules=Rules())
    x, y = np.array([0.0, 100.0, 1000.0, 1990.0, 2000.0]), np.full(5, 1000.0)
    slope_up, slope_down = 0.5 * np.tan(np.radians((10.0, 30.0)))
    np.testing.assert_allclose(
        problem.demand.required_m(x, y), [5, 5 + 100 * slope_up, 30, 10 + 10 * slope_down, 10]
    )
    # A climb at the limit stays above the raised raster.
    floor = problem.surface.elevation[20]
    climb = 15 + np.tan(np.radians(10.0)) * 50.0 * np.arange(41)
    assert (np.minimum(climb, 60)[1:20] >= floor[1:20]).all()


def random_zone(rng, width_m, height_m):
    """Return a circle or a polygon, often with dents, with random heights and times."""
    x, y = rng.uniform(-0.1, 1.1, 2) * (width_m, height_m)
    radius = float(rng.uniform(0.0, 0.4) * min(width_m, height_m))
    limits = {}
    if rng.random() < 0.3:
        limits["lower_m"] = float(rng.uniform(50, 200))
    if rng.random() < 0.3:
        limits["upper_m"] = float(rng.uniform(201, 400))
    if rng.random() < 0.3:
        limits["t0_s"] = float(rng.uniform(0, 30))
    if rng.random() < 0.3:
        limits["t1_s"] = float(rng.uniform(31, 200))
    if rng.random() < 0.5:
        return Circle(float(x), float(y), radius, **limits)
    angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 12)))
    away = (radius + 1.0) * rng.uniform(0.2, 1.0, len(angles))
    corners = np.column_stack((x + away * np.cos(angles), y + away * np.sin(angles)))
    return Polygon(tuple(map(tuple, corners.tolist())), **limits)


@pytest.mark.parametrize("ceiling_agl_m", [None, 90.0])
@pytest.mark.parametrize("corridor_m", [0.0, 45.0])
def test_a_part_of_the_search_rasters_equals_the_whole(corridor_m, ceiling_agl_m):
    rng = np.random.default_rng(4)
    rules = Rules(corridor_m=corridor_m, ceiling_agl_m=ceiling_agl_m)
    compared = 0
    for _ in range(60):
        shape = rng.integers(4, 40, 2)
        elevation = rng.uniform(0, 60, shape)
        elevation[rng.random(shape) < 0.02] = np.nan
        terrain = land(elevation, *rng.uniform(5, 80, 2).tolist())
        zones = [
            random_zone(rng, terrain.width_m, terrain.height_m) for _ in range(rng.integers(4))
        ]
        ends = [
            (*(rng.random(2) * (terrain.width_m, terrain.height_m)).tolist(), 500.0)
            for _ in range(2)
        ]
        try:
            whole, other = (Problem(terrain, *ends, FOX, zones, rules=rules) for _ in range(2))
            floor, blocked = whole.surface.elevation, whole.blocked_raster
        except InputError:
            # An end in a zone or over a void.
            continue
        for _ in range(6):
            rows, columns = (
                slice(*np.sort(rng.choice(count + 1, 2, replace=False)).tolist()) for count in shape
            )
            found = other.search_part(rows, columns)
            np.testing.assert_array_equal(found[0], floor[rows, columns])
            np.testing.assert_array_equal(found[1], blocked[rows, columns])
            compared += 1
    assert compared > 200
