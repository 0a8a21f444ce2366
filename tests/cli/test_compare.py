"""``pathgene compare`` from options to files."""

import json
import os
import signal
import time

import pytest

from pathgene.host.cli import main
from pathgene.host.planners import PLANNERS

from .conftest import ENDS, started


def arguments(hills, out, planners, *options):
    ends = list(ENDS)
    if "--goal" in options:  # An option is given once.
        at = ends.index("--goal")
        del ends[at : at + 2]
    return [
        str(word)
        for word in (
            "compare",
            "--terrain",
            hills,
            *ends,
            "--out",
            out,
            "--planners",
            planners,
            *options,
        )
    ]


@pytest.fixture(scope="module")
def compared(hills, pathgene, tmp_path_factory):
    """Directory, process and report of a comparison of all planners, in two processes."""
    out = tmp_path_factory.mktemp("compare") / "out"
    planners = ",".join([*PLANNERS, "ga-pc:max_waypoints=8:population=16"])
    done = pathgene(
        *arguments(
            hills,
            out,
            planners,
            "--runs",
            2,
            "--seed",
            5,
            "--jobs",
            2,
            "--generations",
            8,
            "--json",
        ),
        timeout_s=300,
    )
    return out, done, json.loads(done.stdout) if done.returncode == 0 else None


def test_every_planner_takes_part(compared):
    out, done, report = compared
    assert done.returncode == 0, done.stderr
    assert sorted(file.name for file in out.iterdir()) == [
        "compare.json",
        "compare.png",
        "runs.jsonl",
    ]
    assert json.loads((out / "compare.json").read_text()) == report
    assert [planner["label"] for planner in report["planners"]] == [
        *PLANNERS,
        "ga-pc:max_waypoints=8:population=16",
    ]
    assert (report["seeds"], report["paired"]) == ([5, 6], False)
    assert report["nofly"] == [{"x": 3000.0, "y": 2000.0, "radius_m": 400.0}]
    count = len(report["planners"])
    assert len(report["pairs"]) == count * (count - 1) // 2
    for planner in report["planners"]:
        assert [run["seed"] for run in planner["runs"]] == [5, 6]
        assert planner["statistics"]["runs"] == 2
    lines = done.stderr.splitlines()
    assert f"run 0/{2 * count}" in lines
    assert lines[-1].startswith(f"run {2 * count}/{2 * count}  best 1.")


def test_check_agrees_with_every_run(compared, hills, tmp_path, capsys):
    *_, report = compared
    assert report["planners"]
    for planner in report["planners"]:
        for run in planner["runs"]:
            file = tmp_path / "path.csv"
            rows = [",".join(map(repr, point)) for point in run["waypoints"]]
            file.write_text("\n".join(["x,y,z", *rows]) + "\n")
            assert (
                main(
                    [
                        "check",
                        "--terrain",
                        str(hills),
                        "--path",
                        str(file),
                        "--nofly-circle",
                        "3000,2000,400",
                        "--json",
                    ]
                )
                == 0
            )
            checked = json.loads(capsys.readouterr().out)
            assert {key: run[key] for key in ("fitness", "penalty", "feasible", "length_m")} == {
                key: checked[key] for key in ("fitness", "penalty", "feasible", "length_m")
            }


def test_prints_a_finished_comparison_at_once(compared, hills, capsys):
    out, _, report = compared
    before = (out / "runs.jsonl").read_bytes()
    assert (
        main(arguments(hills, out, "ga-fpga,ga-pc", "--runs", 2, "--seed", 5, "--generations", 8))
        == 0
    )
    output = capsys.readouterr()
    assert output.err == ""
    assert (out / "runs.jsonl").read_bytes() == before
    lines = output.out.splitlines()
    assert lines[0].split()[:3] == ["planner", "runs", "feasible"]
    row = next(line for line in lines if line.startswith("ga-pc "))
    statistics = next(
        planner["statistics"] for planner in report["planners"] if planner["label"] == "ga-pc"
    )
    assert f"{statistics['fitness']['mean']:.4f}" in row.split()
    pair = next(line for line in lines if line.startswith("ga-fpga - ga-pc "))
    (found,) = (pair for pair in report["pairs"] if pair["planners"] == ["ga-fpga", "ga-pc"])
    assert f"{found['welch']['p']:.2g}" in pair.split()
    assert any("not paired" in line for line in lines)


