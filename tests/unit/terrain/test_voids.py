"""Marks of voids that a file does not declare: refused at every door, never taken for ground."""

import numpy as np
import pytest
import rasterio
import rasterio.shutil
from affine import Affine

import pathgene
from pathgene.host.errors import InputError
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain, load


MARKS = (-9999.0, -32767.0, -99999.0, -float(np.finfo(np.float32).max), 9999.0, 1e20, -500.5)
DEGREES = Affine(0.001, 0, 9, 0, -0.001, 46)


def ground(mark, *, node=(1, 2), dtype=np.float32):
    """Return 4 x 5 heights of 100 m with a mark at one node."""
    heights = np.full((4, 5), 100, dtype)
    heights[node] = mark
    return heights


def refusal(action):
    with pytest.raises(InputError) as caught:
        action()
    return str(caught.value)


@pytest.mark.parametrize("mark", MARKS)
def test_a_geotiff(write_tif, mark):
    text = repr(float(np.float32(mark))).removesuffix(".0")
    assert refusal(lambda: load(write_tif(ground(mark)))) == (
        "made: 1 of 20 heights lie outside -500 to 9,000 m; the first, 60 m east and 60 m north of "
        f"the south-west node, is {text} m, probably a void mark that is not declared, or no "
        f"height in metres: declare the mark (gdal_translate -a_nodata {text} IN.tif OUT.tif), "
        "or state the unit of the heights."
    )


@pytest.mark.parametrize("mark", MARKS)
def test_a_declared_mark_is_a_void(write_tif, mark):
    terrain = load(write_tif(ground(mark), nodata=mark))
    assert np.argwhere(terrain.voids).tolist() == [[2, 2]]
    assert terrain.lowest == terrain.highest == 100.0


@pytest.mark.parametrize("fill_voids", [False, True])
def test_before_warping_and_filling_mix_it_with_the_ground(write_tif, fill_voids):
    """No warped node has the pixel's own height, and filled ones have less of it."""
    heights = ground(-501.0)
    heights[3, 4] = np.nan
    message = refusal(lambda: load(write_tif(heights, DEGREES, "EPSG:4326"), fill_voids=fill_voids))
    assert "the first, at latitude 45.99850 and longitude 9.00250, is -501 m" in message


def test_feet_on_the_ground_are_metres_of_the_place(write_tif):
    message = refusal(lambda: load(write_tif(ground(-9999.0), crs="EPSG:2285")))
    assert "the first, 18.3 m east and 18.3 m north of the south-west node" in message


@pytest.mark.parametrize(("unit", "scale"), [("ft", 1.0), (None, 0.1)])
def test_the_remedy_names_the_number_of_the_file(write_tif, unit, scale):
    file = write_tif(ground(-9999, dtype=np.int16), unit=unit)
    if scale != 1.0:
        with rasterio.open(file, "r+") as made:
            made.scales = (scale,)
    assert "gdal_translate -a_nodata -9999 IN.tif" in refusal(lambda: load(file))


@pytest.mark.parametrize("mark", [-9999, -32767, 9999])
def test_an_hgt_and_a_usgs_dem(tmp_path, mark):
    heights = np.full((1201, 1201), 300, ">i2")
    heights[600, 300] = mark
    hgt = tmp_path / "N46E008.hgt"
    hgt.write_bytes(heights.tobytes())
    message = refusal(lambda: load(hgt))
    assert message.startswith("N46E008: 1 of 1,442,401 heights lie outside")
    assert f"the first, at latitude 46.50000 and longitude 8.25000, is {mark} m" in message
    if mark != -32767:  # The format's own mark, which GDAL declares.
        rasterio.shutil.copy(hgt, tmp_path / "tile.dem", driver="USGSDEM")
        assert f"is {mark} m" in refusal(lambda: load(tmp_path / "tile.dem"))


def test_a_dted(tmp_path):
    heights = np.full((1201, 1201), 300, ">i2")
    heights[600, 300:302] = -9999
    hgt = tmp_path / "N46E008.hgt"
    hgt.write_bytes(heights.tobytes())
    rasterio.shutil.copy(hgt, tmp_path / "tile.dt1", driver="DTED")
    message = refusal(lambda: load(tmp_path / "tile.dt1"))
    assert message.startswith("tile: 2 of 1,442,401 heights lie outside")


def test_an_ascii_grid(tmp_path):
    file = tmp_path / "grid.asc"
    head = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 50\n"
    file.write_text(f"{head}10 20 -9999\n40 50 60\n")
    assert "100 m east and 50 m north of the south-west node, is -9999 m" in refusal(
        lambda: load(file)
    )


def test_arrays(tmp_path):
    heights = ground(-9999.0)
    np.save(tmp_path / "made.npy", heights)
    np.savez(tmp_path / "made.npz", elevation=heights, dx_m=30, dy_m=20)
    doors = (
        lambda: load(tmp_path / "made.npy", cell=(30, 20)),
        lambda: load(tmp_path / "made.npz", fill_voids=True),
        lambda: pathgene.Terrain.from_array(heights, (30, 20)),
        lambda: Terrain("made", heights, 30, 20),
    )
    for door in doors:
        assert refusal(door).endswith(
            ": 1 of 20 heights lie outside -500 to 9,000 m; the first, 60 m east and 20 m north of "
            "the south-west node, is -9999 m, probably a void mark that is not declared, or no "
            "height in metres: write NaN where there is no height."
        )


def test_the_mark_of_srtm_is_a_void_in_every_array():
    for terrain in (
        Terrain("made", ground(-32768.0), 30, 20),
        pathgene.Terrain.from_array(ground(-32768.0), 30),
    ):
        assert np.argwhere(terrain.voids).tolist() == [[1, 2]]


def test_a_masked_node_is_a_void():
    heights = np.ma.masked_equal(ground(-9999.0), -9999.0)
    for terrain in (Terrain("made", heights, 30, 20), pathgene.Terrain.from_array(heights, 30)):
        assert np.argwhere(terrain.voids).tolist() == [[1, 2]]


def test_the_lowest_and_the_highest_ground_are_kept():
    heights = np.array([[-500.0, 9000.0], [0.0, 1.0]])
    assert Terrain("made", heights, 30, 20).elevation.tolist() == heights.tolist()


def test_a_zone_that_is_flown_over_may_reach_higher():
    terrain = Terrain("made", np.full((40, 40), 100.0), 30, 30)
    zone = Circle(600.0, 600.0, 100.0, upper_m=20_000.0)
    problem = Problem(terrain, (100.0, 100.0, 200.0), (1000.0, 1000.0, 200.0), zones=(zone,))
    assert problem.surface.highest > 20_000.0
    assert problem.surface.dx_m == 30.0
