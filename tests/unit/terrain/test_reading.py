"""The facts that are read from a terrain."""

import json
import warnings

import numpy as np
import pyproj
import pytest
from rasterio import Affine

import pathgene
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
        "marks": [{"value": -9999.0, "cells": 1}], "are_filled": False,
    }  # fmt: skip
    assert [each["grade"] for each in read["remarks"]] == ["warning", "note", "note"]


def test_a_map_that_is_warped_says_why(tmp_path):
    land = Land(60.0, 10.0)
    assert write(tmp_path / "a.tif", land, "EPSG:3857")
    assert write(tmp_path / "b.tif", land, "EPSG:3413")
    (mercator,), (polar,) = (
        [each.text for each in load(tmp_path / name).reading.remarks] for name in ("a.tif", "b.tif")
    )
    assert mercator.startswith("The map is warped from EPSG:3857 to a local frame, because its ")
    assert "north lies 55 degrees off true north" in polar


def test_embedded_and_made_terrains_have_facts():
    read = load("jacksboro").reading.facts
    assert read["grid_north_deg"] == pytest.approx(1.63, abs=0.01)
    assert read["cell_m"]["middle"] == pytest.approx(read["cell_m"]["used"], abs=1e-3)
    assert load("canyon").reading.facts["projection"] is None
    made = pathgene.Terrain.from_array(HEIGHTS, 30.0)
    assert made.reading.facts["nodes"] == [20, 30]
    assert info(made)["read"]["remarks"] == []


def test_an_array_in_a_frame_of_false_metres_is_warned_of():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = pathgene.Terrain.from_array(
            HEIGHTS, 30.0, crs="EPSG:3857", origin=(0.0, 8_399_737.0)
        )
        utm = pathgene.Terrain.from_array(HEIGHTS, 30.0, crs="EPSG:32632", origin=(5e5, 5e6))
    (text,) = made.reading.warnings
    assert text.startswith("A metre of the frame is 0.50")
    assert not utm.reading.warnings
