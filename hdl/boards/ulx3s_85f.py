"""Radiona ULX3S with an LFE5U-85F of speed grade 6: the full design."""

from dataclasses import replace

from amaranth_boards.ulx3s import ULX3S_85F_Platform

from pathgene.hdl.boards.board import Board
from pathgene.hdl.boards.ecp5 import (
    MAP_SITES,
    OVERRIDES,
    PLANNER_FLOOR_PLAN,
    PLANNER_MAP_SITES,
    PLANNER_OVERRIDES,
    floor_plan,
)
from pathgene.hdl.boards.ecp5_cells import Ecp5Cells
from pathgene.hdl.boards.pll import Ecp5Pll
from pathgene.hdl.config import CheckerBuild, Config, GeneticCore


__all__ = ["CHIPS"]

_SIZES = Config(checker=CheckerBuild.PARALLEL, lanes=8)


class _Platform(ULX3S_85F_Platform):
    """Platform with the cells of an ECP5 and fixed sites for the map's block RAMs."""

    cells = Ecp5Cells(MAP_SITES)


class _PlannerPlatform(_Platform):
    """Platform with the map's block RAMs around the middle of the die."""

    cells = Ecp5Cells(PLANNER_MAP_SITES)


_PAPER = Board(
    name="ulx3s-85f",
    platform=_Platform,
    # 25 MHz to 100 MHz; its USB bridge, an FT231X, goes up to 3 Mbaud.
    pll=Ecp5Pll(feedback_divider=4, output_divider=6),
    reset=("button_fire", 0),
    sizes=_SIZES,
    seed=2,
    overrides={**OVERRIDES, "script_after_synth": floor_plan(_SIZES)},
)
_PLANNER = replace(
    _PAPER,
    platform=_PlannerPlatform,
    # The map takes 160 of the 208 block RAMs; with altitudes of 11 bits it would take 176, and with
    # 24 waypoints the paths would take six more.
    sizes=_SIZES.replace(core=GeneticCore.PLANNER, altitude_bits=10, max_waypoints=18),
    seed=1,
    overrides={
        **PLANNER_OVERRIDES,
        "script_after_synth": f"{PLANNER_OVERRIDES['script_after_synth']}\n{PLANNER_FLOOR_PLAN}",
    },
)

CHIPS = (_PLANNER, _PAPER)
