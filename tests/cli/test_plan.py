"""``pathgene plan`` from options to files."""

import json
import math
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import rasterio

from host.cli import main
from host.terrain import load

from .conftest import ENDS, ROOT


FILES = ["path.geojson", "path.png", "summary.json", "terrain.npz"]


def summary_in(out):
    return json.loads((out / "summary.json").read_text())


def test_plans_and_writes_everything(planned):
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


def test_check_agrees_with_the_summary(planned, pathgene, hills):
    out, _, summary = planned
    by_summary = json.loads(pathgene("check", "--path", out / "summary.json", "--json").stdout)
    by_geojson = json.loads(
        pathgene(
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
    terms = [
        "fitness",
        "penalty",
        "cost",
        "length_m",
        "mean_altitude_m",
        "fuel_N",
        "feasible",
        "feasible_at_ds",
        "minimum_clearance_m",
        "impossible_arcs",
        "waypoints",
        "nofly",
        "ds_m",
        "uav",
        "wind",
    ]
    for report in (by_summary, by_geojson):
        assert {name: report[name] for name in terms} == {name: summary[name] for name in terms}


def test_check_of_a_moved_summary_loads_the_source(planned, hills, tmp_path, capsys):
    _, _, summary = planned
    file = tmp_path / "summary.json"
    file.write_text(json.dumps(summary))
    assert main(["check", "--path", str(file), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["fitness"] == summary["fitness"]
    assert report["terrain"]["name"] == "hills"


def test_check_options_come_before_the_summary(planned, capsys):
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


def test_check_of_a_csv_in_words(hills, tmp_path, capsys):
    file = tmp_path / "path.csv"
    file.write_text("x,y,z\n500,500,600\n3000,3000,700\n5500,3500,600\n")
    assert main(["check", "--terrain", str(hills), "--path", str(file)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["feasible", "yes"]
    assert lines[-1].split()[:2] == ["waypoints", "3,"]


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


def test_same_seed_same_path_in_every_link_mode(planned, hills, tmp_path, capsys):
    _, _, summary = planned
    for mode in ("population", "recipe"):
        assert (
            main(
                [
                    "plan",
                    "--terrain",
                    str(hills),
                    *ENDS,
                    "--generations",
                    "60",
                    "--seed",
                    "1",
                    "--out",
                    str(tmp_path / mode),
                    "--link-mode",
                    mode,
                ]
            )
            == 0
        )
        other = summary_in(tmp_path / mode)
        assert other["waypoints"] == summary["waypoints"]
        assert other["history"] == summary["history"]
        assert other["hardware"]["link_mode"] == mode
    assert "fitness" in capsys.readouterr().out


def test_collisions_counted_by_the_board(hills, tmp_path, capsys):
    assert (
        main(
            [
                "plan",
                "--terrain",
                str(hills),
                *ENDS,
                "--generations",
                "40",
                "--seed",
                "1",
                "--feasibility",
                "board",
                "--out",
                str(tmp_path),
            ]
        )
        == 0
    )
    summary, said = summary_in(tmp_path), capsys.readouterr().out
    counted = summary["hardware"]["feasibility"]
    assert 0 < counted["evaluated_in_full"] < counted["counted_on_board"] == 128 + 40 * 22
    assert f"{counted['counted_on_board']} paths" in said
    assert main(["check", "--path", str(tmp_path / "summary.json"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["fitness"] == summary["fitness"]


def test_baseline_and_an_option_it_does_not_know(hills, tmp_path, capsys):
    assert (
        main(
            [
                "plan",
                "--terrain",
                str(hills),
                *ENDS,
                "--planner",
                "ga-pc",
                "--generations",
                "40",
                "--board",
                "sim:",
                "--out",
                str(tmp_path),
            ]
        )
        == 0
    )
    output = capsys.readouterr()
    assert output.err.splitlines()[0] == (
        "pathgene: --board means nothing to ga-pc and is ignored."
    )
    summary = summary_in(tmp_path)
    assert (summary["board"], summary["hardware"]) == (None, None)
    assert "board              none" in output.out


def test_grid_search_and_what_check_says_of_it(hills, tmp_path, capsys):
    assert (
        main(
            [
                "plan",
                "--terrain",
                str(hills),
                *ENDS,
                "--planner",
                "astar",
                "--max-waypoints",
                "9",
                "--out",
                str(tmp_path),
                "--json",
            ]
        )
        == 0
    )
    output = capsys.readouterr()
    assert output.err.splitlines()[-1].startswith("generation 4/8  best 1.")
    summary = json.loads(output.out)
    assert (summary["planner"], summary["generations"]) == ("astar", 4)
    assert len(summary["waypoints"]) <= 11
    assert main(["check", "--path", str(tmp_path / "summary.json"), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    terms = ("fitness", "penalty", "cost", "length_m", "mean_altitude_m", "fuel_N", "feasible")
    assert {name: report[name] for name in terms} == {name: summary[name] for name in terms}


# A wall of no-fly zones from edge to edge.
WALL = [part for y in range(0, 4001, 400) for part in ("--nofly-circle", f"3000,{y},300")]


def test_grid_search_without_a_way_is_status_1_with_files(hills, tmp_path, capsys):
    assert (
        main(
            [
                "plan",
                "--terrain",
                str(hills),
                *ENDS,
                *WALL,
                "--planner",
                "astar",
                "--out",
                str(tmp_path),
            ]
        )
        == 1
    )
    assert (
        capsys.readouterr()
        .err.splitlines()[-1]
        .startswith("pathgene: No feasible path was found, the best one is written; ")
    )
    assert sorted(entry.name for entry in tmp_path.iterdir()) == FILES
    assert len(summary_in(tmp_path)["waypoints"]) == 2


@pytest.mark.parametrize("planner", ["ga-fpga", "ga-pc", "fpa", "fpa-2opt", "ga-dp", "ga-auv"])
def test_start_from_the_grid_search(hills, tmp_path, capsys, planner):
    common = ["plan", "--terrain", str(hills), *ENDS, "--generations", "3", "--json"]
    assert main([*common, "--planner", planner, "--init", "astar", "--out", str(tmp_path)]) == 0
    history = json.loads(capsys.readouterr().out)["history"]
    assert main([*common, "--planner", "astar", "--init", "astar", "--out", str(tmp_path)]) == 0
    output = capsys.readouterr()
    assert output.err.splitlines()[0] == "pathgene: --init means nothing to astar and is ignored."
    assert history[0][1] > json.loads(output.out)["fitness"] - 0.01


def test_start_without_a_way_is_random(hills, tmp_path, capsys):
    main(
        [
            "plan",
            "--terrain",
            str(hills),
            *ENDS,
            *WALL,
            "--planner",
            "ga-pc",
            "--init",
            "astar",
            "--generations",
            "2",
            "--out",
            str(tmp_path),
        ]
    )
    assert capsys.readouterr().err.splitlines()[0] == (
        "pathgene: The grid search finds no way from start to goal, so the first population is "
        "random."
    )


@pytest.mark.parametrize("planner", ["fpa", "fpa-2opt"])
def test_flower_pollination_and_check_agree(hills, tmp_path, pathgene, planner):
    done = pathgene(
        "plan",
        "--terrain",
        hills,
        *ENDS,
        "--planner",
        planner,
        "--generations",
        60,
        "--population",
        64,
        "--waypoints",
        3,
        "--out",
        tmp_path,
        "--json",
    )
    assert done.returncode == 0, done.stderr
    summary = summary_in(tmp_path)
    assert summary == json.loads(done.stdout)
    assert (summary["planner"], summary["board"], summary["generations"]) == (planner, None, 60)
    assert len(summary["waypoints"]) == 5
    assert summary["evaluations"] >= 64
    assert summary["cut_short"] > 0
    assert summary["seconds"]["iterations"] > 0
    checked = json.loads(pathgene("check", "--path", tmp_path / "summary.json", "--json").stdout)
    for term in ("fitness", "penalty", "cost", "length_m", "mean_altitude_m", "fuel_N", "feasible"):
        assert checked[term] == summary[term]


def test_engines_of_the_processor_agree(hills, tmp_path, capsys):
    found = []
    for engine in ("sequential", "cores"):
        assert main(
            [
                "plan",
                "--terrain",
                str(hills),
                *ENDS,
                "--planner",
                "fpa-2opt",
                "--engine",
                engine,
                "--generations",
                "25",
                "--population",
                "40",
                "--two-opt-every",
                "10",
                "--out",
                str(tmp_path),
            ]
        ) in (0, 1)
        found.append(summary_in(tmp_path))
    assert found[0]["history"] == found[1]["history"]
    assert found[0]["waypoints"] == found[1]["waypoints"]
    capsys.readouterr()


def test_no_feasible_path_is_status_1_with_files(hills, tmp_path, capsys):
    assert (
        main(
            [
                "plan",
                "--terrain",
                str(hills),
                *ENDS,
                *WALL,
                "--generations",
                "3",
                "--out",
                str(tmp_path),
            ]
        )
        == 1
    )
    assert capsys.readouterr().err.splitlines()[-1] == (
        "pathgene: No feasible path was found, the best one is written; try more --generations, "
        "another --seed, or move start and goal."
    )
    assert sorted(entry.name for entry in tmp_path.iterdir()) == FILES
    summary = summary_in(tmp_path)
    assert (summary["feasible"], summary["feasible_at_ds"]) == (False, False)
    assert summary["distance_in_nofly_m"] > 0


def test_stop_criteria(hills, tmp_path, capsys):
    common = [
        "plan",
        "--terrain",
        str(hills),
        *ENDS,
        "--out",
        str(tmp_path),
        "--generations",
        "100000",
        "--json",
    ]
    assert main([*common, "--target-fitness", "1.01"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["stopped_by"] == "target-fitness"
    assert summary["history"][-1][1] >= 1.01
    assert main([*common, "--time-limit", "0.5"]) in (0, 1)
    summary = json.loads(capsys.readouterr().out)
    assert summary["stopped_by"] == "time-limit"
    assert 0.5 <= summary["seconds"]["total"] < 5


@pytest.mark.parametrize("planner", ["ga-fpga", "ga-pc", "fpa", "fpa-2opt", "ga-dp", "ga-auv"])
def test_interrupt_writes_the_best_so_far(hills, tmp_path, planner):
    command = [
        sys.executable,
        "-m",
        "host",
        "plan",
        "--terrain",
        hills,
        *ENDS,
        "--planner",
        planner,
        "--generations",
        "10000000",
        "--out",
        tmp_path,
        "--json",
    ]
    with subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr.readline().startswith("generation 0/")
        process.send_signal(signal.SIGINT)
        output, error = process.communicate(timeout=60)
    assert process.returncode == 130
    assert error.splitlines()[-1] == "pathgene: Interrupted; what was best so far is written."
    summary = json.loads(output)
    assert summary == summary_in(tmp_path)
    assert (summary["interrupted"], summary["stopped_by"]) == (True, "interrupt")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == FILES


def test_progress_is_a_bar_on_a_terminal(hills, tmp_path):
    ours, theirs = os.openpty()
    command = [
        sys.executable,
        "-m",
        "host",
        "plan",
        "--terrain",
        hills,
        *ENDS,
        "--generations",
        "5",
        "--out",
        tmp_path,
    ]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=theirs):
        os.close(theirs)
        seen = b""
        while True:
            try:
                part = os.read(ours, 4096)
            except OSError:  # The terminal went away with the process.
                break
            if not part:
                break
            seen += part
    os.close(ours)
    assert b"\r\x1b[K[" + b"#" * 30 + b"] generation 5/5" in seen


def test_grid_beside_the_summary_is_what_was_evaluated(planned, hills):
    out, _, _ = planned
    with np.load(out / "terrain.npz") as grid, np.load(hills) as source:
        assert np.array_equal(grid["elevation"], source["elevation"], equal_nan=True)
        assert grid["nofly"][20, 30]
        assert grid["nofly"].sum() == 49  # Nodes within 4 cells of the centre.


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


def test_no_picture_leaves_matplotlib_alone(hills, tmp_path, capsys):
    (tmp_path / "path.png").write_bytes(b"of an earlier run")
    arguments = ["plan", "--terrain", str(hills), *ENDS, "--generations", "2", "--seed", "1"]
    script = (
        "import sys; from host.cli import main; status = main(sys.argv[1:]); "
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
    assert main([*arguments, "--out", str(with_picture)]) == 0
    assert sorted(entry.name for entry in with_picture.iterdir()) == FILES
    one, other = summary_in(tmp_path), summary_in(with_picture)
    for summary in (one, other):
        del summary["seconds"]
    assert one == other
    for name in ("path.geojson", "terrain.npz"):
        assert (tmp_path / name).read_bytes() == (with_picture / name).read_bytes()
