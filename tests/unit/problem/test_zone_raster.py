"""The conservative raster: no cell of a zone is missed, and few additional ones are blocked."""

import numpy as np
import shapely

from pathgene.host.problem.zone_raster import blocked_cells
from pathgene.host.problem.zones import Circle, Polygon, raster
from pathgene.host.terrain import Terrain
from tests.support.host.random_flights import random_zones
from tests.support.host.zone_oracle import distances, outline


def terrain(shape=(21, 31), dx_m=100.0, dy_m=100.0):
    return Terrain(
        name="world", elevation=np.zeros(shape), dx_m=dx_m, dy_m=dy_m, crs=None, origin=(0.0, 0.0)
    )


def gaps(zone, where):
    """Return the distance of every cell to a zone without margin, 0 where they meet."""
    rows, columns = where.elevation.shape
    x, y = np.meshgrid(np.arange(columns) * where.dx_m, np.arange(rows) * where.dy_m)
    half_x, half_y = where.dx_m / 2, where.dy_m / 2
    if isinstance(zone, Circle):
        dx = np.maximum(np.abs(x - zone.x_m) - half_x, 0)
        dy = np.maximum(np.abs(y - zone.y_m) - half_y, 0)
        return np.maximum(np.hypot(dx, dy) - zone.radius_m, 0)
    cells = shapely.box(x - half_x, y - half_y, x + half_x, y + half_y)
    return shapely.distance(cells, outline(zone))


def test_matches_the_distances_of_the_cells():
    rng = np.random.default_rng(5)
    blocked = free = 0
    for _ in range(250):
        shape = tuple(rng.integers(2, 33, 2).tolist())
        where = terrain(shape, *rng.choice([10.0, 30.87, 74.35, 100.0], 2).tolist())
        width_m, height_m = shape[1] * where.dx_m, shape[0] * where.dy_m
        margin_m = float(rng.choice([0.0, 25.0, rng.uniform(0, 200)]))
        zones = random_zones(rng, width_m, height_m)
        for zone in zones:
            found, gap = blocked_cells([zone], where, margin_m), gaps(zone, where)
            assert found[gap <= margin_m].all()
            assert not found[gap > margin_m + 1e-5].any()
            blocked += found.sum()
            free += (~found).sum()
        together = np.any([blocked_cells([zone], where, margin_m) for zone in zones], axis=0)
        np.testing.assert_array_equal(blocked_cells(zones, where, margin_m), together)
    assert min(blocked, free) > 10_000


def test_blocks_every_sampled_place():
    """Places within the margin are drawn at random, independently of the geometry of cells."""
    rng = np.random.default_rng(6)
    where = terrain((20, 20), 30.0, 40.0)
    inside = 0
    for _ in range(100):
        (zone, *_) = random_zones(rng, 570.0, 760.0)
        margin_m = float(rng.uniform(0, 40))
        x, y = rng.uniform(0, 570, 3000), rng.uniform(0, 760, 3000)
        held = distances(zone, x, y) <= margin_m
        found = blocked_cells([zone], where, margin_m)
        assert found[where.nearest_nodes(x[held], y[held])].all()
        assert not (raster([zone], where) & ~found).any()
        inside += held.sum()
    assert inside > 5000


def test_circle_between_the_nodes_is_seen():
    zone = Circle(350, 250, 70)
    assert not raster([zone], terrain()).any()
    rows, columns = np.nonzero(blocked_cells([zone], terrain(), 0))
    assert set(zip(columns.tolist(), rows.tolist(), strict=True)) == {
        (3, 2),
        (3, 3),
        (4, 2),
        (4, 3),
    }
    assert blocked_cells([Circle(350, 250, 0)], terrain(), 0).sum() == 4


def test_wall_thinner_than_a_cell_closes_the_map():
    for thick_m in (80, 1e-3):
        wall = Polygon(((310, -1), (310 + thick_m, -1), (310 + thick_m, 2001), (310, 2001)))
        assert not raster([wall], terrain()).any()
        assert blocked_cells([wall], terrain(), 0)[:, 3].all()
    slanting = Polygon(((0, 1), (3000, 2000), (3000, 1999.999), (0, 0.999)))
    found = blocked_cells([slanting], terrain(), 0)
    free = ~found
    # No two free cells on its two sides touch, not even at a corner.
    north = np.add.outer(np.arange(21) * 100.0, -np.arange(31) * 1999 / 30) > 1
    for dy, dx in ((0, 1), (1, 0), (1, 1)):
        a = (slice(0, 21 - dy), slice(0, 31 - dx))
        b = (slice(dy, 21), slice(dx, 31))
        assert not (free[a] & free[b] & (north[a] != north[b])).any()
    a, b = (slice(0, 20), slice(1, 31)), (slice(1, 21), slice(0, 30))
    assert not (free[a] & free[b] & (north[a] != north[b])).any()


def test_path_inside_an_edge_is_blocked():
    # The nodes beyond the edge, 55 m from it, are outside; their cells are not.
    zone = Polygon(((1045, 0), (3000, 0), (3000, 2000), (1045, 2000)))
    assert not raster([zone], terrain())[:, 10].any()
    assert blocked_cells([zone], terrain(), 0)[:, 10].all()
    assert not blocked_cells([zone], terrain(), 94.9)[:, 9].any()
    assert blocked_cells([zone], terrain(), 95.1)[:, 9].all()


def test_holes_are_free_where_a_whole_cell_is():
    zone = Polygon(
        ((0, 0), (2000, 0), (2000, 2000), (0, 2000)),
        (((550, 550), (1250, 550), (1250, 1250), (550, 1250)),),
    )
    found = blocked_cells([zone], terrain(), 0)
    assert not found[7:12, 7:12].any()
    assert found[6, 6:13].all()
    # The cells next to the edge touch it.
    assert np.count_nonzero(~blocked_cells([zone], terrain(), 40)[5:14, 5:14]) == 25
    assert np.count_nonzero(~blocked_cells([zone], terrain(), 101)[5:14, 5:14]) == 9


def test_cells_as_near_as_the_rounding_of_the_strict_rule_are_blocked():
    for gap_m, blocked in ((1e-6, True), (1e-5, False)):
        assert blocked_cells([Circle(250 + 30 + gap_m, 200, 30)], terrain(), 0)[2, 2] == blocked
        edge = 275 + gap_m
        zone = Polygon(((edge, 0), (edge + 50, 0), (edge + 50, 400), (edge, 400)))
        assert blocked_cells([zone], terrain(), 25)[2, 2] == blocked


def test_zones_off_the_map_and_none():
    for zone in (
        Circle(-5000, 0, 100),
        Circle(500, 9000, 100),
        Polygon(((1e7, 0), (1e7 + 5, 0), (1e7, 5))),
    ):
        assert not blocked_cells([zone], terrain(), 25).any()
    assert blocked_cells([], terrain(), 25).shape == (21, 31)
    around = Polygon(((-500, -500), (9999, -500), (9999, 9999), (-500, 9999)))
    assert blocked_cells([around], terrain(), 0).all()
