"""The recipe "Add a format" of CONTRIBUTING.md: its file and its row are a complete format."""

import json
import re
import subprocess
import sys
import textwrap
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from pathgene.host.cli import main
from pathgene.host.formats import registry
from pathgene.host.terrain import Terrain


PAGE = Path(__file__).resolve().parents[3] / "CONTRIBUTING.md"
PLACE = {"crs": "EPSG:32632", "origin": (400_000.0, 5_130_000.0)}


def blocks():
    """Return the code of the recipe: the file of a format, and its row."""
    section = PAGE.read_text().partition("## Add a format")[2].partition("\n## ")[0]
    return map(textwrap.dedent, re.findall(r"```python\n(.*?)\n *```", section, re.DOTALL))


@pytest.fixture
def recipe(monkeypatch):
    """Add the format of the recipe, as its file and its row do."""
    module_text, row_text = blocks()
    names = {}
    exec(row_text, names)
    row = names["row"]
    module = ModuleType(f"pathgene.host.formats.{row.name}")
    exec(module_text, vars(module))
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(registry, "FORMATS", (row, *registry.FORMATS))
    return row


@pytest.fixture
def plain(tmp_path):
    """Write a plain with a place on Earth."""
    file = tmp_path / "plain.npz"
    terrain = Terrain("plain", np.zeros((41, 61)), 100.0, 100.0, **PLACE)
    with file.open("wb") as opened:
        terrain.save_npz(opened, np.zeros((41, 61), dtype=bool))
    return terrain, file


@pytest.mark.usefixtures("recipe")
def test_a_format_of_one_file_and_one_row_is_written_and_read(plain, tmp_path, capsys):
    terrain, file = plain
    out, zones = tmp_path / "out", tmp_path / "zones.txt"
    ring = np.array([(2500.0, 1500.0), (3500.0, 1500.0), (3500.0, 2500.0), (2500.0, 1500.0)])
    lat, lon = terrain.to_geographic(*ring.T)
    corners = ", ".join(f"{east} {north}" for east, north in zip(lon, lat, strict=True))
    zones.write_text(f"POLYGON (({corners}))\n")
    ends = ("--start", "500,500,100", "--goal", "5500,3500,100")
    arguments = ["plan", "--terrain", str(file), *ends, "--planner", "astar", "--no-picture"]
    assert main([*arguments, "--nofly", str(zones), "--out", str(out), "--write", "wkt"]) == 0
    summary = json.loads((out / "summary.json").read_text())

    (zone,) = summary["nofly"]
    assert np.allclose(zone["polygon"], ring[:3], atol=1e-3)
    written = (out / "path.wkt").read_text()
    assert written.startswith("LINESTRING Z (")
    numbers = np.array([row.split() for row in written[14:-2].split(",")], float)
    x, y = terrain.to_local(numbers[:, 1], numbers[:, 0])
    assert np.allclose(np.column_stack((x, y, numbers[:, 2])), summary["waypoints"], atol=1e-3)
    assert "path.wkt" in summary["files"]
    again = tmp_path / "again"
    assert main(["export", str(out / "summary.json"), "--write", "wkt", "--out", str(again)]) == 0
    assert (again / "path.wkt").read_text() == written


@pytest.mark.usefixtures("recipe")
def test_its_row_is_in_help_and_sentences(plain, tmp_path, capsys):
    _, file = plain
    with pytest.raises(SystemExit):
        main(["export", "--help"])
    assert "wkt (databases)" in " ".join(capsys.readouterr().out.split())
    assert main(["export", str(file), "--write", "gpx"]) == 2
    assert "give some of wkt, plan, waypoints," in capsys.readouterr().err
    bad = tmp_path / "bad.wkt"
    bad.write_text("POLYGON ((one two))")
    ends = ("--start", "500,500,100", "--goal", "5500,3500,100")
    assert main(["plan", "--terrain", str(file), *ends, "--nofly", str(bad)]) == 2
    # The report on the terrain stands above it.
    assert capsys.readouterr().err.splitlines()[-1] == (
        f"pathgene: No-fly file {str(bad)!r}: polygon 1: 'one two' are no longitudes and latitudes."
    )
    assert ".wkt" in registry.zone_suffixes()


def test_its_row_is_in_the_options_of_a_plan():
    """The options are made when their table is imported, after the row is added."""
    _, row_text = blocks()
    code = f"""{row_text}
from pathgene.host.formats import registry
registry.FORMATS = (row, *registry.FORMATS)
from pathgene.host.cli import main
main(["plan", "--help"])
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=PAGE.parent
    )
    text = " ".join(done.stdout.split())
    assert "the fences of a .waypoints, the fences of a .plan or well-known text" in text
    assert "wkt (databases), plan (QGroundControl, MAVSDK), waypoints" in text
