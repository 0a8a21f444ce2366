"""Planners and their options through ``pathgene plan``."""

import json

import pytest

from pathgene.host.cli import main

from .conftest import ENDS, FILES, PAPER, WALL, assert_check_agrees, plan, run_here, summary_in


#: A picture takes half a second of the processor; other tests draw them.
UNDRAWN = "--no-picture"


def test_same_seed_same_path_in_every_link_mode(planned, hills, tmp_path, capsys):
    _, _, summary = planned
    for mode in ("population", "recipe"):
        assert plan(hills, tmp_path / mode, *PAPER, "--link-mode", mode, UNDRAWN) == 0
        other = summary_in(tmp_path / mode)
        assert other["waypoints"] == summary["waypoints"]
        assert other["history"] == summary["history"]
        assert other["hardware"]["link_mode"] == mode
    assert "fitness" in capsys.readouterr().out


def test_plans_by_other_planners_beside_it(hills, tmp_path, capsys):
    options = [UNDRAWN, "--polish", "chip", "--chip-ms", 2, "--seed", 1]
    options += ["--beside", "ga-fpga, ga-chip,astar"]
    assert plan(hills, tmp_path, *options) == 0
    output = capsys.readouterr()
    assert "pathgene: Beside it, ga-fpga on model:." in output.err.splitlines()
    lines = output.out.splitlines()
    (first,) = [number for number, line in enumerate(lines) if line.startswith("planner  board ")]
    rows = [line.split() for line in lines[first + 1 : first + 4]]
    summary = summary_in(tmp_path)
    chip_us = f"{summary['hardware']['plan_us']:,.0f}"
    assert rows[0][:4] == ["ga-chip", "model:", "yes", f"{summary['fitness']:.4f}"]
    assert rows[0][4:8] == [chip_us, "us", "at", "100"]
    assert [row[:3] for row in rows[1:]] == [
        ["ga-fpga", "model:", "yes"],
        ["astar", "none", "yes"],
    ]
    assert [row[4] for row in rows[1:]] == ["-", "-"]

    assert plan(hills, tmp_path, *options[:8], "astar", "--json") == 0
    printed = json.loads(capsys.readouterr().out)
    beside = printed.pop("beside")
    assert printed == summary_in(tmp_path)
    assert [row["planner"] for row in beside] == ["ga-chip", "astar"]
    assert beside[1]["plan_us"] is None


def test_says_that_the_route_is_that_of_astar(hills, tmp_path, capsys):
    options = [UNDRAWN, "--chip-ms", 1, "--generations", 1, "--seed", 1]
    assert plan(hills, tmp_path, *options, "--beside", "astar") == 0
    lines = capsys.readouterr().out.splitlines()
    hardware = summary_in(tmp_path)["hardware"]
    assert hardware["route_from"] == "astar"
    (route,) = [line.split(maxsplit=1) for line in lines if line.startswith("route ")]
    chip = hardware["routes"]["chip"]
    assert route == ["route", f"of astar; the chip's own has fitness {chip:.4f}"]
    assert [line for line in lines if line.startswith("ga-chip, route of astar  model:  yes ")]

    assert plan(hills, tmp_path, *options, "--polish", "chip") == 0
    (route,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("route ")]
    assert route.split() == ["route", "of", "the", "chip"]


def test_a_board_of_one_core_leaves_the_model_to_the_planner_beside_it(hills, tmp_path, capsys):
    board = [UNDRAWN, "--board", "model:?core=planner", "--chip-ms", "1"]
    assert plan(hills, tmp_path, *board, "--beside", "ga-fpga", "--generations", "200") == 0
    assert "pathgene: Beside it, ga-fpga on model:." in capsys.readouterr().err.splitlines()
    assert plan(hills, tmp_path, *board, "--beside", "gafpga") == 2
    assert "There is no planner 'gafpga'" in capsys.readouterr().err
    assert plan(hills, tmp_path, *board, "--beside", "ga-fpga,,astar") == 2
    assert "--beside has an empty name in 'ga-fpga,,astar'" in capsys.readouterr().err


