"""Geozones of INAV."""

import json

import numpy as np
import pytest

from pathgene.host.formats import inav
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, LeftOut, Limit, Reference
from pathgene.host.problem.zones import read_zones
from pathgene.host.remarks import Grade
from pathgene.host.terrain import Terrain


POINT = {"type": "Point", "coordinates": [10.0, 60.0]}
RING = [[10.0, 60.0], [10.1, 60.0], [10.1, 60.1], [10.0, 60.0]]
POLYGON = {"type": "Polygon", "coordinates": [RING]}
FACTS = {
    "Name": "Circle 1",
    "Type": "Exclusive",
    "Action": "Avoid",
    "MinAlt": 23.0,
    "MaxAlt": 120.0,
    "IsAMSL": "true",
    "Radius": 160.0,
}


def read(*geozones):
    features = [
        {"type": "Feature", "properties": facts, "geometry": geometry}
        for facts, geometry in geozones
    ]
    content = Content(json.dumps({"type": "FeatureCollection", "features": features}).encode())
    assert inav.recognises(content)
    return list(inav.features(content))


def test_reads_a_circle_to_keep_out_of():
    (found,) = read((FACTS, POINT))
    assert (found.rings, found.radius_m, found.keeps_in) == ((((10.0, 60.0),),), 160.0, False)
    assert (found.lower, found.upper) == (Limit(23, Reference.AMSL), Limit(120, Reference.AMSL))
    assert (found.label, found.unread) == ('feature 1, "Circle 1"', ())


def limits(found):
    return [
        (each.keeps_in, *(limit and limit.height_m for limit in (each.lower, each.upper)))
        for each in found
    ]


STAY_IN = {key: value for key, value in FACTS.items() if key != "Radius"} | {"Type": "inclusive"}


@pytest.mark.parametrize("is_circle", [True, False])
def test_an_area_to_stay_in_forbids_below_its_floor_and_above_its_ceiling(is_circle):
    geozone = (STAY_IN | {"Radius": 160.0}, POINT) if is_circle else (STAY_IN, POLYGON)
    found = read(geozone)
    assert limits(found) == [(True, None, None), (False, None, 23), (False, 120, None)]
    assert len({(each.rings, each.radius_m, each.label) for each in found}) == 1
    assert all(each.unread == each.remarks == () for each in found)
    floor_only = read((STAY_IN | {"MaxAlt": 0}, POLYGON))
    assert limits(floor_only) == [(True, None, None), (False, None, 23)]
    assert limits(read((STAY_IN | {"MinAlt": 0, "MaxAlt": 0}, POLYGON))) == [(True, None, None)]


def test_a_height_of_0_is_no_limit():
    (found,) = read((FACTS | {"MinAlt": 0, "MaxAlt": 0.0}, POINT))
    assert (found.lower, found.upper, found.unread) == (None, None, ())


@pytest.mark.parametrize("name", ["IsAMSL", "isSealevelRef", "isSeaLevelRef"])
@pytest.mark.parametrize("is_amsl", ["true", "True", True, 1, "1"])
def test_heights_above_sea_level_are_read(is_amsl, name):
    facts = {key: value for key, value in FACTS.items() if key != "IsAMSL"} | {name: is_amsl}
    (found,) = read((facts, POINT))
    assert (found.lower, found.upper) == (Limit(23, Reference.AMSL), Limit(120, Reference.AMSL))
    assert found.remarks == ()


@pytest.mark.parametrize("is_amsl", ["false", False, None, 0, "missing"])
def test_heights_above_home_are_a_warning_and_no_limit(is_amsl):
    facts = FACTS | {"IsAMSL": is_amsl, "MinAlt": 0}
    if is_amsl == "missing":
        del facts["IsAMSL"]
    (found,) = read((facts, POINT))
    assert (found.lower, found.upper) == (None, None)
    (remark,) = found.remarks
    assert remark.grade is Grade.WARNING
    assert "above home" in remark.text
    assert "from the ground to the sky" in remark.text
    (inside,) = read((facts | {"Type": "Inclusive"}, POINT))
    assert (inside.keeps_in, inside.lower, inside.upper) == (True, None, None)
    assert "at any height" in inside.remarks[0].text
    (unlimited,) = read((facts | {"MaxAlt": 0}, POINT))
    assert unlimited.remarks == ()


