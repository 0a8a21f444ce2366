"""Chips with one operator altered: the tests notice, and the planned path is another.

What a board does is thus not done by the host behind its back, nor is the comparison with the model
one that everything passes.
"""

import dataclasses
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import hdl
from hdl.protocol import LinkMode
from host.device.boards import open_board
from host.device.chip import Chip
from host.device.link import Link
from host.evaluation import Evaluator
from host.planners.base import Options
from host.planners.ga_fpga import FpgaGeneticPlanner
from host.problem import aircraft
from host.problem.problem import Problem
from host.terrain import Terrain
from sim.board import SimulatedBoard, build_program
from sim.exported import cached_verilog, exported_verilog
from tests.chips import SMALL, Pair, board_url


pytestmark = pytest.mark.cosim

#: File of the gateware, what stands there, how often, and what to put in its place.
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
        "ga_core/waypoint_perturber.py",
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

EXPORT = """
import json, pathlib, sys
import hdl.verilog
from hdl.config import Config
assert pathlib.Path(hdl.verilog.__file__).parents[1] == pathlib.Path.cwd()
sys.stdout.write(hdl.verilog.export("planner", Config(**json.loads(sys.argv[1]))))
"""


def altered_verilog(folder, name):
    """Return the Verilog that a copy of the gateware with one alteration exports."""

    def export():
        file, old, times, new = ALTERATIONS[name]
        shutil.copytree(Path(hdl.__file__).parent, folder / "hdl")
        path = folder / "hdl" / file
        source = path.read_text()
        assert source.count(old) == times
        path.write_text(source.replace(old, new))
        sizes = json.dumps(dataclasses.asdict(SMALL))
        return subprocess.run(
            [sys.executable, "-c", EXPORT, sizes],
            cwd=folder,
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        ).stdout

    return cached_verilog(export, "altered planner", *ALTERATIONS[name][::3], repr(SMALL))


@pytest.fixture
def open_chip():
    """Opens a chip of this Verilog."""
    boards = []

    def open_verilog(verilog):
        program = build_program("verilator", verilog, "planner", SMALL.clocks_per_bit)
        boards.append(SimulatedBoard(program))
        return Chip(Link(boards[-1].open(), timeout_s=60, attempts=2))

    yield open_verilog
    for board in boards:
        board.close()


@pytest.fixture(scope="module")
def evaluator():
    """A flight over a wall with a gap."""
    elevation = np.full((31, 31), 100.0)
    elevation[:24, 14:17] = 500.0
    terrain = Terrain(
        name="wall", elevation=elevation, dx_m=100.0, dy_m=100.0, crs=None, origin=(0.0, 0.0)
    )
    problem = Problem(terrain, (200, 300, 200), (2800, 300, 200), aircraft.load("silver-fox"))
    return Evaluator(problem, threads=1)


# One for the way; `tools.mutate` alters much more.
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.ci] if number else [])
        for number, name in enumerate(ALTERATIONS)
    ],
)
def test_comparison_fails(name, tmp_path, open_chip):
    verilog = altered_verilog(tmp_path, name)
    assert verilog != exported_verilog("planner", SMALL)
    chips = Pair(open_chip(verilog), open_board(board_url("model", SMALL)), seed=4)
    assert chips.board.info == chips.model.info  # As the chip sees it, it is the same.
    chips.start()
    with pytest.raises(AssertionError):
        breed(chips)


def breed(chips):
    for _ in range(20):
        chips.step(LinkMode.RECIPE)


def planned(evaluator, chip):
    planner = FpgaGeneticPlanner(link_mode="recipe", open_board=lambda url: chip)
    return planner.plan(evaluator, Options(generations=6, seed=2))


def test_path_changes(tmp_path, evaluator, open_chip):
    expected = planned(evaluator, open_board(board_url("model", SMALL)))
    same = planned(evaluator, open_board(board_url("sim", SMALL)))
    assert np.array_equal(same.path, expected.path)
    assert same.history == expected.history
    other = planned(evaluator, open_chip(altered_verilog(tmp_path, "middle-rounded-up")))
    assert other.history[0] == expected.history[0]
    assert not np.array_equal(other.path, expected.path)
