"""Frames of true metres: the largest map that has one, maps near a pole, other bodies."""

import numpy as np
import pytest
from affine import Affine

import pathgene
from pathgene.host.errors import InputError
from pathgene.host.terrain import load
from tests.support.host.earth import apart_m, places


HEIGHTS = np.add.outer(np.arange(40.0), np.arange(40.0)) + 100


def refusal(action):
    with pytest.raises(InputError) as caught:
        action()
    return str(caught.value)


def square(write_tif, size_m, crs, x, y, cells=40):
    """Write a map of a square around a point."""
    side = size_m / cells
    heights = np.add.outer(np.arange(float(cells)), np.arange(float(cells))) + 100
    return write_tif(heights, Affine(side, 0, x - size_m / 2, 0, -side, y + size_m / 2), crs)


LARGE = [
    ("EPSG:32632", 500_000, 5_150_000),
    ("EPSG:3035", 4_321_000, 3_210_000),
    ("EPSG:3857", 1_000_000, 5_860_000),
    ("EPSG:32661", 2_000_000, 1_000_000),
]


@pytest.mark.parametrize(("crs", "x", "y"), LARGE)
@pytest.mark.parametrize("size_m", [20_000.0, 200_000.0, 380_000.0, 540_000.0])
def test_cells_have_their_true_size_over_large_maps(write_tif, crs, x, y, size_m):
    terrain = load(square(write_tif, size_m, crs, x, y))
    columns, rows = (np.arange(1, count - 1) for count in terrain.shape[::-1])
    column, row = (each.ravel() for each in np.meshgrid(columns[::5], rows[::5]))
    nodes = [
        np.stack(places(terrain, np.stack((x * terrain.dx_m, y * terrain.dy_m), axis=1)))
        for x, y in ((column, row), (column + 1, row), (column, row + 1))
    ]
    for other, side in ((nodes[1], terrain.dx_m), (nodes[2], terrain.dy_m)):
        lengths = apart_m(nodes[0], other)
        assert np.abs(lengths / side - 1).max() < 5.2e-4


def test_axes_that_are_not_at_right_angles(write_tif):
    """North-east of the centre of this projection both axes have one length, and an angle."""
    terrain = load(square(write_tif, 20_000, "EPSG:3035", 4_621_000, 3_510_000))
    (text,) = (each.text for each in terrain.reading.remarks)
    assert "to a local frame, because its axes are not at right angles; a metre of it is " in text
    ends = [
        (0, 0),
        (terrain.width_m, terrain.height_m),
        (terrain.width_m, 0),
        (0, terrain.height_m),
    ]
    lat, lon = places(terrain, ends)
    diagonals = [apart_m((lat[i], lon[i]), (lat[i + 1], lon[i + 1])) for i in (0, 2)]
    assert diagonals[0] == pytest.approx(diagonals[1], rel=1e-5)


@pytest.mark.parametrize(("crs", "x", "y"), LARGE[:2])
@pytest.mark.parametrize("size_m", [600_000.0, 900_000.0])
def test_larger_maps_are_refused(write_tif, crs, x, y, size_m):
    file = square(write_tif, size_m, crs, x, y)
    message = refusal(lambda: load(file))
    assert message.startswith("made: is ")
    assert message.endswith("; cut out the part you need, at most about 560 km from west to east.")


def test_a_long_map_from_south_to_north(write_tif):
    """A local frame is true along its meridian."""
    heights = np.zeros((100, 20)) + 100
    file = write_tif(heights, Affine(10_000, 0, 400_000, 0, -10_000, 5_800_000), "EPSG:32632")
    terrain = load(file)
    assert terrain.height_m > 900_000
    assert terrain.metric.is_metric


@pytest.mark.parametrize("lat", [79.5, 82.0, 84.5, -80.0])
def test_arctic_maps_in_degrees(write_tif, lat):
    terrain = load(write_tif(HEIGHTS, Affine(1 / 1200, 0, 15, 0, -1 / 1200, lat), "EPSG:4326"))
    assert terrain.metric.is_metric
    assert terrain.shape[0] < 13 * 40


