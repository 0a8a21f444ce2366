"""The compiled surface below a few points equals the one of NumPy, bit for bit."""

import math

import numpy as np
import pytest

from pathgene.host.problem.compiled.surfaces import nodes_around, surfaces_below
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import surface_below


def land():
    rng = np.random.default_rng(3)
    heights = rng.uniform(-50, 900, (13, 17))
    heights[rng.random(heights.shape) < 0.05] = np.nan
    return Terrain("land", heights, 30.87, 74.35)


@pytest.mark.parametrize("void_m", [math.inf, -math.inf])
def test_equals_the_surface_of_numpy(void_m):
    terrain = land()
    rng = np.random.default_rng(4)
    # Some are beyond the map, some on nodes and half-way between them.
    points = rng.uniform(-0.2, 1.2, (2, 3000)) * [[terrain.width_m], [terrain.height_m]]
    on_nodes = rng.integers(0, 26, (2, 3000)) * [[terrain.dx_m / 2], [terrain.dy_m / 2]]
    points = np.hstack((points, on_nodes))
    expected = surface_below(terrain, *points, void_m=void_m)
    found = surfaces_below(terrain, points, void_m)
    np.testing.assert_array_equal(found, expected)
    assert 0 < np.isinf(found).sum() < found.size


def test_needs_no_node_but_those_around_the_points():
    terrain = land()
    rng = np.random.default_rng(5)
    for _ in range(200):
        points = rng.uniform(-0.1, 1.1, (2, 4)) * [[terrain.width_m], [terrain.height_m]]
        part = nodes_around(terrain, points)
        first = part[0].start, part[1].start
        found = surfaces_below(terrain, points, math.inf, terrain.elevation[part], first)
        np.testing.assert_array_equal(found, surface_below(terrain, *points))


def test_a_nearest_node_is_the_first_of_the_nearest_nodes():
    terrain = land()
    rng = np.random.default_rng(6)
    for x, y in rng.uniform(-900, 2500, (500, 2)).tolist():
        assert terrain.nearest_node(x, y) == tuple(map(int, terrain.nearest_nodes(x, y)))
    half = 0.5 * terrain.dx_m, 0.5 * terrain.dy_m
    assert terrain.nearest_node(*half) == (1, 1)
