"""Barriers compared with shapely, which joins zones and tests if the ends are connected."""

import numpy as np
import pytest
from shapely.geometry import LineString, Point, box
from shapely.geometry import Polygon as Shape
from shapely.ops import unary_union

from pathgene.host.diagnosis.barriers import Barrier, nearest_points
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain


SIDE_M = 1000.0
MAP = box(0, 0, SIDE_M, SIDE_M)
OUTSIDE = MAP.buffer(300).difference(MAP)


def barrier_of(zones, margin, start, goal, forbidden=None):
    terrain = Terrain("flat", np.zeros((11, 11)), 100.0, 100.0)
    if forbidden is None:
        forbidden = np.zeros((11, 11), dtype=bool)
    pieces = [zone.footprint.capsules(margin) for zone in zones]
    owners = [np.full(len(own), index) for index, own in enumerate(pieces)]
    return Barrier(
        terrain,
        (*start, 0.0),
        (*goal, 0.0),
        forbidden,
        np.concatenate([np.empty((0, 5)), *pieces]),
        np.concatenate([np.empty(0, dtype=np.int64), *owners]),
    )


def shape_of(zone, margin):
    if isinstance(zone, Circle):
        return Point(zone.x_m, zone.y_m).buffer(zone.radius_m + margin, quad_segs=64)
    return Shape(zone.ring, zone.holes).buffer(margin, quad_segs=64)


def random_case(seed):
    """Return zones that often close the map, the margin and two points outside them."""
    rng = np.random.default_rng(seed)
    margin = float(rng.choice([0.0, 10.0, 25.0]))
    zones = []
    for _ in range(int(rng.integers(5, 40))):
        x, y = rng.uniform(-50, SIDE_M + 50, 2)
        if rng.random() < 0.5:
            zones.append(Circle(x, y, rng.uniform(10, 130)))
        else:
            angles = 2 * np.pi / 5 * (np.arange(5) + rng.uniform(0, 0.9, 5))
            reach = rng.uniform(20, 220, 5)
            ring = np.column_stack((x + reach * np.cos(angles), y + reach * np.sin(angles)))
            zones.append(Polygon(tuple(map(tuple, ring.tolist()))))
    nodes = rng.random((11, 11)) < rng.choice([0.0, 0.15, 0.3])
    shapes = [shape_of(zone, margin) for zone in zones]
    shapes += [
        box(100 * column - 50, 100 * row - 50, 100 * column + 50, 100 * row + 50)
        for row, column in np.argwhere(nodes)
    ]
    forbidden = unary_union(shapes)
    points = []
    while len(points) < 2:
        point = rng.uniform(0, SIDE_M, 2)
        if not forbidden.buffer(1).contains(Point(point)):
            points.append(tuple(point.tolist()))
    return zones, margin, points, nodes, forbidden


@pytest.mark.parametrize(
    "block", [0, 1, *(pytest.param(block, marks=pytest.mark.ci) for block in range(2, 10))]
)
def test_closes_where_shapely_finds_two_pieces(block):
    closed = decided = 0
    for seed in range(20 * block, 20 * block + 20):
        zones, margin, (start, goal), nodes, forbidden = random_case(seed)
        free = MAP.difference(forbidden.buffer(-0.5))
        wide = MAP.difference(forbidden.buffer(0.5))
        verdicts = [
            not any(
                part.contains(Point(start)) and part.contains(Point(goal))
                for part in getattr(room, "geoms", [room])
            )
            for room in (free, wide)
        ]
        if verdicts[0] != verdicts[1]:
            continue  # A gap of less than a metre.
        decided += 1
        barrier = barrier_of(zones, margin, start, goal, nodes)
        assert barrier.closed == verdicts[0], seed
        if barrier.closed:
            closed += 1
            ring = barrier.ring()
            covered = forbidden.buffer(0.5).union(OUTSIDE)
            assert all(LineString(line).within(covered) for line in ring.lines)
            assert forbidden.buffer(0.5).contains(Point(ring.place))
    assert decided >= 15
    assert closed >= 4


def test_names_the_zones_of_the_ring():
    walls = [Circle(500, y, 60) for y in range(0, 1001, 110)]
    others = [Circle(150, 500, 40), Circle(850, 500, 40)]
    ring = barrier_of([others[0], *walls, others[1]], 0.0, (50, 500), (950, 500)).ring()
    assert ring.zones == tuple(range(1, 11))
    assert ring.edge_of_map
    assert len(ring.lines) == 1


def test_two_zones_that_touch_twice_enclose():
    # Two horseshoes with one capsule per side.
    left = Polygon(
        (
            (400, 300),
            (500, 300),
            (500, 320),
            (420, 320),
            (420, 680),
            (500, 680),
            (500, 700),
            (400, 700),
        )
    )
    right = Polygon(
        (
            (500, 300),
            (600, 300),
            (600, 700),
            (500, 700),
            (500, 680),
            (580, 680),
            (580, 320),
            (500, 320),
        )
    )
    barrier = barrier_of([left, right], 5.0, (500, 500), (100, 100))
    assert barrier.closed
    assert barrier.ring().zones == (0, 1)
    assert not barrier.ring().edge_of_map
    assert not barrier_of([left], 5.0, (500, 500), (100, 100)).closed


def test_start_above_goal_is_never_enclosed():
    assert not barrier_of([Circle(500, 500, 50)], 0.0, (100, 100), (100, 100)).closed


def test_nearest_points_of_segments():
    one = np.array([[0, 0, 10, 0], [0, 0, 10, 0], [0, 0, 10, 10], [3, 3, 3, 3]], dtype=float)
    other = np.array([[12, 5, 12, -5], [4, 2, 6, 3], [0, 10, 10, 0], [0, 0, 0, 9]], dtype=float)
    p, q = nearest_points(one, other)
    assert p.tolist() == [[10, 0], [4, 0], [5, 5], [3, 3]]
    assert q.tolist() == [[12, 0], [4, 2], [5, 5], [0, 3]]
