"""Zones as flat fences."""

import itertools
import math

import numpy as np
import pytest
from pyproj import Geod
from shapely.geometry import Polygon as Shape
from shapely.ops import unary_union

from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.autopilot.flight_plan import (
    FenceCircle,
    FencePolygon,
    fences,
    without_holes,
)
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain


GROUND = Terrain("plain", np.zeros((41, 41)), 100.0, 100.0, "EPSG:32632", (500_000.0, 5_000_000.0))
SQUARE = ((1500.0, 1500.0), (2500.0, 1500.0), (2500.0, 2500.0), (1500.0, 2500.0))


def fences_of(*zones):
    problem = Problem(GROUND, (100, 2000, 100), (3900, 2000, 100), zones=zones, as_paper=True)
    track = Evaluator(problem, threads=1).track(np.array([problem.start, problem.goal]))
    return fences(problem.zones, track, GROUND)


def even_odd(ring, x, y):
    """Return which points are inside by the rule of autopilots."""
    inside = np.zeros(len(x), bool)
    for (xa, ya), (xb, yb) in itertools.pairwise((*ring, ring[0])):
        crosses = (ya > y) != (yb > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= crosses & (x < (xb - xa) * (y - ya) / (yb - ya) + xa)
    return inside


def test_a_polygon_without_holes_covers_the_same_points():
    rng = np.random.default_rng(3)
    x, y = rng.uniform(0, 100, (2, 20_000))
    for _ in range(20):
        holes = []
        for corner in ((25, 25), (70, 30), (45, 75)):
            turns = np.sort(rng.uniform(0, 2 * np.pi, 6))
            hole = np.column_stack((np.cos(turns), np.sin(turns))) * 9 + corner
            holes.append(tuple(map(tuple, hole)))
        ring = ((0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0))
        joined = without_holes(ring, tuple(holes))
        expected = even_odd(ring, x, y)
        for hole in holes:
            expected &= ~even_odd(hole, x, y)
        assert np.array_equal(even_odd(joined, x, y), expected)
        assert len(joined) == 4 + 3 * 6 + 3 * 2


def test_circles_keep_their_radius():
    (made,), left_out = fences_of(Circle(2000, 3000, 250))
    assert isinstance(made, FenceCircle)
    assert (made.radius_m, made.inclusion, left_out) == (250, False, ())


def test_a_polygon_keeps_its_corners():
    ((made,), _) = fences_of(Polygon(SQUARE))
    assert isinstance(made, FencePolygon)
    lat, lon = np.array(made.corners).T
    x, y = GROUND.to_local(lat, lon)
    assert np.allclose(np.column_stack((x, y)), SQUARE, atol=1e-3)
    area, _ = Geod(ellps="WGS84").polygon_area_perimeter(lon, lat)
    assert area == pytest.approx(1e6, rel=1e-3)


@pytest.mark.parametrize("limit", ["lower_m", "upper_m", "t0_s", "t1_s"])
@pytest.mark.parametrize(
    "make", [lambda **limits: Polygon(SQUARE, **limits), lambda **k: Circle(2000, 2100, 300, **k)]
)
def test_a_crossed_zone_with_limits_has_no_fence(make, limit):
    made, left_out = fences_of(make(name="R-12", **{limit: 300.0}), make(**{limit: 9.0}))
    assert made == ()
    assert left_out == (
        "No fence for R-12: the path crosses it above, below, before or after its limits, which a "
        "fence cannot express.",
        "No fence for zone 2: the path crosses it above, below, before or after its limits, which "
        "a fence cannot express.",
    )


def test_a_zone_with_limits_beside_the_path_has_a_fence():
    made, left_out = fences_of(Circle(2000, 3000, 250, upper_m=300), Polygon(SQUARE))
    assert len(made) == 2  # The unlimited one, too, though the path enters it.
    assert left_out == ()


def test_a_path_through_a_hole_does_not_cross_the_zone():
    hole = ((50.0, 1900.0), (3950.0, 1900.0), (3950.0, 2100.0), (50.0, 2100.0))
    ring = ((10.0, 10.0), (3990.0, 10.0), (3990.0, 3990.0), (10.0, 3990.0))
    made, left_out = fences_of(Polygon(ring, (hole,), upper_m=500.0))
    assert len(made) == 1
    assert left_out == ()
    lat, lon = np.array(made[0].corners).T
    x, y = GROUND.to_local(lat, lon)
    shape = unary_union(Shape(np.column_stack((x, y))).buffer(0))
    assert math.isclose(shape.area, 3980**2 - 3900 * 200, rel_tol=1e-6)
