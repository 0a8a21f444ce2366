"""Planners and their options through ``pathgene plan``."""

import json

import pytest

from host.cli import main

from .conftest import ENDS, FILES, WALL, summary_in


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
        .startswith("pathgene: No feasible path was found, the best path is written; ")
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


@pytest.mark.parametrize("planner", [pytest.param("fpa", marks=pytest.mark.ci), "fpa-2opt"])
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
