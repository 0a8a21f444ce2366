"""Zones whose numbers are read in one sense and look like another."""

import json

import numpy as np
import pytest
from pyproj import Transformer

from pathgene.host.formats.features import Feature, Limit, Reference
from pathgene.host.problem.zone_doubts import mirrored, of_corners, of_holes, of_size
from pathgene.host.problem.zones import read_zones
from pathgene.host.remarks import Grade
from pathgene.host.terrain import Terrain


HEIGHTS = np.zeros((41, 41))
PLACE = Transformer.from_crs(4326, 32632, always_xy=True).transform(9.0, 46.0)
PLACED = Terrain("plain", HEIGHTS, 100.0, 100.0, "EPSG:32632", PLACE)
NOWHERE = Terrain("plain", HEIGHTS, 100.0, 100.0)


def warnings(tmp_path, terrain, geometry, **properties):
    properties["name"] = "R-7"
    feature = {"type": "Feature", "properties": properties, "geometry": geometry}
    file = tmp_path / "zones.geojson"
    file.write_text(json.dumps({**feature, "crs_local": True}))
    remarks = read_zones(file, terrain).reading.remarks
    return [each.text for each in remarks if each.grade is Grade.WARNING and "degrees" in each.text]


def square(west, south, size):
    east, north = west + size, south + size
    ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
    return {"type": "Polygon", "coordinates": [ring]}


@pytest.mark.parametrize(
    ("terrain", "geometry", "radius_m", "size"),
    [
        (NOWHERE, square(9.01, 46.01, 0.01), None, "0.014 m wide"),
        (PLACED, square(-75.0, 40.0, 0.5), None, "0.71 m wide"),
        # Larger, and on the map in degrees, in either order.
        (PLACED, square(5.0, 42.0, 8.0), None, "11 m wide"),
        (PLACED, square(42.0, 5.0, 8.0), None, "11 m wide"),
        (PLACED, {"type": "Point", "coordinates": [9.01, 46.01]}, 500, "near a corner of the map"),
        # Metres near the corner of a map.
        (NOWHERE, square(0.0, 0.0, 50.0), None, ""),
        (PLACED, square(100.0, 50.0, 40.0), None, ""),
        (PLACED, {"type": "Point", "coordinates": [50, 80]}, 30, ""),
        (NOWHERE, {"type": "Point", "coordinates": [9.01, 46.01]}, 500, ""),
        (NOWHERE, square(1000.0, 1000.0, 1.0), None, ""),
    ],
)
def test_local_metres_that_look_like_degrees_are_a_warning(
    tmp_path, terrain, geometry, radius_m, size
):
    found = warnings(tmp_path, terrain, geometry, radius_m=radius_m)
    assert found == [
        "zones.geojson: crs_local is true, so coordinates are metres, but some look like degrees: "
        f'feature 1, "R-7" is {size}; remove crs_local if they are longitudes and latitudes.'
    ] * bool(size)


RINGS = (((9.0, 46.0), (9.1, 46.0), (9.1, 46.1)),)


def circle(radius_m, **fields):
    return Feature(1, "R-7", (((9.0, 46.0),),), radius_m, **fields)


def between(lower=None, upper=None):
    return Feature(1, "R-7", RINGS, None, lower, upper)


@pytest.mark.parametrize(
    ("feature", "doubt"),
    [
        (circle(0.5), "its radius is 0.5 m; kilometres or nautical miles may be meant"),
        (circle(9.99), "its radius is 9.99 m; kilometres or nautical miles may be meant"),
        (circle(2500 * 1852.0), "its radius is 4,630 km; metres may be meant"),
        (circle(10.0), None),
        (circle(200_000.0), None),
        (circle(0.5, is_local=True), None),
        (
            between(upper=Limit(0.12, Reference.AGL, "0.12 m AGL")),
            "its upper limit is 0.12 m AGL, so it forbids little; correct its unit",
        ),
        (
            between(Limit(45_720.0, Reference.STANDARD, "FL 1500")),
            "its lower limit is FL 1500, over all flights; correct its unit",
        ),
        (between(Limit(300.0, Reference.AMSL), Limit(5.0, Reference.AGL)), None),
        (between(Limit(0.0, Reference.AGL), Limit(1.0, Reference.AMSL)), None),
    ],
)
def test_sizes_that_look_like_another_unit_are_a_warning(feature, doubt):
    found = [(each.grade, each.text) for each in of_size("z.json", [feature, feature])]
    assert found == [(Grade.WARNING, f'z.json: feature 1, "R-7": {doubt}.')] * bool(doubt)


