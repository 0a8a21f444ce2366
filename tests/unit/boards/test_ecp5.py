"""Options of the ECP5 tools have their effect, and all block RAMs have different sites."""

import json
import re

import pytest
from amaranth import *
from amaranth.back import verilog
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.boards import BOARDS, chips_of, find_board
from pathgene.hdl.boards.board import ChipKind
from pathgene.hdl.boards.build import prepare
from pathgene.hdl.boards.ecp5 import (
    KEEP_FANOUT,
    MAP_SITES,
    OTHER_SITES,
    OVERRIDES,
    PLANNER_FLOOR_PLAN,
    PLANNER_MAP_SITES,
    PLANNER_OVERRIDES,
    SYNTHESIS,
    floor_plan,
)
from pathgene.hdl.boards.tools import run_tool
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.primitives.logic import fanout


class Copied(wiring.Component):
    """Three equal registers, each with separate loads."""

    first: In(1)
    second: In(1)
    taken: Out(3)

    def elaborate(self, platform):
        m = Module()
        three = fanout(m, *[self.first & self.second] * 3, name="copy")
        m.d.comb += self.taken.eq(Cat(three) ^ self.first.replicate(3))
        return m


@pytest.mark.parametrize(("before", "registers"), [(KEEP_FANOUT, 3), ("", 1)])
def test_copies_stay_separate(before, registers, tmp_path):
    (tmp_path / "copied.v").write_text(verilog.convert(Copied(), name="copied"))
    script = f"read_verilog copied.v; {before}; synth_ecp5 {SYNTHESIS} -top copied"
    run_tool("yosys", ["-q", "-p", f"{script}; tee -q -o cells.json stat -json"], tmp_path)
    cells = json.loads((tmp_path / "cells.json").read_text())["design"]["num_cells_by_type"]
    assert cells["TRELLIS_FF"] == registers


@pytest.mark.parametrize("name", [name for name in BOARDS if "ecp" in name or "ulx" in name])
def test_boards_use_it(name):
    for board in chips_of(name):
        if board.chip is ChipKind.PAPER:
            assert OVERRIDES.items() <= board.overrides.items()
            continue
        assert board.overrides.keys() == PLANNER_OVERRIDES.keys()
        for option, text in board.overrides.items():
            assert text.startswith(PLANNER_OVERRIDES[option])


def test_sites_are_different():
    sites = [*MAP_SITES, *OTHER_SITES.values()]
    assert len(sites) == len(set(sites)) == 199


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("ulx3s-85f", marks=pytest.mark.long),
        pytest.param("ecpix5-85f", marks=pytest.mark.long),
    ],
)
def test_commands_follow_synthesis(tmp_path, name):
    """Each command checks that its cell exists; the exported Verilog has all of them."""
    board = find_board(name, "paper")
    prepare(board, tmp_path)
    lines = (tmp_path / "chip.ys").read_text().splitlines()
    found = [line for line in lines if "BEL" in line or "assert-count" in line]
    assert found == floor_plan(board.sizes).splitlines()
    assert lines.index(found[0]) > lines.index("    synth_ecp5 -nodsp -top chip")
    assert found[0].startswith("select -assert-count 1 c:planner.line.")
    assert found[1].startswith('setattr -set BEL "X17/')

    text = (tmp_path / "chip.v").read_text()
    modules = dict(re.findall(r"^module \\?(\S+) (.*?)^endmodule", text, re.DOTALL | re.MULTILINE))
    placed = [line.rpartition(" c:")[2] for line in found[::2]]
    assert len(placed) == len(set(placed)) == 7 + 4 * (board.sizes.lanes + 1)
    for name in placed:
        # Synthesis numbers the block RAMs of a memory.
        unit, _, leaf = re.sub(r"\.\d+\.\d+$", "", name).rpartition(".")
        declaration = rf"\\?{leaf} +\(" if leaf == "primitive" else rf"reg \S+ \\?{leaf} +\["
        assert len(re.findall(declaration, modules[f"chip.{unit}"])) == 1, name


def test_planners_link_has_sites():
    """Each of its block RAMs has a site that the map leaves free, next to the pins."""
    board = find_board("ulx3s-85f", "planner")
    script = board.overrides["script_after_synth"]
    assert script.splitlines()[-4:] == PLANNER_FLOOR_PLAN.splitlines()
    sites = re.findall(r'BEL "(.+?)"', PLANNER_FLOOR_PLAN)
    assert len(set(sites)) == 2
    assert set(sites) < set(PLANNER_MAP_SITES[176:])
    assert {site[:4] for site in sites} == {"X44/"}
    paper = find_board("ulx3s-85f", "paper").overrides["script_after_synth"]
    for name in re.findall(r"-count 1 (\S+)", PLANNER_FLOOR_PLAN):
        assert name in paper


def test_only_chips_on_an_85f_have_one():
    for board in (chip for name in BOARDS for chip in chips_of(name)):
        script = board.overrides.get("script_after_synth", "")
        devices = ("LFE5U-85F", "LFE5UM5G-85F")
        if board.chip is ChipKind.PAPER and board.platform().device in devices:
            assert script == floor_plan(board.sizes)
        elif board.name == "ulx3s-85f":
            assert script.endswith(PLANNER_FLOOR_PLAN)
        else:
            assert "BEL" not in script


@pytest.mark.parametrize(
    "other", [{"core": "none"}, {"checker": CheckerBuild.TWO_TIER, "lanes": 1}, {"map_size": 256}]
)
def test_other_chips(other):
    with pytest.raises(ValueError, match=r"^Floor plan must belong to the default configuration"):
        floor_plan(Config(**other))
    assert floor_plan(Config(lanes=16)).count("MULT18_") == 68


def test_a_planners_map_lies_around_the_middle():
    """All sites are used; a map of 11 bits lies outside the middle of the inner rows."""
    assert set(PLANNER_MAP_SITES) >= {*MAP_SITES, *OTHER_SITES.values()}
    assert len(PLANNER_MAP_SITES) == len(set(PLANNER_MAP_SITES)) == 208
    for site in PLANNER_MAP_SITES[176:]:
        x, y = map(int, re.fullmatch(r"X(\d+)/Y(\d+)/EBR\d", site).groups())
        assert 42 < x < 82
        assert y in (46, 70)
    for name in ("ulx3s-85f", "ecpix5-85f"):
        for board in chips_of(name):
            is_planner = board.chip is ChipKind.PLANNER
            sites = PLANNER_MAP_SITES if is_planner else MAP_SITES
            assert board.platform().cells.sites == sites
