import json
import warnings
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pathgene.host.errors import InputError
from pathgene.host.terrain import Terrain, geodesy, info, load


HEIGHTS = np.array([[1.0, 2.0, 3.0], [4.0, np.nan, 6.0]])
UTM = Terrain("utm", HEIGHTS, 30, 20, "EPSG:32632", (500_000.0, 5_100_000.0), "made")
BARE = Terrain("bare", HEIGHTS, 30, 20)


def test_knows_its_shape_and_heights():
    assert UTM.shape == (2, 3)
    assert (UTM.width_m, UTM.height_m) == (60.0, 20.0)
    assert (UTM.lowest, UTM.highest) == (1.0, 6.0)
    assert UTM.voids.tolist() == [[False, False, False], [False, True, False]]


def test_keeps_a_read_only_copy():
    heights = np.arange(4, dtype=np.int16).reshape(2, 2)
    terrain = Terrain("t", heights, 1, 1)
    heights[0, 0] = 99
    assert terrain.elevation.dtype == np.float64
    assert terrain.elevation.tolist() == [[0.0, 1.0], [2.0, 3.0]]
    with pytest.raises(ValueError, match="read-only"):
        terrain.elevation[0, 0] = 1


def test_infinities_are_voids():
    terrain = Terrain("t", [[1.0, np.inf], [-np.inf, np.nan]], 1, 1)
    assert terrain.voids.tolist() == [[False, True], [True, True]]


@pytest.mark.parametrize(
    ("x", "y", "height"),
    [
        (0, 0, 1.0),
        (14.999, 9.999, 1.0),
        (15, 0, 2.0),
        (45, 0, 3.0),
        (0, 10, 4.0),
        (-1e9, -1e30, 1.0),
        (1e30, 1e9, 6.0),
        (60, 20, 6.0),
    ],
)
def test_ground_is_the_nearest_node(x, y, height):
    ground = UTM.ground(x, y)
    assert type(ground) is float
    assert ground == height


def test_ground_over_a_void_is_nan():
    assert np.isnan(UTM.ground(30, 20))


def test_ground_broadcasts():
    ground = UTM.ground(np.array([0.0, 30.0, 60.0]), np.array([[0.0], [20.0]]))
    np.testing.assert_array_equal(ground, HEIGHTS)


@given(
    st.tuples(st.integers(2, 6), st.integers(2, 6)),
    st.floats(0.1, 100),
    st.floats(0.1, 100),
    st.floats(-50, 700),
    st.floats(-50, 700),
)
def test_ground_matches_an_exhaustive_search(shape, dx_m, dy_m, x, y):
    terrain = Terrain("t", np.arange(shape[0] * shape[1]).reshape(shape), dx_m, dy_m)
    # The higher index of two equally near nodes comes last, and `<=` selects it.
    nearest = []
    for side, nodes, at in ((dy_m, shape[0], y), (dx_m, shape[1], x)):
        best = 0
        for index in range(nodes):
            if abs(index - at / side) <= abs(best - at / side):
                best = index
        nearest.append(best)
    assert terrain.ground(x, y) == nearest[0] * shape[1] + nearest[1]


@pytest.mark.parametrize(
    ("heights", "message"),
    [
        (np.zeros(4), "t: the heights must be a grid of rows and columns, but have 1 dimensions."),
        (
            np.zeros((2, 2, 2)),
            "t: the heights must be a grid of rows and columns, but have 3 dimensions.",
        ),
        (np.zeros((1, 5)), "t: a terrain needs at least 2 x 2 nodes, but this one has 1 x 5."),
        (np.zeros((0, 5)), "t: a terrain needs at least 2 x 2 nodes, but this one has 0 x 5."),
        (np.full((2, 2), np.nan), "t: every node is void; choose a terrain with heights."),
        (np.zeros((2, 2), complex), "t: the heights must be real numbers, but are complex128."),
        (np.array([["a", "b"]] * 2), "t: the heights must be real numbers, but are <U1."),
    ],
)
def test_refuses_bad_heights(heights, message):
    with pytest.raises(InputError) as error:
        Terrain("t", heights, 1, 1)
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("sides", "message"),
    [
        ((0, 1), "t: the sides of a cell must be positive metres, but dx_m is 0."),
        ((1, -2.5), "t: the sides of a cell must be positive metres, but dy_m is -2.5."),
        ((np.nan, 1), "t: the sides of a cell must be positive metres, but dx_m is nan."),
        ((1, np.inf), "t: the sides of a cell must be positive metres, but dy_m is inf."),
        (
            (1e308, 1),
            "t: 3 nodes at 1e+308 m are a map of inf m, and no map may be longer than 1e+09 m; "
            "give the sides of a cell in metres.",
        ),
        (
            (1, 2e9),
            "t: 2 nodes at 2e+09 m are a map of 2e+09 m, and no map may be longer than 1e+09 m; "
            "give the sides of a cell in metres.",
        ),
    ],
)
def test_refuses_bad_sides(sides, message):
    with pytest.raises(InputError) as error:
        Terrain("t", HEIGHTS, *sides)
    assert str(error.value) == message


