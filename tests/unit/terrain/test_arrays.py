"""Files in numpy's formats: datums and units of heights, and statements that have no effect."""

import numpy as np
import pyproj
import pytest

from pathgene.host.errors import InputError
from pathgene.host.report.read import summary_terrain
from pathgene.host.terrain import load, names, vertical
from pathgene.host.terrain.stated import Stated
from tests.support.host.lands import write_geoid


HEIGHTS = np.add.outer(np.arange(20.0), np.arange(20.0)) + 400
PLACE = {"origin": (400_000.0, 5_000_000.0)}
ELLIPSOIDAL = Stated(heights="ellipsoidal")


def refusal(*arguments, **options):
    with pytest.raises(InputError) as caught:
        load(*arguments, **options)
    return str(caught.value)


@pytest.fixture
def npz(tmp_path):
    def write(**values):
        file = tmp_path / "grid.npz"
        np.savez(file, elevation=HEIGHTS, dx_m=30.0, dy_m=30.0, **values)
        return file

    return write


# Two ways of an .npz to state the ellipsoid, and the option.
WAYS = [
    ({"crs": "EPSG:32632", "datum": "ellipsoid"}, None),
    ({"crs": "EPSG:32632"}, ELLIPSOIDAL),
]


def on_wgs84_3d():
    """Return UTM with a third axis, as WKT."""
    return pyproj.CRS.from_epsg(32632).to_3d().to_wkt()


def test_heights_above_the_ellipsoid_are_refused_without_the_geoid(npz, monkeypatch):
    monkeypatch.setattr(vertical, "geoid_heights", lambda lon, lat: None)
    for values, named in (
        ({"crs": "EPSG:32632", "datum": "ellipsoid"}, "datum"),
        ({"crs": on_wgs84_3d()}, "WGS 84 / UTM zone 32N"),
    ):
        file = npz(**values, **PLACE)
        assert refusal(file) == (
            f"grid: its heights count from the ellipsoid ({named}), and PROJ has no grid of the "
            "geoid to turn them to heights above the sea: install us_nga_egm96_15.tif (pyproj sync "
            "--file us_nga_egm96_15), or accept altitudes above the ellipsoid in all files "
            "(--heights ellipsoidal)."
        )
        terrain = load(file, stated=ELLIPSOIDAL)
        assert terrain.reading.warnings[0].startswith("Heights and all altitudes count from the e")
        assert terrain.reading.facts["heights"]["datum"] == "ellipsoid"
        np.testing.assert_array_equal(terrain.elevation, HEIGHTS)
        at_sea = load(file, stated=Stated(heights="sea-level"))
        assert at_sea.reading.facts["heights"]["datum"] == "mean sea level"


def test_heights_are_turned_where_proj_has_the_geoid(npz, tmp_path):
    geoid = write_geoid(tmp_path / "us_nga_egm96_15.tif")
    before = pyproj.datadir.get_data_dir()
    pyproj.datadir.append_data_dir(str(tmp_path))
    try:
        for values, stated in (*WAYS, ({"crs": on_wgs84_3d()}, None)):
            terrain = load(npz(**values, **PLACE), stated=stated)
            lat, lon = terrain.to_geographic(*np.meshgrid([0.0, 300.0, 570.0], [0.0, 570.0]))
            rows, columns = np.meshgrid([0, 19], [0, 10, 19], indexing="ij")
            turned = HEIGHTS[rows, columns] - geoid(lon, lat)
            np.testing.assert_allclose(terrain.elevation[rows, columns], turned, atol=0.01)
            assert terrain.reading.facts["heights"]["datum"] == "EGM96 geoid"
            assert not terrain.reading.warnings
    finally:
        pyproj.datadir.set_data_dir(before)


def test_without_a_place_heights_cannot_be_turned(npz, tmp_path):
    file = npz(datum="ellipsoid")
    assert refusal(file) == (
        f"{file}: its heights count from the ellipsoid (datum), and without a place on Earth they "
        "cannot be turned to heights above the sea: write crs and origin as well, or accept "
        "altitudes above the ellipsoid in all files (--heights ellipsoidal)."
    )
    np.save(tmp_path / "a.npy", HEIGHTS)
    for terrain in (
        load(file, stated=ELLIPSOIDAL),
        load(tmp_path / "a.npy", cell=(30, 30), stated=ELLIPSOIDAL),
    ):
        (text,) = terrain.reading.warnings
        assert text.startswith("Heights and all altitudes count from the ellipsoid")


