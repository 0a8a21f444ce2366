"""Digilent Arty A7-100: a build script for Vivado, which must be installed."""

from dataclasses import replace

from amaranth_boards.arty_a7 import ArtyA7_100Platform

from pathgene.hdl.boards.board import Board
from pathgene.hdl.boards.pll import Series7Pll
from pathgene.hdl.config import CheckerBuild, Config, GeneticCore


__all__ = ["CHIPS"]

_PAPER = Board(
    name="arty-a7-100",
    platform=ArtyA7_100Platform,
    # 100 MHz to 100 MHz; its USB bridge is an FT2232H.
    pll=Series7Pll(clkfbout_mult=10, clkout0_divide=10),
    reset=("button", 0),
    sizes=Config(checker=CheckerBuild.PARALLEL, lanes=8),
)

CHIPS = (replace(_PAPER, sizes=_PAPER.sizes.replace(core=GeneticCore.PLANNER)), _PAPER)
