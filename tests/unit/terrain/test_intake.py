"""Files of every kind that are generated, and read again by PROJ and the definition of the land."""

import functools
import re
import warnings

import numpy as np
import pyproj
import pytest
import rasterio
from pyproj.database import query_crs_info
from pyproj.enums import PJType

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import load
from pathgene.host.terrain.stated import Stated
from tests.support.host.earth import apart_m, places
from tests.support.host.lands import GEODESICS, Land, write


# Files of a group in `make test` and in `make test-long`.
FEW, MANY = range(10), range(100)
SYSTEMS = 6
LONG = [pytest.param(seed, marks=pytest.mark.long) for seed in MANY if seed not in FEW]
SEEDS = [*FEW, *LONG]


@pytest.fixture(autouse=True)
def quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@functools.cache
def projected():
    """Return all projected systems of PROJ."""
    return query_crs_info("EPSG", [PJType.PROJECTED_CRS])


def systems(rng):
    """Yield projected systems of EPSG at random, each with a place in its area of use."""
    known = projected()
    while True:
        found = known[rng.integers(len(known))]
        area = found.area_of_use
        if area is None:
            continue
        east = area.east + (360 if area.east < area.west else 0)
        lat = area.south + rng.uniform(0.2, 0.8) * (area.north - area.south)
        lon = area.west + rng.uniform(0.2, 0.8) * (east - area.west)
        if abs(lat) < 84:
            yield f"EPSG:{found.code}", float(lat), float((lon + 180) % 360 - 180)


@pytest.mark.parametrize("seed", SEEDS)
def test_any_projection(tmp_path, seed):
    """Heights lie in their place, cells have their true size, and north is true north."""
    read = 0
    drawn = systems(np.random.default_rng(seed))
    for _ in range(4 * SYSTEMS):
        crs, lat, lon = next(drawn)
        land, file = Land(lat, lon), tmp_path / "land.tif"
        if not write(file, land, crs, unit="m"):
            continue
        check(load(file), land, crs)
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
    near = 1.5 if terrain.crs.startswith("EPSG:") else 40.0
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
    is_exact = re.search("WGS|World Geodetic|NAD83|ETRS|European Terr", str(pyproj.CRS(crs).datum))
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


def path_of(terrain, land, legs, above):
    """Return the local metres of a path by metres east and north of the land's place.

    Its inner points lie ``above`` the altitude of its ends.
    """
    lon, lat, _ = GEODESICS.fwd(
        np.full(len(legs), land.lon),
        np.full(len(legs), land.lat),
        [np.degrees(np.arctan2(*leg)) for leg in legs],
        [np.hypot(*leg) for leg in legs],
    )
    x, y = terrain.to_local(lat, lon)
    altitude = [700.0, *[700.0 + above] * (len(legs) - 2), 700.0]
    return np.stack((x, y, altitude), axis=1)


SAME = {
    "alps": (46.5, 8.5, ["EPSG:4326", "EPSG:32632", "EPSG:3857", "EPSG:3035", "EPSG:32631",
                         "+proj=utm +zone=32 +datum=WGS84 +units=us-ft"]),
    "arctic": (80.0, 15.0, ["EPSG:4326", "EPSG:32633", "EPSG:3413", "EPSG:3995", "EPSG:3857",
                            "+proj=laea +lat_0=90 +lon_0=-40 +datum=WGS84"]),
    "antimeridian": (-17.0, 180.0, ["EPSG:4326", "EPSG:32760", "EPSG:32701", "EPSG:3832",
                                    "EPSG:3994", "+proj=eqc +lon_0=180 +datum=WGS84"]),
}  # fmt: skip


@pytest.mark.parametrize("name", SAME)
def test_the_same_land_in_six_projections(tmp_path, name):
    """The same path has the same verdict, and length and time within a thousandth."""
    lat, lon, crss = SAME[name]
    land = Land(lat, lon, wave_m=4000.0)
    legs = [(-1300, -900), (-300, 400), (600, -300), (1200, 1000)]
    found = {}
    for crs in crss:
        file = tmp_path / "land.tif"
        in_feet = "us-ft" in crs
        assert write(
            file, land, crs, cells=120, cell_m=40.0, unit_m=1200 / 3937 if in_feet else 1.0
        )
        terrain = load(file, stated=Stated("us-ft" if in_feet else None))
        for above in (0.0, -90.0):
            path = path_of(terrain, land, legs, above)
            problem = Problem(terrain, tuple(path[0]), tuple(path[-1]), wind=(5.0, -3.0))
            found[crs, above] = Evaluator(problem, threads=1).evaluate(path)
    for above, feasible in ((0.0, True), (-90.0, False)):
        terms = [found[crs, above] for crs in crss]
        assert {each.feasible for each in terms} == {feasible}
        for figure in ("length_m", "flight_time_s", "fuel_N"):
            values = np.array([getattr(each, figure) for each in terms])
            assert np.ptp(values) < 1e-3 * values.mean(), (above, figure, values)
