"""``pathgene diagnose``: exit status, sentence and JSON."""

import json

import numpy as np
import pytest

from pathgene.host.cli import main

from .conftest import ENDS, WALL


@pytest.fixture
def diagnosed(hills, capsys):
    """Function that runs the command; returns the status, standard output and the last sentence."""

    def run(*options):
        status = main(["diagnose", "--terrain", str(hills), *ENDS, *options])
        said = capsys.readouterr()
        return status, said.out, said.err.splitlines()[-1:]

    return run


def test_connected(diagnosed):
    status, out, said = diagnosed()
    assert (status, said) == (0, [])
    assert out == "connected  yes, a feasible path is found by astar\n"
    status, out, _ = diagnosed("--json")
    report = json.loads(out)
    assert (status, report["connected"], report["reason"]) == (0, True, None)


def test_closed(diagnosed):
    sentence = (
        "No way leads from the start to the goal at any altitude: the edge of the map, zone 1, "
        "zone 2, zone 3 and 8 more enclose the goal, and must open near (3000, 2000) m."
    )
    status, out, said = diagnosed(*WALL)
    assert (status, said) == (1, [f"pathgene: {sentence}"])
    assert out.splitlines()[:2] == ["connected  no", "reason     closed"]
    status, out, _ = diagnosed(*WALL, "--json")
    report = json.loads(out)
    assert (status, report["connected"], report["leg"]) == (1, False, None)
    reason = report["reason"]
    assert (reason["code"], reason["sentence"]) == ("closed", sentence)
    assert reason["proven"] is True
    assert reason["ring"]


@pytest.mark.parametrize("command", ["diagnose", "plan"])
def test_a_goal_in_a_pit_too_deep_for_costs_has_a_reason(command, tmp_path, capsys):
    """The straight line there burns no fuel, so costs have no reference."""
    heights = np.full((60, 60), 900.0)
    heights[39:42, 39:42] = 100.0
    ground = tmp_path / "pit.npz"
    np.savez(ground, elevation=heights, dx_m=50.0, dy_m=50.0)
    ends = ["--agl", "--start", "500,500,100", "--goal", "2000,2000,60"]
    out = tmp_path / "out"
    status = main([command, "--terrain", str(ground), *ends, "--out", str(out)])
    assert status == 1
    said = capsys.readouterr().err.splitlines()[-1]
    assert "way down to the goal is too steep" in said
    if command == "diagnose":
        report = json.loads((out / "diagnosis.json").read_text())
        assert report["reason"]["code"] == "descent"
        assert not (out / "diagnosis.png").exists()


def test_leg_without_a_way(diagnosed):
    status, _, said = diagnosed(*WALL, "--via", "1500,2500,100")
    assert status == 1
    assert said[0].startswith(
        "pathgene: Leg 2, from via point 1 to the goal: No way leads from the start to the goal"
    )


def test_writes_the_reason_and_its_picture(diagnosed, tmp_path):
    out = tmp_path / "made" / "out"
    status, printed, said = diagnosed(*WALL, "--out", str(out))
    assert status == 1
    assert [line.split()[1] for line in printed.splitlines() if line.startswith("written")] == [
        str(out / "diagnosis.json"),
        str(out / "diagnosis.png"),
    ]
    written = json.loads((out / "diagnosis.json").read_text())
    assert said == [f"pathgene: {written['reason']['sentence']}"]
    assert written == json.loads(diagnosed(*WALL, "--json")[1])
    assert (out / "diagnosis.png").read_bytes().startswith(b"\x89PNG")

    # A later run that finds a path leaves no picture of a reason.
    assert diagnosed("--out", str(out))[0] == 0
    assert [file.name for file in out.iterdir()] == ["diagnosis.json"]
    assert json.loads((out / "diagnosis.json").read_text())["connected"] is True


def test_a_problem_file_chooses_no_folder(hills, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "problem.toml"
    file.write_text(
        f'[terrain]\nsource = "{hills}"\n[mission]\nstart = [500, 500, 100]\n'
        'goal = [5500, 3500, 100]\nagl = true\n[output]\nout = "out"\n'
    )
    assert main(["diagnose", str(file)]) == 0
    assert [each.name for each in tmp_path.iterdir()] == ["problem.toml"]


def test_a_folder_that_cannot_be_written_is_bad_input(diagnosed, tmp_path):
    (tmp_path / "taken").touch()
    status, out, said = diagnosed("--out", str(tmp_path / "taken" / "out"))
    assert (status, out) == (2, "")
    assert said[0].startswith("pathgene: Cannot write to the directory ")


def test_bad_input(diagnosed):
    status, out, said = diagnosed("--ceiling", "nan")
    assert (status, out) == (2, "")
    assert said == ["pathgene: The ceiling must be a finite number, not nan."]
