"""Rasters that hold no heights: they are refused if they say so, and a warning if they look so."""

import numpy as np
import pytest
import rasterio
from rasterio.enums import ColorInterp

from pathgene.host.errors import InputError
from pathgene.host.terrain import load, names
from pathgene.host.terrain.stated import Stated


LAND = 100 + np.add.outer(np.arange(20.0), np.arange(30.0))
METRES = Stated(height_unit="m")
REMEDY = "state the unit if they are heights (--height-unit m|dm|cm|ft|us-ft)."


def directions(heights, cell_m=30.0):
    north, east = np.gradient(heights, cell_m)
    return (np.degrees(np.arctan2(east, north)) % 360).astype(np.float32)


@pytest.mark.parametrize(
    ("description", "tags", "word"),
    [
        ("Hillshade", {}, "hillshade"),
        ("hill-shading", {}, "hill-shading"),
        ("Slope (degrees)", {}, "slope"),
        (None, {"long_name": "terrain aspect"}, "aspect"),
        (None, {"DESCRIPTION": "shaded_relief"}, "shaded_relief"),
        ("NDVI", {}, "ndvi"),
        ("Canopy height", {}, "canopy height"),
        ("vertical error", {}, "error"),
    ],
)
def test_a_band_that_is_described_as_something_else_is_refused(write_tif, description, tags, word):
    file = write_tif(LAND)
    with rasterio.open(file, "r+") as made:
        if description:
            made.set_band_description(1, description)
        made.update_tags(1, **tags)
    text = f"so it holds no heights but {word}; give the heights, or {REMEDY}"
    with pytest.raises(InputError) as error:
        load(file)
    assert str(error.value).endswith(text)
    assert load(file, stated=METRES).highest == LAND.max()


@pytest.mark.parametrize("unit", ["degree", "Degrees", "°", "percent", "radians"])
def test_a_unit_of_angles_is_refused(write_tif, unit):
    file = write_tif(LAND, unit=unit)
    with pytest.raises(InputError, match="as for slopes or directions, not for heights; give the"):
        load(file)


def test_colours_of_a_palette_are_refused(write_tif):
    file = write_tif(LAND.astype(np.uint8))
    with rasterio.open(file, "r+") as made:
        made.write_colormap(1, {0: (0, 0, 0, 255), 1: (255, 255, 255, 255)})
        made.colorinterp = (ColorInterp.palette,)
    with pytest.raises(InputError, match="its numbers are colours of a palette, not heights; give"):
        load(file)
    assert load(file, stated=METRES).highest == LAND.max()


@pytest.mark.parametrize(
    "description", ["Elevation of the slope", "DEM", "Height (aspect free)", "Gray", "Band 1"]
)
def test_heights_that_mention_slopes_are_heights(write_tif, description):
    file = write_tif(LAND)
    with rasterio.open(file, "r+") as made:
        made.set_band_description(1, description)
        made.update_tags(TITLE="North Slope DTM")
    assert load(file).reading.warnings == ()


def warning(reason):
    return (f"The terrain may hold no heights: {reason}; give the heights, or {REMEDY}",)


def test_a_name_or_a_title_of_something_else_is_a_warning(write_tif):
    file = write_tif(LAND)
    other = file.rename(file.with_name("tile_7-slope.tif"))
    reason = "its name, 'tile_7-slope', does not sound like heights"
    assert load(other).reading.warnings == warning(reason)
    assert load(other, stated=METRES).reading.warnings == ()
    file = other.rename(file)
    with rasterio.open(file, "r+") as made:
        made.update_tags(TIFFTAG_IMAGEDESCRIPTION="Relief, shaded relief of the Alps")
    reason = "its description, 'Relief, shaded relief of the Alps', does not sound like heights"
    assert load(file).reading.warnings == warning(reason)


def test_bytes_without_a_unit_are_a_warning(write_tif):
    reason = "its numbers are bytes, as in a picture such as a hillshade"
    file = write_tif(LAND.astype(np.uint8))
    assert load(file).reading.warnings == warning(reason)
    assert load(file, stated=METRES).reading.warnings == ()
    assert load(write_tif(LAND.astype(np.uint8), unit="m")).reading.warnings == ()
    with rasterio.open(file, "r+") as made:
        made.units = ("",)
        made.scales = (10.0,)
    assert load(file).reading.warnings == ()
    assert load(write_tif(LAND.astype(np.int16))).reading.warnings == ()


def test_directions_are_a_warning_and_land_is_not(write_tif):
    reason = "its numbers are directions of 0 to 360 degrees, as of slopes"
    for name in names()[:2]:
        heights = load(name).elevation[::5, ::5]
        aspect = directions(heights)
        assert load(write_tif(aspect)).reading.warnings[:1] == warning(reason)
        aspect[3:5, 3:5] = -9999
        assert reason in load(write_tif(aspect, nodata=-9999)).reading.warnings[0]
        low = ((heights - heights.min()) * (360 / np.ptp(heights))).astype(np.float32)
        assert warning(reason)[0] not in load(write_tif(low)).reading.warnings


def test_numbers_between_0_and_1_are_a_warning(write_tif):
    shares = ((LAND - LAND.min()) / np.ptp(LAND)).astype(np.float32)
    reason = "all its numbers are between 0 and 1, as shares or kilometres"
    assert load(write_tif(shares)).reading.warnings == warning(reason)
    assert load(write_tif(shares), stated=METRES).reading.warnings == ()
    shares[:2] = -9999
    assert load(write_tif(shares, nodata=-9999)).reading.warnings == warning(reason)
    shares[:2] = 0.5
    assert load(write_tif(2 * shares)).reading.warnings == ()


def test_a_band_of_depths_or_above_the_ellipsoid_is_a_warning(write_tif):
    for description, sign, end, stated in (
        ("Depth (m)", 1, "so depths count as heights; change their sign in the file.", METRES),
        ("Ellipsoidal height", 1, "(--heights sea-level|ellipsoidal).", METRES),
        ("Depth (m)", -1, "", METRES),
        ("Ellipsoidal height", 1, "", Stated(heights="sea-level")),
    ):
        file = write_tif(sign * LAND)
        with rasterio.open(file, "r+") as made:
            made.set_band_description(1, description)
        said = [text for text in load(file, stated=stated).reading.warnings if "described" in text]
        assert len(said) == bool(end)
        assert all(text.endswith(end) for text in said)
