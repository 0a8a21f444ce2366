"""The surroundings of nodes: the same for all of a map at once and for a few of them."""

import numpy as np
import pytest

from pathgene.host.problem import surroundings
from pathgene.host.terrain import Terrain


@pytest.mark.parametrize("corridor_m", [0.0, 25.0, 90.0])
def test_bands_and_single_nodes_agree_with_the_map_at_once(monkeypatch, corridor_m):
    rng = np.random.default_rng(4)
    for _ in range(20):
        rows, columns = rng.integers(2, 60, 2).tolist()
        heights = rng.uniform(0, 900, (rows, columns))
        heights[rng.random(heights.shape) < 0.02] = np.nan
        heights[0, 0] = 5.0
        terrain = Terrain("land", heights, *rng.uniform(5, 80, 2).tolist())
        at_once = surroundings._highest_around(
            terrain, corridor_m, slice(0, rows), slice(0, columns)
        )
        monkeypatch.setattr(surroundings, "_BAND_NODES", int(rng.integers(1, 400)))
        nodes = surroundings.Surroundings(corridor_m).nodes(terrain)
        np.testing.assert_array_equal(nodes, at_once)
        for _ in range(10):
            row, column = int(rng.integers(rows)), int(rng.integers(columns))
            x, y = column * terrain.dx_m, row * terrain.dy_m
            found = surroundings.Surroundings(corridor_m).highest_within(terrain, x, y, np.inf)
            assert found == at_once[row, column]
