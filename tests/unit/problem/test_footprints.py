"""Footprints of zones compared with shapely: box, border, inside, distance and outline."""

import math

import numpy as np
import pytest
import shapely

from pathgene.host.problem.footprints import Area, Disc, Footprint
from pathgene.host.problem.zones import Circle, Polygon


DISC = Disc(200.0, -100.0, 80.0)
SQUARE = ((0.0, 0.0), (400.0, 0.0), (400.0, 300.0), (0.0, 300.0))
HOLE = ((100.0, 100.0), (200.0, 100.0), (150.0, 200.0))
AREA = Area((SQUARE, HOLE))


def shape(footprint):
    if footprint.disc:
        x, y, radius = footprint.disc
        return shapely.Point(x, y).buffer(radius, quad_segs=512)
    ring, *holes = footprint.rings
    return shapely.Polygon(ring, holes)


def star(seed, corners=40):
    """Return an area with a border of many corners."""
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, corners))
    away = rng.uniform(50.0, 300.0, corners)
    return Area(
        (
            tuple(
                map(tuple, np.column_stack((away * np.cos(angles), away * np.sin(angles))).tolist())
            ),
        )
    )


def test_zones_have_the_footprint_of_their_fields():
    assert Circle(1, 2, 3, upper_m=9).footprint == Disc(1, 2, 3)
    assert Polygon(SQUARE, (HOLE,), name="a").footprint == AREA


def test_a_footprint_is_a_disc_or_has_rings():
    assert (DISC.disc, DISC.rings) == ((200.0, -100.0, 80.0), ())
    assert (AREA.disc, AREA.rings) == (None, (SQUARE, HOLE))
    assert not hasattr(Footprint, "__dataclass_fields__")
    with pytest.raises(TypeError, match="abstract"):
        type("Strip", (Footprint,), {"disc": None, "rings": ()})()


def test_box_and_middle():
    assert DISC.box == (120.0, -180.0, 280.0, -20.0)
    assert AREA.box == (0.0, 0.0, 400.0, 300.0)
    assert (DISC.middle, AREA.middle) == ((200.0, -100.0), (200.0, 150.0))


def test_outlines():
    (inner,), (outer,) = DISC.outline(12), DISC.outline(12, around=True)
    assert len(inner) == len(outer) == 12
    assert shapely.Polygon(outer).buffer(1e-6).covers(shape(DISC))
    assert shape(DISC).buffer(1e-3).covers(shapely.Polygon(inner))
    assert AREA.outline(12) == AREA.outline(12, around=True) == (SQUARE, HOLE)


def test_rings_wind_as_in_rfc_7946():
    for ring in (SQUARE, SQUARE[::-1]):
        for hole in (HOLE, HOLE[::-1]):
            outer, inner = Area((ring, hole)).wound_rings
            assert shapely.LinearRing(outer).is_ccw
            assert not shapely.LinearRing(inner).is_ccw


@pytest.mark.parametrize("footprint", [DISC, AREA, star(1)])
def test_capsules_are_the_border_and_its_margin(footprint):
    capsules = footprint.capsules(25.0)
    widened = shapely.union_all(
        [
            shapely.LineString(row[:4].reshape(2, 2)).buffer(row[4], quad_segs=512)
            for row in capsules
        ]
    )
    border = shape(footprint) if footprint.disc else shape(footprint).boundary
    assert widened.symmetric_difference(border.buffer(25.0, quad_segs=512)).area < 20.0


@pytest.mark.parametrize("footprint", [DISC, AREA, *map(star, range(20))])
def test_points_inside_and_their_distance(footprint):
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-400.0, 500.0, (2, 500))
    inside = shapely.contains_xy(shape(footprint), x, y)
    away = shapely.distance(shape(footprint).boundary, shapely.points(x, y))
    clear = away > 0.01
    assert (footprint.contains(x, y) == inside)[clear].all()
    assert footprint.covers(x, y).diagonal()[clear].tolist() == inside[clear].tolist()
    signed = np.where(inside, -away, away)
    np.testing.assert_allclose(footprint.distance_m(x, y), signed, atol=0.01)
    least = [footprint.least_distance_m(*at) for at in zip(x, y, strict=True)]
    assert (np.array(least) <= signed.clip(0.0) + 0.01).all()
    assert max(least) > 100.0


def test_points_are_compared_with_edges_in_parts(monkeypatch):
    footprint = star(5, corners=200)
    x, y = np.random.default_rng(4).uniform(-300.0, 300.0, (2, 100))
    whole = footprint.contains(x, y)
    assert 0 < whole.sum() < 100
    monkeypatch.setattr("pathgene.host.problem.footprints._PAIRS", 700)
    assert footprint.contains(x, y).tolist() == whole.tolist()
    assert footprint.contains(x[:0], y[:0]).shape == (0,)


def test_an_edge_without_length_has_a_distance():
    footprint = Area((((0.0, 0.0), (0.0, 0.0), (3.0, 0.0), (0.0, 4.0)),))
    distance = footprint.distance_m(np.array([-3.0]), np.array([-4.0]))
    assert math.isclose(distance[0], 5.0)
