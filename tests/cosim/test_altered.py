"""Chips with one altered operator: the comparison with the model fails, and the path changes.

So the board, not the host, computes the path, and the comparison can fail. The planner core is
compared alone.
"""

import dataclasses
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pathgene.hdl.protocol.codes import LinkMode
from pathgene.host.device.boards import open_board
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link
from pathgene.host.planners.allaire.ga_fpga import FpgaGeneticPlanner
from pathgene.host.planners.base import Options
from pathgene.sim.board import SimulatedBoard, build_program
from pathgene.sim.cache import BuildCache
from pathgene.sim.exported import cached_verilog, exported_verilog
from tests.cosim.test_planner_core import fly, planner_verilog
from tests.support.gateware.chips import SMALL, Pair
from tests.support.planner.cases import SMALL as PLANNER
from tools.chips import board_url


pytestmark = pytest.mark.cosim

ROOT = Path(__file__).resolve().parents[2]

#: File of the gateware, the text, its number of occurrences, and its replacement.
ALTERATIONS = {
    "middle-rounded-up": (
        "ga_core/crossover.py",
        "middle.eq(parent.length >> 1)",
        1,
        "middle.eq((parent.length + 1) >> 1)",
    ),
    "worse-of-two-ranks": (
        "ga_core/selection.py",
        "Mux(first < second, first, second)",
        1,
        "Mux(first < second, second, first)",
    ),
    "offset-subtracted": (
        "ga_core/mutator.py",
        "passed[axis] + self.offset[axis]",
        1,
        "passed[axis] - self.offset[axis]",
    ),
    "or-in-the-random-source": (
        "ga_core/random_source.py",
        "tap(c, 45) & tap(c, 46)",
        1,
        "tap(c, 45) | tap(c, 46)",
    ),
}

#: The same for the planner.
ALTERATIONS_OF_THE_PLANNER = {
    "cut": ("planner/child_planner.py", "length << 2, 0", 1, "length << 1, 0"),
    "worse-parent": ("planner/child_planner.py", "Mux(one < other, one, other)", 1, "one"),
    "steep-for-nothing": (
        "planner/scorer/penalty_counter.py",
        "judged.excess + STEEP",
        1,
        "judged.excess",
    ),
    "given-up-for-feasible": (
        "planner/path_evaluator.py",
        "PathClass.FEASIBLE.value, PathClass.GIVEN_UP.value",
        1,
        "PathClass.FEASIBLE.value, PathClass.FEASIBLE.value",
    ),
    "late-members-first": (
        "planner/collector.py",
        "members.p.late.eq(~there)",
        1,
        "members.p.late.eq(there)",
    ),
    "does-not-wait": ("planner/run_control.py", "is_final & options.until_feasible", 1, "0"),
}

EXPORT_OF_THE_PLANNER = """
import json, pathlib, sys
import pathgene.hdl.planner.core
from tests.cosim.test_planner_core import planner_verilog
from tests.support.planner.cases import SMALL
assert pathlib.Path(pathgene.hdl.planner.core.__file__).parents[3] == pathlib.Path.cwd()
sys.stdout.write(planner_verilog(SMALL, 64))
"""

EXPORT = """
import json, pathlib, sys
import pathgene.hdl.verilog
from pathgene.hdl.config import Config
assert pathlib.Path(pathgene.hdl.verilog.__file__).parents[2] == pathlib.Path.cwd()
sys.stdout.write(pathgene.hdl.verilog.export("chip", Config(**json.loads(sys.argv[1]))))
"""


def altered_verilog(folder, name):
    """Return the Verilog of a chip with one alteration."""
    sizes = json.dumps(dataclasses.asdict(SMALL))
    return exported_of(folder, ALTERATIONS[name], EXPORT, sizes)


def exported_of(folder, alteration, program, *arguments):
    """Return the output of a program that runs with an altered copy of the gateware."""

    def export():
        file, old, times, new = alteration
        # The program imports the copies.
        for folder_name in ("hdl", "host", "pathgene", "sim", "tests"):
            shutil.copytree(ROOT / folder_name, folder / folder_name, symlinks=True)
        path = folder / "hdl" / file
        source = path.read_text()
        assert source.count(old) == times
        path.write_text(source.replace(old, new))
        return subprocess.run(
            [sys.executable, "-c", program, *arguments],
            cwd=folder,
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        ).stdout

    return cached_verilog(export, "altered", *alteration[::3], program, *arguments)


@pytest.fixture
def open_chip():
    """Function that opens a chip of the given Verilog."""
    boards = []

    def open_verilog(verilog):
        program = build_program("verilator", verilog, "chip", SMALL.clocks_per_bit)
        boards.append(SimulatedBoard(program))
        return Chip(Link(boards[-1].open(), timeout_s=60, attempts=2))

    yield open_verilog
    for board in boards:
        board.close()


def some_in_ci(names):
    """Return the names as parameters: `make test-ci` builds one, the rest take minutes."""
    return [
        pytest.param(name, marks=[pytest.mark.long] if i >= 1 else [])
        for i, name in enumerate(names)
    ]


# `tools.mutate` makes many more alterations.
@pytest.mark.ci
@pytest.mark.parametrize("name", some_in_ci(ALTERATIONS))
def test_comparison_with_the_model_fails(name, tmp_path, open_chip):
    verilog = altered_verilog(tmp_path, name)
    assert verilog != exported_verilog("chip", SMALL)
    chips = Pair(open_chip(verilog), open_board(board_url("model", SMALL)), seed=4)
    assert chips.board.info == chips.model.info  # INFO does not depend on the alteration.
    chips.start()
    with pytest.raises(AssertionError):
        breed(chips)


def breed(chips):
    for _ in range(20):
        chips.step(LinkMode.RECIPE)


@pytest.mark.ci
def test_a_copy_of_the_planner_that_is_not_altered_is_the_same(tmp_path):
    alteration = "planner/core.py", "class PlannerCore", 1, "class PlannerCore"
    text = exported_of(tmp_path, alteration, EXPORT_OF_THE_PLANNER)
    assert text == planner_verilog(PLANNER, 64)


@pytest.mark.ci
@pytest.mark.parametrize("name", some_in_ci(ALTERATIONS_OF_THE_PLANNER))
def test_comparison_of_the_planner_fails(name, tmp_path):
    alteration = ALTERATIONS_OF_THE_PLANNER[name]
    text = exported_of(tmp_path / "copy", alteration, EXPORT_OF_THE_PLANNER)
    with pytest.raises(AssertionError):
        fly(PLANNER, 64, 60, 60, 120, BuildCache(tmp_path / "builds"), text)


def planned(evaluator, chip):
    planner = FpgaGeneticPlanner(link_mode="recipe", open_board=lambda url: chip)
    return planner.plan(evaluator, Options(generations=6, seed=2))


@pytest.mark.ci
def test_planned_path_changes(tmp_path, evaluator, open_chip):
    expected = planned(evaluator, open_board(board_url("model", SMALL)))
    same = planned(evaluator, open_board(board_url("sim", SMALL)))
    assert np.array_equal(same.path, expected.path)
    assert same.history == expected.history
    other = planned(evaluator, open_chip(altered_verilog(tmp_path, "middle-rounded-up")))
    assert other.history[0] == expected.history[0]
    assert not np.array_equal(other.path, expected.path)
