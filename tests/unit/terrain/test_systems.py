"""Reference systems whose parameters contradict their name."""

import re

import numpy as np
import pyproj
import pytest

from pathgene.host.errors import InputError
from pathgene.host.terrain import load
from tests.support.host.earth import places
from tests.support.host.lands import Land, misread_m, write


@pytest.mark.parametrize("code", [9311, 2163])
def test_a_file_that_lost_its_code_is_refused(tmp_path, code):
    file = tmp_path / "land.tif"
    assert write(file, Land(37.6, -94.3), f"EPSG:{code}", unit="m")
    with pytest.raises(InputError) as caught:
        load(file)
    away = re.search(r"middle of the map ([\d,]+) m apart", str(caught.value))
    assert float(away[1].replace(",", "")) == pytest.approx(misread_m(file, "EPSG:9311"), rel=0.01)
    assert "gdalwarp -s_srs EPSG:9311 -t_srs EPSG:4326" in str(caught.value)


@pytest.mark.parametrize(
    ("crs", "edit"),
    [
        ("EPSG:32632", ("WGS 84 / UTM zone 32N", "Our plane")),
        # The same name in other units is an old habit.
        ("EPSG:2274", ("NAD83 / Tennessee (ftUS)", "NAD83 / Tennessee")),
    ],
)
def test_a_system_of_its_own_name_or_units_is_read(tmp_path, crs, edit):
    place = (46.5, 8.5) if crs == "EPSG:32632" else (35.5, -86.5)
    wkt = re.sub(r",\s*ID\[[^\[]*\]\]$", "]", pyproj.CRS(crs).to_wkt()).replace(*edit)
    land, file = Land(*place), tmp_path / "land.tif"
    assert write(file, land, wkt, unit="m")
    terrain = load(file)
    iy, ix = (each.ravel() for each in np.indices(terrain.shape))
    points = np.stack((ix * terrain.dx_m, iy * terrain.dy_m), axis=1)
    height = land.height(*places(terrain, points))
    assert np.abs(terrain.elevation[iy, ix] - height).max() < 1.5
