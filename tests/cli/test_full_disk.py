"""``pathgene plan`` into the folder of an older run, on a disk that fails at each call in turn."""

import errno
import json
import os
import shutil
import tempfile

import pytest

from pathgene.host.cli import main
from pathgene.host.errors import InputError
from pathgene.host.files.disk import using
from pathgene.host.report.run_files import verify
from tests.cli.conftest import ENDS
from tests.support.bad_input.runs import REPORTED
from tools.faults.disk import FaultyDisk, Killed


pytestmark = pytest.mark.ci

PLACED = ("--planner", "astar", "--as-paper", "--origin", "-33.5,151.25", "--no-picture")
OLD_ENDS = ("--start", "500,500,100", "--goal", "5000,3000,100", "--agl")
OLD_FILES = {"path.geojson", "path.kml", "path.plan", "path.png", "summary.json", "terrain.npz"}
NEW_FILES = {"path.geojson", "path.kml", "path.waypoints", "summary.json", "terrain.npz"}


@pytest.fixture(scope="module")
def older(hills, tmp_path_factory):
    """Return the folder of an older run."""
    out = tmp_path_factory.mktemp("older")
    command = ["plan", "--terrain", str(hills), *OLD_ENDS, *PLACED, "--out", str(out)]
    assert main([*command, "--write", "kml,plan"]) == 0
    (out / "path.png").write_bytes(b"a picture")
    assert {file.name for file in out.iterdir()} == OLD_FILES
    return out


def plan(hills, out):
    """Plan a different problem, whose files differ."""
    command = ["plan", "--terrain", str(hills), *ENDS, *PLACED, "--out", str(out)]
    return main([*command, "--write", "kml,waypoints"])


def content(folder):
    """Return the visible files with their content, and the number of hidden files."""
    files = {file.name: file.read_bytes() for file in folder.iterdir()}
    visible = {name: text for name, text in files.items() if name[0] != "."}
    return visible, len(files) - len(visible)


def is_newer(folder):
    """Return whether the visible files are exactly the newer run's."""
    file = folder / "summary.json"
    summary = json.loads(file.read_text())
    try:
        verify(file, summary)
    except InputError:
        return False
    return set(content(folder)[0]) == NEW_FILES == {*summary["files"], "summary.json"}


def calls(hills, older, out):
    """Copy the older run, and return the number of calls that the newer one takes."""
    shutil.copytree(older, out)
    with using(disk := FaultyDisk()):
        assert plan(hills, out) == 0
    assert is_newer(out)
    return len(disk.calls)


