# amaranth: UnusedElaboratable=no
"""Recipes of CONTRIBUTING.md: each is followed as it stands there."""

import inspect
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
from tests.support.gateware.unit_pool import unit_classes
from tests.unit.test_documented_ports import compare, documented


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


@pytest.fixture
def unit():
    """The unit of the recipe, and the program that tests it."""
    source, test = recipe("Add a unit")
    names = {"__name__": "pathgene.hdl.primitives.pulse_counter"}
    exec(compile(source, "pulse_counter.py", "exec"), names)
    exec(compile(test, "test_pulse_counter.py", "exec"), names)
    yield names["PulseCounter"], names["test_counts_pulses"]
    # Other tests see the units that exist.
    names["PulseCounter"].__module__ = "recipe"


def test_a_unit_declares_its_parameters(unit):
    """Its checks and its documentation come with the declaration, and tests find the unit."""
    kind, test = unit
    test()
    assert kind in unit_classes()
    assert "count_bits : int\n    Count width, 1 or more.\n" in inspect.getdoc(kind)
    assert "step : int, default 1\n    Step, from 1 to 2**count_bits - 1. " in inspect.getdoc(kind)
    for arguments, message in (
        ((0,), "Count width must be 1 or more, not 0"),
        ((3, 8), "Step must be from 1 to 7, not 8"),
    ):
        with pytest.raises(ValueError, match=f"^{message}$"):
            kind(*arguments)
    with pytest.raises(TypeError, match=r"^Count width must be an integer, not '3'$"):
        kind("3")


def test_ports_of_a_unit_are_compared_with_its_docstring(unit):
    kind, _ = unit
    members, names = kind(3).signature.members, {"count_bits": 3}
    assert set(members) == documented(kind).keys()
    assert compare(members, documented(kind), names) == ([], 2)
    kind.__doc__ = inspect.getdoc(kind).replace("Out(count_bits)", "Out(count_bits + 1)")
    assert compare(members, documented(kind), names)[0] == [("count", "Out(count_bits + 1)")]
    kind.__doc__ = inspect.getdoc(kind).replace("pulse : In(1)\n", "")
    assert set(members) - documented(kind).keys() == {"pulse"}