def test_the_grid_of_a_run_keeps_its_datum(npz, tmp_path):
    """Its heights are never turned; a summary accepts them, a user must."""
    file = npz(crs="EPSG:32632", datum="ellipsoid", nofly=np.zeros((20, 20), bool), **PLACE)
    file.rename(tmp_path / "terrain.npz")
    assert refusal(tmp_path / "terrain.npz").endswith("(--heights ellipsoidal).")
    stated = {"source": "gone.tif", "fill_voids": False, "cell_m": None, "heights": "ellipsoidal"}
    summary = {
        "terrain": stated,
        "read": {"terrain": {"heights": {"datum": "ellipsoid"}}},
    }
    terrain = summary_terrain(tmp_path / "summary.json", summary)
    np.testing.assert_array_equal(terrain.elevation, HEIGHTS)
    assert len(terrain.reading.warnings) == 1


def test_a_run_over_turned_heights_is_read_again(npz, tmp_path):
    """The option of the run does not concern its grid, whose heights are above the sea."""
    file = npz(crs="EPSG:32632", datum="EGM96 geoid", nofly=np.zeros((20, 20), bool), **PLACE)
    file.rename(tmp_path / "terrain.npz")
    stated = {"source": "gone.tif", "fill_voids": False, "cell_m": None, "height_unit": "ft"}
    summary = {
        "terrain": {**stated, "heights": "ellipsoidal"},
        "read": {"terrain": {"heights": {"datum": "EGM96 geoid"}}},
    }
    terrain = summary_terrain(tmp_path / "summary.json", summary)
    np.testing.assert_array_equal(terrain.elevation, HEIGHTS)
    assert terrain.reading.facts["heights"]["datum"] == "EGM96 geoid"


STATEMENTS = {
    "--height-unit": Stated(height_unit="ft"),
    "--heights": ELLIPSOIDAL,
    "--void": Stated(void=0),
}


@pytest.mark.parametrize("option", STATEMENTS)
def test_statements_without_an_effect_are_refused(npz, option):
    for name in names():
        assert refusal(name, stated=STATEMENTS[option]) == (
            f"The terrain {name!r} has heights above the sea, in metres, with voids marked; leave "
            f"out {option}."
        )
    file = npz(nofly=np.zeros((20, 20), bool))
    assert refusal(file, stated=STATEMENTS[option]) == (
        f"{file}: is the grid of a run with final heights, in metres, with voids marked; leave out "
        f"{option}."
    )


def test_the_water_level_has_an_effect_everywhere(npz):
    high = Stated(water_level=410.0)
    assert load(npz(nofly=np.zeros((20, 20), bool)), stated=high).lowest == 410
    assert load("jacksboro", stated=high).lowest == 410


def test_final_heights_are_not_checked_again(tmp_path):
    """A run with numbers that its user accepted is read as it was."""
    heights = HEIGHTS.copy()
    heights[3, 3], heights[9, 9] = -700.5, 4_321.5
    np.save(tmp_path / "a.npy", heights)
    with pytest.raises(InputError, match=r"accept all numbers as heights \(--void none\)\.$"):
        load(tmp_path / "a.npy", cell=(30, 30))
    terrain = load(tmp_path / "a.npy", cell=(30, 30), stated=Stated(void="none"))
    terrain.save_npz(tmp_path / "run.npz", terrain.voids)
    again = load(tmp_path / "run.npz")
    np.testing.assert_array_equal(again.elevation, heights)


@pytest.mark.parametrize(("unit", "unit_m"), [("cm", 0.01), ("dm", 0.1), ("ft", 0.3048)])
def test_heights_in_small_units(npz, tmp_path, unit, unit_m):
    """Numbers above 9,000 are heights in such a unit."""
    stated = Stated(height_unit=unit)
    tall = HEIGHTS / unit_m
    np.save(tmp_path / "a.npy", tall)
    np.savez(tmp_path / "a.npz", elevation=tall, dx_m=30.0, dy_m=30.0)
    np.savez(tmp_path / "b.npz", elevation=tall, dx_m=30.0, dy_m=30.0, crs="EPSG:32632", **PLACE)
    for terrain in (
        load(tmp_path / "a.npy", cell=(30, 30), stated=stated),
        load(tmp_path / "a.npz", stated=stated),
        load(tmp_path / "b.npz", stated=stated),
    ):
        np.testing.assert_allclose(terrain.elevation, HEIGHTS, rtol=1e-12)
        assert terrain.reading.facts["heights"]["unit"] == unit
