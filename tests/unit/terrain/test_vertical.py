"""Units and datums of heights."""

import numpy as np
import pyproj
import pytest
import rasterio

from pathgene.host.errors import InputError
from pathgene.host.formats.geojson import heights_datum
from pathgene.host.terrain import load, vertical
from pathgene.host.terrain.stated import Stated
from tests.support.host.lands import write_geoid


HEIGHTS = np.add.outer(np.arange(20.0), np.arange(20.0)) + 400
FEET = rasterio.Affine(100, 0, 1_740_000, 0, -100, 660_000)  # Tennessee, EPSG:2274.


def refusal(*arguments, **options):
    with pytest.raises(InputError) as caught:
        load(*arguments, **options)
    return str(caught.value)


def facts_of(terrain):
    return {key: terrain.reading.facts["heights"][key] for key in ("unit", "unit_from")}


def test_a_plane_in_feet_needs_a_unit(write_tif):
    file = write_tif(HEIGHTS, FEET, "EPSG:2274")
    assert refusal(file) == (
        f"{file}: its plane is in feet (US survey foot), and it states no unit of heights; state "
        "it (--height-unit m|ft|us-ft)."
    )
    for unit, unit_m in (("m", 1.0), ("ft", 0.3048), ("us-ft", 1200 / 3937)):
        terrain = load(file, stated=Stated(height_unit=unit))
        np.testing.assert_allclose(terrain.elevation, HEIGHTS[::-1] * unit_m, rtol=1e-14)
        assert facts_of(terrain) == {"unit": unit, "unit_from": "option"}


def described(file, description=None, **tags):
    with rasterio.open(file, "r+") as made:
        if description is not None:
            made.set_band_description(1, description)
        made.update_tags(**tags)
    return file


@pytest.mark.parametrize(
    ("description", "tags", "named"),
    [
        ("Elevation (ft)", {}, "Elevation (ft)"),
        ("height_feet", {}, "height_feet"),
        ("DTM, decimetres", {}, "DTM, decimetres"),
        (None, {"UNITS": "feet"}, "UNITS=feet"),
        (None, {"VERTICAL_UNITS": "cm"}, "VERTICAL_UNITS=cm"),
    ],
)
def test_a_described_unit_must_be_stated(write_tif, description, tags, named):
    file = described(write_tif(HEIGHTS), description, **tags)
    assert refusal(file) == (
        f"{file}: its heights are described as {named!r}, and it states no unit of heights; state "
        "it (--height-unit m|dm|cm|ft|us-ft)."
    )
    terrain = load(file, stated=Stated(height_unit="ft"))
    np.testing.assert_allclose(terrain.elevation, HEIGHTS[::-1] * 0.3048, rtol=1e-14)


@pytest.mark.parametrize(
    ("description", "tags"),
    [
        ("Elevation (m)", {"UNITS": "metres"}),
        ("soft ground of the aircraft", {}),
        (None, {"TIFFTAG_RESOLUTIONUNIT": "3 (pixels/cm)", "SOURCE": "feet"}),
    ],
)
def test_a_description_without_another_unit(write_tif, description, tags):
    assert facts_of(load(described(write_tif(HEIGHTS), description, **tags))) == {
        "unit": "m",
        "unit_from": "assumed",
    }


def test_a_stated_unit_or_a_scale_is_stronger_than_a_description(write_tif):
    file = described(write_tif(HEIGHTS, unit="m"), "Elevation (ft)")
    assert load(file).lowest == 400
    file = described(write_tif(HEIGHTS), "Elevation (dm)")
    with rasterio.open(file, "r+") as made:
        made.scales = (0.1,)
    assert load(file).lowest == pytest.approx(40)


def test_the_unit_of_the_user_is_stronger_than_that_of_the_file(write_tif):
    terrain = load(write_tif(HEIGHTS, unit="m"), stated=Stated(height_unit="ft"))
    assert terrain.lowest == pytest.approx(400 * 0.3048)


@pytest.mark.parametrize(
    ("unit", "description", "given", "source"),
    [
        ("ft", None, "m", "the band states 'ft'"),
        ("metre", None, "ft", "the band states 'metre'"),
        ("ft", None, "us-ft", "the band states 'ft'"),
        (None, "Elevation (ft)", "m", "the file says 'Elevation (ft)'"),
        (None, "heights in US feet", "m", "the file says 'heights in US feet'"),
        ("metre", None, "m", None),
        ("us_survey_foot", None, "us-ft", None),
        ("fathom", None, "m", None),
        (None, "Elevation (feet)", "ft", None),
        (None, None, "dm", None),
    ],
)
def test_a_unit_that_contradicts_the_file_is_a_warning(write_tif, unit, description, given, source):
    file = write_tif(HEIGHTS, unit=unit)
    with rasterio.open(file, "r+") as made:
        if description:
            made.set_band_description(1, description)
    assert load(file, stated=Stated(height_unit=given)).reading.warnings == (
        f"Heights are in {given}, as --height-unit states, but {source}; leave the option out, or "
        "correct it, if the file is right.",
    ) * bool(source)


def test_a_unit_that_contradicts_the_vertical_system_is_a_warning(write_tif):
    # Metres of UTM, and heights of NAVD88 in US survey feet.
    system = rasterio.crs.CRS.from_string("EPSG:26910+6360")
    file = write_tif(HEIGHTS, crs=system)
    (text,) = load(file, stated=Stated(height_unit="m")).reading.warnings
    assert "states 'US survey foot'; leave the option out" in text
    assert load(file, stated=Stated(height_unit="us-ft")).reading.warnings == ()
    # The file contradicts itself.
    file = write_tif(HEIGHTS, crs=system, unit="m")
    terrain = load(file)
    assert terrain.lowest == 400
    assert terrain.reading.warnings == (
        "Heights are in m, as the band states, but the reference system states 'US survey foot'; "
        "state the unit (--height-unit m|dm|cm|ft|us-ft).",
    )


