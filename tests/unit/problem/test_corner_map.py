import dataclasses
import math

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.host.device.chip_map import drawn_corners
from pathgene.host.problem.corner_map import EASES, CornerMap
from pathgene.host.problem.no_fly_shape import no_fly_shape
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


CONFIG = Config(map_size=16, coarse_factor=4)
LARGE = Config(map_size=64, coarse_factor=4)


def corner_map(shape, seed=0):
    rng = np.random.default_rng(seed)
    terrain = Terrain("t", rng.uniform(0, 300, size=shape), dx_m=10.0, dy_m=20.0)
    rows, columns = shape
    ends = (5.0, 5.0, 400.0), (10.0 * columns - 15, 20.0 * rows - 25, 350.0)
    return CornerMap(CONFIG, Problem(terrain, *ends, as_paper=True))


@pytest.mark.parametrize("shape", [(16, 16), (9, 12), (30, 40)])
def test_a_corner_is_as_high_as_its_highest_cell(shape):
    grid = corner_map(shape)
    cells, corners = grid.heights, grid.corners()
    assert corners.shape == cells.shape
    assert corners.dtype == np.uint16
    for y in range(CONFIG.map_size):
        for x in range(CONFIG.map_size):
            around = cells[y : y + 2, x : x + 2]
            highest = around.max() if around.size == 4 else CONFIG.blocked_altitude
            assert corners[y, x] == highest


@pytest.mark.parametrize("ease", EASES)
@pytest.mark.parametrize("shape", [(16, 16), (9, 12), (30, 40)])
def test_around_an_end_in_the_ground_a_corner_is_lower_and_nowhere_higher(shape, ease):
    rng = np.random.default_rng(3)
    terrain = Terrain("t", rng.uniform(200, 300, size=shape), dx_m=10.0, dy_m=20.0)
    rows, columns = shape
    places = (50.0, 60.0), (10.0 * columns - 35, 20.0 * rows - 55)
    ends = [(*place, float(terrain.ground(*place)) + 1) for place in places]
    grid = CornerMap(CONFIG, Problem(terrain, *ends, as_paper=True))
    cells, corners = grid.heights.astype(int), grid.corners(ends, ease)
    far, share = EASES[ease]
    near = {}
    for end in ends:
        x, y, altitude = grid.nearest_corner(end)
        for v in range(max(y - far, 0), min(y + far, grid.corner_limits[1]) + 1):
            for u in range(max(x - far, 0), min(x + far, grid.corner_limits[0]) + 1):
                four = cells[v : v + 2, u : u + 2]
                usual = math.ceil(four.mean() + share * (four.max() - four.mean()))
                lowered = altitude if (u, v) == (x, y) else max(altitude, usual)
                near[u, v] = min(near.get((u, v), four.max()), lowered, four.max())
        assert corners[y, x] <= altitude
        assert grid.around(end)[0].start <= max(y - 3, 0)
    for y in range(grid.corner_limits[1] + 1):
        for x in range(grid.corner_limits[0] + 1):
            assert corners[y, x] == near.get((x, y), cells[y : y + 2, x : x + 2].max())


def test_a_blocked_cell_beside_an_end_stays_blocked():
    elevation = np.full((16, 16), 300.0)
    elevation[4, 3] = 200.0
    elevation[6, 5] = np.nan
    terrain = Terrain("t", elevation, dx_m=10.0, dy_m=20.0)
    problem = Problem(terrain, (32.0, 84.0, 210.0), (120.0, 200.0, 310.0), as_paper=True)
    grid = CornerMap(CONFIG, problem)
    x, y, altitude = grid.nearest_corner(problem.start)
    assert (x, y) == (3, 4)
    corners = grid.corners([problem.start])
    assert corners[y, x] == altitude
    assert corners[y + 1, x + 1] == CONFIG.blocked_altitude


def test_no_waypoint_is_above_the_ceiling():
    elevation = np.full((16, 16), 100.0)
    terrain = Terrain("t", elevation, dx_m=10.0, dy_m=20.0)
    ends = (30.0, 80.0, 150.0), (120.0, 200.0, 150.0)
    free = CornerMap(CONFIG, Problem(terrain, *ends, rules=Rules()))
    low = CornerMap(CONFIG, Problem(terrain, *ends, rules=Rules(ceiling_m=200.0)))
    assert free.corner_limits[2] == CONFIG.blocked_altitude - 1
    top = low.corner_limits[2]
    assert low.base_m + top * low.step_m <= 200 < low.base_m + (top + 1) * low.step_m
    report = low.report()
    assert report["limits"] == [14, 14, top]
    assert report["padding_cells"] == [1, 1]
    assert report["offset_m"] == [5.0, 10.0, low.base_m]


def test_limits_leave_a_cell_of_terrain_on_every_side():
    grid = corner_map((9, 12))
    assert grid.corner_limits == (10, 7, CONFIG.blocked_altitude - 1)
    corners = grid.corners()
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


