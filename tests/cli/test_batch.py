"""``pathgene batch``: many problem files, resumed."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pathgene.host.cli import main
from pathgene.host.mission.batch import Job, _parts, _Task
from pathgene.host.mission.problem_file import read_problem
from tests.support.host.processes import Started

from .conftest import ROOT


@pytest.fixture
def files(hills, tmp_path):
    """Three problem files over the hills: two good ones, and one whose goal is off the map."""
    made = []
    for name, goal in (("one", "5500, 3500"), ("two", "3000, 3500"), ("bad", "9000, 0")):
        file = tmp_path / f"{name}.toml"
        file.write_text(
            f'[terrain]\nsource = "{hills}"\n[mission]\nstart = [500, 500, 100]\n'
            f'goal = [{goal}, 100]\nagl = true\n[planner]\nname = "astar"\n'
        )
        made.append(str(file))
    return made


def batch(capsys, *arguments):
    status = main(["batch", *map(str, arguments)])
    return status, *capsys.readouterr()


def test_a_problem_with_an_altered_file_is_planned_again(files, tmp_path, capsys):
    out = tmp_path / "out"
    command = [files[0], "--out", out, "--jobs", "1", "--no-picture", "--json"]
    batch(capsys, *command)
    path = out / "one" / "path.geojson"
    content = path.read_bytes()
    for harm, kept in ((path.unlink, True), (lambda: path.write_bytes(content[:-9]), False)):
        harm()
        rows = json.loads(batch(capsys, *command)[1])["problems"]
        assert [row["kept"] for row in rows] == [kept]
    assert path.read_bytes() == content


def test_plans_each_once(files, tmp_path, capsys):
    out = tmp_path / "out"
    options = ["--out", out, "--jobs", "1", "--no-picture"]
    status, printed, said = batch(capsys, *files, *options, "--json")
    report = json.loads(printed)
    assert report == json.loads((out / "batch.json").read_text())
    rows = {row["name"]: row for row in report["problems"]}
    assert list(rows) == ["one", "two", "bad"]
    assert [row["feasible"] for row in rows.values()] == [True, True, False]
    assert not any(row["kept"] for row in rows.values())
    assert status == 2
    assert said.splitlines()[-1].startswith("pathgene: bad: The goal at (9000, 0) is outside the ")
    written = sorted(file.name for file in (out / "one").iterdir())
    assert written == ["path.geojson", "summary.json", "terrain.npz"]

    assert main(["check", "--path", str(out / "one" / "summary.json")]) == 0
    capsys.readouterr()
    again = json.loads(batch(capsys, *files, *options, "--json")[1])["problems"]
    assert [row["kept"] for row in again] == [True, True, False]
    for row, first in zip(again, rows.values(), strict=True):
        assert {**row, "kept": False} == first
    changed = json.loads(batch(capsys, *files[:2], *options, "--seed", 3, "--json")[1])["problems"]
    assert [row["kept"] for row in changed] == [False, False]


def test_no_path_is_status_1(files, tmp_path, capsys):
    with Path(files[0]).open("a") as file:
        for y in range(0, 4001, 400):
            file.write(f"[[zones]]\ncircle = [3000, {y}, 300]\n")
    options = ["--out", tmp_path / "out", "--jobs", 1, "--no-picture", "--planner", "ga-pc"]
    status, printed, said = batch(capsys, *files, *options, "--generations", 2, "--no-grid")
    assert status == 1
    assert "pathgene: one: No way leads from the start to the goal at any altitude" in said
    row = next(line.split() for line in printed.splitlines() if line.startswith("one"))
    assert row[:2] == ["one", "no"]
    assert not (tmp_path / "out" / "one" / "terrain.npz").exists()
    # The reason of a kept result is the same.
    again = batch(capsys, *files, *options, "--generations", 2, "--no-grid")[2]
    told = [line for line in said.splitlines() if line.startswith("pathgene: one: ")]
    assert told == [line for line in again.splitlines() if line.startswith("pathgene: one: ")]


@pytest.mark.ci
def test_fallback_is_that_of_the_option_before_that_of_the_file(files, tmp_path, capsys):
    file = Path(files[0])
    blind = 'name = "fpa"\nwaypoints = 6\ngenerations = 1\npopulation = 4'
    text = file.read_text().replace('name = "astar"', blind)
    for zone in ("3000, 2000, 400", "4500, 1000, 800", "1200, 2000, 500"):
        text += f"[[zones]]\ncircle = [{zone}]\n"
    file.write_text(text)
    options = ["--out", tmp_path / "out", "--jobs", 1, "--no-picture"]

    status, printed, _ = batch(capsys, file, *options)
    assert status == 0
    row = next(line.split() for line in printed.splitlines() if line.startswith("one"))
    assert (row[1], row[-2:]) == ("yes", ["by", "astar"])
    (row,) = json.loads(batch(capsys, file, *options, "--json")[1])["problems"]
    assert (row["kept"], row["planner"], row["fallback"]) == (True, "fpa", "astar")

    # A different fallback is a different search, so earlier results are not kept.
    status, printed, said = batch(capsys, file, *options, "--fallback", "none", "--json")
    assert status == 1
    (row,) = json.loads(printed)["problems"]
    assert (row["kept"], row["feasible"], row["fallback"]) == (False, False, None)
    assert "pathgene: one: No path was found at this cell size" in said


def test_ctrl_c_keeps_what_is_done(files, tmp_path, capsys):
    out = tmp_path / "out"
    # The second would take hours.
    second = Path(files[1])
    text = second.read_text().replace('"astar"', '"ga-pc"\ngenerations = 10000000')
    second.write_text(text)
    arguments = ["batch", *files[:2], "--jobs", "1", "--no-picture", "--out", str(out)]
    with Started(
        [sys.executable, "-m", "pathgene", *arguments], cwd=ROOT, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr.readline() == "problem 0/2\n"
        kept = out / "one" / "summary.json"
        while not (kept.exists() and '"batch"' in kept.read_text()):
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        error = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert error.splitlines()[-1] == (
        f"pathgene: Interrupted; 1 of 2 problems are kept in {out}; repeat the command to continue."
    )
    status, printed, _ = batch(capsys, files[0], "--out", out, "--no-picture", "--json")
    assert status == 0
    assert json.loads(printed)["problems"][0]["kept"]


def test_a_problem_without_a_place_is_told_the_key_and_not_planned(files, tmp_path, capsys):
    file = Path(files[0])
    file.write_text(f'{file.read_text()}[output]\nwrite = "plan"\n')
    status, printed, said = batch(capsys, file, "--out", tmp_path / "out", "--jobs", 1, "--json")
    assert status == 2
    sentence = json.loads(printed)["problems"][0]["failure"]
    assert sentence.endswith(
        "has no place on Earth, which this file needs; give the latitude and longitude of its "
        "south-west node (--origin LAT,LON, or origin under [terrain] in a problem file)."
    )
    assert said.splitlines() == [
        "problem 0/1",
        "problem 1/1  one, not planned",
        f"pathgene: one: {sentence}",
    ]


def test_notes_the_options_that_a_planner_lacks_once_for_each_problem(files, tmp_path, capsys):
    first, second, bad = map(Path, files)
    first.write_text(f"{first.read_text()}two_opt_every = 5\n")
    options = ["--out", tmp_path / "out", "--jobs", 1, "--no-picture"]
    expected = "pathgene: one: two_opt_every means nothing to astar and is ignored."
    for _ in range(2):  # Planned, and kept.
        status, _, said = batch(capsys, first, second, *options)
        assert status == 0
        assert [line for line in said.splitlines() if "ignored" in line] == [expected]

    said = batch(capsys, first, bad, *options, "--engine", "threads")[2]
    assert [line for line in said.splitlines() if "ignored" in line] == [
        "pathgene: one: engine means nothing to astar and is ignored.",
        expected,
        "pathgene: bad: engine means nothing to astar and is ignored.",
    ]


def test_as_paper_is_in_place_of_the_rules_of_the_files(files, tmp_path, capsys):
    out = tmp_path / "out"
    file = Path(files[0])
    file.write_text(f"{file.read_text()}[rules]\nclearance = 40\n")
    options = [file, "--out", out, "--jobs", 1, "--no-picture", "--json"]

    def planned(*more):
        status, printed, _ = batch(capsys, *options, *more)
        assert status == 0
        (row,) = json.loads(printed)["problems"]
        return row["kept"], json.loads((out / "one" / "summary.json").read_text())

    _, summary = planned()
    assert (summary["as_paper"], summary["rules"]["clearance_m"]) == (False, 40)
    kept, summary = planned("--as-paper")
    assert (kept, summary["as_paper"], summary["rules"]) == (False, True, None)
    assert planned("--as-paper")[0]

    file.write_text(file.read_text().replace("clearance = 40", "as_paper = true"))
    assert planned()[1]["as_paper"]
    assert not planned("--no-as-paper")[1]["as_paper"]


def test_refuses_bad_options(files, tmp_path, capsys):
    assert batch(capsys, *files, "--jobs", 0)[0] == 2
    status, _, said = batch(capsys, files[0], files[0], "--out", tmp_path / "out")
    assert status == 2
    assert "would have one name" in said


def has_gpu():
    from numba import cuda

    return cuda.is_available()


@pytest.mark.skipif(has_gpu(), reason="there is a GPU")
def test_without_a_gpu_each_problem_says_so(files, tmp_path, capsys):
    options = ["--out", tmp_path / "out", "--planner", "fpa", "--engine", "gpu", "--no-picture"]
    status, printed, said = batch(capsys, *files, *options, "--json")
    assert status == 2
    rows = json.loads(printed)["problems"]
    assert [row["bad_input"] for row in rows] == [True] * 3
    for name in ("one", "two"):
        assert f"pathgene: {name}: The engine gpu needs an NVIDIA GPU and CUDA for numba" in said
    assert "pathgene: bad: The goal at (9000, 0) is outside the " in said


def test_a_gpu_gets_problems_in_parts(files, monkeypatch):
    jobs = [Job(str(at), file, read_problem(Path(file))) for at, file in enumerate(files[:2] * 4)]
    tasks = [_Task(at, job.make()[0], job.values) for at, job in enumerate(jobs)]

    def parts():
        return [[task.number for task in part] for part in _parts(tasks)]

    assert parts() == [[*range(8)]]
    monkeypatch.setattr("pathgene.host.mission.batch._MOST_TOGETHER", 3)
    assert parts() == [[0, 1, 2], [3, 4, 5], [6, 7]]
    nodes = tasks[0].mission.whole.terrain.elevation.size
    monkeypatch.setattr("pathgene.host.mission.batch._MOST_NODES", 2 * nodes)
    assert parts() == [[0, 1], [2, 3], [4, 5], [6, 7]]
    # A map that is already too large is planned alone.
    monkeypatch.setattr("pathgene.host.mission.batch._MOST_NODES", nodes - 1)
    assert parts() == [[at] for at in range(8)]


def test_says_and_keeps_what_was_read_of_zones(files, tmp_path, capsys):
    zones = tmp_path / "zones.geojson"
    ring = [[2500, 500], [3500, 500], [3500, 900], [2500, 500]]
    kinds = [({"type": "Polygon", "coordinates": [ring]}, {"name": "R-1", "upper": 20})]
    kinds += [({"type": "LineString", "coordinates": ring[:2]}, {"name": "wire"})]
    features = [{"type": "Feature", "properties": own, "geometry": shape} for shape, own in kinds]
    document = {"type": "FeatureCollection", "crs_local": True, "features": features}
    zones.write_text(json.dumps(document))
    with Path(files[0]).open("a") as file:
        file.write('[[zones]]\nfile = "zones.geojson"\n')
    out = tmp_path / "out"
    options = [files[0], "--out", out, "--jobs", 1, "--no-picture", "--json"]
    status, printed, said = batch(capsys, *options)
    assert status == 0
    told = [line for line in said.splitlines() if line.startswith("pathgene: one: ")]
    assert any('Note: zones.geojson: feature 2, "wire" left out' in line for line in told)
    (warning,) = (line for line in told if 'Warning: zones.geojson: feature 1, "R-1"' in line)
    (row,) = json.loads(printed)["problems"]
    assert (
        row["warnings"] == json.loads((out / "batch.json").read_text())["problems"][0]["warnings"]
    )
    assert f"pathgene: one: Warning: {row['warnings'][1]}" == warning
    # A kept result says the same.
    again = batch(capsys, *options)[2]
    assert [line for line in again.splitlines() if line.startswith("pathgene: one: ")] == told
    # check of the summary repeats it.
    assert main(["check", "--path", str(out / "one" / "summary.json")]) == 0
    checked = capsys.readouterr().err.splitlines()
    assert [line.replace("one: ", "", 1) for line in told] == checked


def test_a_refused_problem_says_first_what_was_read(files, tmp_path, capsys):
    point = {"type": "Point", "coordinates": [2500, 500]}
    features = [{"type": "Feature", "properties": {"name": "mast"}, "geometry": point}]
    document = {"type": "FeatureCollection", "crs_local": True, "features": features}
    (tmp_path / "zones.geojson").write_text(json.dumps(document))
    with Path(files[2]).open("a") as file:
        file.write('[[zones]]\nfile = "zones.geojson"\n')
    status, _, said = batch(capsys, files[2], "--out", tmp_path / "out", "--jobs", 1)
    assert status == 2
    told = [line for line in said.splitlines() if line.startswith("pathgene: bad: ")]
    assert any('Note: zones.geojson: feature 1, "mast" left out' in line for line in told[:-1])
    assert "goal" in told[-1]


def test_zones_are_read_with_the_options(files, tmp_path, capsys):
    zones = tmp_path / "zones.txt"
    zones.write_text("AC E\nAN OPEN\nAH 9000ft MSL\nAL GND\nV X=47:01:00 N 008:02:00 E\nDC 0.1\n")
    with Path(files[0]).open("a") as file:
        file.write('[[zones]]\nfile = "zones.txt"\n')
    text = Path(files[0]).read_text().replace("[mission]", "origin = [47.0, 8.0]\n[mission]")
    Path(files[0]).write_text(text)
    options = [files[0], "--jobs", 1, "--no-picture", "--no-grid", "--out", tmp_path / "out"]
    batch(capsys, *options)
    assert json.loads((tmp_path / "out/one/summary.json").read_text())["nofly"] == []
    said = batch(capsys, *options, "--forbid", "E", "--qnh", "1000")[2]
    summary = json.loads((tmp_path / "out/one/summary.json").read_text())
    assert [zone["name"] for zone in summary["nofly"]] == ["OPEN"]
    assert summary["read"]["zones"]["options"] == {"forbid": "E", "qnh": 1000.0}
    assert "pathgene: one: Note: zones.txt: 1 zone read as OpenAir" in said
