"""Files of every kind that are generated, and read again by PROJ and the definition of the land."""

import re
import warnings

import numpy as np
import pyproj
import pytest
import rasterio
from scipy.ndimage import binary_dilation

from pathgene.host.errors import InputError
from pathgene.host.terrain import load
from pathgene.host.terrain.stated import Stated
from tests.support.host.earth import apart_m, places
from tests.support.host.lands import GEODESICS, Land, misread_m, systems, write


# Files of a group in `make test` and in `make test-long`.
FEW, MANY = range(10), range(100)
SYSTEMS = 6
LONG = [pytest.param(seed, marks=pytest.mark.long) for seed in MANY if seed not in FEW]
SEEDS = [*FEW, *LONG]
# Draws of EPSG:9311 and EPSG:2163, whose code GDAL loses in a GeoTIFF.
CODE_IS_LOST = (50005, 60018)


@pytest.fixture(autouse=True)
def quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@pytest.mark.parametrize("seed", [*SEEDS, *CODE_IS_LOST])
def test_any_projection(tmp_path, seed):
    """Heights lie in their place, cells have their true size, and north is true north."""
    read = 0
    drawn = systems(np.random.default_rng(seed))
    for _ in range(4 * SYSTEMS):
        crs, lat, lon = next(drawn)
        land, file = Land(lat, lon), tmp_path / "land.tif"
        if not write(file, land, crs, unit="m"):
            continue
        try:
            terrain = load(file)
        except InputError as error:
            if "the two place the middle" not in str(error):
                raise
            assert misread_m(file, crs) > 1, crs
            continue
        check(terrain, land, crs)
        read += 1
        if read == SYSTEMS:
            break
    assert read == SYSTEMS


def check(terrain, land, crs):
    rows, columns = terrain.shape
    assert min(rows, columns) >= 9, crs
    iy, ix = (each.ravel() for each in np.indices(terrain.shape))
    points = np.stack((ix * terrain.dx_m, iy * terrain.dy_m), axis=1)
    lat, lon = (np.asarray(each) for each in places(terrain, points))
    # Between centres of pixels the land is curved; datums may be shifted by other parameters.
    system = pyproj.CRS(crs)
    is_exact = re.search("WGS|World Geodetic|NAD83|ETRS|European Terr", str(system.datum))
    is_kept = terrain.crs.startswith("EPSG:") and (is_exact or system.is_projected)
    near = 1.5 if is_kept else 40.0
    off = np.abs(terrain.elevation[iy, ix] - land.height(lat, lon))
    assert off.max() < near, (crs, terrain.crs)
    corners = [0, columns - 1, (rows - 1) * columns]
    width, height = (apart_m((lat[0], lon[0]), (lat[node], lon[node])) for node in corners[1:])
    assert terrain.width_m == pytest.approx(width, rel=5e-4), crs
    assert terrain.height_m == pytest.approx(height, rel=5e-4), crs
    middle = points.max(axis=0) / 2
    lat, lon = places(terrain, [middle - np.array((0, 100)), middle + np.array((0, 100))])
    north = GEODESICS.inv(lon[0], lat[0], lon[1], lat[1])[0]
    assert abs((north - terrain.north_deg + 180) % 360 - 180) < 0.11, crs
    assert abs(terrain.north_deg) <= 10, crs
    back = terrain.to_local(*terrain.to_geographic(points[:, 0], points[:, 1]))
    # Several shifts of an old datum may hold at a place, and there and back may take two of them.
    assert np.abs(np.stack(back, axis=1) - points).max() < (1e-3 if is_exact else 20), crs


def mark_of(rng, dtype):
    """Return a number that some program writes for a void, as ``dtype`` holds it."""
    kinds = {
        "int16": [-9999, -32767, -32768, 32767, 9999, -12345],
        "int32": [-9999, -99999, 2147483647, -2147483648, 65535, 999999],
        "float32": [-9999.0, -3.4028235e38, 3.4028235e38, 1e20, -9999.99, -99999.0, 12345.25],
        "float64": [-1.7976931348623157e308, 1e30, -9999.0, -999999.0, 99999.0, 5000.0, -777.0],
    }
    return rng.choice(kinds[dtype])


