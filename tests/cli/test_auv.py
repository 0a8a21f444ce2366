"""``pathgene auv``, and its planners over terrain."""

import json

import matplotlib.image
import numpy as np
import pytest

from pathgene.host.auv.field import AuvField
from pathgene.host.cli import main

from .conftest import assert_check_agrees, interrupted, plan


pytestmark = pytest.mark.ci


def run(capsys, out, *options):
    assert main(["auv", *options, "--out", str(out), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("planner", ["ga-dp", "ga-auv"])
def test_writes_a_summary_and_a_picture(tmp_path, capsys, planner):
    options = ("--landscape", "2", "--planner", planner, "--generations", "12", "--seed", "3")
    summary = run(capsys, tmp_path / "one", *options)
    assert summary == json.loads((tmp_path / "one" / "auv.json").read_text())
    assert (summary["planner"], summary["landscape"]) == (planner, 2)
    assert (summary["as_paper"], summary["samples"]) == (False, None)
    assert len(summary["history"]) == summary["generations"] == 12
    assert min(matplotlib.image.imread(tmp_path / "one" / "auv.png").shape[:2]) > 600

    # The control points determine the path.
    control = np.zeros((len(summary["control_points"]), 10, 2))
    counts = np.array([len(points) for points in summary["control_points"]])
    for row, points in zip(control, summary["control_points"], strict=True):
        row[: len(points)] = points
    for samples, terms in ((None, summary), (1001, summary["at_1001_samples"])):
        length, turning, rate = AuvField(2).measure(control, counts, samples).T
        assert terms["path_length"] == pytest.approx(length.sum())
        assert terms["minimum_turn_deg"] == pytest.approx(180 * (1 - turning.max()))
        assert terms["elevation_rate"] == pytest.approx(rate.max())
        assert terms["delta"] == pytest.approx(
            (length.sum() + 2 * turning.max() + 4 * rate.max()) / 7
        )

    again = run(capsys, tmp_path / "two", *options)
    assert again["control_points"] == summary["control_points"]
    other = run(capsys, tmp_path / "two", *options[:-1], "4")
    assert other["control_points"] != summary["control_points"]


def test_as_paper_is_version_0_1(tmp_path, capsys):
    """Version 0.1 gives the same figures with the same options."""
    summary = run(capsys, tmp_path, "--as-paper", "--seed", "1", "--generations", "40")
    again = run(capsys, tmp_path, "--samples", "21", "--seed", "1", "--generations", "40")
    assert (summary["as_paper"], summary["samples"]) == (True, 21)
    assert summary["delta"] == pytest.approx(0.6370660068856192, rel=1e-9)
    assert summary["at_1001_samples"]["delta"] == pytest.approx(2.624330736509207, rel=1e-9)
    assert again["control_points"] == summary["control_points"]
    # Reports with the paper's samples are also even in the parameter.
    control = np.zeros((1, 10, 2))
    points = summary["control_points"][0]
    control[0, : len(points)] = points
    _, _, rate = AuvField(1, samples=1001).measure(control, np.array([len(points)]))[0]
    assert summary["at_1001_samples"]["elevation_rate"] == rate


def test_progress_shows_delta(tmp_path, capsys):
    assert main(["auv", "--generations", "2", "--out", str(tmp_path)]) == 0
    last = capsys.readouterr().err.splitlines()[-1]
    delta = json.loads((tmp_path / "auv.json").read_text())["delta"]
    assert last == f"generation 2/2  delta {delta:.4f}"


def test_options_reach_the_problem(tmp_path, capsys):
    common = ("--generations", "5", "--seed", "1")
    summary = run(
        capsys,
        tmp_path,
        *common,
        "--reading",
        "sum",
        "--draws",
        "uniform",
        "--samples",
        "11",
        "--added-points",
        "3",
        "--length",
        "3d",
    )
    assert [
        summary[name]
        for name in ("reading", "draws", "samples", "added_points", "length", "landscape")
    ] == ["sum", "uniform", 11, 3, "3d", 1]
    assert main(["auv", *common, "--out", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split(maxsplit=1) == ["planner", "ga-dp, reading route, draws near"]
    assert lines[-1].endswith("auv.png")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--landscape", "3"], "The landscape must be one of 1, 2, not 3."),
        (["--samples", "1"], "The samples of a segment must be from 2 to 100001, not 1."),
        (["--generations", "0"], "The number of generations must be 1 or more, not 0."),
        (["--seed", "-1"], "The seed must be from 0 to 2**64 - 1, not -1."),
        (
            ["--added-points", "51"],
            "The crossover points added per generation must be from 1 to 50, not 51.",
        ),
        (["--planner", "ga-pc"], "Argument --planner: there is no choice 'ga-pc' (did you mean "),
    ],
)
def test_refuses_bad_options(tmp_path, capsys, options, sentence):
    out = tmp_path / "out"
    assert main(["auv", *options, "--out", str(out)]) == 2
    assert capsys.readouterr().err.startswith(f"pathgene: {sentence}")
    assert not out.exists()


def test_interrupt_writes_the_best_so_far(tmp_path):
    report = interrupted(["auv", "--out", tmp_path], "generation 1/")
    assert report == json.loads((tmp_path / "auv.json").read_text())
    assert report["interrupted"]


@pytest.mark.parametrize(
    ("planner", "options"),
    [
        pytest.param("ga-dp", (), marks=pytest.mark.ci),
        ("ga-dp", ("--reading", "sum", "--draws", "uniform")),
        ("ga-auv", ("--population", "24", "--added-points", "6")),
    ],
)
def test_check_agrees_over_terrain(hills, tmp_path, capsys, planner, options):
    assert (
        plan(
            hills,
            tmp_path,
            "--planner",
            planner,
            *options,
            "--generations",
            "30",
            "--seed",
            "1",
            "--json",
        )
        == 0
    )
    summary = json.loads(capsys.readouterr().out)
    assert (summary["planner"], summary["feasible"]) == (planner, True)
    assert_check_agrees(tmp_path, summary, capsys)
