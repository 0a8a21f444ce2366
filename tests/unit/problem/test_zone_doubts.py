"""Zones whose numbers are read in one sense and look like another."""

import json

import numpy as np
import pytest
from pyproj import Transformer

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