@pytest.mark.ci
def test_interrupted_and_resumed(hills, tmp_path, capsys):
    command = arguments(
        hills, tmp_path, "ga-pc", "--runs", 6, "--generations", 10**6, "--time-limit", 0.6
    )
    file = tmp_path / "runs.jsonl"
    # A new session, so that the signal reaches all its processes, as from a terminal.
    with started(*command, "--jobs", "2", start_new_session=True) as process:
        while not (file.exists() and file.read_bytes().endswith(b"\n")):
            assert process.poll() is None
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        output, error = process.communicate(timeout=60)
    assert process.returncode == 130
    assert output == ""
    before = file.read_bytes()
    done = before.count(b"\n")
    assert 1 <= done < 6
    assert error.splitlines()[-1] == (
        f"pathgene: Interrupted; {done} of 6 runs are kept in {file}; repeat the command "
        "to continue."
    )
    assert "Traceback" not in error

    assert main([*command, "--jobs", "1", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["interrupted"] is False
    assert [run["seed"] for run in report["planners"][0]["runs"]] == list(range(6))
    assert file.read_bytes().startswith(before)
    assert file.read_bytes().count(b"\n") == 6


def test_planners_without_feasible_paths_do_not_fail(hills, tmp_path, capsys):
    wall = [part for y in range(0, 4001, 400) for part in ("--nofly-circle", f"3000,{y},300")]
    assert (
        main(
            [
                *arguments(
                    hills,
                    tmp_path,
                    "ga-pc,ga-pc:population=16",
                    "--runs",
                    2,
                    "--jobs",
                    1,
                    "--generations",
                    2,
                ),
                *wall,
            ]
        )
        == 0
    )
    rows = capsys.readouterr().out.splitlines()
    assert rows[1].split()[:3] == ["ga-pc", "2", "0%"]


def test_reports_a_failed_planner_and_completes_the_others(hills, tmp_path, capsys):
    assert (
        main(
            arguments(
                hills,
                tmp_path,
                "ga-pc,ga-pc:population=4",
                "--runs",
                2,
                "--jobs",
                1,
                "--generations",
                2,
            )
        )
        == 2
    )
    output = capsys.readouterr()
    assert output.err.splitlines()[-1] == (
        "pathgene: ga-pc:population=4: 2 of 2 runs failed: The population of ga-pc must be from 8 "
        "to 100000, not 4."
    )
    row, empty = output.out.splitlines()[1:3]
    assert row.split()[:2] == ["ga-pc", "2"]
    assert empty.split()[1:] == ["0", *"------"]
    assert "(there are no runs)" in output.out


@pytest.mark.parametrize(
    ("planners", "options", "sentence"),
    [
        ("a-star", [], "There is no planner 'a-star' (did you mean astar?); the "),
        ("ga-pc,ga-pc", [], "ga-pc and ga-pc are the same planner with the same options; "),
        ("ga-pc", ["--runs", "0"], "The number of runs must be from 1 to 100,000, not 0."),
        (
            "ga-pc",
            ["--runs", "100001"],
            "The number of runs must be from 1 to 100,000, not 100001.",
        ),
        ("ga-pc", ["--jobs", "0"], "The number of jobs must be 1 or more, not 0."),
        ("ga-pc", ["--seed", "-1"], "The seed must be from 0 to 2**64 - 1, not -1."),
        (
            "ga-pc",
            ["--seed", str(2**64 - 1)],
            f"The seed must be from 0 to 2**64 - 1, not {2**64 + 48}.",
        ),
        (
            "ga-fpga",
            ["--board", "/dev/ttyUSB0", "--jobs", "2"],
            "ga-fpga: a board serves one run at a time; give --jobs 1.",
        ),
        (
            "ga-fpga:board=/dev/ttyUSB0",
            ["--scheduler", "local"],
            "ga-fpga:board=/dev/ttyUSB0: a board at this machine cannot be reached from a "
            "cluster; ",
        ),
        (
            "ga-fpga:board=/dev/ttyUSB0",
            ["--scheduler"],
            "ga-fpga:board=/dev/ttyUSB0: a board at this machine cannot be reached from a "
            "cluster; ",
        ),
        ("ga-pc", ["--goal", "9500,3500,100"], "The goal at (9500, 3500) is outside the map"),
    ],
)
def test_refuses_bad_options(hills, tmp_path, capsys, planners, options, sentence):
    out = tmp_path / "out"
    assert main(arguments(hills, out, planners, *options)) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith(f"pathgene: {sentence}")
    assert output.err.count("\n") == 1
    assert not out.exists()


def test_refuses_runs_of_another_problem(compared, hills, capsys):
    out, *_ = compared
    before = (out / "compare.json").read_bytes()
    assert main([*arguments(hills, out, "ga-pc", "--runs", 1), "--wind", "1,0"]) == 2
    assert capsys.readouterr().err.startswith(
        f"pathgene: The directory {str(out)!r} holds runs of another problem; give another with "
    )
    assert (out / "compare.json").read_bytes() == before


def test_reports_an_option_without_effect(compared, hills, capsys):
    out, *_ = compared
    assert (
        main(
            arguments(
                hills, out, "ga-pc", "--runs", 2, "--seed", 5, "--generations", 8, "--board", "sim:"
            )
        )
        == 0
    )
    assert capsys.readouterr().err.splitlines()[0] == (
        "pathgene: --board means nothing to ga-pc and is ignored."
    )


def test_times_of_zones_are_those_of_a_plan(hills, tmp_path, capsys):
    """A zone over the straight way, active an hour after the flight, does not matter."""
    wall = "polygon = [[2500, -500], [3500, -500], [3500, 4500], [2500, 4500]]"
    text = f'[terrain]\nsource = "{hills}"\n[mission]\nstart = [500, 500, 100]\n'
    text += "goal = [5500, 3500, 100]\nagl = true\n"
    found = {}
    for name, zone in (("free", ""), ("later", f"[[zones]]\n{wall}\nt0 = 4000\nt1 = 5000\n")):
        file = tmp_path / f"{name}.toml"
        file.write_text(text + zone)
        out = tmp_path / name
        options = ["--planners", "astar,ga-pc:generations=30", "--runs", 1, "--jobs", 1]
        assert main(list(map(str, ["compare", file, *options, "--out", out, "--json"]))) == 0
        report = json.loads(capsys.readouterr().out)
        found[name] = [each["statistics"]["fitness"]["best"] for each in report["planners"]]
        assert all(each["statistics"]["feasible_share"] == 1 for each in report["planners"])
    assert found["free"] == found["later"]
