"""Coordinates of GeoJSON that are no degrees, and the names of their reference systems."""

import json

import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats import geojson
from pathgene.host.formats.areas import named_system
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Feature


RING = [[9.0, 45.0], [9.01, 45.0], [9.01, 45.01], [9.0, 45.0]]


def document(geometry):
    return {"type": "Feature", "properties": {}, "geometry": geometry}


def reads(value):
    return list(geojson.features(Content(json.dumps(value).encode())))


def moved(ring, scale, east=0.0, north=0.0):
    coordinates = [[lon * scale + east, lat * scale + north] for lon, lat in ring]
    return {"type": "Polygon", "coordinates": [coordinates]}


@pytest.mark.parametrize(
    ("geometry", "remedy"),
    [
        (moved(RING, 1e7), "it looks like degrees times 10,000,000: divide them, or save in "),
        (moved(RING, 1.0, 500_000, 5_000_000), "it looks like projected metres: name the system"),
        (moved(RING, 100.0), 'for local metres add the member "crs_local": true.'),
    ],
)
def test_the_remedy_for_positions_that_are_no_degrees(geometry, remedy):
    (part,) = reads(document(geometry))
    assert f" is no WGS84 longitude and latitude; {remedy}" in part.reason


@pytest.mark.parametrize("system", ["EPSG:3857", "EPSG:25832"])
def test_degrees_in_a_projected_system_are_bad(system):
    crs = {"type": "name", "properties": {"name": system}}
    (part,) = reads(document(moved(RING, 1.0)) | {"crs": crs})
    assert part.reason == (
        "(9, 45) looks like longitude and latitude, but crs names the projected system "
        f"{system}; remove crs if they are degrees."
    )
    (part,) = reads(document(moved(RING, 1.0, 500_000, 5_000_000)) | {"crs": crs})
    assert isinstance(part, Feature)


@pytest.mark.parametrize(
    ("crs", "system"),
    [
        ({"type": "name", "properties": {"name": "ESRI::102100"}}, "ESRI:102100"),
        ({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG:9.9.1:2056"}}, "EPSG:2056"),
        ({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::2056"}}, "EPSG:2056"),
        ({"properties": {"name": "http://www.opengis.net/def/crs/EPSG/0/2056"}}, "EPSG:2056"),
        ({"type": "EPSG", "properties": {"code": 2056}}, "EPSG:2056"),
        ({"type": "EPSG", "properties": {"code": 4326}}, None),
        ({"type": "name", "properties": {"name": "epsg:4326"}}, None),
    ],
)
def test_names_of_reference_systems(crs, system):
    assert named_system({"crs": crs}) == system


def test_refuses_a_bare_list_of_features_by_its_kind():
    with pytest.raises(InputError, match=r"^it is a bare list; put its features into "):
        reads([document(None)])
