"""Zones with more corners than are read."""

import json

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.problem.zones import Polygon, read_zones
from pathgene.host.terrain import Terrain


def test_too_many_corners_are_refused_at_once():
    corners = [(0.001 * number, float(number % 2)) for number in range(100_001)]
    with pytest.raises(InputError, match=r"^100,001 corners of no-fly zones are more than 100,000"):
        Polygon(tuple(corners))
    assert len(Polygon(tuple(corners[:-1])).ring) == 100_000


def test_too_many_corners_of_a_file_are_refused(tmp_path):
    """Two rings may have as many corners as one."""
    terrain = Terrain("plain", np.zeros((31, 31)), 100.0, 100.0)
    ring = [[100 + 0.01 * number, 100 + 100.0 * (number % 2)] for number in range(60_000)]
    polygons = [{"type": "Polygon", "coordinates": [ring]}] * 2
    file = tmp_path / "z.geojson"
    collection = {"type": "GeometryCollection", "geometries": polygons, "crs_local": True}
    file.write_text(json.dumps(collection))
    with pytest.raises(InputError, match=r"z\.geojson': 120,000 corners of no-fly zones are more"):
        read_zones(file, terrain)
