"""All files of a run."""

import hashlib
import json

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.report import picture
from pathgene.host.report.run_files import DATA, FLIGHT, verify
from pathgene.host.report.summary import summarise
from pathgene.host.report.write import scene, write_report
from pathgene.host.terrain import load


FILES = ["path.geojson", "path.png", "summary.json", "terrain.npz"]


@pytest.fixture
def report(make_run, tmp_path):
    evaluator, result = make_run(void=True)
    summary = summarise(evaluator, result, planner="ga-pc", board=None, seed=0, source={})
    warnings = []

    def write(directory=tmp_path, **options):
        return write_report(directory, evaluator, result, summary, warnings.append, **options)

    return evaluator, summary, warnings, write


def names(directory):
    return sorted(entry.name for entry in directory.iterdir())


def test_writes_exactly_the_files(report, tmp_path):
    evaluator, summary, warnings, write = report
    written, whole = write()
    assert sorted(path.name for path in written) == names(tmp_path) == FILES
    assert warnings == []
    assert json.loads((tmp_path / "summary.json").read_text()) == whole
    assert whole == {**summary, "files": whole["files"]}
    for name in ("terrain.npz", "path.geojson"):
        content = (tmp_path / name).read_bytes()
        assert whole["files"].pop(name) == hashlib.sha256(content).hexdigest()
    assert whole["files"] == {}
    problem = evaluator.problem
    with np.load(tmp_path / "terrain.npz") as grid:
        assert np.array_equal(grid["elevation"], problem.terrain.elevation, equal_nan=True)
        assert np.array_equal(grid["nofly"], problem.nofly_raster)
        assert (float(grid["dx_m"]), float(grid["dy_m"])) == (100.0, 100.0)
    assert np.array_equal(
        load(tmp_path / "terrain.npz").elevation, problem.terrain.elevation, equal_nan=True
    )


def test_the_files_of_an_earlier_run_go(report, tmp_path):
    """All that this run does not have, its picture included; files of other programs stay."""
    *_, write = report
    for name in (*DATA, *FLIGHT, "path.png", "notes.txt"):
        (tmp_path / name).write_text("of an earlier run")
    written, whole = write(picture=False, grid=False, others={"path.kml": b"kml"})
    assert [path.name for path in written] == ["summary.json", "path.geojson", "path.kml"]
    assert list(whole["files"]) == ["path.geojson", "path.kml"]
    assert names(tmp_path) == ["notes.txt", "path.geojson", "path.kml", "summary.json"]
    verify(tmp_path / "summary.json", whole)


def test_an_error_in_the_picture_loses_only_the_picture(report, tmp_path, monkeypatch):
    *_, warnings, write = report

    def fails(scene, file):
        raise RuntimeError("no ink")

    monkeypatch.setattr(picture, "write", fails)
    (tmp_path / "path.png").write_text("of an earlier run")
    written, _ = write()
    assert sorted(path.name for path in written) == names(tmp_path)
    assert "path.png" not in names(tmp_path)
    assert warnings == ["There is no picture this time, drawing it failed: RuntimeError: no ink."]


def test_reports_a_removed_directory(report, tmp_path):
    *_, write = report
    gone = tmp_path / "gone"
    with pytest.raises(InputError) as caught:
        write(gone)
    assert str(caught.value) == (
        f"Cannot write to the directory {str(gone)!r} (No such file or directory); give another "
        "(--out)."
    )


@pytest.mark.parametrize(
    ("legs", "title"),
    [
        ([], "hills, planned by fpa, path by astar"),
        (
            [{"planned": True, "generations": 0, "fitness": 1.5}] * 2,
            "hills, planned by fpa, in part by astar",
        ),
    ],
)
def test_the_title_names_the_fallback(report, make_run, legs, title):
    evaluator, summary, *_ = report
    _, result = make_run()
    told = {**summary, "planner": "fpa", "fallback": "astar", "legs": legs}
    told["terrain"] = {**summary["terrain"], "name": "hills"}
    assert scene(evaluator, result, told).title == title
