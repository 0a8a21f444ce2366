"""Options of the ECP5 tools have their effect."""

import json

import pytest
from amaranth import *
from amaranth.back import verilog
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.boards import BOARDS, chips_of
from pathgene.hdl.boards.board import ChipKind
from pathgene.hdl.boards.ecp5 import KEEP_FANOUT, OVERRIDES, PLANNER_OVERRIDES, SYNTHESIS
from pathgene.hdl.boards.tools import run_tool
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