def test_the_report_has_the_doubts_on_sizes(tmp_path):
    point = {"type": "Point", "coordinates": [9.02, 46.02]}
    for properties, is_said in (({"radius_m": 0.5}, True), ({"radius_m": 50}, False)):
        document = {"type": "Feature", "properties": properties, "geometry": point}
        (tmp_path / "z.geojson").write_text(json.dumps(document))
        remarks = read_zones(tmp_path / "z.geojson", PLACED).reading.warnings
        assert len(remarks) == is_said


def ring(west, south, size):
    (corners,) = square(west, south, size)["coordinates"]
    return tuple(map(tuple, corners[:-1]))


@pytest.mark.parametrize(
    ("holes", "doubt"),
    [
        ([ring(9.5, 46.5, 0.2)], None),
        # A corner on the outline, and the whole outline.
        ([ring(9.0, 46.0, 0.2)], None),
        ([ring(9.0, 46.0, 1.0)[::-1]], None),
        (
            [ring(9.5, 46.5, 0.2), ring(10.5, 46.5, 0.2)],
            "a hole lies outside the outline and is forbidden, too; make it a polygon",
        ),
        (
            [ring(8.0, 45.0, 3.0)],
            "a hole lies around the outline, so the ground between is forbidden; swap them",
        ),
    ],
)
def test_holes_that_lie_elsewhere_are_a_warning(holes, doubt):
    zone = Feature(1, "R-7", (ring(9.0, 46.0, 1.0), *holes))
    found = [each.text for each in of_holes("z.json", [zone])]
    assert found == [f'z.json: {doubt}: feature 1, "R-7".'] * bool(doubt)


@pytest.mark.parametrize(
    ("corner", "is_said"),
    [((0.0, 0.0), True), ((46.0, 9.0), True), ((90.5, 46.5), True), ((9.0, 46.9), False)],
)
def test_a_corner_far_from_the_others_is_a_warning(corner, is_said):
    near = (*ring(9.5, 46.5, 0.02)[:3], corner)
    wide = ((9.0, 46.0), (12.0, 46.0), (12.0, 49.0), (0.0, 47.0))
    features = [Feature(1, "R-7", (near,)), Feature(2, "wide", (wide,))]
    found = [each.text for each in of_corners("z.json", features)]
    start = (
        "z.json: one corner lies more than 1 degree from all other corners, which are near each "
    )
    end = 'other; correct its longitude or latitude: feature 1, "R-7".'
    assert found == [start + end] * is_said


@pytest.mark.parametrize(
    ("west", "south", "is_said"),
    [(-9.03, 46.01, True), (9.01, -46.03, True), (-9.03, -46.03, True), (-8.0, 45.0, False)],
)
def test_signs_that_place_a_zone_elsewhere_are_a_warning(west, south, is_said):
    zone = Feature(1, "R-7", (ring(west, south, 0.01),))
    found = [each.text for each in mirrored("z.json", [zone], PLACED)]
    start = "z.json: with another sign of longitude or latitude, the zone would be on the map; "
    end = 'check east and west, and north and south: feature 1, "R-7".'
    assert found == [start + end] * is_said


def test_the_report_has_the_doubts_on_places(tmp_path):
    east, far = square(9.01, 46.01, 0.02), square(9.01, 46.01, 0.02)
    far["coordinates"][0][2] = [0, 0]
    for geometry, words in (
        (square(-9.03, 46.01, 0.02), ["lies off", "with another sign", "0 can forbid"]),
        (far, ["one corner"]),
        (east, []),
    ):
        document = {"type": "Feature", "properties": {}, "geometry": geometry}
        (tmp_path / "z.geojson").write_text(json.dumps(document))
        said = read_zones(tmp_path / "z.geojson", PLACED).reading.warnings
        assert len(said) == len(words)
        assert all(any(word in text for text in said) for word in words)