def test_collisions_counted_by_the_board(hills, tmp_path, capsys):
    assert plan(hills, tmp_path, *PAPER, "--feasibility", "board", UNDRAWN) == 0
    summary, said = summary_in(tmp_path), capsys.readouterr().out
    counted = summary["hardware"]["feasibility"]
    assert 0 < counted["evaluated_in_full"] < counted["counted_on_board"] == 128 + 60 * 22
    assert f"{counted['counted_on_board']} paths" in said
    assert_check_agrees(tmp_path, summary, capsys)


def test_ignores_an_option_of_another_planner(hills, tmp_path, capsys):
    options = ("--planner", "ga-pc", "--generations", "40", "--board", "sim:", UNDRAWN)
    assert plan(hills, tmp_path, *options) == 0
    output = capsys.readouterr()
    assert output.err.splitlines()[0] == (
        "pathgene: --board means nothing to ga-pc and is ignored."
    )
    summary = summary_in(tmp_path)
    assert (summary["board"], summary["hardware"]) == (None, None)
    assert "board              none" in output.out


def test_check_agrees_with_the_grid_search(hills, tmp_path, capsys):
    options = ("--planner", "astar", "--max-waypoints", "9", "--json", UNDRAWN)
    assert plan(hills, tmp_path, *options) == 0
    output = capsys.readouterr()
    assert output.err.splitlines()[-1].startswith("generation 4/400  best 1.")
    summary = json.loads(output.out)
    assert (summary["planner"], summary["generations"]) == ("astar", 4)
    assert len(summary["waypoints"]) <= 11
    assert_check_agrees(tmp_path, summary, capsys)


def test_grid_search_without_a_way_exits_1_with_files(hills, tmp_path, capsys):
    assert plan(hills, tmp_path, *WALL, "--planner", "astar") == 1
    assert (
        capsys.readouterr()
        .err.splitlines()[-1]
        .startswith("pathgene: No way leads from the start to the goal at any altitude: ")
    )
    assert sorted(entry.name for entry in tmp_path.iterdir()) == FILES
    assert len(summary_in(tmp_path)["waypoints"]) == 2


@pytest.mark.ci
@pytest.mark.parametrize("planner", ["ga-fpga", "ga-pc", "fpa", "fpa-2opt", "ga-dp", "ga-auv"])
def test_start_from_the_grid_search(hills, tmp_path, capsys, planner):
    common = ["plan", "--terrain", str(hills), *ENDS, "--generations", "3", "--json", UNDRAWN]
    assert main([*common, "--planner", planner, "--init", "astar", "--out", str(tmp_path)]) == 0
    history = json.loads(capsys.readouterr().out)["history"]
    assert main([*common, "--planner", "astar", "--init", "astar", "--out", str(tmp_path)]) == 0
    output = capsys.readouterr()
    assert output.err.splitlines()[0] == "pathgene: --init means nothing to astar and is ignored."
    assert history[0][1] > json.loads(output.out)["fitness"] - 0.01


def test_start_from_the_grid_search_without_a_way_states_the_reason(hills, tmp_path, capsys):
    options = ("--planner", "ga-pc", "--init", "astar", "--generations", "2", UNDRAWN)
    plan(hills, tmp_path, *WALL, *options)
    said = capsys.readouterr().err
    assert "The grid search finds no way" not in said
    assert said.splitlines()[-1].startswith("pathgene: No way leads from the start to the goal at ")


@pytest.mark.parametrize("planner", [pytest.param("fpa", marks=pytest.mark.ci), "fpa-2opt"])
def test_check_agrees_with_flower_pollination(hills, tmp_path, capsys, planner):
    done = run_here(
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
        UNDRAWN,
    )
    assert done.returncode == 0, done.stderr
    summary = summary_in(tmp_path)
    assert summary == json.loads(done.stdout)
    assert (summary["planner"], summary["board"], summary["generations"]) == (planner, None, 60)
    assert len(summary["waypoints"]) == 5
    assert summary["evaluations"] >= 64
    assert summary["cut_short"] > 0
    assert summary["seconds"]["iterations"] > 0
    assert_check_agrees(tmp_path, summary, capsys)


def test_engines_of_the_processor_agree(hills, tmp_path, capsys):
    found = []
    for engine in ("sequential", "threads"):
        assert plan(
            hills,
            tmp_path,
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
            UNDRAWN,
        ) in (0, 1)
        found.append(summary_in(tmp_path))
    assert found[0]["history"] == found[1]["history"]
    assert found[0]["waypoints"] == found[1]["waypoints"]
    capsys.readouterr()
