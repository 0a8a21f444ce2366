"""Undeclared marks of voids: they are voids on every input path, and never taken for ground."""

import numpy as np
import pytest
import rasterio
import rasterio.shutil
from affine import Affine

import pathgene
from pathgene.host.errors import InputError
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain, load, names
from pathgene.host.terrain.stated import Stated


# Numbers that programs write for a void.
MARKS = (
    -9999.0, -32767.0, -99999.0, -3.4028234663852886e38, 9999.0, 32767.0, 65535.0, 1e20, -1e30,
    -999999.0, 2147483647.0, -9999.99,
)  # fmt: skip
DEGREES = Affine(0.001, 0, 9, 0, -0.001, 46)


def ground(mark, *, node=(1, 2), dtype=np.float32, shape=(4, 5)):
    """Return heights of 100 m and a little more with a mark at one node."""
    heights = np.add.outer(np.arange(shape[0]), np.arange(shape[1])).astype(dtype) + 100
    heights[node] = mark
    return heights


def sea_floor(rows, columns, lowest):
    """Return land of 100 m that falls evenly to ``lowest``."""
    return np.tile(np.linspace(100.0, lowest, columns), (rows, 1)).astype(np.float32)


def voids_of(terrain):
    return np.argwhere(terrain.voids[::-1]).tolist()


def warnings_of(terrain):
    return [text for text in terrain.reading.warnings if "mark" in text]


def refusal(action):
    with pytest.raises(InputError) as caught:
        action()
    return str(caught.value)


@pytest.mark.parametrize("mark", MARKS)
def test_a_mark_that_is_not_declared_is_a_void(write_tif, mark):
    terrain = load(write_tif(ground(mark)))
    assert voids_of(terrain) == [[1, 2]]
    assert (terrain.lowest, terrain.highest) == (100.0, 107.0)
    (text,) = warnings_of(terrain)
    assert text.startswith("1 cell holds ")
    (found,) = terrain.reading.facts["voids"]["marks"]
    assert found["cells"] == 1
    assert found["value"] == pytest.approx(mark, rel=1e-6)


@pytest.mark.parametrize("mark", [*MARKS, 8888.0, -500.5])
def test_a_declared_mark_is_a_void(write_tif, mark):
    terrain = load(write_tif(ground(mark), nodata=mark))
    assert voids_of(terrain) == [[1, 2]]
    assert terrain.reading.facts["voids"]["declared"] == pytest.approx(mark, rel=1e-6)
    assert not warnings_of(terrain)


@pytest.mark.parametrize("mark", [-2500.0, -777.0, 5000.0, 3333.0, 12345.0, 0.0])
def test_a_number_that_repeats_far_from_all_heights_is_a_void(write_tif, mark):
    base = 1500.0 if mark == 0 else 100.0
    heights = np.add.outer(np.arange(20.0), np.arange(20.0)).astype(np.float32) + base
    heights[3:6, 4:9] = heights[15, 15] = mark
    terrain = load(write_tif(heights))
    assert terrain.voids.sum() == 16
    assert terrain.lowest >= base


@pytest.mark.parametrize("value", [12345.6, -700.0, 9100.0])
def test_a_single_number_of_no_form_is_refused(write_tif, value):
    message = refusal(lambda: load(write_tif(ground(value))))
    text = repr(float(np.float32(value))).removesuffix(".0")
    assert message.startswith("made: 1 of 20 heights lies ")
    assert f"the first, 60 m east and 60 m north of the south-west node, is {text} m" in message
    assert f": name the mark (--void {text}), " in message
    is_possible = -11_000 <= value <= 9_000
    assert message.endswith(" accept all numbers as heights (--void none).") is is_possible


def test_heights_in_feet_are_refused(write_tif):
    heights = np.linspace(4_000, 14_000, 400, dtype=np.float32).reshape(20, 20)
    message = refusal(lambda: load(write_tif(heights)))
    assert message.startswith("made: 200 of 400 heights lie outside -11,000 to 9,000 m; the first")
    assert "or state the unit of the heights (--height-unit m|dm|cm|ft|us-ft)." in message


def test_a_mark_that_was_smeared_is_refused(write_tif):
    """Bilinear resampling leaves heights between the mark and the ground."""
    heights = np.random.default_rng(1).uniform(100, 200, (20, 20)).astype(np.float32)
    heights[5:10, 5:10] = -9999
    smeared = (heights[:-1, :-1] + heights[1:, :-1] + heights[:-1, 1:] + heights[1:, 1:]) / 4
    message = refusal(lambda: load(write_tif(smeared)))
    assert "heights lie below -500 m, with no slope to the ground around; the first" in message


