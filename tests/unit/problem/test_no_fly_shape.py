"""Shapes for zones: they contain every corner that the zone blocks, and hardly any more."""

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.no_fly_shape import no_fly_shape
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain
from pathgene.sim.model.run_commands import block


CONFIG = Config()
BLOCKED = CONFIG.blocked_altitude


def make(shape, dx_m, dy_m, zones=(), rules=None):
    rows, columns = shape
    terrain = Terrain("t", np.zeros(shape), dx_m=dx_m, dy_m=dy_m)
    far = (columns - 1.5) * dx_m, (rows - 1.5) * dy_m, 50.0
    return Problem(terrain, (0.5 * dx_m, 0.5 * dy_m, 50.0), far, zones=zones, rules=rules)


def beside(grid, zone):
    """Return the corners of the whole map around a zone."""
    whole = slice(0, CONFIG.map_size)
    return grid.beside(zone, whole, whole)


#: Cells as nodes, oblong cells, and axes that are compressed to the map's size.
GRIDS = [((300, 260), 30.0, 30.0), ((200, 300), 20.0, 31.0), ((400, 700), 25.0, 25.0)]


@pytest.mark.parametrize("rules", [None, Rules(zone_margin_m=70.0)], ids=["paper", "rules"])
@pytest.mark.parametrize("grid", GRIDS, ids=["square", "oblong", "compressed"])
def test_a_shape_blocks_what_the_map_of_the_zone_blocks(grid, rules):
    rng = np.random.default_rng(1)
    without = CornerMap(CONFIG, make(*grid, rules=rules))
    terrain = make(*grid).terrain
    size = np.array((terrain.width_m, terrain.height_m))
    for number in range(24):
        centre, reach = rng.uniform(0.2, 0.8, size=2) * size, rng.uniform(0.0, 0.17) * size.min()
        if number % 2:
            zone = Zone.circle(*centre, reach)
        else:
            angles = np.sort(rng.uniform(0, 2 * np.pi, size=int(rng.integers(3, 12))))
            ring = centre + (reach + 1) * np.column_stack((np.cos(angles), np.sin(angles)))
            zone = Zone.polygon(ring)
        with_zone = CornerMap(CONFIG, make(*grid, zones=(zone,), rules=rules)).corners()
        drawn = without.corners().copy()
        shape = no_fly_shape(without, zone)
        shape.pack(CONFIG)
        block(drawn, BLOCKED, shape)
        assert not ((with_zone == BLOCKED) & (drawn != BLOCKED)).any()
        # In paper mode the map takes only nodes in the zone; the shape takes the cells that it
        # meets.
        needed, more = beside(without, zone), (drawn == BLOCKED) & (without.corners() != BLOCKED)
        assert ((with_zone == BLOCKED) & (without.corners() != BLOCKED) <= needed).all()
        half_outline = np.ptp(np.argwhere(needed), axis=0).sum()
        assert more.sum() - needed.sum() <= half_outline


def test_a_zone_beside_the_map_has_no_shape():
    grid = CornerMap(CONFIG, make(*GRIDS[0]))
    assert no_fly_shape(grid, Zone.circle(-900.0, 500.0, 300.0)) is None


def test_a_zone_on_the_edge_of_the_map_is_a_row_of_corners():
    grid = CornerMap(CONFIG, make(*GRIDS[0]))
    shape = no_fly_shape(grid, Zone.polygon([(-90, 300), (-10, 300), (-10, 400), (-90, 400)]))
    assert (shape.first_x, shape.last_x, shape.edges) == (0, 0, ())
    assert shape.first_y == 9
