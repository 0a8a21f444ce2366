"""``pathgene plan`` from options to files."""

import json
import math
import os
import re
import subprocess
import sys

import numpy as np
import pytest
import rasterio

from pathgene.host.cli import main
from pathgene.host.report import style
from pathgene.host.terrain import load
from tests.support.host.processes import Started

from .conftest import (
    ENDS,
    FILES,
    ROOT,
    TERMS,
    WALL,
    assert_check_agrees,
    interrupted,
    plan,
    run_here,
    summary_in,
)


def test_writes_all_files(planned):
    out, done, summary = planned
    assert done.returncode == 0, done.stderr
    assert sorted(entry.name for entry in out.iterdir()) == FILES
    assert summary == summary_in(out)
    assert summary["feasible"]
    assert (summary["planner"], summary["board"], summary["seed"]) == ("ga-fpga", "model:", 1)
    assert (summary["generations"], summary["stopped_by"]) == (60, "generations")
    assert len(summary["history"]) == 61
    assert summary["hardware"]["generations"] == 60
    assert summary["terrain"]["shape"] == [41, 61]
    assert summary["nofly"] == [{"x": 3000.0, "y": 2000.0, "radius_m": 400.0}]
    assert done.stderr.splitlines()[-1].startswith("generation 60/60  best 1.")
    document = json.loads((out / "path.geojson").read_text())
    assert document["features"][0]["geometry"]["coordinates"] == summary["waypoints"]


def test_plans_on_the_chip_where_neither_planner_nor_board_is_named(hills, tmp_path, capsys):
    assert plan(hills, tmp_path, "--chip-ms", 2, "--seed", 1, "--no-picture") == 0
    summary = summary_in(tmp_path)
    assert (summary["planner"], summary["board"], summary["feasible"]) == (
        "ga-chip",
        "model:",
        True,
    )
    assert 2000 <= summary["hardware"]["plan_us"] < 2100
    assert_check_agrees(tmp_path, summary, capsys)


def test_check_agrees_with_the_summary(planned, hills):
    out, _, summary = planned
    by_summary = json.loads(run_here("check", "--path", out / "summary.json", "--json").stdout)
    by_geojson = json.loads(
        run_here(
            "check",
            "--terrain",
            hills,
            "--path",
            out / "path.geojson",
            "--nofly-circle",
            "3000,2000,400",
            "--json",
        ).stdout
    )
    terms = [*TERMS, "nofly", "ds_m", "uav", "wind"]
    for report in (by_summary, by_geojson):
        assert {name: report[name] for name in terms} == {name: summary[name] for name in terms}


