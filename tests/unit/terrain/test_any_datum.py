"""Water levels and heights above the ellipsoid, generated and judged by numpy and by PROJ."""

import warnings

import numpy as np
import pyproj
import pytest
import rasterio
from pyproj.enums import PJType
from pyproj.transformer import TransformerGroup

from pathgene.host.errors import InputError
from pathgene.host.remarks import Grade
from pathgene.host.terrain import load
from pathgene.host.terrain.stated import Stated
from tests.support.host.earth import places
from tests.support.host.lands import Land, systems, write, write_geoid


# Files of a group in `make test` and in `make test-long`.
FEW, MANY = range(10), range(100)
LONG = [pytest.param(seed, marks=pytest.mark.long) for seed in MANY if seed not in FEW]
SEEDS = [*FEW, *LONG]
# Heights above the ellipsoid and above EGM96.
ELLIPSOIDAL, ABOVE_SEA = "EPSG:4979", "EPSG:9707"


@pytest.fixture(autouse=True)
def quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def coast(rng, level, share):
    """Return ground in metres of which about a share lies below a level."""
    shape = rng.integers(12, 40, 2)
    slope = np.add.outer(
        np.arange(shape[0]) * rng.uniform(-8, 8), np.arange(shape[1]) * rng.uniform(-8, 8)
    )
    ground = slope + rng.uniform(0, 6, shape)
    return (ground - np.quantile(ground, share) + level).astype("float32")


@pytest.mark.parametrize("seed", SEEDS)
def test_any_water_level(tmp_path, seed):
    """No height is below the level of the water, and the rest stay as in the file."""
    rng = np.random.default_rng(7000 + seed)
    for _ in range(2):
        stated = [None, "none", round(float(rng.uniform(-400, 1500)), 1)][rng.integers(3)]
        level = 0.0 if stated in (None, "none") else stated
        heights = coast(rng, level, rng.choice([0.0, rng.uniform(0, 0.1), rng.uniform(0, 0.95)]))
        rows, columns = heights.shape
        file = tmp_path / "coast.tif"
        with rasterio.open(
            file, "w", driver="GTiff", height=rows, width=columns, count=1, dtype="float32",
            crs="EPSG:32632", transform=rasterio.Affine(30, 0, 500_000, 0, -30, 5_100_000),
        ) as made:  # fmt: skip
            made.write(heights, 1)
        terrain = load(file, stated=Stated(water_level=stated))
        is_dry = stated == "none"
        file_heights = heights.astype(np.float64)[::-1]
        surface = file_heights if is_dry else np.maximum(file_heights, level)
        np.testing.assert_array_equal(terrain.elevation, surface)
        assert terrain.reading.facts["water_level_m"] == (None if is_dry else level)
        below = np.mean(file_heights < level)
        grades = [each.grade for each in terrain.reading.remarks if " below " in each.text]
        expected = [Grade.WARNING if below >= 0.05 else Grade.NOTE]
        assert grades == ([] if is_dry or below == 0 else expected), (stated, below)


def is_kept(file):
    """Return whether a file still states heights above the ellipsoid, as PROJ reads it."""
    with rasterio.open(file) as made:
        system = pyproj.CRS.from_wkt(made.crs.to_wkt(version="WKT2_2019"))
    if system.is_compound:
        return "ellipsoid" in str(system.sub_crs_list[1].datum).lower()
    return len(system.axis_info) == 3 and not system.is_geocentric


def compounds(rng):
    """Yield UTM zones with heights above the ellipsoid, each with a place."""
    upright = 'VERT_CS["height",VERT_DATUM["Ellipsoid",2002],UNIT["metre",1],AXIS["Up",UP]]'
    while True:
        zone, lat = int(rng.integers(1, 61)), float(rng.uniform(-75, 75))
        plane = pyproj.CRS(f"EPSG:{(32600 if lat > 0 else 32700) + zone}")
        wkt = f'COMPD_CS["both",{plane.to_wkt("WKT1_GDAL")},{upright}]'
        yield wkt, lat, 6 * zone - 183 + float(rng.uniform(-3, 3))


def ellipsoidal(rng, file):
    """Write land above the ellipsoid in a random system, and return it."""
    is_compound = rng.integers(2) > 0
    drawn = compounds(rng) if is_compound else systems(rng, PJType.GEOGRAPHIC_3D_CRS)
    for _ in range(50):
        crs, lat, lon = next(drawn)
        land = Land(lat, lon)
        if write(file, land, crs) and is_kept(file):
            return crs, land
    raise AssertionError(is_compound)


@pytest.mark.parametrize("seed", SEEDS)
def test_any_ellipsoidal_heights(tmp_path, seed):
    """Heights are turned as PROJ turns them, and refused where PROJ has no grid."""
    rng = np.random.default_rng(8000 + seed)
    file = tmp_path / "land.tif"
    crs, land = ellipsoidal(rng, file)
    if not TransformerGroup(ELLIPSOIDAL, ABOVE_SEA).best_available:
        with pytest.raises(InputError, match=r"count from the ellipsoid .* install us_nga_egm96"):
            load(file)
    kept = load(file, stated=Stated(heights="sea-level"))
    write_geoid(tmp_path / "us_nga_egm96_15.tif")
    before = pyproj.datadir.get_data_dir()
    pyproj.datadir.append_data_dir(str(tmp_path))
    try:
        terrain = load(file)
        turned = pyproj.Transformer.from_crs(ELLIPSOIDAL, ABOVE_SEA, always_xy=True)
        iy, ix = (each.ravel() for each in np.indices(terrain.shape))
        points = np.stack((ix * terrain.dx_m, iy * terrain.dy_m), axis=1)
        lat, lon = (np.asarray(each) for each in places(terrain, points))
        _, _, height = turned.transform(lon, lat, land.height(lat, lon))
    finally:
        pyproj.datadir.set_data_dir(before)
    assert np.abs(terrain.elevation[iy, ix] - height).max() < 3, crs
    assert np.abs(kept.elevation[iy, ix] - land.height(lat, lon)).max() < 3, crs
    assert np.abs(height - land.height(lat, lon)).min() > 10
    assert terrain.reading.facts["heights"]["datum"] == "EGM96 geoid"
