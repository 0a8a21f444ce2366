"""Which features of a GeoJSON file are zones."""

import json

import numpy as np
import pytest

from pathgene.host.formats.features import LeftOut
from pathgene.host.problem.zones import Circle, Polygon, read_zones
from pathgene.host.terrain import Terrain


SQUARE = ((100.0, 100.0), (300.0, 100.0), (300.0, 300.0), (100.0, 300.0))
CLOSED = [list(corner) for corner in (*SQUARE, SQUARE[0])]
TERRAIN = Terrain("world", np.zeros((9, 12)), 50.0, 50.0)


def read(tmp_path, *features):
    """Return the zones of a collection of (type, coordinates, properties) in local metres."""
    document = {
        "type": "FeatureCollection",
        "crs_local": True,
        "features": [
            {
                "type": "Feature",
                "properties": properties,
                "geometry": {"type": kind, "coordinates": coordinates},
            }
            for kind, coordinates, properties in features
        ],
    }
    file = tmp_path / "zones.geojson"
    file.write_text(json.dumps(document))
    return read_zones(file, TERRAIN)


# The values of the property ``kind`` in a ``path.geojson``.
OWN_KINDS = ("start", "goal", "via", "return", "waypoints", "smoothed track")


@pytest.mark.parametrize("kind", OWN_KINDS)
def test_a_zone_is_kept_whatever_its_kind_says(tmp_path, kind):
    zones = read(
        tmp_path,
        ("Polygon", [CLOSED], {"kind": kind}),
        ("MultiPolygon", [[CLOSED]], {"kind": kind}),
        ("Point", [1, 2], {"kind": kind, "radius_m": 3}),
    ).zones
    assert zones == (Polygon(SQUARE), Polygon(SQUARE), Circle(1, 2, 3))


@pytest.mark.parametrize(
    ("geometry", "kind"),
    [("LineString", "start"), ("Point", "waypoints"), ("MultiPoint", "start")],
)
def test_a_kind_of_another_geometry_is_left_out_by_name(tmp_path, geometry, kind):
    coordinates = [1, 2] if geometry == "Point" else [[1, 2], [3, 4]]
    found = read(tmp_path, (geometry, coordinates, {"kind": kind, "name": "A"}))
    assert found.zones == ()
    assert found.left_out == (LeftOut('feature 1, "A"', f"a {geometry} is not an area"),)


def test_an_empty_geometry_is_named(tmp_path):
    found = read(tmp_path, ("MultiPolygon", [], {"name": "A"}))
    assert found.left_out == (LeftOut('feature 1, "A"', "its geometry is empty"),)