@pytest.mark.parametrize("lowest", [-300.0, -900.0, -4000.0])
def test_a_sea_floor_that_joins_the_land_is_kept(write_tif, lowest):
    heights = sea_floor(10, 60, lowest)
    terrain = load(write_tif(heights))
    assert not terrain.voids.any()
    assert terrain.lowest == 0.0
    assert terrain.reading.facts["heights"]["lowest_in_file_m"] == lowest


def test_a_mark_in_a_sea_floor_is_found(write_tif):
    heights = sea_floor(20, 60, -4000.0)
    heights[8:12, 40:44] = -9999
    terrain = load(write_tif(heights))
    assert terrain.voids.sum() == 16
    assert terrain.reading.facts["heights"]["lowest_in_file_m"] == -4000.0


def test_only_sea_floor(write_tif):
    heights = np.linspace(-3000, -2500, 400, dtype=np.float32).reshape(20, 20)
    terrain = load(write_tif(heights))
    assert not terrain.voids.any()
    assert terrain.lowest == terrain.highest == 0.0


def test_two_marks(write_tif):
    heights = ground(-9999.0)
    heights[3, 3] = 32767
    assert voids_of(load(write_tif(heights))) == [[1, 2], [3, 3]]


def test_steep_ground_is_kept(write_tif):
    """Two walls of 70 degrees lie between a lake and a plateau, in cells of 30 m."""
    profile = np.concatenate((np.full(20, 200.0), 200 + 82.0 * np.arange(1, 25), np.full(16, 2168)))
    heights = np.tile(profile, (30, 1)).astype(np.float32)
    terrain = load(write_tif(heights))
    assert not terrain.voids.any()
    assert not terrain.reading.warnings


def test_outliers_are_refused(write_tif):
    heights = ground(4000.0, shape=(20, 20))
    heights[10, 10] = 4100.0
    assert refusal(lambda: load(write_tif(heights))) == (
        "made: 2 of 400 heights lie more than 1,000 m from all other heights, with no ground "
        "between; the first, 60 m east and 540 m north of the south-west node, is 4000 m, probably "
        "a void mark that is not declared, or no height in metres: name the mark (--void 4000), "
        "state the unit of the heights (--height-unit m|dm|cm|ft|us-ft), or accept all numbers as "
        "heights (--void none)."
    )
    accepted = load(write_tif(heights), stated=Stated(void="none"))
    assert not accepted.voids.any()
    assert accepted.highest == 4100.0
    named = load(write_tif(heights), stated=Stated(void=(4000.0, 4100.0)))
    assert voids_of(named) == [[1, 2], [10, 10]]
    assert not named.reading.warnings


@pytest.mark.parametrize("fill_voids", [False, True])
def test_before_warping_and_filling_mix_it_with_the_ground(write_tif, fill_voids):
    """Warped nodes do not have the pixel's exact height, and filled nodes even less."""
    heights = ground(-9999.0, shape=(12, 12), node=(5, 6))
    terrain = load(write_tif(heights, DEGREES, "EPSG:4326"), fill_voids=fill_voids)
    assert terrain.voids.any() is not np.bool_(fill_voids)
    assert terrain.lowest > 99
    message = refusal(lambda: load(write_tif(ground(-501.5), DEGREES, "EPSG:4326")))
    assert "the first, at latitude 45.99850 and longitude 9.00250, is -501.5 m" in message


def test_feet_on_the_ground_are_metres_of_the_place(write_tif):
    heights = ground(12345.0)
    message = refusal(lambda: load(write_tif(heights, crs="EPSG:2285", unit="m")))
    assert "the first, 18.3 m east and 18.3 m north of the south-west node" in message


@pytest.mark.parametrize(("unit", "scale"), [("ft", 1.0), (None, 0.1)])
def test_the_number_is_the_one_of_the_file(write_tif, unit, scale):
    for mark, is_void in ((-9999, True), (-31234, False)):
        file = write_tif(ground(mark, dtype=np.int16), unit=unit)
        if scale != 1.0:
            with rasterio.open(file, "r+") as made:
                made.scales = (scale,)
        if not is_void:
            with pytest.raises(InputError, match=r"name the mark \(--void -31234\)"):
                load(file)
            assert voids_of(load(file, stated=Stated(void=-31234))) == [[1, 2]]
            continue
        (found,) = load(file).reading.facts["voids"]["marks"]
        assert found == {"value": -9999.0, "cells": 1}


