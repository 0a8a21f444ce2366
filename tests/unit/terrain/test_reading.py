"""The facts that are read from a terrain."""

import json
import warnings

import numpy as np
import pyproj
import pytest
from rasterio import Affine

import pathgene
from pathgene.host.errors import InputError
from pathgene.host.terrain import info, load
from tests.support.host.earth import true_sides
from tests.support.host.lands import Land, write


HEIGHTS = np.add.outer(np.arange(20.0), np.arange(30.0)) + 100


def test_all_facts_of_a_file(write_tif):
    heights = HEIGHTS.copy()
    heights[0, 0] = -9999
    file = write_tif(heights, Affine(30, 0, 700_000, 0, -30, 5_100_000), unit="m", nodata=-1)
    read = load(file).reading.to_dict()
    assert json.loads(json.dumps(read)) == read
    assert (read["source"], read["driver"], read["nodes"]) == (str(file), "GTiff", [20, 30])
    assert read["projection"]["file"] == read["projection"]["frame"] == "EPSG:32632"
    assert read["projection"]["is_warped"] is False
    sides = true_sides("EPSG:32632", 700_450, 5_099_700, 30, 30)
    assert read["cell_m"]["used"] == pytest.approx(sides, abs=1e-3)
    for name, (x, y) in {"sw": (15, 585), "ne": (885, 15)}.items():
        sides = true_sides("EPSG:32632", 700_000 + x, 5_100_000 - y, 30, 30)
        assert read["cell_m"][name] == pytest.approx(sides, abs=1e-3)
    to_wgs84 = pyproj.Transformer.from_crs("EPSG:32632", "EPSG:4326", always_xy=True)
    turned = pyproj.Proj("EPSG:32632").get_factors(*to_wgs84.transform(700_450, 5_099_700))
    # PROJ counts the convergence of meridians from the grid.
    assert abs(read["grid_north_deg"]) == pytest.approx(abs(turned.meridian_convergence), abs=1e-3)
    assert read["grid_north_deg"] > 1.5
    assert read["heights"] == {
        "unit": "m", "unit_from": "file", "datum": "mean sea level", "datum_from": "assumed",
        "lowest_m": 101.0, "highest_m": 148.0, "lowest_in_file_m": 101.0, "share_below_0": 0.0,
    }  # fmt: skip
    assert read["voids"] == {
        "nodes": 1, "share": round(1 / 600, 4), "declared": -1.0,
        "marks": [{"value": -9999.0, "cells": 1}], "named": None, "are_filled": False,
    }  # fmt: skip
    assert [each["grade"] for each in read["remarks"]] == ["warning", "note", "note"]


def test_a_map_that_is_warped_says_why(tmp_path):
    land = Land(60.0, 10.0)
    assert write(tmp_path / "a.tif", land, "EPSG:3857")
    assert write(tmp_path / "b.tif", land, "EPSG:3413")
    assert write(tmp_path / "c.tif", Land(60.0, -100.0), "EPSG:3413")
    maps = [load(tmp_path / name).reading for name in ("a.tif", "b.tif", "c.tif")]
    (mercator,), *polar = ([each.text for each in read.remarks] for read in maps)
    assert mercator.startswith("The map is warped from EPSG:3857 to a local frame, because its ")
    assert all("its north lies 55 degrees off true north" in text for (text,) in polar)
    assert not any(f"{read.facts['grid_north_deg']:g}" == "-0" for read in maps)


def test_embedded_and_made_terrains_have_facts():
    read = load("jacksboro").reading.facts
    assert read["grid_north_deg"] == pytest.approx(1.63, abs=0.01)
    assert read["cell_m"]["middle"] == pytest.approx(read["cell_m"]["used"], abs=1e-3)
    assert load("canyon").reading.facts["projection"] is None
    made = pathgene.Terrain.from_array(HEIGHTS, 30.0)
    assert made.reading.facts["nodes"] == [20, 30]
    assert info(made)["read"]["remarks"] == []


@pytest.mark.parametrize(
    ("crs", "origin", "said"),
    [
        ("EPSG:3857", (0.0, 8_399_737.0), "a metre of EPSG:3857 is 0.50"),
        ("EPSG:3395", (0.0, 8_362_698.0), "a metre of EPSG:3395 is 0.50"),
        ("EPSG:3857", (0.0, 0.0), "a metre of EPSG:3857 is 1.0000 m on the ground to the east and"),
        ("EPSG:32631", (1_400_000.0, 7_000_000.0), "a metre of EPSG:32631 is 0.990"),
        ("EPSG:5936", (2_000_000.0, 4_000_000.0), "a metre of EPSG:5936 is 0.98"),
        ("EPSG:32661", (3_050_000.0, 2_000_000.0), "north of EPSG:32661 lies 90 degrees off true "),
    ],
)
def test_an_array_in_a_frame_of_false_metres_is_refused(crs, origin, said):
    with pytest.raises(InputError) as caught:
        pathgene.Terrain.from_array(HEIGHTS, 30.0, crs=crs, origin=origin)
    message = str(caught.value)
    assert message.startswith(f"terrain: {said}")
    assert message.endswith(
        "; give an array in a UTM zone, or load the map from a file, which is warped."
    )


def test_an_array_has_cells_of_their_true_size():
    origin = (700_000.0, 5_100_000.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = pathgene.Terrain.from_array(HEIGHTS, 30.0, crs="EPSG:32632", origin=origin)
    sides = true_sides("EPSG:32632", 700_435, 5_100_285, 30, 30)
    assert (made.dx_m, made.dy_m) == pytest.approx(sides, rel=1e-7)
    assert (made.on_paper.dx_m, made.on_paper.dy_m) == (30.0, 30.0)
    north_east = pyproj.Transformer.from_crs("EPSG:32632", "EPSG:4326").transform(
        700_000 + 29 * 30, 5_100_000 + 19 * 30
    )
    assert made.to_geographic(made.width_m, made.height_m) == pytest.approx(north_east, abs=1e-9)
