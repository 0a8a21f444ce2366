"""Recipes of CONTRIBUTING.md: each is followed literally."""

import inspect
import os
import re
import subprocess
import sys
import textwrap
import types

import numpy as np
import pytest

from pathgene import Problem, Terrain, plan
from pathgene.host.cli import main
from pathgene.host.compare.entrants import parse_entrants
from pathgene.host.planners import PLANNERS, registry
from tests.docs.pages import ROOT, copy_sources
from tests.support.gateware.unit_pool import unit_classes
from tests.unit.test_documented_ports import compare, documented


PAGE = (ROOT / "CONTRIBUTING.md").read_text("utf-8")


def recipe(title, language="python"):
    """Return the fences of a chapter in a language."""
    chapter = re.search(rf"^## {title}\n(.*?)^## ", PAGE, re.DOTALL | re.MULTILINE)[1]
    found = re.findall(rf"^ *```{language}\n(.*?)^ *```$", chapter, re.DOTALL | re.MULTILINE)
    return [textwrap.dedent(text) for text in found]


def follow(places, folder):
    """Write the lines of a recipe into the files that its headings name."""
    headings = r"^(\S+), (?:(after|before) `(.+)`|instead of the comment at the top of (\S+)):\n"
    _, *parts = re.split(headings, places, flags=re.MULTILINE)
    for file, side, anchor, model, lines in zip(*(parts[at::5] for at in range(5)), strict=True):
        text = (folder / (model or file)).read_text("utf-8")
        if model:
            text = lines + re.sub(r"\A(#.*\n)+", "", text)
        else:
            anchor = anchor.replace("\\`", "`")
            (found,) = re.finditer(rf"^.*{re.escape(anchor)}.*\n", text, re.MULTILINE)
            at = found.end() if side == "after" else found.start()
            text = text[:at] + lines + text[at:]
        (folder / file).write_text(text, "utf-8")


PYTEST = "pytest", "-n", "0", "-p", "no:cacheprovider", "-v"


def run(folder, *command):
    """Run a module of the copy in ``folder``."""
    done = subprocess.run(
        [sys.executable, "-m", *command],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:]
    return done.stdout


@pytest.fixture
def straight(monkeypatch):
    """The planner of the recipe in the table: its file and its row."""
    source, row = recipe("Add a planner")
    module = types.ModuleType("pathgene.host.planners.grid.straight")
    exec(compile(source, "straight.py", "exec"), vars(module))
    monkeypatch.setitem(sys.modules, module.__name__, module)
    for name, entry in eval(f"{{{row}}}", vars(registry)).items():
        monkeypatch.setitem(PLANNERS, name, entry)


def test_a_planner_is_two_files(straight, capsys, tmp_path):
    """The command line, comparisons and the API know it without further changes."""
    ends = ["--terrain", "canyon", "--agl", "--start", "300,300,60", "--goal", "4700,4600,60"]
    assert main(["plan", *ends, "--planner", "straight", "--fallback", "none", "--no-picture",
                 "--out", str(tmp_path / "out")]) == 0  # fmt: skip
    assert "straight" in capsys.readouterr().out
    # Runs of a comparison are separate processes, which import the tables of the sources.
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
    # The remaining tests see the existing units.
    names["PulseCounter"].__module__ = "recipe"


def test_a_unit_declares_its_parameters(unit):
    """The declaration provides its checks and documentation, and tests find the unit."""
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


@pytest.mark.ci
def test_a_board_is_a_file_and_its_rows(tmp_path):
    copy_sources(tmp_path)
    (source,), (places,) = recipe("Add a board"), recipe("Add a board", "text")
    (tmp_path / "hdl" / "boards" / "ulx3s_25f.py").write_text(source)
    follow(places, tmp_path)
    chosen = "[ulx3s-25f or default_chip or every_file or only_chips or unknown_board"
    told = run(tmp_path, *PYTEST, "-k", chosen, "tests/unit/boards")
    assert told.count("ulx3s-25f") >= 6
    run(tmp_path, "pathgene.hdl.boards.build", "ulx3s-25f", "--sources")
    folder = tmp_path / "build" / "bitstream" / "ulx3s-25f" / "paper"
    assert "--25k" in (folder / "build_chip.sh").read_text()
    assert 'LOCATE COMP "uart_0__rx__io" SITE "M1"' in (folder / "chip.lpf").read_text()
    # The mutation tester only alters gateware, which tables of boards are not.
    assert "ulx3s_25f" not in run(tmp_path, "tools.mutate", "--list", "--count", "4000")


# A host of the message: the model takes a value and refuses 0.
HOST = """
from pathgene.host.device.boards import open_board
from pathgene.host.device.link import RefusedError
with open_board("model:?checker=none") as chip:
    chip.ping(5)
    try:
        chip.ping(0)
    except RefusedError as error:
        print(error)
"""


@pytest.mark.long
def test_a_message_is_a_row_of_each_part(tmp_path):
    copy_sources(tmp_path)
    (places,) = recipe("Add a message", "text")
    follow(places, tmp_path)
    for file in tmp_path.rglob("*.py"):
        text = file.read_text("utf-8")
        if "ping_request" in text:
            home = "from pathgene.hdl.protocol.messages import "
            text = text.replace(f"\n{home}", f"\n{home}ping_request\n{home}", 1)
            file.write_text(text, "utf-8")
    (tmp_path / "use_ping.py").write_text(HOST)
    assert "BAD_VALUE" in run(tmp_path, "use_ping")
    run(tmp_path, "tools.protocol_page")
    page = (tmp_path / "docs" / "protocol.md").read_text("utf-8")
    assert "| 19 | [PING](#ping) | send a value | fields | none |" in page
    assert "| 0 | 8 | `value` | 1 … 255 | Any value but 0 |" in page
    tests = ("tools/test_protocol_page", "command/test_receiver", "command/test_receiver_runs")
    files = [f"tests/unit/{name}.py" for name in (*tests, "model/test_chip")]
    chosen = "[19- or refused or every_command or committed or golden"
    told = run(tmp_path, *PYTEST, "-k", chosen, *files)
    # Each refused value by the model, and all of them by the receiver.
    assert len(re.findall(r"\[19-.*PASSED", told)) >= 2
    assert re.search(r"test_receiver\.py::test_refused PASSED", told)