@pytest.mark.parametrize("mark", [-9999, -32767, 9999])
def test_an_hgt_and_a_usgs_dem(tmp_path, mark):
    heights = np.full((1201, 1201), 300, ">i2")
    heights[:, 0] = 301
    heights[600, 300] = mark
    hgt = tmp_path / "N46E008.hgt"
    hgt.write_bytes(heights.tobytes())
    rasterio.shutil.copy(hgt, tmp_path / "tile.dem", driver="USGSDEM")
    for file in (hgt, tmp_path / "tile.dem"):
        terrain = load(file)
        assert 1 <= terrain.voids.sum() <= 12
        assert terrain.lowest >= 300


def test_a_dted(tmp_path):
    heights = np.full((1201, 1201), 300, ">i2")
    heights[600, 300:302] = -9999
    hgt = tmp_path / "N46E008.hgt"
    hgt.write_bytes(heights.tobytes())
    rasterio.shutil.copy(hgt, tmp_path / "tile.dt1", driver="DTED")
    assert load(tmp_path / "tile.dt1").lowest == 300


def test_an_ascii_grid(tmp_path):
    file = tmp_path / "grid.asc"
    head = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 50\n"
    file.write_text(f"{head}10 20 -9999\n40 50 60\n")
    assert voids_of(load(file)) == [[0, 2]]


def test_arrays(tmp_path):
    heights = ground(-9999.0)
    np.save(tmp_path / "made.npy", heights)
    np.savez(tmp_path / "made.npz", elevation=heights, dx_m=30, dy_m=20)
    for terrain in (
        load(tmp_path / "made.npy", cell=(30, 20)),
        load(tmp_path / "made.npz"),
        pathgene.Terrain.from_array(heights, (30, 20)),
        Terrain("made", heights, 30, 20),
    ):
        assert np.argwhere(terrain.voids).tolist() == [[1, 2]]
        assert len(warnings_of(terrain)) == 1
    assert refusal(lambda: Terrain("made", ground(12345.0), 30, 20)) == (
        "made: 1 of 20 heights lies outside -11,000 to 9,000 m; the first, 60 m east and 20 m "
        "north of the south-west node, is 12345 m, probably a void mark that is not declared, or "
        "no height in metres: write NaN where there is no height."
    )


def test_an_array_of_towers_is_kept(tmp_path):
    """Numbers that ground can have are searched for only in files of other programs."""
    heights = np.zeros((20, 20))
    heights[0, 0], heights[5:8, 5:8] = 1.0, 3000.0
    assert not Terrain("made", heights, 30, 30).voids.any()
    assert not pathgene.Terrain.from_array(heights, 30).voids.any()
    pathgene.Terrain.from_array(heights, 30).save_npz(tmp_path / "own.npz", heights > 1e9)
    assert not load(tmp_path / "own.npz").voids.any()
    np.savez(tmp_path / "other.npz", elevation=heights, dx_m=30, dy_m=30)
    assert load(tmp_path / "other.npz").voids.sum() == 9


def test_the_mark_of_srtm_is_a_void_in_every_array(write_tif):
    for terrain in (
        Terrain("made", ground(-32768.0), 30, 20),
        pathgene.Terrain.from_array(ground(-32768.0), 30),
    ):
        assert np.argwhere(terrain.voids).tolist() == [[1, 2]]
    terrain = load(write_tif(ground(-32768.0), nodata=-1))
    assert terrain.reading.facts["voids"]["marks"] == [{"value": -32768.0, "cells": 1}]


def test_a_masked_node_is_a_void():
    heights = np.ma.masked_equal(ground(-9999.0), -9999.0)
    for terrain in (Terrain("made", heights, 30, 20), pathgene.Terrain.from_array(heights, 30)):
        assert np.argwhere(terrain.voids).tolist() == [[1, 2]]
        assert not terrain.reading.remarks


def test_nothing_but_marks(write_tif):
    heights = np.full((4, 5), -9999, np.float32)
    heights[0] = 9999
    assert "every node is void" in refusal(lambda: load(write_tif(heights)))


def test_the_lowest_and_the_highest_ground_are_kept():
    heights = np.array([[-500.0, 9000.0], [0.0, 1.0]])
    assert Terrain("made", heights, 30, 20).elevation.tolist() == heights.tolist()


@pytest.mark.parametrize("name", names())
def test_embedded_ground_has_no_marks(name):
    assert not load(name).reading.warnings


def test_a_zone_that_is_flown_over_may_reach_higher():
    terrain = Terrain("made", np.full((40, 40), 100.0), 30, 30)
    zone = Circle(600.0, 600.0, 100.0, upper_m=20_000.0)
    problem = Problem(terrain, (100.0, 100.0, 200.0), (1000.0, 1000.0, 200.0), zones=(zone,))
    assert problem.surface.highest > 20_000.0
    assert problem.surface.dx_m == 30.0
