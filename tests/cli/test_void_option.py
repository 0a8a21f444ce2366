"""``--void`` in every place that names a terrain: it marks numbers as voids, or keeps them."""

import json

import numpy as np
import pytest
import rasterio

from pathgene.host.cli import main


ENDS = ("--agl", "--start", "300,300,80", "--goal", "1400,1400,80")


@pytest.fixture
def tile(tmp_path):
    """A plain with numbers of no form in two nodes, which are refused without the option."""
    heights = np.add.outer(np.arange(60.0), np.arange(60.0)).astype("float32") + 100
    heights[30, 30], heights[5, 50] = -1234.5, 4321.5
    file = tmp_path / "tile.tif"
    with rasterio.open(
        file, "w", driver="GTiff", height=60, width=60, count=1, dtype="float32",
        crs="EPSG:32632", transform=rasterio.Affine(30, 0, 500_000, 0, -30, 5_100_000),
    ) as made:  # fmt: skip
        made.write(heights, 1)
    return file


def run(capsys, *arguments):
    status = main(list(map(str, arguments)))
    out, err = capsys.readouterr()
    return status, out, err


def voids_of(capsys, *arguments):
    status, out, _ = run(capsys, "terrain", "info", *arguments, "--json")
    assert status == 0
    return json.loads(out)["read"]["voids"]


def test_describing(tile, capsys):
    status, _, error = run(capsys, "terrain", "info", tile)
    assert status == 2
    assert "name the mark (--void -1234.5)" in error
    assert error.endswith("or accept all numbers as heights (--void none).\n")
    status, _, error = run(capsys, "terrain", "info", tile, "--void", "-1234.5")
    assert status == 2
    assert "the first, 1500 m east and 1620 m north" in error
    voids = voids_of(capsys, tile, "--void", "-1234.5,4321.5")
    assert voids["nodes"] == 2
    assert voids["named"] == [
        {"value": -1234.5, "cells": 1},
        {"value": 4321.5, "cells": 1},
    ]
    voids = voids_of(capsys, tile, "--void", "none")
    assert (voids["nodes"], voids["named"]) == (0, "none")
    _, out, _ = run(capsys, "terrain", "info", tile, "--void", "none")
    assert "All numbers from -11,000 to 9,000 m are taken as heights, as --void none states" in out


def test_a_plan_and_its_check(tile, tmp_path, capsys):
    """The run keeps the statement, in its summary and in its problem file."""
    out = tmp_path / "out"
    planning = ("--planner", "astar", "--out", out, "--no-grid", "--no-picture")
    status, _, error = run(capsys, "plan", "--terrain", tile, *ENDS, *planning)
    assert status == 2
    assert "(--void -1234.5)" in error
    void = ("--void", "-1234.5,4321.5")
    status, _, error = run(capsys, "plan", "--terrain", tile, *ENDS, *planning, *void)
    assert status == 0
    assert "1 cell holds -1234.5, a void as --void states." in error
    summary = json.loads((out / "summary.json").read_text())
    assert summary["terrain"]["void"] == [-1234.5, 4321.5]
    assert summary["read"]["terrain"]["voids"]["nodes"] == 2
    assert run(capsys, "check", "--path", out / "summary.json")[0] == 0
    assert run(capsys, "export", out / "summary.json", "--write", "plan", "--out", out)[0] == 0
    problem = tmp_path / "problem.toml"
    for text, expected in (("[-1234.5, 4321.5]", 0), ('"none"', 0), ("-1234.5", 2)):
        problem.write_text(
            f'[terrain]\nsource = "tile.tif"\nvoid = {text}\n[mission]\nagl = true\n'
            "start = [300, 300, 80]\ngoal = [1400, 1400, 80]\n"
        )
        assert run(capsys, "problem", "check", problem)[0] == expected
        assert run(capsys, "diagnose", problem)[0] == expected


@pytest.mark.parametrize("text", ["", "high", "1,,2", "nan", "none,3"])
def test_other_words(tile, capsys, text):
    status, _, error = run(capsys, "terrain", "info", tile, f"--void={text}")
    assert status == 2
    assert error == (
        "pathgene: Argument --void: must be numbers of the file, as in -9999,0, or none, not "
        f"{text!r}; see pathgene terrain info --help.\n"
    )


def test_a_number_that_no_cell_holds(tile, capsys):
    status, out, _ = run(capsys, "terrain", "info", tile, "--void", "-1234.5,4321.5,-9999")
    assert status == 0
    assert "No cell holds -9999, which --void names as a void." in out
