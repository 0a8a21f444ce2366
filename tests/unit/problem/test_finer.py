"""Problems over smaller cells: their ground, their ends, and the chip's map of them."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from pathgene.hdl.config import Config
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.grid.fine_grid import fine_grid
from pathgene.host.planning import Search
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.finer import divided, finer, on_grid
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


CHIP = Config(core="planner")


def hills(seed, nodes=60):
    rng = np.random.default_rng(seed)
    heights = 300 * gaussian_filter(rng.standard_normal((nodes, nodes + 7)), 3)
    return Terrain("hills", heights - heights.min(), 40.0, 50.0)


def hill_problem(**own):
    ends = (300.0, 400.0, 80.0), (2300.0, 2500.0, 80.0)
    return Problem(hills(1), *ends, agl=True, **own)


def strict_ground(terrain, x, y):
    """Return the ground that the strict rule assumes: nearest node or bilinear, the higher one."""
    column, row = x / terrain.dx_m, y / terrain.dy_m
    i, j = (min(int(place), size - 2) for place, size in zip(
        (column, row), terrain.shape[::-1], strict=True
    ))  # fmt: skip
    u, v = column - i, row - j
    (a, b), (c, d) = terrain.elevation[j : j + 2, i : i + 2]
    between = (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d)
    return max(between, terrain.ground(x, y))


@pytest.mark.parametrize("parts", [1, 2, 3, 4])
def test_no_corner_lies_below_the_ground_around_it(parts):
    """A waypoint on a corner of the map, and any point up to half a cell from it, is above it."""
    rng = np.random.default_rng(parts)
    problem = hill_problem(rules=Rules(clearance_m=0, corridor_m=0))
    grid = CornerMap(CHIP, problem, None, parts)
    corners = grid.corners()
    terrain, close = problem.terrain, []
    for _ in range(2_000):
        x, y = rng.uniform((0, 0), (terrain.width_m, terrain.height_m))
        ground = strict_ground(terrain, x, y)
        column, row, _ = grid.nearest_corner((x, y, grid.top_m))
        above_m = grid.base_m + int(corners[row, column]) * grid.step_m - ground
        assert above_m > -1e-9
        close.append(above_m)
    # The corners of a finer map are closer to the ground.
    assert np.mean(close) < 70 / parts


def test_a_finer_grid_has_the_nodes_of_the_terrain_between_smaller_cells():
    terrain = Terrain("four", [[0.0, 8.0], [16.0, 100.0]], 30.0, 60.0)
    fine = divided(terrain, 2)
    assert (fine.dx_m, fine.dy_m, fine.shape) == (15.0, 30.0, (3, 3))
    # On the edge between two cells, the higher one counts.
    assert fine.elevation.tolist() == [[0, 8, 8], [16, 100, 100], [16, 100, 100]]
    third = divided(terrain, 3)
    assert third.elevation[0].tolist() == pytest.approx([0, 8 / 3, 8, 8])


def test_a_void_stays_one():
    heights = np.zeros((4, 4))
    heights[1, 2] = np.nan
    fine = divided(Terrain("void", heights, 30.0, 30.0), 3)
    assert fine.voids.sum() == 9
    assert fine.voids[2:5, 5:8].all()


def test_an_end_on_the_ground_may_lie_below_a_finer_node():
    """Such an end ended the search with a refusal."""
    found = 0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        heights = 300 * gaussian_filter(rng.standard_normal((100, 100)), 3)
        terrain = Terrain("rough", heights - heights.min(), 40.0, 40.0)
        ends = ((*rng.uniform((300, 300), (3600, 3600)), 0.0) for _ in range(2))
        problem = Problem(terrain, *ends, agl=True)
        grid = fine_grid(problem, 480, 3)
        fine = divided(terrain, 3)
        found += any(fine.ground(x, y) > z for x, y, z in (problem.start, problem.goal))
        assert grid is not None
    assert found


def test_keeps_everything_but_the_grid():
    zone = Zone.circle(1300, 1500, 200)
    problem = hill_problem(zones=(zone,), wind=(3.0, 1.0), start_heading_deg=20)
    assert finer(problem, 1) is problem
    fine = finer(problem, 4)
    assert fine.terrain.shape == (237, 265)
    assert (
        problem.nofly_raster.sum() * 10 < fine.nofly_raster.sum() < problem.nofly_raster.sum() * 18
    )
    for name in ("start", "goal", "aircraft", "zones", "wind", "rules", "start_heading_deg"):
        assert getattr(fine, name) == getattr(problem, name)
    assert on_grid(problem, fine.terrain, ()).zones == ()


def test_ga_chip_divides_small_terrain():
    def scale_m(problem, **own):
        plan = Search("ga-chip", generations=40, polish="chip", **own).run(Evaluator(problem))
        return plan.result.hardware["map"]["scale_m"][:2]

    assert scale_m(hill_problem()) == [10.0, 12.5]
    assert scale_m(hill_problem(), chip_ms=5) == [40.0, 50.0]
    assert scale_m(hill_problem(as_paper=True)) == [40.0, 50.0]


def test_a_replan_keeps_the_smaller_cells():
    board = "model:?core=planner"
    from pathgene.host.device.boards import open_board

    with open_board(board) as chip:
        search = Search("ga-chip", generations=400, polish="chip", board=chip)
        plan = search.run(Evaluator(hill_problem()))
        assert plan.evaluation.feasible
        middle = plan.path[len(plan.path) // 2]
        after = plan.replan(zones=[Zone.circle(float(middle[0]), float(middle[1]), 150)])
        assert after.evaluation.feasible
        assert after.result.hardware["map"]["scale_m"] == plan.result.hardware["map"]["scale_m"]