def test_check_of_a_moved_summary_loads_its_source(planned, hills, tmp_path, capsys):
    _, _, summary = planned
    file = tmp_path / "summary.json"
    file.write_text(json.dumps(summary))
    assert main(["check", "--path", str(file), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["fitness"] == summary["fitness"]
    assert report["terrain"]["name"] == "hills"


def test_check_options_override_the_summary(planned, capsys):
    out, _, summary = planned
    arguments = [
        "check",
        "--path",
        str(out / "summary.json"),
        "--json",
        "--wind",
        "-3,2",
        "--uav",
        "silver-fox",
        "--ds",
        "40",
    ]
    assert main(arguments) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["wind"], report["ds_m"]) == ([-3.0, 2.0], 40.0)
    assert report["fuel_N"] != summary["fuel_N"]


def test_check_judges_a_path_as_paper_by_the_rules_if_told(tmp_path, capsys):
    out = tmp_path / "out"
    ends = ["--agl", "--start", "300,300,60", "--goal", "4700,4600,60"]
    command = ["plan", "--terrain", "canyon", *ends, "--as-paper", "--planner", "astar"]
    assert main([*command, "--no-picture", "--out", str(out)]) == 0
    for words, as_paper in (([], True), (["--as-paper"], True), (["--no-as-paper"], False)):
        capsys.readouterr()
        main(["check", "--path", str(out / "summary.json"), "--json", *words])
        assert json.loads(capsys.readouterr().out)["as_paper"] is as_paper


def test_check_of_a_csv_prints_a_report(hills, tmp_path, capsys):
    file = tmp_path / "path.csv"
    file.write_text("x,y,z\n500,500,600\n3000,3000,700\n5500,3500,600\n")
    assert main(["check", "--terrain", str(hills), "--path", str(file)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["feasible", "yes"]
    assert lines[-1].split()[:2] == ["waypoints", "3,"]


def test_check_names_the_nearest_limit_or_the_worst_broken_one_with_units(hills, tmp_path, capsys):
    file = tmp_path / "path.csv"
    for middle_m, status, start in (
        (700, 0, r"nearest limit +stall: 23 m/s, allowed 14\.23 m/s, "),
        (3000, 1, r"worst limit +climb: [\d.]+ m/s, allowed [\d.]+ m/s, "),
    ):
        file.write_text(f"x,y,z\n500,500,600\n3000,3000,{middle_m}\n5500,3500,600\n")
        assert main(["check", "--terrain", str(hills), "--path", str(file)]) == status
        lines = capsys.readouterr().out.splitlines()
        (limit,) = [line for line in lines if " limit " in line]
        assert re.fullmatch(start + r"[\d.]+ km from the start", limit)


def test_check_takes_ends_above_the_ground(hills, tmp_path, capsys):
    file = tmp_path / "path.csv"
    file.write_text("x,y,z\n500,500,600\n3000,3000,700\n5500,3500,600\n")
    common = ["check", "--terrain", str(hills), "--path", str(file), "--agl", "--start"]
    height = 600 - (300 + 150 * math.sin(5 / 8) * math.cos(5 / 6))
    assert main([*common, f"500,500,{height}"]) == 0
    assert main([*common, f"500,500,{height + 1}"]) == 2
    assert "The start of the path is (500.0, 500.0, 600.0), not" in capsys.readouterr().err
    height = 600 - (300 + 150 * math.sin(55 / 8) * math.cos(35 / 6))
    assert main([*common[:-1], "--goal", f"5500,3500,{height}"]) == 0


def test_check_of_a_path_that_is_not_feasible_exits_1(hills, tmp_path, capsys):
    file = tmp_path / "path.csv"
    file.write_text("x,y,z\n500,500,600\n3000,2000,700\n5500,3500,600\n")
    around = ["--nofly-circle", "3000,2000,400"]
    arguments = ["check", "--terrain", str(hills), "--path", str(file), *around]
    assert main([*arguments, "--json"]) == 1
    output = capsys.readouterr()
    report = json.loads(output.out)
    assert not report["feasible"]
    assert report["distance_in_nofly_m"] > 0
    assert output.err == (
        "pathgene: The path is not feasible; the report shows its distances and limits.\n"
    )


def test_no_grid_leaves_the_terrain_out(hills, tmp_path, capsys):
    options = ["--seed", "1", "--generations", "60", "--no-picture"]
    plan(hills, tmp_path, *options)
    assert "terrain.npz" in [entry.name for entry in tmp_path.iterdir()]
    plan(hills, tmp_path, *options, "--no-grid")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["path.geojson", "summary.json"]
    assert_check_agrees(tmp_path, summary_in(tmp_path), capsys)


def test_no_feasible_path_exits_1_with_files(hills, tmp_path, capsys):
    assert plan(hills, tmp_path, *WALL, "--generations", "3") == 1
    assert capsys.readouterr().err.splitlines()[-1] == (
        "pathgene: No way leads from the start to the goal at any altitude: the edge of the map, "
        "zone 1, zone 2, zone 3 and 8 more enclose the goal, and must open near (3000, 2000) m; "
        "the best path is written."
    )
    assert sorted(entry.name for entry in tmp_path.iterdir()) == FILES
    summary = summary_in(tmp_path)
    assert (summary["feasible"], summary["feasible_at_ds"]) == (False, False)
    assert summary["distance_in_nofly_m"] > 0
    reason = summary["reason"]
    assert (reason["code"], reason["proven"], reason["place"]) == ("closed", True, [3000, 2000])
    assert summary["fallback"] is None


def test_falls_back_to_astar(hills, tmp_path, capsys):
    blind = ["--planner", "fpa", "--waypoints", "6", "--generations", "1", "--population", "4"]
    blind += ["--nofly-circle", "4500,1000,800", "--nofly-circle", "1200,2000,500"]
    blind += ["--no-picture"]
    assert plan(hills, tmp_path, *blind) == 0
    assert capsys.readouterr().err.splitlines()[-1] == (
        "pathgene: fpa found no feasible path; the path was found by astar."
    )
    summary = summary_in(tmp_path)
    assert (summary["planner"], summary["fallback"]) == ("fpa", "astar")
    assert (summary["feasible"], summary["reason"]) == (True, None)
    assert summary["generations"] == 1
    assert plan(hills, tmp_path, *blind, "--fallback", "none") == 1
    summary = summary_in(tmp_path)
    assert (summary["feasible"], summary["fallback"]) == (False, None)
    assert (summary["reason"]["code"], summary["reason"]["proven"]) == ("not-found", False)
    assert (
        capsys.readouterr()
        .err.splitlines()[-1]
        .startswith(
            "pathgene: No path was found at this cell size (100 m), and no limit was found that "
        )
    )
    plan(hills, tmp_path, *blind, "--as-paper")
    assert summary_in(tmp_path)["fallback"] is None


def test_stop_criteria(hills, tmp_path, capsys):
    common = [
        "plan",
        "--terrain",
        str(hills),
        *ENDS,
        "--out",
        str(tmp_path),
        "--planner",
        "ga-fpga",
        "--generations",
        "100000",
        "--json",
        "--no-picture",
    ]
    assert main([*common, "--target-fitness", "1.01"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["stopped_by"] == "target-fitness"
    assert summary["history"][-1][1] >= 1.01
    assert main([*common, "--time-limit", "0.5"]) in (0, 1)
    summary = json.loads(capsys.readouterr().out)
    assert summary["stopped_by"] == "time-limit"
    assert 0.5 <= summary["seconds"]["total"] < 5


@pytest.mark.ci
@pytest.mark.parametrize(
    "planner",
    [
        "ga-chip",
        "ga-fpga",
        "ga-pc",
        *(
            pytest.param(name, marks=pytest.mark.ci)
            for name in ("fpa", "fpa-2opt", "ga-dp", "ga-auv")
        ),
    ],
)
def test_interrupt_writes_the_best_so_far(hills, tmp_path, planner):
    summary = interrupted(
        ["plan", "--terrain", hills, *ENDS, "--planner", planner, "--out", tmp_path],
        "generation 0/",
    )
    assert summary == summary_in(tmp_path)
    assert (summary["interrupted"], summary["stopped_by"]) == (True, "interrupt")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == FILES


def test_shows_a_progress_bar_on_a_terminal(hills, tmp_path):
    ours, theirs = os.openpty()
    command = [
        sys.executable,
        "-m",
        "pathgene",
        "plan",
        "--terrain",
        hills,
        *ENDS,
        "--generations",
        "5",
        "--no-picture",
        "--out",
        tmp_path,
    ]
    with Started(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=theirs):
        os.close(theirs)
        seen = b""
        while True:
            try:
                part = os.read(ours, 4096)
            except OSError:  # The terminal closes with the process.
                break
            if not part:
                break
            seen += part
    os.close(ours)
    assert re.search(rb"\r *\d+ % \|[^|]+\| generation \d/5  best \d\.\d+  mean \d\.\d+, ", seen)
    assert b"\rgeneration 5/5  best " in seen


def test_grid_beside_the_summary_is_the_evaluated_one(planned, hills):
    out, _, _ = planned
    with np.load(out / "terrain.npz") as grid, np.load(hills) as source:
        assert np.array_equal(grid["elevation"], source["elevation"], equal_nan=True)
        assert grid["nofly"][20, 30]
        assert grid["nofly"].sum() == 69  # Cells that meet the circle or its margin.


@pytest.fixture(scope="module")
def projected(hills, tmp_path_factory):
    """The hills as a GeoTIFF in UTM zone 32, without voids."""
    with np.load(hills) as grid:
        elevation = np.nan_to_num(grid["elevation"], nan=300.0)
    file = tmp_path_factory.mktemp("projected") / "hills.tif"
    with rasterio.open(
        file,
        "w",
        driver="GTiff",
        width=61,
        height=41,
        count=1,
        dtype="float64",
        crs="EPSG:32632",
        transform=rasterio.Affine(100, 0, 600_000, 0, -100, 5_100_000),
    ) as raster:
        raster.write(elevation[::-1], 1)
    return file


def test_geographic_ends_zones_and_path(projected, tmp_path, capsys):
    terrain = load(projected)
    (start, goal, zone) = (
        [float(value) for value in terrain.to_geographic(x, y)]
        for x, y in ((500, 500), (5500, 3500), (3000, 2000))
    )
    nofly = tmp_path / "zone.geojson"
    nofly.write_text(
        json.dumps(
            {
                "type": "Feature",
                "properties": {"radius_m": 400},
                "geometry": {"type": "Point", "coordinates": zone[::-1]},
            }
        )
    )
    out = tmp_path / "out"
    assert (
        main(
            [
                "plan",
                "--terrain",
                str(projected),
                "--start-geo",
                f"{start[0]},{start[1]},100",
                "--goal-geo",
                f"{goal[0]},{goal[1]},100",
                "--agl",
                "--nofly",
                str(nofly),
                "--generations",
                "60",
                "--out",
                str(out),
            ]
        )
        == 0
    )
    summary = summary_in(out)
    assert summary["terrain"]["crs"] == "EPSG:32632"
    assert np.array(summary["waypoints"])[[0, -1], :2] == pytest.approx(
        np.array([[500, 500], [5500, 3500]]), abs=1e-3
    )
    circle = summary["nofly"][0]
    assert (circle["x"], circle["y"]) == pytest.approx((3000, 2000), abs=1e-3)

    longitude, latitude, _ = json.loads((out / "path.geojson").read_text())["features"][0][
        "geometry"
    ]["coordinates"][0]
    assert (latitude, longitude) == pytest.approx(start, abs=1e-9)
    capsys.readouterr()
    assert (
        main(
            [
                "check",
                "--terrain",
                str(projected),
                "--path",
                str(out / "path.geojson"),
                "--nofly",
                str(nofly),
                "--json",
            ]
        )
        == 0
    )
    report = json.loads(capsys.readouterr().out)
    assert report["length_m"] == pytest.approx(summary["length_m"], abs=0.01)


def test_no_picture_does_not_import_matplotlib(hills, tmp_path, capsys, monkeypatch):
    (tmp_path / "path.png").write_bytes(b"of an earlier run")
    arguments = ["plan", "--terrain", str(hills), *ENDS, "--generations", "2", "--seed", "1"]
    script = (
        "import sys; from pathgene.host.cli import main; status = main(sys.argv[1:]); "
        "assert 'matplotlib' not in sys.modules; sys.exit(status)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, *arguments, "--no-picture", "--out", str(tmp_path)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    names = [name for name in FILES if name != "path.png"]
    assert sorted(entry.name for entry in tmp_path.iterdir()) == names
    assert "path.png" not in done.stdout
    with_picture = tmp_path / "with picture"
    printed = []

    def saved(*drawn, save=style.save):
        printed.append(capsys.readouterr().out)
        save(*drawn)

    monkeypatch.setattr(style, "save", saved)
    assert main([*arguments, "--out", str(with_picture)]) == 0
    # The result is there before the picture.
    (result,) = printed
    assert "fitness" in result
    assert capsys.readouterr().out == f"{'written':<17}  {with_picture / 'path.png'}\n"
    assert sorted(entry.name for entry in with_picture.iterdir()) == FILES
    one, other = summary_in(tmp_path), summary_in(with_picture)
    for summary in (one, other):
        del summary["seconds"]
    assert one == other
    for name in ("path.geojson", "terrain.npz"):
        assert (tmp_path / name).read_bytes() == (with_picture / name).read_bytes()