def test_a_unit_that_is_not_stated_is_assumed(write_tif):
    assert facts_of(load(write_tif(HEIGHTS))) == {"unit": "m", "unit_from": "assumed"}
    assert facts_of(load(write_tif(HEIGHTS, unit="m"))) == {"unit": "m", "unit_from": "file"}


def test_numpy_files_take_the_unit_of_the_user(tmp_path):
    np.save(tmp_path / "a.npy", HEIGHTS)
    terrain = load(tmp_path / "a.npy", cell=(30, 30), stated=Stated(height_unit="ft"))
    assert terrain.lowest == pytest.approx(400 * 0.3048)
    assert facts_of(terrain) == {"unit": "ft", "unit_from": "option"}


def test_numpy_files_have_the_datum_that_the_user_states(tmp_path):
    np.save(tmp_path / "a.npy", HEIGHTS)
    np.savez(tmp_path / "a.npz", elevation=HEIGHTS, dx_m=30.0, dy_m=30.0)
    stated = Stated(heights="ellipsoidal")
    for terrain in (
        load(tmp_path / "a.npy", cell=(30, 30), stated=stated),
        load(tmp_path / "a.npz", stated=stated),
    ):
        assert heights_datum(terrain) == "above the ellipsoid WGS84, not AMSL"


def test_exports_name_the_datum(write_tif):
    terrain = load(write_tif(HEIGHTS, crs="EPSG:32632+5773"))
    assert heights_datum(terrain) == "AMSL (EGM96 height)"


def test_depths_count_downwards(write_tif):
    terrain = load(write_tif(-HEIGHTS, crs="EPSG:32632+5715"))
    np.testing.assert_array_equal(terrain.elevation, HEIGHTS[::-1])
    assert terrain.crs == "EPSG:32632"


@pytest.mark.parametrize("value", ["yard", 3])
def test_other_words(value):
    with pytest.raises(
        InputError, match=r"^The unit of heights must be m or dm or cm or ft or us-ft, not "
    ):
        Stated(height_unit=value)


class TestEllipsoid:
    PLACE = rasterio.Affine(0.0005, 0, 8.0, 0, -0.0005, 46.5)

    def test_is_refused_without_the_geoid(self, write_tif, monkeypatch, tmp_path):
        monkeypatch.setattr(vertical, "geoid_heights", lambda lon, lat: None)
        file = write_tif(HEIGHTS, self.PLACE, "EPSG:4979")
        assert refusal(file) == (
            "made: its heights count from the ellipsoid (WGS 84), and PROJ has no grid of the "
            "geoid to turn them to heights above the sea: install us_nga_egm96_15.tif (pyproj "
            "sync --file us_nga_egm96_15), or accept altitudes above the ellipsoid in all files "
            "(--heights ellipsoidal)."
        )
        terrain = load(file, stated=Stated(heights="ellipsoidal"))
        assert terrain.lowest == pytest.approx(400, abs=1)
        (text,) = terrain.reading.warnings
        assert text.startswith("Heights and all altitudes count from the ellipsoid, not from the ")
        assert terrain.reading.facts["heights"]["datum"] == "ellipsoid"
        terrain.save_npz(tmp_path / "grid.npz", terrain.voids)
        again = load(tmp_path / "grid.npz", stated=Stated(heights="ellipsoidal"))
        np.testing.assert_array_equal(again.elevation, terrain.elevation)
        assert again.reading.warnings == (text,)
        assert refusal(tmp_path / "grid.npz") == (
            f"{tmp_path / 'grid.npz'}: its heights count from the ellipsoid (datum), and as the "
            "grid of a run they are final: plan again over heights above the sea, or accept "
            "altitudes above the ellipsoid in all files (--heights ellipsoidal)."
        )
        for each in (terrain, again):
            assert heights_datum(each) == "above the ellipsoid WGS84, not AMSL"
        stated = load(file, stated=Stated(heights="sea-level"))
        assert stated.reading.facts["heights"]["datum"] == "mean sea level"

    def test_heights_are_turned_where_proj_has_the_geoid(self, write_tif, tmp_path):
        """A grid of our own making takes the place of EGM96; PROJ itself reads it."""
        geoid = write_geoid(tmp_path / "us_nga_egm96_15.tif")
        before = pyproj.datadir.get_data_dir()
        pyproj.datadir.append_data_dir(str(tmp_path))
        try:
            lon, lat = np.array([8.005]), np.array([46.495])
            assert vertical.geoid_heights(lon, lat) == pytest.approx(geoid(lon, lat), abs=0.01)
            terrain = load(write_tif(HEIGHTS, self.PLACE, "EPSG:4979"))
        finally:
            pyproj.datadir.set_data_dir(before)
        middle = terrain.width_m / 2, terrain.height_m / 2
        lat, lon = terrain.to_geographic(*middle)
        above = terrain.ground(*middle) + geoid(lon, lat)
        column, row = (lon - 8) / 0.0005 - 0.5, (46.5 - lat) / 0.0005 - 0.5
        assert above == pytest.approx(400 + column + row, abs=1.5)
        assert terrain.reading.facts["heights"]["datum"] == "EGM96 geoid"