@pytest.mark.parametrize(
    ("error", "lasting"),
    [
        # A disk that refuses one call with EIO also refuses to remove a file.
        pytest.param(errno.ENOSPC, False, marks=pytest.mark.long),
        (errno.ENOSPC, True),
        (errno.EIO, False),
        pytest.param(errno.EROFS, True, marks=pytest.mark.long),
    ],
)
def test_a_failing_disk_leaves_the_older_run_or_the_newer_one(
    hills, older, tmp_path, capsys, monkeypatch, error, lasting
):
    """If only the folder fails, the plan is kept elsewhere."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    ended, rescued = [], 0
    for at in range(1, calls(hills, older, tmp_path / "count") + 1):
        out = tmp_path / str(at)
        shutil.copytree(older, out)
        capsys.readouterr()
        with using(disk := FaultyDisk(at, error=error, lasting=lasting, seed=at)):
            status = plan(hills, out)
        said = capsys.readouterr().err
        ended.append(status)
        visible, hidden = content(out)
        if status == 0:
            assert is_newer(out)
        else:
            assert status == 2
            reason = os.strerror(error)
            if "put back" in said:  # A disk that takes nothing at all any more.
                assert (error, lasting) == (errno.EROFS, True)
                reason += ", and not all older files could be put back"
                assert main(["check", "--path", str(out / "summary.json")]) == 2
            else:
                assert visible == content(older)[0]
            kept = list(temporary.iterdir())
            sentence = (
                f"pathgene: Cannot write to the directory {str(out)!r} ({reason}); give another "
                "(--out)"
            )
            if kept:
                assert not lasting
                sentence += f"; this plan is kept in {str(kept[0])!r}"
                assert is_newer(kept[0])
                shutil.rmtree(kept[0])
            assert said.splitlines()[-1] == f"{sentence}."
            rescued += bool(kept)
        refused = any(call.startswith("unlink") for call in disk.calls[at - 1 :])
        assert not hidden or (refused and error != errno.ENOSPC)
        with using(FaultyDisk()):  # Which fails no more.
            assert plan(hills, out) == 0
        assert is_newer(out)
        assert content(out)[1] == 0
    assert set(ended) == {0, 2}
    assert bool(rescued) != lasting


def test_a_killed_plan_leaves_a_run_or_a_mixture_that_check_names(hills, older, tmp_path, capsys):
    mixed = 0
    for at in range(1, calls(hills, older, tmp_path / "count") + 1):
        out = tmp_path / str(at)
        shutil.copytree(older, out)
        with using(FaultyDisk(at, kill=True, seed=at)), pytest.raises(Killed):
            plan(hills, out)
        capsys.readouterr()
        status = main(["check", "--as-paper", "--path", str(out / "summary.json")])
        if content(out)[0] == content(older)[0] or is_newer(out):
            assert status == 0
        else:
            mixed += 1
            assert status == 2
            assert "altered or of another run; remove it, or plan again." in capsys.readouterr().err
        with using(FaultyDisk()):  # Which fails no more.
            assert plan(hills, out) == 0
        assert is_newer(out)
        assert content(out)[1] == 0
    assert mixed


def test_a_picture_or_a_problem_that_cannot_be_written(hills, older, tmp_path, capsys):
    """The picture of a whole run is missing, or there is no run, but never a part of either."""

    def run(at=None):
        out, problem = tmp_path / str(at) / "out", tmp_path / str(at) / "problem.toml"
        shutil.copytree(older, out)
        problem.write_text("older")
        command = ["plan", "--terrain", str(hills), *ENDS, *PLACED, "--picture", "--out", str(out)]
        capsys.readouterr()
        with using(disk := FaultyDisk(at, error=errno.EIO, seed=at or 0)):
            saved = ["--save-problem", str(problem), "--write", "kml,waypoints"]
            status = main([*command, *saved])
        return status, out, problem, disk.calls, capsys.readouterr().err.splitlines()

    _, out, problem, calls, _ = run()
    picture, whole = (out / "path.png").read_bytes(), problem.read_text()
    drawn = calls.index("rename summary.json")
    outcomes = set()
    for at, call in enumerate(calls, start=1):
        is_saving = "problem.toml" in call
        if not (is_saving or ("path.png" in call and at > drawn)):
            continue
        status, out, problem, _, said = run(at)
        visible, hidden = content(out)
        has_picture = visible.pop("path.png") == picture if "path.png" in visible else False
        outcomes.add((is_saving, status, has_picture))
        if status == 0:
            assert problem.read_text() == whole
            assert set(visible) == NEW_FILES
            sentence = "pathgene: There is no picture this time, drawing it failed: OSError: "
            assert has_picture or said[-1].startswith(sentence)
        else:
            assert said[-1:] == [
                f"pathgene: Cannot write to {str(problem)!r} (Input/output error); give another "
                "file (--out)."
            ]
            assert all(line.startswith(REPORTED) for line in said[:-1])
            assert problem.read_text() == "older"
            assert {**visible, "path.png": b"a picture"} == content(older)[0]
        assert not hidden
    # With the picture, which removes the older one that could not be removed; without; no run.
    assert outcomes == {(False, 0, True), (False, 0, False), (True, 2, False)}
