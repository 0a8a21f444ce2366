"""Coverage of the host: decisions, their vectors, pairs, and the table of the documentation."""

import ast
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from tools.conditions.decisions import instrument
from tools.conditions.page import PAGE, table_in
from tools.conditions.pairs import lacking
from tools.conditions.plugin import VARIABLE
from tools.conditions.recorder import Recorder
from tools.conditions.rooms import LEAST_PERCENT, ROOMS, ROOT, files_of


def without_pair(source, *calls):
    """Return the conditions of a function ``f`` that calls with these arguments leave without."""
    tree, decisions = instrument("module", source)
    recorder = Recorder()
    names, plain = recorder.names(), {}
    exec(compile(tree, "module", "exec"), names)
    exec(source, plain)
    for arguments in calls:
        assert names["f"](*arguments) == plain["f"](*arguments)
    return [
        decision.conditions[i]
        for decision in decisions
        if decision.key not in recorder.arrays
        for i in lacking(
            decision,
            recorder.vectors.get(decision.key, ()),
            is_choice=decision.key in recorder.choices,
        )
    ]


BOTH = "def f(a, b):\n    if a > 0 and b > 0:\n        return 1\n    return 0\n"


def test_a_missing_pair_is_reported():
    assert without_pair(BOTH, (1, 1), (0, 1), (1, 0)) == []
    assert without_pair(BOTH, (1, 1), (0, 1)) == ["b > 0"]
    assert without_pair(BOTH, (1, 1), (0, 0)) == ["b > 0"]
    assert without_pair(BOTH, (1, 1)) == without_pair(BOTH) == ["a > 0", "b > 0"]


def test_every_branch_may_run_and_a_pair_be_missing():
    source = "def f(a, b, c):\n    return 1 if (a or b) and c else 0\n"
    # Both outcomes, and both values of each condition; b never decides.
    vectors = ((True, False, True), (False, False, True), (True, False, False))
    assert without_pair(source, *vectors) == ["b"]
    assert without_pair(source, *vectors, (False, True, True)) == []


def test_two_conditions_that_change_together_are_no_pair():
    source = "def f(a, b):\n    return (a < 0) | (b < 0)\n"
    assert without_pair(source, (-1, -1), (0, 0)) == ["a < 0", "b < 0"]
    assert without_pair(source, (-1, 0), (0, -1), (0, 0)) == []


@pytest.mark.parametrize(
    ("body", "conditions"),
    [
        ("return 0 < a <= b", ["0 < a", "a <= b"]),
        ("return not 0 < a <= b", ["0 < a", "a <= b"]),
        ("return [x for x in (a, b) if x and x > 1]", ["x", "x > 1"]),
        ("return [x for x in ([a] if a and b else [b])]", ["a", "b"]),
        ("return a if b else 0", ["b"]),
        ("while a and b:\n        a -= 1\n    return a", ["b"]),
        ("match a:\n        case 1 if b:\n            return 1", ["b"]),
        ("return (lambda x: x and not b)(a > 1)", ["x", "b", "a > 1"]),
        ("return max(a, b) == 1", ["max(a, b) == 1"]),
        ("return a > 1 if b > 1 else a > 2", ["a > 1", "a > 2", "b > 1"]),
        ("return a or b", ["a"]),
        ("while True:\n        return 1", []),
        ("assert a < 9\n    return 1", []),
    ],
)
def test_conditions_are_found_and_values_stay(body, conditions):
    found = without_pair(f"def f(a, b):\n    {body}\n", (1, 1))
    assert sorted(found) == sorted(conditions)


def test_comparisons_of_arrays_are_no_decisions():
    source = "def f(a, b):\n    return ((a > 0) & (a < b)).sum()\n"
    assert without_pair(source, (np.arange(3), 2)) == []


def test_lines_are_kept():
    source = "def f(a):\n    if (\n        a > 1\n        or a < 0\n    ):\n        a = 1\n"
    tree, _ = instrument("module", source)
    assert {node.lineno for node in ast.walk(tree) if hasattr(node, "lineno")} <= set(range(1, 8))


def test_the_plugin_records_an_imported_module(tmp_path):
    (tmp_path / "judged.py").write_text(BOTH)
    (tmp_path / "test_judged.py").write_text(
        "import judged\ndef test():\n    assert judged.f(1, 1) and not judged.f(0, 1)\n"
    )
    file = tmp_path / "vectors"
    environment = {"PYTHONPATH": f"{ROOT}:{tmp_path}", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = subprocess.run(
        [*(sys.executable, "-m", "pytest", "-q", "-p", "tools.conditions.plugin"), str(tmp_path)],
        env={**os.environ, **environment, VARIABLE: f"{file}\njudged"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout
    recorded = json.loads(file.read_text())
    (decision,) = instrument("judged", BOTH)[1]
    assert lacking(decision, recorded["vectors"][decision.key], is_choice=False) == [1]


def test_the_table_names_every_room_and_none_is_below_its_least():
    table = table_in(PAGE.read_text(encoding="utf-8"))
    assert [cells[0] for cells in table] == [room.name for room in ROOMS]
    for room, (_, *cells) in zip(ROOMS, table, strict=True):
        statements, branches, percent, decisions, conditions, paired = (
            float(cell.removesuffix(" %").replace(",", "")) for cell in cells
        )
        assert LEAST_PERCENT <= percent <= 100
        assert 0 < decisions <= conditions
        assert 0 < branches < 2 * statements
        assert paired == conditions if room.needs_pairs else 0 < paired <= conditions


def test_rooms_share_no_file_and_have_all_of_their_folders():
    files = [file for room in ROOMS for file in files_of(room)]
    assert len(files) == len(set(files))
    folders = ("evaluation", "problem", "terrain", "formats", "mission")
    every = {
        file.relative_to(ROOT).as_posix()
        for folder in folders
        for file in (ROOT / "host" / folder).rglob("*.py")
    }
    assert every <= set(files)