def test_a_name_with_bytes_that_are_no_text_is_shown():
    assert Terrain("x\udcff", HEIGHTS, 1, 1).name == "x\\udcff"


def test_geographic_against_a_known_point():
    # On the central meridian of zone 32 the northing is 0.9996 of the meridian's length from the
    # equator, integrated here over the ellipsoid by the midpoint rule.
    lat, lon = UTM.to_geographic(0.0, 0.0)
    assert type(lat) is float
    assert lon == pytest.approx(9.0, abs=1e-9)
    squared = 0.0066943799901413165
    step = np.radians(lat) / 100_000
    middles = (np.arange(100_000) + 0.5) * step
    radii = 6_378_137 * (1 - squared) / (1 - squared * np.sin(middles) ** 2) ** 1.5
    meridian_m = radii.sum() * step
    assert 0.9996 * meridian_m == pytest.approx(5_100_000, abs=1e-3)


@given(st.floats(-50_000, 50_000), st.floats(-50_000, 50_000))
def test_geographic_round_trip(x, y):
    assert UTM.to_local(*UTM.to_geographic(x, y)) == pytest.approx((x, y), abs=1e-5)


def test_geographic_accepts_arrays():
    x, y = np.array([[0.0, 1000.0], [2000.0, 3000.0]]), np.array([[0.0], [500.0]])
    lat, lon = UTM.to_geographic(x, y)
    assert lat.shape == lon.shape == (2, 2)
    assert lat[1, 0] > lat[0, 0]
    assert lon[0, 1] > lon[0, 0]
    back = UTM.to_local(lat, lon)
    np.testing.assert_allclose(back[0], x, atol=1e-5)
    np.testing.assert_allclose(back[1], np.broadcast_to(y, (2, 2)), atol=1e-5)


def test_geographic_in_feet():
    # EPSG:2285 uses US survey feet of 1200/3937 m; the local frame is still in metres.
    feet = Terrain("feet", HEIGHTS, 30, 20, "EPSG:2285", (1_600_000.0, 200_000.0))
    south = feet.to_geographic(0.0, 0.0)
    north = feet.to_geographic(0.0, 1000.0)
    assert (north[0] - south[0]) * 111_170 == pytest.approx(1000, rel=2e-3)
    assert feet.to_local(*north) == pytest.approx((0.0, 1000.0), abs=1e-4)


NO_PLACE = (
    "The terrain 'bare' has no coordinate reference system, so latitude and longitude have "
    "no meaning on it; give local metres."
)


@pytest.mark.parametrize("method", ["to_local", "to_geographic"])
def test_refuses_places_without_a_crs(method):
    with pytest.raises(InputError) as error:
        getattr(BARE, method)(1.0, 2.0)
    assert str(error.value) == NO_PLACE


def test_refuses_a_latitude_beyond_a_pole():
    with pytest.raises(InputError) as error:
        UTM.to_local(-122.0, 46.0)
    assert str(error.value) == "A latitude must lie between -90 and 90 degrees, but one is -122."


def test_refuses_a_point_without_place():
    with pytest.raises(InputError) as error:
        UTM.to_geographic(1e12, 1e12)
    assert str(error.value) == (
        "A point cannot be placed in the terrain's coordinate reference system; check its "
        "coordinates, latitude before longitude."
    )


def test_warns_once_of_an_approximate_datum():
    geodesy._warn_if_approximate.cache_clear()
    nad27 = Terrain("nad27", HEIGHTS, 30, 30, "EPSG:26710", (558_060.0, 5_108_220.0))
    message = (
        "The exact shift between the datum 'North American Datum 1927' and WGS84 needs grid "
        "files that are not installed, so latitudes and longitudes may be some metres off."
    )
    with pytest.warns(UserWarning, match=f"^{message}$") as caught:
        place = nad27.to_geographic(0.0, 0.0)
    assert len(caught) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert nad27.to_local(*place) == pytest.approx((0.0, 0.0), abs=1e-3)


