"""The level of the water: below it lies the bottom of the sea."""

import argparse

import numpy as np
import pytest

import pathgene
from pathgene.host.cli.values import source_of
from pathgene.host.errors import InputError
from pathgene.host.problem.problem import Problem
from pathgene.host.report.read import summary_terrain
from pathgene.host.terrain import Terrain, load
from pathgene.host.terrain.origin import at_origin
from pathgene.host.terrain.stated import Stated
from pathgene.host.terrain.water import under_water


HEIGHTS = np.tile(np.linspace(-90.0, 100.0, 20), (20, 1)).astype(np.float32)


@pytest.fixture
def coast(write_tif):
    return write_tif(HEIGHTS)


def test_the_sea_is_the_default(coast):
    terrain = load(coast)
    np.testing.assert_array_equal(terrain.elevation, np.maximum(HEIGHTS[::-1], 0))
    (text,) = terrain.reading.warnings
    assert text == (
        "180 heights lie below 0 m, down to -90 m, on 45.00% of the map, and are taken for water "
        "of that level; give --water-level none for land."
    )
    facts = terrain.reading.facts
    assert facts["water_level_m"] == 0.0
    assert facts["heights"]["share_below_0"] == 0.45
    assert (facts["heights"]["lowest_m"], facts["heights"]["lowest_in_file_m"]) == (0.0, -90.0)


def test_one_height(write_tif):
    heights = np.full((20, 20), 5.0)
    heights[3, 3] = -1.0
    (remark,) = [each for each in load(write_tif(heights)).reading.remarks if "below" in each.text]
    assert remark.text == (
        "1 height lies below 0 m, down to -1 m, on 0.25% of the map, and is taken for water of "
        "that level; give --water-level none for land."
    )


@pytest.mark.parametrize("level", [-45.0, 30])
def test_another_level(coast, level):
    terrain = load(coast, stated=Stated(water_level=level))
    np.testing.assert_array_equal(terrain.elevation, np.maximum(HEIGHTS[::-1], level))


def test_land_below_the_sea(coast):
    terrain = load(coast, stated=Stated(water_level="none"))
    np.testing.assert_array_equal(terrain.elevation, HEIGHTS[::-1])
    assert terrain.reading.facts["water_level_m"] is None
    assert not terrain.reading.warnings


def test_without_a_place_there_is_no_sea(tmp_path):
    np.save(tmp_path / "a.npy", HEIGHTS)
    terrain = load(tmp_path / "a.npy", cell=(30, 30))
    assert terrain.lowest == -90
    assert at_origin(terrain, 46.0, 8.0).lowest == 0
    land = load(tmp_path / "a.npy", cell=(30, 30), stated=Stated(water_level="none"))
    assert at_origin(land, 46.0, 8.0).lowest == -90
    assert load(tmp_path / "a.npy", cell=(30, 30), stated=Stated(water_level=-10)).lowest == -10


def test_the_grid_of_a_run_stays_as_it_is_at_its_origin(tmp_path):
    np.save(tmp_path / "a.npy", HEIGHTS)
    terrain = load(tmp_path / "a.npy", cell=(30, 30))
    terrain.save_npz(tmp_path / "terrain.npz", np.zeros(terrain.shape, bool))
    again = at_origin(load(tmp_path / "terrain.npz"), 46.0, 8.0)
    np.testing.assert_array_equal(again.elevation, HEIGHTS)


def test_the_papers_have_no_sea(coast):
    terrain = load(coast)
    ends = ((300.0, 300.0, 200.0), (400.0, 500.0, 200.0))
    paper = Problem(terrain, *ends, as_paper=True).terrain
    np.testing.assert_array_equal(paper.elevation, HEIGHTS[::-1])
    assert (paper.dx_m, paper.dy_m) == (30.0, 30.0)
    assert (paper.name, paper.loading) == (terrain.name, terrain.loading)
    assert Problem(terrain, *ends).terrain.lowest == 0


def test_a_run_keeps_its_ground(coast, tmp_path):
    """The grid of a run is read again as it was, below the sea and above it."""
    for level in (None, "none", 20.0):
        terrain = load(coast, stated=Stated(water_level=level))
        terrain.save_npz(tmp_path / "terrain.npz", np.zeros(terrain.shape, bool))
        again = load(tmp_path / "terrain.npz")
        np.testing.assert_array_equal(again.elevation, terrain.elevation)
        assert (again.dx_m, again.dy_m) == (terrain.dx_m, terrain.dy_m)
        assert again.to_geographic(100.0, 200.0) == terrain.to_geographic(100.0, 200.0)


def test_a_run_without_its_grid_is_read_with_its_water(coast, tmp_path):
    arguments = {"terrain": str(coast), "fill_voids": False, "cell": None, "water_level": "none"}
    stated = source_of(argparse.Namespace(**arguments))
    terrain = summary_terrain(tmp_path / "summary.json", {"terrain": stated})
    assert terrain.lowest == -90
    del stated["water_level"]
    assert summary_terrain(tmp_path / "summary.json", {"terrain": stated}).lowest == 0


def test_voids_stay_voids(write_tif):
    heights = HEIGHTS.copy()
    heights[5, 2] = np.nan
    assert np.argwhere(load(write_tif(heights)).voids[::-1]).tolist() == [[5, 2]]


def test_in_python(coast):
    assert pathgene.Terrain.load(coast).lowest == 0
    assert pathgene.Terrain.load(coast, water_level="none").lowest == -90
    assert pathgene.Terrain.load(coast, water_level=-50.0).lowest == -50
    with pytest.raises(InputError) as caught:
        pathgene.Terrain.load(coast, water_level="high")
    assert str(caught.value) == ("The water level must be a height in metres or none, not 'high'.")


def test_all_heights_are_kept_above_the_sea():
    """Nothing is copied if nothing changes."""
    terrain = Terrain("a", HEIGHTS + 200, 30, 30, "EPSG:32632", (5e5, 5e6))
    assert under_water(terrain, None).elevation is terrain.elevation
