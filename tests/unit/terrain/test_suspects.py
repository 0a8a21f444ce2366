"""One number amid land that lies higher, and whole numbers too steep for metres."""

from pathlib import Path

import numpy as np
import pytest
import rasterio
from affine import Affine

from pathgene.host.errors import InputError
from pathgene.host.terrain import load, names
from pathgene.host.terrain.stated import Stated


TILES = sorted((Path(__file__).parents[4] / "shared" / "terrain").glob("*.tif"))


@pytest.fixture
def land(write_tif):
    """Function that writes rolling land of 160 m and more, with zeros at some nodes."""

    def write(zeros=(), *, lowest=160.0, side_m=30.0, dtype=np.int16, **profile):
        row, column = np.indices((60, 80))
        heights = lowest + 40 * (2 + np.sin(row / 9) + np.cos(column / 7))
        for block in zeros:
            heights[block] = 0
        place = Affine(side_m, 0, 500_000, 0, -side_m, 5_100_000)
        return write_tif(np.rint(heights).astype(dtype), place, **profile)

    return write


def warning_of(file, **options):
    texts = load(file, **options).reading.warnings
    assert len(texts) <= 1
    return texts[0] if texts else None


@pytest.mark.parametrize("dtype", [np.int16, np.float32])
@pytest.mark.parametrize("side_m", [1.0, 30.0, 90.0, 100.0])
def test_zeros_amid_land(land, side_m, dtype):
    file = land([np.s_[20:30, 10:25], np.s_[0:2, 70:80]], side_m=side_m, dtype=dtype)
    text = warning_of(file)
    assert text.startswith("170 cells hold 0 amid heights of ")
    assert text.endswith(
        " m north of the south-west node; this looks like voids without a mark: give --void 0 if "
        "so, or --void none if it is ground."
    )
    assert side_m != 30.0 or " m and more, the first 2100 m east and 1770 m north of " in text
    named = load(file, stated=Stated(void=0))
    assert named.voids.sum() == 170
    assert not named.reading.warnings
    assert load(file, stated=Stated(void="none")).lowest == 0
    assert warning_of(file, stated=Stated(void="none")) is None


def test_one_zero(land):
    assert warning_of(land([np.s_[20, 30]])).startswith("1 cell holds 0 amid heights of ")


def test_zeros_of_another_number(land):
    """The number in the file counts, not the height that an offset makes of it."""
    file = land([np.s_[20:30, 10:25]])
    with rasterio.open(file, "r+") as made:
        made.offsets = (50.0,)
    assert warning_of(file).startswith("150 cells hold 0 amid heights of ")
    named = load(file, stated=Stated(void=0))
    assert named.voids.sum() == 150


def test_a_declared_zero(land):
    assert warning_of(land([np.s_[20:30, 10:25]], nodata=0)) is None


def test_arrays(tmp_path):
    heights = np.full((40, 40), 300.0) + np.arange(40)
    heights[10:14, 10:14] = 0
    np.save(tmp_path / "a.npy", heights)
    np.savez(tmp_path / "a.npz", elevation=heights, dx_m=30.0, dy_m=30.0)
    np.savez(
        tmp_path / "b.npz", elevation=heights, dx_m=30.0, dy_m=30.0, crs="EPSG:32632",
        origin=(5e5, 5e6),
    )  # fmt: skip
    for name, options in (("a.npy", {"cell": (30, 30)}), ("a.npz", {}), ("b.npz", {})):
        assert warning_of(tmp_path / name, **options).startswith("16 cells hold 0 amid heights of ")
        assert load(tmp_path / name, stated=Stated(void=0), **options).voids.sum() == 16


@pytest.mark.parametrize("slope", [0.02, 0.3, 1.0])
def test_a_coast_is_no_void(write_tif, slope):
    """The land begins at the water, gently or steeply."""
    x = np.arange(80) * 30.0
    heights = np.maximum(0, slope * (x - 1_200)) + np.zeros((60, 1))
    assert warning_of(write_tif(np.rint(heights).astype(np.int16))) is None


def test_embedded_land_is_not_suspected():
    assert [text for name in names() for text in load(name).reading.warnings] == []


@pytest.mark.parametrize("file", TILES, ids=lambda file: file.stem)
@pytest.mark.parametrize(("factor", "unit"), [(1, "m"), (10, "dm"), (100, "cm")])
def test_real_tiles(write_tif, file, factor, unit):
    """Real land in metres is not suspected; in decimetres without a scale it is."""
    with rasterio.open(file) as opened:
        heights = opened.read(1, masked=True)
        place, crs = opened.transform, opened.crs
    numbers = np.rint(heights.filled(0).astype(float) * factor).astype(np.int32)
    numbers[np.ma.getmaskarray(heights)] = -(2**31)
    made = write_tif(numbers, place, crs, nodata=-(2**31))
    if factor == 100:
        # Nearly all land is then higher than any mountain.
        stated = load(made, stated=Stated("cm"))
        np.testing.assert_allclose(stated.elevation, load(file).elevation, atol=0.2)
        return
    assert warning_of(made, stated=Stated(unit)) is None
    if factor == 1:
        assert warning_of(made) is None
        return
    with pytest.raises(InputError, match=r"state the unit of the heights \(--height-unit m\|dm"):
        load(made)