@pytest.mark.parametrize(
    "crs", ["EPSG:32632", "EPSG:25832", "EPSG:26910", "EPSG:2056", "EPSG:7845", "EPSG:2955"]
)
def test_accepts_datums_near_wgs84_without_warning(crs):
    geodesy._warn_if_approximate.cache_clear()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        geodesy._warn_if_approximate(crs)


@pytest.mark.parametrize("crs", ["EPSG:27700", "EPSG:31467", "EPSG:23032", "EPSG:21781"])
def test_warns_of_older_datums(crs):
    geodesy._warn_if_approximate.cache_clear()
    with pytest.warns(UserWarning, match=r"^The exact shift between the datum '.*' and WGS84 "):
        geodesy._warn_if_approximate(crs)


def test_npz_round_trip(tmp_path):
    file = tmp_path / "grid.data.npz"
    nofly = np.array([[True, False, False], [False, False, True]])
    UTM.save_npz(file, nofly)
    with np.load(file) as saved:
        assert sorted(saved) == [
            "crs", "dx_m", "dy_m", "elevation", "metres_per_unit", "nofly", "origin"
        ]  # fmt: skip
        assert saved["metres_per_unit"].tolist() == [1.0, 1.0]
        assert saved["nofly"].dtype == np.bool_
        np.testing.assert_array_equal(saved["nofly"], nofly)
    again = load(file)
    np.testing.assert_array_equal(again.elevation, UTM.elevation)
    assert (again.dx_m, again.dy_m) == (30.0, 20.0)
    assert (again.crs, again.origin) == (UTM.crs, UTM.origin)
    assert again.to_geographic(10.0, 10.0) == UTM.to_geographic(10.0, 10.0)


def test_only_heights_that_shrink_are_compressed(tmp_path):
    """A quarter of the rows decides as little as a flat edge."""
    rng = np.random.default_rng(5)
    noise = rng.uniform(100.0, 200.0, (200, 200))
    for heights, is_compressed in (
        (noise, False),
        (noise.round(), True),
        (np.vstack((noise[:50], noise[50:].round())), True),
        (np.vstack((np.zeros((50, 200)), noise[50:])), False),
    ):
        file = tmp_path / "grid.npz"
        terrain = Terrain("noise", heights, 30.0, 30.0)
        terrain.save_npz(file, np.zeros(heights.shape, dtype=bool))
        with zipfile.ZipFile(file) as archive:
            kind = archive.getinfo("elevation.npy").compress_type
        assert (kind == zipfile.ZIP_DEFLATED) == is_compressed
        assert np.array_equal(load(file).elevation, heights)


def test_npz_without_a_place(tmp_path):
    local = Terrain("local", [[1, 2], [3, 4]], 30, 20)
    local.save_npz(tmp_path / "t.npz", np.zeros((2, 2), bool))
    with np.load(tmp_path / "t.npz") as saved:
        assert sorted(saved) == ["dx_m", "dy_m", "elevation", "nofly"]
    again = load(tmp_path / "t.npz")
    assert (again.crs, again.origin) == (None, None)


def test_npz_refuses_another_shape(tmp_path):
    message = r"^No-fly raster must have the terrain's shape \(2, 3\), not \(3, 2\)$"
    with pytest.raises(ValueError, match=message):
        UTM.save_npz(tmp_path / "t.npz", np.zeros((3, 2), bool))
    assert not (tmp_path / "t.npz").exists()


def test_info_is_json():
    described = json.loads(json.dumps(info(UTM)))
    corners = described.pop("corners")
    assert described.pop("read")["nodes"] == [2, 3]
    assert described == {
        "name": "utm",
        "shape": [2, 3],
        "dx_m": 30.0,
        "dy_m": 20.0,
        "crs": "EPSG:32632",
        "origin": [500_000.0, 5_100_000.0],
        "width_m": 60.0,
        "height_m": 20.0,
        "elevation_m": {"min": 1.0, "max": 6.0, "mean": 3.2},
        "voids": 1,
        "void_share": 1 / 6,
        "source": "made",
    }
    assert list(corners) == ["sw", "se", "nw", "ne"]
    for point, at in zip(corners.values(), ((0, 0), (60, 0), (0, 20), (60, 20)), strict=True):
        assert point == pytest.approx(UTM.to_geographic(*map(float, at)), abs=1e-9)


def test_info_without_a_place():
    described = info(BARE)
    assert described["crs"] is described["origin"] is described["corners"] is None
