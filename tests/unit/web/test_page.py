"""The page of a plan: a single file that does not use the network, and refused inputs."""

import base64
import json
import re
from html.parser import HTMLParser
from importlib import metadata

import numpy as np
import pytest

from pathgene.host.cli import main
from pathgene.host.errors import InputError
from pathgene.host.problem.zones import Zone
from pathgene.host.report.read import read_run
from pathgene.host.terrain import Terrain
from pathgene.host.web import page as pages
from pathgene.host.web.page import MODULES, page_of, three_js
from pathgene.host.web.scene import zones_scene
from tests.support.host.web_plans import KINDS, evaluated, page_text, planned


MOST_BYTES = 8_000_000
NAMESPACES = {"http://www.w3.org/1999/xhtml"}


class Elements(HTMLParser):
    """Collects attributes and the text of scripts."""

    def __init__(self, text):
        super().__init__()
        self.links, self.scripts, self.inside = [], {}, None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.links += [values[name] for name in ("src", "href", "action") if name in values]
        if tag == "script":
            self.inside = values["type"]
            self.scripts[self.inside] = ""

    def handle_endtag(self, tag):
        if tag == "script":
            self.inside = None

    def handle_data(self, data):
        if self.inside:
            self.scripts[self.inside] += data


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_is_one_file_that_loads_nothing(kind):
    text = page_text(kind)
    assert len(text.encode()) < MOST_BYTES
    elements = Elements(text)
    assert all(link.startswith("data:") for link in elements.links)
    imports = json.loads(elements.scripts["importmap"])["imports"]
    assert set(imports) == {"nicegui-scene", *MODULES}
    programs = [elements.scripts["module"]]
    for url in imports.values():
        kind_of_data, _, content = url.partition("base64,")
        assert kind_of_data == "data:text/javascript;"
        programs.append(base64.b64decode(content).decode())
    addresses = set(re.findall(r"https?://[^\s\"'`)]+", "".join(programs)))
    assert addresses <= NAMESPACES
    assert not re.search(r"https?:", text)
    for program in programs:
        # Every import has its module in the file.
        assert set(re.findall(r'from "([^"]+)";', program)) <= set(imports)
    assert "default-src 'none'" in text


@pytest.mark.parametrize("kind", KINDS)
def test_the_scene_in_a_page_has_the_figures_of_the_summary(kind):
    scene = json.loads(Elements(page_text(kind)).scripts["application/json"])
    summary = planned(kind).summary
    for figure in scene["figures"]:
        if not figure["key"].startswith("legs"):
            assert figure["value"] == summary[figure["key"]]
    assert scene["verdict"]["feasible"] == summary["feasible"]


def test_names_of_a_user_are_no_markup():
    evaluator, path = evaluated(Terrain("</script><b>x", np.zeros((20, 20)), 100, 100))
    text = page_of(evaluator, path, {"terrain": {"name": "</script><b>x"}, "planner": "{{scene}}"})
    assert "<b>x" not in text
    elements = Elements(text)
    assert json.loads(elements.scripts["application/json"])["title"] == "</script><b>x"
    assert set(elements.scripts) == {"application/json", "importmap", "module"}


@pytest.mark.ci
def test_the_page_of_a_huge_problem_keeps_its_size():
    rng = np.random.default_rng(1)
    terrain = Terrain("huge", rng.uniform(0, 900, (3000, 2500)), 30, 30)
    evaluator, path = evaluated(terrain)
    corners = rng.uniform(0, 70_000, (30_000, 2))
    squares = np.array([[0, 0], [9, 0], [9, 9], [0, 9], [4, 4]])
    zones = tuple(Zone.polygon(corner + squares, name="zone") for corner in corners)
    drawn = zones_scene(zones)
    assert len(drawn) == 12_000
    text = page_of(evaluator, path, {})
    assert len(text.encode()) + len(json.dumps(drawn)) < MOST_BYTES


def test_the_library_has_what_the_views_import():
    exports = re.search(r"export\{([^}]*)\}", three_js())[1]
    assert {"THREE", "OrbitControls"} <= {name.split(" as ")[-1] for name in exports.split(",")}


@pytest.fixture
def run(tmp_path):
    """Folder of a finished plan."""
    planned("plain").save(tmp_path, picture=False)
    return tmp_path


def test_export_writes_a_page_with_its_digest(run, capsys):
    file = run / "summary.json"
    assert main(["export", str(file), "--write", "html"]) == 0
    assert str(run / "path.html") in capsys.readouterr().out
    assert (run / "path.html").read_text().startswith("<!DOCTYPE html>")
    read_run(file)
    (run / "path.html").write_text("altered")
    with pytest.raises(InputError, match=r"path\.html is not the file that the run of"):
        read_run(file)


def test_plan_writes_a_page(run, tmp_path, capsys):
    terrain = str(run / "terrain.npz")
    ends = ["--start", "200,200,90", "--goal", "2800,2200,90", "--agl"]
    out = tmp_path / "page"
    options = ["--planner", "astar", "--generations", "1", "--no-picture", "--out", str(out)]
    assert main(["plan", "--terrain", terrain, *ends, *options, "--write", "html"]) == 0
    scene = json.loads(Elements((out / "path.html").read_text()).scripts["application/json"])
    summary = json.loads((out / "summary.json").read_text())
    lengths = [figure["value"] for figure in scene["figures"] if figure["key"] == "length_m"]
    assert lengths == [summary["length_m"]]
    assert "path.html" in summary["files"]


def test_without_the_extra_one_sentence_names_it(run, monkeypatch, capsys):
    def missing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(pages.metadata, "distribution", missing)
    before = {file: file.read_bytes() for file in run.iterdir()}
    assert main(["export", str(run / "summary.json"), "--write", "html,geojson"]) == 2
    assert capsys.readouterr().err == (
        "pathgene: The page needs three.js of the extra: pip install 'pathgene[desk]' "
        "(--write html).\n"
    )
    assert {file: file.read_bytes() for file in run.iterdir()} == before
    terrain = str(run / "terrain.npz")
    ends = ["--start", "200,200,90", "--goal", "2800,2200,90", "--agl"]
    folder = run / "none"
    assert main(["plan", "--terrain", terrain, *ends, "--write", "html", "--out", str(folder)]) == 2
    assert "pathgene[desk]" in capsys.readouterr().err
    assert not folder.exists()