def test_hills_in_decimetres(write_tif):
    """Land below 900 m has numbers that are also heights in metres."""
    hills = load("jacksboro")
    heights = np.rint((hills.elevation[::-1] - 240) * 10).astype(np.int16)
    place = Affine(hills.dx_m, 0, 500_000, 0, -hills.dy_m, 4_000_000)
    assert warning_of(write_tif(heights, place, "EPSG:32616")) == (
        "More than a quarter of the slopes between neighbouring cells are steeper than 45 degrees, "
        "as on no land; the whole numbers look like decimetres, centimetres or feet: state their "
        "unit (--height-unit m|dm|cm|ft|us-ft)."
    )
    stated = load(write_tif(heights, place, "EPSG:32616"), stated=Stated("dm"))
    np.testing.assert_allclose(stated.elevation, hills.elevation - 240, atol=0.051)


def test_a_scale_or_a_unit_is_believed(write_tif):
    rng = np.random.default_rng(1)
    heights = rng.integers(0, 2_000, (40, 40)).astype(np.int16)
    assert "steeper than 45 degrees" in warning_of(write_tif(heights))
    assert warning_of(write_tif(heights, unit="m")) is None
    assert warning_of(write_tif(heights.astype(np.float32) + 0.5)) is None
    file = write_tif(heights)
    with rasterio.open(file, "r+") as made:
        made.scales = (0.99,)
    assert warning_of(file) is None


def test_buildings_in_fine_cells_are_steep(write_tif):
    heights = np.random.default_rng(1).integers(0, 2, (60, 60)).astype(np.int16) * 30
    place = Affine(1, 0, 500_000, 0, -1, 5_100_000)
    assert warning_of(write_tif(heights, place)) is None


@pytest.mark.parametrize("value", [-1, -99, -499, 1, 10])
@pytest.mark.parametrize("dtype", [np.int16, np.float32])
def test_another_number_amid_land(land, write_tif, value, dtype):
    """Raised to the water, or left as a pit, each would be ground that is not there."""
    file = land(lowest=500.0, dtype=dtype)
    with rasterio.open(file, "r+") as made:
        heights = made.read(1)
        heights[20:30, 10:25] = value
        made.write(heights, 1)
    text = load(file).reading.warnings[0]
    assert text.startswith(f"150 cells hold {value} amid heights of 5")
    assert text.endswith(f"give --void {value} if so, or --void none if it is ground.")
    named = load(file, stated=Stated(void=value))
    assert named.voids.sum() == 150
    assert not named.reading.warnings


def test_two_numbers_amid_land(land):
    file = land([np.s_[20:30, 10:25]], lowest=500.0)
    with rasterio.open(file, "r+") as made:
        heights = made.read(1)
        heights[40:44, 10:25] = -1
        made.write(heights, 1)
    assert [text.split(" amid")[0] for text in load(file).reading.warnings] == [
        "60 cells hold -1",
        "150 cells hold 0",
    ]


@pytest.mark.parametrize("file", TILES, ids=lambda file: file.stem)
@pytest.mark.parametrize("every", [2, 4, 8, 16, 32])
def test_coarse_tiles(write_tif, file, every):
    """No pit of coarse cells is a void; a number that is planted in them is."""
    with rasterio.open(file) as opened:
        heights = np.rint(opened.read(1, masked=True)[::every, ::every].filled(-32768))
        place, crs = opened.transform @ Affine.scale(every), opened.crs
    heights = heights.astype(np.int16)
    assert warning_of(write_tif(heights, place, crs, nodata=-32768)) is None


def test_a_lake_is_no_void(write_tif):
    """A lake is one number, but the land rises from it."""
    row, column = np.indices((60, 80))
    far = np.hypot(row - 30, column - 40)
    heights = np.rint(500 + 20 * np.maximum(0, far - 10)).astype(np.int16)
    assert (heights == 500).sum() > 300
    assert warning_of(write_tif(heights)) is None


def test_embedded_land_as_a_file(write_tif):
    for name in names():
        land = load(name)
        heights = np.rint(land.elevation[::-1]).astype(np.int16)
        place = Affine(land.dx_m, 0, 500_000, 0, -land.dy_m, 4_000_000)
        assert warning_of(write_tif(heights, place, unit="m")) is None, name
