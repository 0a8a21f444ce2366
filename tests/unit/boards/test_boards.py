# amaranth: UnusedElaboratable=no
"""Every board: its chip, its PLL, and the sources for its tools."""

import dataclasses
import re
from pathlib import Path

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.boards import BOARDS, board_top, chips_of, find_board
from pathgene.hdl.boards.board import Board, ChipKind
from pathgene.hdl.boards.build import prepare
from pathgene.hdl.boards.pll import Ecp5Pll, Ice40Pll, Series7Pll
from pathgene.hdl.config import CheckerBuild, GeneticCore


#: Every board with each of its chips.
CHIPS = [(board.name, board.chip) for name in BOARDS for board in chips_of(name)]

#: Text about the device in the sources.
DEVICES = {
    "ulx3s-85f": ["--85k", "--package", "CABGA381", "--speed", "6"],
    "ulx3s-45f": ["--45k", "--package", "CABGA381", "--speed", "6"],
    "ecpix5-85f": ["--um5g-85k", "--package", "CABGA554", "--speed", "8"],
    "icebreaker": ["--up5k", "--package", "sg48"],
}


class Wire(wiring.Component):
    """Replacement of the planner, which takes long to elaborate; it uses clock and reset."""

    clk: In(1)
    rst: In(1)
    rx: In(1)
    tx: Out(1)

    def __init__(self, config):
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        m.domains.sync = ClockDomain()
        m.d.comb += [ClockSignal().eq(self.clk), ResetSignal().eq(self.rst)]
        m.d.sync += self.tx.eq(self.rx)
        return m


@pytest.mark.parametrize(("name", "kind"), CHIPS)
def test_clock_and_divisor(name, kind):
    board = find_board(name, kind)
    assert (board.name, board.chip) == (name, kind)
    config = board.config
    assert config.clock_hz == board.clock_hz
    assert abs(config.clock_hz / config.clocks_per_bit / board.baud - 1) < 0.0125
    assert config.replace(clock_hz=100_000_000, clocks_per_bit=33) == board.sizes


@pytest.mark.parametrize("name", ["ulx3s-85f", "ecpix5-85f"])
def test_full_design(name):
    config = find_board(name, "paper").config
    assert (config.checker, config.map_size, config.altitude_bits) == (
        CheckerBuild.PARALLEL,
        512,
        12,
    )
    assert config.lanes >= 8
    assert config.clock_hz >= 100_000_000
    # A block of 1,024 x 18 bits holds 4,096 x 4 bits: 192 of the 208 blocks of an 85F.
    banks = (config.lanes // 2) ** 2
    rows = config.map_size**2 // banks
    assert banks * (rows // 4096) * (config.altitude_bits // 4) == 192


@pytest.mark.parametrize(
    ("name", "lanes", "map_size", "clock_hz"),
    [
        ("ulx3s-85f", 8, 512, 100_000_000),
        ("ulx3s-45f", 4, 256, 80_000_000),
        ("ecpix5-85f", 16, 512, 110_000_000),
    ],
)
def test_planners(name, lanes, map_size, clock_hz):
    config = find_board(name).config
    assert config.core is GeneticCore.PLANNER
    assert (config.lanes, config.map_size) == (lanes, map_size)
    assert config.clock_hz >= clock_hz


@pytest.mark.parametrize("name", BOARDS)
def test_default_chip_is_the_planner_where_there_is_room(name):
    kinds = [board.chip for board in chips_of(name)]
    has_a_core = find_board(name, ChipKind.PAPER).sizes.core is not GeneticCore.NONE
    assert kinds == (list(ChipKind) if has_a_core else [ChipKind.PAPER])


@pytest.mark.parametrize("name", BOARDS)
def test_page_has_a_row_with_the_sizes_of_each_chip(name):
    page = (Path(__file__).parents[3] / "docs" / "boards.md").read_text("utf-8")
    (row,) = re.findall(rf"^\| `{name}` \|(.*)\|$", page, re.MULTILINE)
    device, planner, paper, _ = (cell.strip() for cell in row.split(" | "))
    platform = find_board(name).platform()
    assert device.replace(" ", "").startswith((platform.device, "XC7A100T"))
    chips = {board.chip: board.config for board in chips_of(name)}
    for cell, config in ((planner, chips.get("planner")), (paper, chips["paper"])):
        if config is None:
            assert cell == "none"
            continue
        assert f"map of {config.map_size} x {config.map_size}" in cell
        if config.core is not GeneticCore.NONE:
            assert f"{config.lanes} lanes" in cell
        if name in DEVICES:
            assert f"; {config.clock_hz / 1e6:g} MHz" in cell


def test_refuses_a_chip_without_room():
    with pytest.raises(
        ValueError,
        match=r"^Chip of icebreaker must be paper, for which it has room, not planner$",
    ):
        find_board("icebreaker", "planner")


@pytest.mark.parametrize(("name", "kind"), CHIPS)
def test_sources(name, kind, tmp_path, monkeypatch):
    monkeypatch.setattr(board_top, "Chip", Wire)
    board = find_board(name, kind)
    commands = prepare(board, tmp_path)
    if name not in DEVICES:
        assert commands == [["vivado", "-mode", "batch", "-log", "chip.log", "-source", "chip.tcl"]]
        assert "-part xc7a100ticsg324-1L" in (tmp_path / "chip.tcl").read_text()
    else:
        synthesis, routing, *_ = commands
        assert synthesis == ["yosys", "-q", "-l", "chip.rpt", "chip.ys"]
        assert routing[0].startswith("nextpnr-")
        assert " ".join(DEVICES[name]) in " ".join(routing)
        assert "read_verilog chip.v\n" in (tmp_path / "chip.ys").read_text()
    netlist = (tmp_path / "chip.v").read_text()
    pll = {Ecp5Pll: "EHXPLLL", Ice40Pll: "SB_PLL40_PAD", Series7Pll: "PLLE2_BASE"}
    assert netlist.count(f" {pll[type(board.pll)]} #(") == 1


def test_refuses_an_unknown_board():
    names = ", ".join(BOARDS)
    with pytest.raises(ValueError, match=rf"^Board must be one of {names}, not 'ulx3s'$"):
        find_board("ulx3s")


def test_refuses_an_inexact_divisor():
    board = find_board("ulx3s-85f")
    with pytest.raises(
        ValueError,
        match=r"^Board.baud must divide the clock of 100000000 Hz within 1.25%, not 12000000$",
    ):
        dataclasses.replace(board, baud=12_000_000)
    assert isinstance(dataclasses.replace(board, baud=1_000_000), Board)