@pytest.mark.parametrize(
    ("crs", "place", "polar"),
    [
        ("EPSG:4326", Affine(1 / 600, 0, 15, 0, -1 / 600, 90), "EPSG:32661"),
        ("EPSG:4326", Affine(1 / 600, 0, 15, 0, -1 / 600, 87.1), "EPSG:32661"),
        ("EPSG:4326", Affine(1 / 600, 0, 15, 0, -1 / 600, -88.9), "EPSG:32761"),
        ("EPSG:32662", Affine(200, 0, 0, 0, -200, 9_900_000), "EPSG:32661"),
    ],
)
def test_cells_that_a_pole_makes_narrow(write_tif, crs, place, polar):
    message = refusal(lambda: load(write_tif(np.full((600, 600), 100.0), place, crs)))
    assert message.startswith("made: its cells are ")
    assert message.endswith(
        " times as long as wide, so near the pole; warp it to square cells first (gdalwarp -r max "
        f"-t_srs {polar} IN.tif OUT.tif)."
    )


@pytest.mark.parametrize(
    ("crs", "x", "y"),
    [
        ("EPSG:3413", 0, 0),
        ("EPSG:32661", 2_000_000, 2_000_000),
        ("EPSG:3031", 0, 0),
        ("EPSG:3995", 300_000, -40_000),
    ],
)
def test_a_map_around_a_pole(write_tif, crs, x, y):
    terrain = load(square(write_tif, 12_000, crs, x, y))
    assert min(terrain.shape) >= 28
    assert not terrain.reading.warnings
    assert terrain.metric.is_metric
    lat, lon = places(terrain, [(0, 0), (terrain.width_m, terrain.height_m)])
    long = float(apart_m((lat[0], lon[0]), (lat[1], lon[1])))
    assert long == pytest.approx(np.hypot(terrain.width_m, terrain.height_m), rel=5e-4)


BODIES = [
    ("+proj=eqc +R=3396190 +units=m", "Mars", "3,396"),
    ("+proj=stere +lat_0=90 +R=1737400 +units=m", "the Moon", "1,737"),
    ("+proj=merc +R=25559000 +units=m", "another body", "25,559"),
]


@pytest.mark.parametrize(("crs", "body", "radius"), BODIES)
def test_maps_of_other_bodies(write_tif, tmp_path, crs, body, radius):
    file = write_tif(HEIGHTS, crs=crs)
    words = f" is of {body}, with a radius of {radius} km, and not of the Earth; "
    message = refusal(lambda: load(file))
    assert message.startswith(f"{file}: its reference system ")
    assert words in message
    np.savez(
        tmp_path / "a.npz", elevation=HEIGHTS, dx_m=30.0, dy_m=30.0, crs=crs, origin=(0.0, 0.0)
    )
    assert words in refusal(lambda: load(tmp_path / "a.npz"))
    assert words in refusal(
        lambda: pathgene.Terrain.from_array(HEIGHTS, 30.0, crs=crs, origin=(0.0, 0.0))
    )


def test_a_sphere_may_be_the_earth(write_tif):
    terrain = load(write_tif(HEIGHTS, crs="+proj=sinu +R=6371007.181 +units=m"))
    assert terrain.metric.is_metric


@pytest.mark.parametrize(
    ("crs", "system"),
    [
        ("EPSG:32632", "its reference system EPSG:32632"),
        ("+proj=tmerc +lat_0=0 +lon_0=9 +k=0.99 +x_0=500000 +datum=WGS84", "its reference system"),
    ],
)
def test_cells_of_degrees_in_a_projected_system(write_tif, crs, system):
    file = write_tif(HEIGHTS, Affine(0.0005, 0, 8.0, 0, -0.0005, 46.5), crs)
    assert refusal(lambda: load(file)) == (
        f"made: cells of 0.0005 x 0.0005 look like degrees, but {system} is projected; correct it "
        "(gdal_edit -a_srs EPSG:4326 FILE)."
    )


def test_a_kilometre_is_no_degree(write_tif):
    crs = "+proj=utm +zone=32 +datum=WGS84 +units=km"
    terrain = load(write_tif(HEIGHTS, Affine(0.03, 0, 500, 0, -0.03, 5_100), crs))
    assert terrain.dx_m == pytest.approx(30, rel=1e-3)


def test_a_system_without_a_name(write_tif):
    crs = "+proj=tmerc +lat_0=0 +lon_0=9 +k=0.999 +x_0=500000 +datum=WGS84"
    text = load(write_tif(HEIGHTS, crs=crs)).reading.remarks[0].text
    assert text.startswith("A metre of its reference system is 1.001")