@pytest.mark.parametrize("seed", SEEDS)
def test_any_mark(tmp_path, seed):
    """Exactly the marked cells are voids, at any scale and in any type."""
    rng = np.random.default_rng(1000 + seed)
    for _ in range(2):
        dtype = str(rng.choice(["int16", "int32", "float32", "float64"]))
        mark = mark_of(rng, dtype)
        rough = rng.uniform(0, 30, (20, 20)) + np.add.outer(
            *[np.arange(20) * rng.uniform(0, 9)] * 2
        )
        heights = (rough + rng.uniform(5, 900)).astype(dtype)
        marked = np.zeros((20, 20), bool)
        for _ in range(int(rng.integers(1, 4))):
            row, column = rng.integers(0, 16, 2)
            marked[row : row + rng.integers(2, 5), column : column + rng.integers(2, 5)] = True
        heights[marked] = mark
        scale = float(rng.choice([1.0, 0.1])) if dtype == "int32" else 1.0
        file = tmp_path / "marks.tif"
        with rasterio.open(
            file, "w", driver="GTiff", height=20, width=20, count=1, dtype=dtype,
            crs="EPSG:32632", transform=rasterio.Affine(30, 0, 500_000, 0, -30, 5_100_000),
        ) as made:  # fmt: skip
            made.write(heights, 1)
            made.scales = (scale,)
        terrain = load(file)
        np.testing.assert_array_equal(terrain.voids[::-1], marked, err_msg=f"{dtype} {mark}")
        (found,) = terrain.reading.facts["voids"]["marks"]
        assert found["cells"] == marked.sum()
        assert found["value"] == pytest.approx(float(mark), rel=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_any_unit_and_datum(tmp_path, seed):
    """Heights are metres above the sea, by the axes of PROJ."""
    rng = np.random.default_rng(2000 + seed)
    for _ in range(2):
        code = int(rng.choice([5703, 6360, 8228, 5773, 3855, 5701, 5715, 8052]))
        upright = pyproj.CRS.from_epsg(code)
        axis = upright.axis_info[0]
        plane = str(rng.choice(["EPSG:32614", "EPSG:2274", "EPSG:26914", "EPSG:4269"]))
        lat, lon = (35.5, -86.5) if plane == "EPSG:2274" else (40.3, -98.4)
        land, file = Land(lat, lon), tmp_path / "unit.tif"
        sign = -1 if axis.direction == "down" else 1
        unit_m = sign * axis.unit_conversion_factor
        assert write(file, land, f"{plane}+{code}", unit_m=unit_m)
        terrain = load(file)
        middle = (terrain.width_m / 2, terrain.height_m / 2)
        ground = terrain.ground(*middle)
        lat, lon = places(terrain, [middle])
        assert ground == pytest.approx(land.height(lat, lon)[0], abs=5), (plane, code)
        heights = terrain.reading.facts["heights"]
        assert heights["datum"] == upright.name
        assert (heights["unit_from"], heights["datum_from"]) == ("file", "file")


def tile(file, heights, side_m, **profile):
    """Write heights, rows from the north, over UTM."""
    rows, columns = heights.shape
    with rasterio.open(
        file, "w", driver="GTiff", height=rows, width=columns, count=1, dtype=heights.dtype,
        crs="EPSG:32632", transform=rasterio.Affine(side_m, 0, 500_000, 0, -side_m, 5_100_000),
        **profile,
    ) as made:  # fmt: skip
        made.write(heights, 1)
    return file


def numbers_of(file):
    """Return the numbers of a file as rasterio reads them."""
    with rasterio.open(file) as opened:
        return opened.read(1)


def rough(rng, dtype, *, lowest=5.0, rows=24, columns=30):
    """Return ground with a relief of less than 700 m."""
    slopes = np.add.outer(
        np.arange(rows) * rng.uniform(0, 9), np.arange(columns) * rng.uniform(0, 9)
    )
    return (slopes + rng.uniform(0, 30, (rows, columns)) + lowest).astype(dtype)


def lonely_numbers(rng, ground, dtype):
    """Return 1 to 8 numbers from 1,001 m to 5,000 m above the ground, equal or different."""
    count, above = int(rng.integers(1, 9)), float(ground.max()) + rng.uniform(1_001, 2_000)
    values = (
        above
        + rng.uniform(0, 3_000)
        + (np.zeros(count) if rng.integers(2) else rng.uniform(0, 900, count))
    )
    return (np.ceil(values) if dtype == "int16" else values).astype(dtype)


NAMED = re.compile(r"name the mark \(--void ([^)]+)\)")


@pytest.mark.parametrize("seed", SEEDS)
def test_any_lonely_number(tmp_path, seed):
    """Numbers far from all heights are voids or refused; the advice of a refusal mends the file."""
    rng = np.random.default_rng(3000 + seed)
    for _ in range(4):
        dtype = str(rng.choice(["int16", "float32", "float64"]))
        ground, side_m = rough(rng, dtype, lowest=rng.uniform(5, 900)), float(rng.uniform(5, 500))
        lonely = lonely_numbers(rng, ground, dtype)
        cells = rng.permutation(ground.size)[: len(lonely)]
        ground.ravel()[cells] = lonely
        file = tile(
            tmp_path / "lonely.tif", ground, side_m, nodata=ground[0, 0] if 0 in cells else None
        )
        alone = np.isin(numbers_of(file), lonely)
        is_mark = len(np.unique(lonely)) == 1 and (len(lonely) > 3 or is_form(lonely[0]))
        stated, named = Stated(), []
        if is_mark or 0 in cells:
            pass
        else:
            with pytest.raises(InputError) as caught:
                load(file)
            message = str(caught.value)
            row, column = np.argwhere(alone)[0]
            east, north = column * side_m, (len(ground) - 1 - row) * side_m
            assert message.startswith(f"lonely: {len(lonely)} of {ground.size} height")
            assert f"{round(east, 1):g} m east and " in message or round(east, 1) >= 1e5
            assert f"{round(north, 1)}".removesuffix(".0") + " m north of the south" in message
            assert f", is {float(ground[row, column])!r}".removesuffix(".0") in message
        for _ in range(len(lonely)):
            try:
                terrain = load(file, stated=stated)
                break
            except InputError as refused:
                named.append(float(NAMED.search(str(refused)).group(1)))
                stated = Stated(void=named)
        else:
            terrain = load(file, stated=stated)
        np.testing.assert_array_equal(terrain.voids[::-1], alone)
        kept = load(file, stated=Stated(void="none"))
        if 0 not in cells:
            np.testing.assert_array_equal(kept.elevation[::-1], numbers_of(file))


def is_form(value):
    """Return whether a number consists of nines, or is next to a power of two."""
    text = f"{value:g}"
    powers = {2.0**exponent + end for exponent in range(7, 15) for end in (-1, 0)}
    return set(text) <= set("9.") or float(value) in powers


@pytest.mark.parametrize("seed", SEEDS)
def test_any_coarse_land(tmp_path, seed):
    """Land that rises from the sea within a cell is ground."""
    rng = np.random.default_rng(4000 + seed)
    side_m = float(rng.uniform(1_000, 8_000))
    foot = rng.uniform(1_010, 1.45 * side_m) if side_m > 1_200 else 1_010
    heights = rough(rng, "float32", lowest=min(foot, 6_000))
    row, column = rng.integers(3, 12, 2)
    if rng.integers(2):
        heights[:row] = heights[:, :column] = 0
    else:
        heights[row : row + 9, column : column + 9] = 0
    terrain = load(tile(tmp_path / "coarse.tif", heights, side_m))
    assert not terrain.voids.any()
    assert not [text for text in terrain.reading.warnings if "looks like voids" in text]


@pytest.mark.parametrize("seed", SEEDS)
def test_any_zeros(tmp_path, seed):
    """Zeros are suspicious where all land around lies higher than any shore."""
    rng = np.random.default_rng(5000 + seed)
    for _ in range(2):
        side_m, dtype = float(rng.uniform(5, 150)), str(rng.choice(["int16", "float32"]))
        heights = rough(rng, dtype, lowest=rng.uniform(1, 400))
        zeros = np.zeros(heights.shape, bool)
        row, column = rng.integers(1, 12, 2)
        zeros[row : row + rng.integers(1, 9), column : column + rng.integers(1, 9)] = True
        heights[zeros] = 0
        file = tile(tmp_path / "zeros.tif", heights, side_m)
        shore = binary_dilation(zeros) & ~zeros
        lowest = numbers_of(file)[shore].min()
        # The true side differs from the side in the file by up to 0.04 %.
        if abs(lowest - 1.5 * side_m) < 0.2:
            continue
        found = [text for text in load(file).reading.warnings if "looks like voids" in text]
        assert bool(found) is bool(lowest > max(100, 1.5 * side_m)), (lowest, side_m)
        voids = load(file, stated=Stated(void=0)).voids[::-1]
        np.testing.assert_array_equal(voids, numbers_of(file) == 0)


@pytest.mark.parametrize("seed", SEEDS)
def test_any_numpy_file(tmp_path, seed):
    """An .npz has the same land as a raster of its numbers, in any unit."""
    rng = np.random.default_rng(6000 + seed)
    drawn, read = systems(rng), 0
    while read < 3:
        crs, lat, lon = next(drawn)
        land, file = Land(lat, lon), tmp_path / "land.tif"
        if pyproj.CRS(crs).is_geographic or not write(file, land, crs, unit="m"):
            continue
        unit = str(rng.choice(["m", "dm", "cm", "ft", "us-ft"]))
        with rasterio.open(file) as opened:
            side, heights = opened.transform, opened.read(1)[::-1]
        unit_m = pyproj.CRS(crs).axis_info[0].unit_conversion_factor
        np.savez(
            tmp_path / "land.npz",
            elevation=heights / UNITS_M[unit],
            dx_m=side.a * unit_m,
            dy_m=-side.e * unit_m,
            crs=crs,
            origin=(side.c + 0.5 * side.a, side.f + (len(heights) - 0.5) * side.e),
        )
        terrain = load(tmp_path / "land.npz", stated=Stated(height_unit=unit))
        check(terrain, land, crs)
        read += 1


UNITS_M = {"m": 1.0, "dm": 0.1, "cm": 0.01, "ft": 0.3048, "us-ft": 1200 / 3937}
