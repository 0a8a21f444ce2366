"""The raised raster compared with dense samples of the heights that its cells require."""

import numpy as np
import pytest

from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
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
        assert (floor >= surface(terrain, x, y) + 30.0 - 1e-9).all()


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
    assert np.isfinite(floor[5, :3]).all()


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
