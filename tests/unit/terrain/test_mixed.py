"""Marks of voids that resampling has mixed into the heights beside them."""

from pathlib import Path

import numpy as np
import pytest
import rasterio
from affine import Affine

from pathgene.host.errors import InputError
from pathgene.host.terrain import load, names
from pathgene.host.terrain.stated import Stated


TILES = sorted((Path(__file__).parents[4] / "shared" / "terrain").glob("*.tif"))
VOID = np.s_[20:30, 10:25]


def ground(mean=500.0):
    row, column = np.indices((60, 80))
    return mean + 20 * (np.sin(row / 9) + np.cos(column / 7))


def refusal(file, **options):
    with pytest.raises(InputError) as caught:
        load(file, **options)
    return str(caught.value)


def mixed(mark, share, *, heights=None, void=VOID):
    """Return land with a void of ``mark``, and a share of the mark in all cells around it."""
    heights = ground() if heights is None else heights
    rows, columns = void
    around = np.s_[rows.start - 1 : rows.stop + 1, columns.start - 1 : columns.stop + 1]
    heights[around] = (1 - share) * heights[around] + share * mark
    heights[void] = mark
    return heights.astype(np.float32)


@pytest.mark.parametrize(
    ("mark", "share", "where"),
    [
        (-9999.0, 0.03, "below"),
        (-9999.0, 0.09, "below"),
        (-32767.0, 0.01, "below"),
        (-32767.0, 0.02, "below"),
        (0.0, 0.3, "below"),
        (-99.0, 0.5, "below"),
        (9999.0, 0.03, "above"),
        (32767.0, 0.01, "above"),
    ],
)
def test_a_declared_mark(write_tif, mark, share, where):
    file = write_tif(mixed(mark, share), nodata=mark)
    assert refusal(file) == (
        f"made: resampling has mixed a mark of voids into 54 heights: they lie beside voids, 100 m "
        f"and more {where} all ground farther away, the first 270 m east and 1200 m north of the "
        f"south-west node; resample again from the original with gdalwarp -srcnodata {mark:g}, or "
        "accept all numbers as heights (--void none)."
    )
    assert load(file, stated=Stated(void="none")).voids.sum() == 150


def test_a_mark_that_is_found(write_tif):
    assert "-srcnodata -9999, or accept" in refusal(write_tif(mixed(-9999.0, 0.03)))
    assert "-srcnodata -7, or accept" in refusal(
        write_tif(mixed(-7.0, 0.4)), stated=Stated(void=-7.0)
    )


def test_one_side(write_tif):
    heights = ground()
    heights[20:30, 9] = 0.97 * heights[20:30, 9] - 0.03 * 9999
    heights[VOID] = -9999
    text = refusal(write_tif(heights.astype(np.float32), nodata=-9999))
    assert "into 10 heights" in text


# After a cubic or Lanczos filter, few cells hold a small mark itself.
FILTERS = [("bilinear", 0.0), ("bilinear", -99.0), ("average", 0.0), ("average", -99.0)] + [
    (name, mark)
    for name in ("bilinear", "cubic", "lanczos", "average")
    for mark in (-9999.0, -32768.0)
]


@pytest.mark.parametrize(("resampling", "mark"), FILTERS)
@pytest.mark.parametrize("side_m", [11.0, 21.0, 44.0])
def test_gdal_itself(write_tif, resampling, side_m, mark):
    """A void that is declared after resampling, and not before."""
    from rasterio.warp import Resampling, reproject

    heights = ground()
    heights[VOID] = mark
    place = Affine(30, 0, 500_000, 0, -30, 5_100_000)
    made = np.zeros((int(1700 / side_m), int(2300 / side_m)), np.float32)
    target = Affine(side_m, 0, 500_047, 0, -side_m, 5_099_961)
    reproject(
        heights.astype(np.float32), made, src_transform=place, dst_transform=target,
        src_crs="EPSG:32632", dst_crs="EPSG:32632", resampling=Resampling[resampling],
    )  # fmt: skip
    assert "resampling has " in refusal(write_tif(made, target, nodata=mark))
    if mark < -1000:
        assert "-srcnodata " in refusal(write_tif(made, target))


@pytest.mark.parametrize("file", TILES, ids=lambda file: file.stem)
@pytest.mark.parametrize("every", [1, 4, 16])
@pytest.mark.parametrize("cut", ["as it is", "steepest", "lowest", "highest"])
def test_real_land_beside_voids(write_tif, file, every, cut):
    """Voids in shadows of mountains, over water and at random are beside ordinary ground."""
    with rasterio.open(file) as opened:
        heights = opened.read(1, masked=True)[::every, ::every].astype(float).filled(np.nan)
        place, crs = opened.transform @ Affine.scale(every), opened.crs
    steep = np.hypot(*np.gradient(heights))
    if cut == "steepest":
        heights[steep > np.nanquantile(steep, 0.97)] = np.nan
    elif cut != "as it is":
        sign = 1 if cut == "lowest" else -1
        heights[sign * heights < np.nanquantile(sign * heights, 0.1)] = np.nan
    load(write_tif(heights, place, crs, unit="m"))


def test_embedded_land_with_voids(write_tif):
    for name in names():
        land = load(name)
        heights = land.elevation[::-1].copy()
        heights[heights <= np.quantile(heights, 0.05)] = np.nan
        place = Affine(land.dx_m, 0, 500_000, 0, -land.dy_m, 4_000_000)
        load(write_tif(heights, place, unit="m"))


@pytest.mark.parametrize("bank", [0, 1, 2])
@pytest.mark.parametrize("rows", [np.s_[0:60], np.s_[15:45]])
def test_a_river_in_a_canyon(write_tif, bank, rows):
    """Walls of 300 m stand a cell beside the water; the canyon continues, also off the map."""
    heights = ground() + 300
    heights[:, 40 - bank : 44 + bank] = 450.0
    heights[rows, 40:44] = np.nan
    assert load(write_tif(heights, unit="m")).voids.any()


@pytest.mark.parametrize("foot", [0, 1, 2])
def test_a_void_below_a_cliff(write_tif, foot):
    heights = ground()
    heights[:, 40:] += 300
    heights[20:40, 36 - foot : 40 - foot] = np.nan
    assert load(write_tif(heights, unit="m")).voids.any()
