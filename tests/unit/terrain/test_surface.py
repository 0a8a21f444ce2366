"""The surface below points, and its compiled form."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from pathgene.host.evaluation.terrain_rule import surface_at
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import VOID_M, surface_below
from tests.support.host.flight_oracle import surface


ROUGH = Terrain("rough", np.random.default_rng(5).uniform(0, 400, (41, 51)), 100.0, 125.0)
# A cliff of 100 m between the columns 4 and 5.
CLIFF = Terrain("cliff", np.tile(np.repeat((0.0, 100.0), 5), (8, 1)), 100.0, 100.0)


class Grid(NamedTuple):
    """The constants that the compiled form reads."""

    dx_m: float
    dy_m: float
    rows: int
    columns: int


def random_land(rng, voids=0.0):
    heights = rng.uniform(0, 60, rng.integers(3, 20, 2))
    heights[rng.random(heights.shape) < voids] = np.nan
    heights[0, 0] = 1.0
    terrain = Terrain("land", heights, *rng.uniform(5, 80, 2).tolist())
    x = rng.uniform(-50, terrain.width_m + 50, 500)
    y = rng.uniform(-50, terrain.height_m + 50, 500)
    # Nodes, and borders of their squares.
    x[:50], y[25:75] = (
        0.5 * side * rng.integers(0, 30, 50) for side in (terrain.dx_m, terrain.dy_m)
    )
    return terrain, x, y


def test_it_is_the_higher_of_two():
    rng = np.random.default_rng(1)
    for _ in range(50):
        terrain, x, y = random_land(rng)
        np.testing.assert_allclose(surface_below(terrain, x, y), surface(terrain, x, y), rtol=1e-12)


def test_by_hand():
    x, y = np.array([100.0, 150.0, 5000.0, 225.0]), np.array([125.0, 125.0, 5000.0, 187.5])
    e = ROUGH.elevation
    between = [
        e[1, 1],
        (e[1, 1] + e[1, 2]) / 2,
        e[40, 50],
        (0.75 * (e[1, 2] + e[2, 2]) + 0.25 * (e[1, 3] + e[2, 3])) / 2,
    ]
    nearest = [e[1, 1], e[1, 2], e[40, 50], e[2, 2]]
    np.testing.assert_allclose(surface_below(ROUGH, x, y), np.maximum(between, nearest))
    x = np.array([440.0, 460.0, 499.0])
    assert surface_below(CLIFF, x, np.full(3, 200.0)) == pytest.approx([40, 100, 100])


def test_outside_the_map_it_is_that_of_the_edge():
    x, y = np.array([-500.0, 9000.0]), np.array([-1.0, 9000.0])
    np.testing.assert_array_equal(surface_below(ROUGH, x, y), ROUGH.elevation[[0, -1], [0, -1]])


@pytest.mark.parametrize("void_m", [math.inf, math.nan])
def test_a_void_with_a_weight_is_a_void(void_m):
    heights = np.full((3, 4), 10.0)
    heights[1, 1] = np.nan
    terrain = Terrain("void", heights, 10.0, 10.0)
    x, y = np.array([10.0, 0.1, 0.0, 19.9, 20.0]), np.array([10.0, 10.0, 10.0, 0.1, 10.0])
    found = surface_below(terrain, x, y, void_m=void_m)
    np.testing.assert_array_equal(found, [void_m, void_m, 10.0, void_m, 10.0])


def test_the_compiled_form_gives_the_same_bits():
    rng = np.random.default_rng(2)
    for _ in range(30):
        terrain, x, y = random_land(rng, voids=0.05)
        grid = Grid(terrain.dx_m, terrain.dy_m, *terrain.shape)
        ground = np.where(terrain.voids, VOID_M, terrain.elevation).ravel()
        at = [surface_at(ground, grid, *point) for point in zip(x, y, strict=True)]
        known = np.array([height if height < 1e200 else math.inf for height in at])
        assert surface_below(terrain, x, y).tobytes() == known.tobytes()