def test_another_problem_has_the_same_corners_and_steps():
    grid = corner_map((16, 16))
    before = grid.heights
    problem = grid._problem
    # With less ground in its way, its own map would have different steps.
    moved = dataclasses.replace(problem, start=(25.0, 45.0, 330.0), zones=[Circle(90, 160, 20)])
    other = grid.of_problem(moved)
    assert (other.scale_m, other.base_m, other.step_m) == (grid.scale_m, grid.base_m, grid.step_m)
    blocked = other.heights == CONFIG.blocked_altitude
    assert np.array_equal(other.heights[~blocked], before[~blocked])
    assert (blocked & (before != CONFIG.blocked_altitude)).sum() > 0
    assert other.nearest_corner(moved.start)[:2] == (2, 2)
    assert np.array_equal(grid.heights, before)
    high = dataclasses.replace(problem, goal=(*problem.goal[:2], grid.top_m + 1))
    assert grid.of_problem(high) is None


def test_a_map_of_a_box_is_the_part_of_a_larger_one():
    """The chip's own cells and points between them, on a terrain that is larger than the map."""
    rng = np.random.default_rng(1)
    elevation = rng.uniform(0, 300, size=(40, 30))
    box = slice(20, 36), slice(5, 21)
    # Both maps have the same steps.
    elevation[21, 6], elevation[35, 20] = 0.0, 300.0
    elevation[0, 0], elevation[1, 1] = 0.0, 300.0
    terrain = Terrain("t", elevation, dx_m=10.0, dy_m=20.0)
    ends = (75.0, 450.0, 400.0), (185.0, 690.0, 350.0)
    zones = Circle(120, 600, 35), Circle(60, 500, 25)
    problem = Problem(terrain, *ends, zones=zones, as_paper=True)
    part, whole = CornerMap(CONFIG, problem, box), CornerMap(LARGE, problem)
    assert whole.is_whole
    assert not part.is_whole
    assert (part.step_m, part.base_m) == (whole.step_m, whole.base_m)
    assert np.array_equal(part.corners(ends)[:15, :15], whole.corners(ends)[20:35, 5:20])
    offset = np.array((5, 20, 0))
    assert (part.nearest_corner(ends[0]) + offset).tolist() == list(whole.nearest_corner(ends[0]))
    corners = np.array([(0, 0, 7), (14, 3, 9)])
    assert part.corners_to_metres(corners).tolist() == (
        whole.corners_to_metres(corners + offset).tolist()
    )
    for zone in zones:
        mine = part.beside(zone, *part.around_zone(zone))
        assert mine.any()
        everywhere = slice(0, 64)
        theirs = whole.beside(zone, everywhere, everywhere)
        assert mine.sum() == theirs[20:35, 5:20].sum()
        shape, larger = no_fly_shape(part, zone), no_fly_shape(whole, zone)
        drawn = np.zeros((64, 64), dtype=bool)
        drawn[larger.first_y : larger.last_y + 1, larger.first_x : larger.last_x + 1] = (
            drawn_corners(larger)
        )
        own = drawn[20:35, 5:20][shape.first_y : shape.last_y + 1, shape.first_x : shape.last_x + 1]
        assert np.array_equal(drawn_corners(shape), own)
    outside = dataclasses.replace(problem, start=(75.0, 395.0, 400.0))
    assert part.of_problem(outside) is None
    assert part.of_problem(problem) is not None


@pytest.mark.parametrize("shape", [(300, 260), (40, 90), (700, 400)])
def test_a_part_of_the_map_is_as_the_whole(shape):
    config = Config()
    rng = np.random.default_rng(sum(shape))
    terrain = Terrain("hills", rng.uniform(0, 60, shape), dx_m=25.0, dy_m=31.0)
    zone = Circle(*(0.4 * np.array((terrain.width_m, terrain.height_m))), 130.0)
    ends = (40.0, 50.0, 75.0), (terrain.width_m - 60.0, terrain.height_m - 50.0, 75.0)
    grid = CornerMap(config, Problem(terrain, *ends, zones=(zone,), rules=Rules(clearance_m=20)))
    whole = slice(0, config.map_size)
    beside = grid.beside(zone, whole, whole)
    for ease in EASES:
        corners = grid.corners(ends, ease)
        for _ in range(40):
            south, west = rng.integers(0, config.map_size - 1, 2)
            rows = slice(int(south), int(rng.integers(south + 1, config.map_size)) + 1)
            columns = slice(int(west), int(rng.integers(west + 1, config.map_size)) + 1)
            assert np.array_equal(
                grid.corners_in(rows, columns, ends, ease), corners[rows, columns]
            )
    rows, columns = grid.around_zone(zone)
    assert np.array_equal(grid.beside(zone, rows, columns), beside[rows, columns])
    assert beside[rows, columns].sum() == beside.sum() > 0
    for part in (rows, columns):
        assert part.stop - part.start < config.map_size
