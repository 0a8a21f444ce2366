"""Recipes of CONTRIBUTING.md: each is followed as it stands there."""

import re
import sys
import textwrap
import types
from pathlib import Path

import numpy as np
import pytest

from pathgene import Problem, Terrain, plan
from pathgene.host.cli import main
from pathgene.host.compare.entrants import parse_entrants
from pathgene.host.planners import PLANNERS, registry


PAGE = (Path(__file__).resolve().parents[2] / "CONTRIBUTING.md").read_text("utf-8")


def recipe(title):
    """Return the Python of a chapter, a text for each fence."""
    chapter = re.search(rf"^## {title}\n(.*?)^## ", PAGE, re.DOTALL | re.MULTILINE)[1]
    found = re.findall(r"^ *```python\n(.*?)^ *```$", chapter, re.DOTALL | re.MULTILINE)
    return [textwrap.dedent(text) for text in found]


@pytest.fixture
def straight(monkeypatch):
    """The planner of the recipe, in the table: its file, and its row."""
    source, row = recipe("Add a planner")
    module = types.ModuleType("pathgene.host.planners.grid.straight")
    exec(compile(source, "straight.py", "exec"), vars(module))
    monkeypatch.setitem(sys.modules, module.__name__, module)
    for name, entry in eval(f"{{{row}}}", vars(registry)).items():
        monkeypatch.setitem(PLANNERS, name, entry)


def test_a_planner_is_two_files(straight, capsys, tmp_path):
    """The command line, comparisons and the API know it without another change."""
    ends = ["--terrain", "canyon", "--agl", "--start", "300,300,60", "--goal", "4700,4600,60"]
    assert main(["plan", *ends, "--planner", "straight", "--fallback", "none", "--no-picture",
                 "--out", str(tmp_path / "out")]) == 0  # fmt: skip
    assert "straight" in capsys.readouterr().out
    # Runs of a comparison are other processes, which import the tables of the sources.
    assert [entrant.planner for entrant in parse_entrants("straight,astar", {}, {})] == [
        "straight",
        "astar",
    ]
    problem = Problem(Terrain.load("canyon"), (300, 300, 60), (4700, 4600, 60), agl=True)
    found = plan(problem, "straight")
    assert found.summary["planner"] == "straight"
    np.testing.assert_array_equal(found.path[[0, -1]], [problem.start, problem.goal])
