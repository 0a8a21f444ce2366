"""Geozones of INAV."""

import json

import pytest

from pathgene.host.formats import inav
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, LeftOut, Limit, Reference


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


def test_reads_a_polygon_to_stay_in():
    facts = {key: value for key, value in FACTS.items() if key != "Radius"} | {"Type": "inclusive"}
    (found,) = read((facts, POLYGON))
    assert (found.radius_m, found.keeps_in) == (None, True)
    assert (found.lower, found.upper) == (None, None)
    assert found.unread == ("MinAlt", "MaxAlt")


def test_a_height_of_0_is_no_limit():
    (found,) = read((FACTS | {"MinAlt": 0, "MaxAlt": 0.0}, POINT))
    assert (found.lower, found.upper, found.unread) == (None, None, ())


@pytest.mark.parametrize("is_amsl", ["false", False, None, 0])
def test_heights_above_home_are_not_read(is_amsl):
    (found,) = read((FACTS | {"IsAMSL": is_amsl, "MinAlt": 0}, POINT))
    assert (found.lower, found.upper, found.unread) == (None, None, ("MaxAlt",))


@pytest.mark.parametrize(
    ("facts", "geometry", "reason"),
    [
        ({"Type": "Both"}, POINT, "its Type must be Exclusive or Inclusive, not 'Both'."),
        ({"Radius": -1}, POINT, "the radius of a circle must be a number above 0, not -1."),
        ({"MaxAlt": "high"}, POINT, "MaxAlt must be a number, not 'high'."),
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