def test_the_warning_names_the_geozone_and_the_zone_has_no_limits(tmp_path):
    features = [
        {"type": "Feature", "properties": FACTS | {"Name": name, **more}, "geometry": POLYGON}
        for name, more in (("near home", {"IsAMSL": "false"}), ("stay", {"Type": "Inclusive"}))
    ]
    file = tmp_path / "geozones.geojson"
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    where = Terrain(
        "flat", np.zeros((9, 9)), 1000.0, 1000.0, "EPSG:32632", (555_000.0, 6_651_000.0)
    )
    found = read_zones(file, where)
    heights = [(zone.name, zone.lower_m, zone.upper_m) for zone in found.zones]
    assert heights == [
        ("near home", None, None),
        ("stay", None, None),
        ("stay", None, 23.0),
        ("stay", 120.0, None),
    ]
    (warning,) = found.reading.warnings
    assert warning.startswith(
        'geozones.geojson: feature 1, "near home": its heights are above home'
    )


@pytest.mark.parametrize(
    ("facts", "geometry", "reason"),
    [
        ({"Type": "Both"}, POINT, "its Type must be Exclusive or Inclusive, not 'Both'."),
        ({"Radius": -1}, POINT, "the radius of a circle must be a number above 0, not -1."),
        ({"MaxAlt": "high"}, POINT, "MaxAlt must be a number, not 'high'."),
        ({"IsAMSL": "yes"}, POINT, "IsAMSL must be true or false, not 'yes'."),
        (
            {"Type": "Inclusive", "MinAlt": 120},
            POINT,
            "its MinAlt is its MaxAlt, so nothing may be flown in it.",
        ),
        ({"MaxAlt": 20}, POINT, "its lower limit, 23 m, lies above its upper, 20 m."),
        ({}, {"type": "Point"}, "a position must be a list of two finite numbers."),
    ],
)
def test_names_a_bad_geozone_and_reads_the_others(facts, geometry, reason):
    first, second = read((FACTS | facts, geometry), (FACTS, POINT))
    assert first == Bad('feature 1, "Circle 1"', reason)
    assert second.number == 2


def test_leaves_out_geozones_without_an_area():
    bare = {key: value for key, value in FACTS.items() if key != "Radius"}
    first, second, third = read((bare, POINT), (FACTS, None), (FACTS, POINT))
    tag = 'feature 1, "Circle 1"'
    assert first == LeftOut(tag, "a Point without Radius is not an area", True)
    assert second == LeftOut(tag.replace("1,", "2,"), "it has no geometry")
    assert third.number == 3


def test_a_hole_in_an_area_to_stay_in_is_a_zone(tmp_path):
    outer = [[9.72, 60.02], [9.82, 60.02], [9.82, 60.07], [9.72, 60.07], [9.72, 60.02]]
    hole = [[9.75, 60.03], [9.78, 60.03], [9.78, 60.05], [9.75, 60.05], [9.75, 60.03]]
    geometry = {"type": "Polygon", "coordinates": [outer, hole]}
    facts = STAY_IN | {"IsAMSL": "true", "MinAlt": 0, "MaxAlt": 0}
    file = tmp_path / "geozones.geojson"
    file.write_text(json.dumps({"type": "Feature", "properties": facts, "geometry": geometry}))
    where = Terrain(
        "flat", np.zeros((99, 99)), 100.0, 100.0, "EPSG:32632", (540_000.0, 6_651_000.0)
    )
    zones = read_zones(file, where).zones

    def forbids(lon, lat):
        x, y = where.to_local([lat], [lon])
        return any(zone.covers(x, y).any() for zone in zones)

    assert forbids(9.765, 60.04)
    assert forbids(9.85, 60.04)
    assert not forbids(9.735, 60.04)
