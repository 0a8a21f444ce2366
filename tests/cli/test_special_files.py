"""Every command writes to devices, FIFOs and sockets, and never replaces them."""

import json
import os
import socket
import tempfile
from pathlib import Path

import pytest

from pathgene.host.cli import main
from tests.cli.conftest import ENDS


NULL = Path("/dev/null")


def link(folder, *names):
    """Put links to a device into a folder; return a function that asserts that they still exist."""
    folder.mkdir(exist_ok=True)
    links = [folder / name for name in names]
    for file in links:
        file.symlink_to(NULL)

    def check():
        assert all(file.is_symlink() for file in links)
        assert NULL.is_char_device()

    return check


@pytest.mark.ci
def test_plan(hills, tmp_path):
    check = link(tmp_path, "terrain.npz", "path.geojson", "path.png", "path.kml", "path.waypoints")
    command = ["plan", "--terrain", str(hills), *ENDS, "--planner", "astar", "--as-paper"]
    place = ["--origin", "-33.5,151.25", "--write", "kml", "--out", str(tmp_path)]
    assert main([*command, *place]) == 0  # path.waypoints is a file to be removed.
    check()
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert list(summary["files"]) == ["terrain.npz", "path.geojson", "path.kml"]

    (tmp_path / "path.plan").symlink_to(NULL)
    (tmp_path / "terrain.npz").unlink()  # No terrain is read from a device.
    export = ["export", str(tmp_path / "summary.json")]
    assert main([*export, "--write", "plan,kml"]) == 0
    (tmp_path / "terrain.npz").symlink_to(NULL)
    check()
    assert (tmp_path / "path.plan").is_symlink()


def test_the_summary_of_a_plan(hills, tmp_path):
    check = link(tmp_path, "summary.json", "problem.toml")
    command = ["plan", "--terrain", str(hills), *ENDS, "--planner", "astar", "--as-paper"]
    saving = ["--save-problem", str(tmp_path / "problem.toml")]
    assert main([*command, "--no-picture", "--out", str(tmp_path), *saving]) == 0
    check()
    assert (tmp_path / "path.geojson").stat().st_size > 1000


def test_a_plan_whose_path_nobody_reads_is_kept(hills, tmp_path, capsys, monkeypatch):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    out = tmp_path / "out"
    out.mkdir()
    os.mkfifo(out / "path.geojson")
    command = ["plan", "--terrain", str(hills), *ENDS, "--planner", "astar", "--as-paper"]
    assert main([*command, "--no-picture", "--out", str(out)]) == 2
    (kept,) = temporary.iterdir()
    assert capsys.readouterr().err.splitlines()[-1] == (
        f"pathgene: Cannot write to the directory {str(out)!r} (path.geojson is a pipe that nobody "
        f"reads); give another (--out); this plan is kept in {str(kept)!r}."
    )
    assert [file.name for file in out.iterdir()] == ["path.geojson"]
    assert (kept / "summary.json").stat().st_size > 1000


@pytest.mark.parametrize("words", [("terrain", "synth", "canyon", "--out"), ("problem", "new")])
def test_a_single_file(tmp_path, words):
    check = link(tmp_path, "file.npz")
    assert main([*words, str(tmp_path / "file.npz")]) == 0
    check()


@pytest.mark.ci
def test_verilog(tmp_path):
    check = link(tmp_path, "chip.v")
    assert main(["verilog", "--top", "ga_core", "--out", str(tmp_path / "chip.v")]) == 0
    check()


@pytest.mark.ci
def test_compare(hills, tmp_path):
    check = link(tmp_path, "compare.json", "compare.png")
    runs = ["--planners", "ga-pc", "--runs", "2", "--generations", "2", "--jobs", "1"]
    assert main(["compare", "--terrain", str(hills), *ENDS, *runs, "--out", str(tmp_path)]) == 0
    check()
    assert (tmp_path / "runs.jsonl").read_text().count("\n") == 2


@pytest.mark.ci
def test_batch(hills, tmp_path):
    out = tmp_path / "out"
    checks = [link(out, "batch.json"), link(out / "one", "path.geojson", "path.png")]
    file = tmp_path / "one.toml"
    file.write_text(
        f'[terrain]\nsource = "{hills}"\n[mission]\nstart = [500, 500, 100]\n'
        'goal = [5500, 3500, 100]\nagl = true\n[planner]\nname = "astar"\n'
    )
    assert main(["batch", str(file), "--jobs", "1", "--no-picture", "--out", str(out)]) == 0
    for check in checks:
        check()


@pytest.mark.ci
def test_auv(tmp_path):
    check = link(tmp_path, "auv.json", "auv.png")
    assert main(["auv", "--generations", "1", "--out", str(tmp_path)]) == 0
    check()


@pytest.mark.ci
def test_diagnose(hills, tmp_path):
    check = link(tmp_path, "diagnosis.json", "diagnosis.png")
    assert main(["diagnose", "--terrain", str(hills), *ENDS, "--out", str(tmp_path)]) in (0, 1)
    check()


def test_a_socket_refuses_and_stays(tmp_path, capsys):
    file = tmp_path / "file.npz"
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(file))
        assert main(["terrain", "synth", "canyon", "--out", str(file)]) == 2
    assert capsys.readouterr().err == (
        f"pathgene: Cannot write to {str(file)!r} (No such device or address); give another file "
        "(--out).\n"
    )
    assert file.is_socket()
