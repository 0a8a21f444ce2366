import numpy as np
import pytest

from hdl.config import Config
from host.problem import Problem
from host.problem.corner_map import CornerMap
from host.terrain import Terrain


CONFIG = Config(map_size=16, coarse_factor=4)


def corner_map(shape, seed=0):
    rng = np.random.default_rng(seed)
    terrain = Terrain("t", rng.uniform(0, 300, size=shape), dx_m=10.0, dy_m=20.0)
    rows, columns = shape
    ends = (5.0, 5.0, 400.0), (10.0 * columns - 15, 20.0 * rows - 25, 350.0)
    return CornerMap(CONFIG, Problem(terrain, *ends, as_paper=True))


@pytest.mark.parametrize("shape", [(16, 16), (9, 12), (30, 40)])
def test_a_corner_is_as_high_as_its_highest_cell(shape):
    grid = corner_map(shape)
    cells, corners = grid.heights, grid.corners
    assert corners.shape == cells.shape
    assert corners.dtype == np.uint16
    for y in range(CONFIG.map_size):
        for x in range(CONFIG.map_size):
            around = cells[y : y + 2, x : x + 2]
            highest = around.max() if around.size == 4 else CONFIG.blocked_altitude
            assert corners[y, x] == highest


def test_limits_leave_a_cell_of_terrain_on_every_side():
    grid = corner_map((9, 12))
    assert grid.corner_limits == (10, 7, CONFIG.blocked_altitude - 1)
    corners = grid.corners
    assert (corners[:8, :11] < CONFIG.blocked_altitude).all()
    assert (corners[8:] == CONFIG.blocked_altitude).all()
    assert (corners[:, 11:] == CONFIG.blocked_altitude).all()


def test_corners_lie_half_a_cell_beyond_the_nodes():
    grid = corner_map((16, 16))
    metres = grid.corners_to_metres(np.array([(0, 0, 0), (3, 2, 100)]))
    assert metres.tolist() == [
        [5.0, 10.0, grid.base_m],
        [35.0, 50.0, grid.base_m + 100 * grid.step_m],
    ]
