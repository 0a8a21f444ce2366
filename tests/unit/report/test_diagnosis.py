"""The files of a diagnosis."""

import json

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from pathgene.host.diagnosis import diagnose
from pathgene.host.diagnosis.reason import CODES
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.aircraft_limits import AIRCRAFT_LIMITS
from pathgene.host.planners.base import Options
from pathgene.host.planners.grid.astar import AstarPlanner
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Polygon
from pathgene.host.report.diagnosis import _MEANINGS, _scene, write_diagnosis
from pathgene.host.report.palette import TROUBLE
from pathgene.host.terrain import Terrain


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
    scene = _scene(closed, None, "flat", reason)
    assert scene.subtitle.startswith("The way is closed at every altitude, proven for every path;")


def test_a_path_leaves_no_picture_of_an_earlier_reason(closed, tmp_path):
    (tmp_path / "diagnosis.png").write_bytes(b"of an earlier run")
    report = {"connected": True, "reason": None}
    (written,) = write_diagnosis(tmp_path, report, (closed, None, "flat"), pytest.fail)
    assert json.loads(written.read_text()) == report
    assert list(tmp_path.iterdir()) == [written]
