"""All files of a run and of a diagnosis."""

import hashlib
import json

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from pathgene.host.diagnosis import diagnose
from pathgene.host.diagnosis.reason import CODES
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.aircraft_limits import AIRCRAFT_LIMITS
from pathgene.host.planners.base import Options
from pathgene.host.planners.grid.astar import AstarPlanner
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Polygon
from pathgene.host.report import picture
from pathgene.host.report.run_files import DATA, FLIGHT, verify
from pathgene.host.report.style import TROUBLE
from pathgene.host.report.summary import summarise
from pathgene.host.report.write import (
    _MEANINGS,
    _reason_scene,
    scene,
    write_diagnosis,
    write_report,
)
from pathgene.host.terrain import Terrain, load


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
    """All files that this run does not have are removed, even its picture; foreign files stay."""
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

    def fails(scene):
        raise RuntimeError("no ink")

    monkeypatch.setattr(picture, "draw", fails)
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


def test_the_title_names_the_route_of_astar(report, make_run):
    evaluator, summary, *_ = report
    told = summary | {"planner": "ga-chip", "board": None, "hardware": {"route_from": "astar"}}
    told["terrain"] = {**summary["terrain"], "name": "hills"}
    title = scene(evaluator, make_run()[1], told).title
    assert title == "hills, planned by ga-chip, route of astar"


WALL = Polygon(((1900, -50), (2100, -50), (2100, 5000), (1900, 5000)), name="border")


@pytest.fixture
def closed():
    terrain = Terrain("flat", np.full((40, 40), 100.0), 100.0, 100.0)
    return Evaluator(Problem(terrain, (500, 500, 250), (3000, 3000, 250), zones=[WALL]), threads=1)


def red_pixels(file):
    with Image.open(file) as image:
        assert image.width >= 1920
        pixels = np.asarray(image.convert("RGB")).astype(int)
    red = np.round(255 * np.array(to_rgb(TROUBLE)))
    return int((np.abs(pixels - red).max(axis=2) <= 1).sum())


def report_of(reason):
    return {"connected": False, "reason": reason}


def test_the_picture_marks_ring_and_place(closed, tmp_path):
    reason = diagnose(closed.problem).to_dict()
    written = write_diagnosis(tmp_path, report_of(reason), (closed, None, "flat"), pytest.fail)
    assert [file.name for file in written] == ["diagnosis.json", "diagnosis.png"]
    assert json.loads(written[0].read_text()) == report_of(reason)
    marked = red_pixels(written[1])
    plain = report_of({**reason, "ring": [], "place": None})
    unmarked = red_pixels(write_diagnosis(tmp_path, plain, (closed, None, "flat"), pytest.fail)[1])
    # A dashed line across a map of 800 pixels.
    assert marked - unmarked > 1000


def test_draws_what_the_search_found(closed, tmp_path):
    result = AstarPlanner().plan(closed, Options(generations=1))
    reason = diagnose(closed.problem).to_dict()
    drawn = []
    for searched in (None, result):
        write_diagnosis(tmp_path, report_of(reason), (closed, searched, "flat"), pytest.fail)
        drawn.append((tmp_path / "diagnosis.png").read_bytes())
    assert drawn[0] != drawn[1]


def test_every_code_has_a_meaning_in_words(closed):
    of_limits = {limit.name for limit in AIRCRAFT_LIMITS if limit.meaning}
    assert of_limits | set(_MEANINGS) == set(CODES)
    assert not of_limits & set(_MEANINGS)
    reason = diagnose(closed.problem).to_dict()
    scene = _reason_scene(closed, None, "flat", reason)
    assert scene.subtitle.startswith("The way is closed at every altitude, proven for every path;")


def test_a_path_leaves_no_picture_of_an_earlier_reason(closed, tmp_path):
    (tmp_path / "diagnosis.png").write_bytes(b"of an earlier run")
    report = {"connected": True, "reason": None}
    (written,) = write_diagnosis(tmp_path, report, (closed, None, "flat"), pytest.fail)
    assert json.loads(written.read_text()) == report
    assert list(tmp_path.iterdir()) == [written]
