"""Radiona ULX3S with an LFE5U-45F of speed grade 6: a smaller map, in 108 block RAMs."""

from dataclasses import replace

from amaranth_boards.ulx3s import ULX3S_45F_Platform

from pathgene.hdl.boards.board import Board
from pathgene.hdl.boards.ecp5 import OVERRIDES, PLANNER_OVERRIDES
from pathgene.hdl.boards.ecp5_cells import Ecp5Cells
from pathgene.hdl.boards.pll import Ecp5Pll
from pathgene.hdl.config import CheckerBuild, Config, GeneticCore


__all__ = ["CHIPS"]


class _Platform(ULX3S_45F_Platform):
    """Platform with the cells of an ECP5."""

    cells = Ecp5Cells()


class _PlannerPlatform(_Platform):
    """Platform with multipliers and block RAMs in place of logic, which is nearly used up."""

    cells = Ecp5Cells(saves_logic=True)


#: Delay of the LUTs on a path in picoseconds, without wires. Faster paths are optimized for area.
_RELAXED = "scratchpad -set abc9.D 9000"

_PAPER = Board(
    name="ulx3s-45f",
    platform=_Platform,
    # 25 MHz to 100 MHz; its USB bridge, an FT231X, goes up to 3 Mbaud.
    pll=Ecp5Pll(feedback_divider=4, output_divider=6),
    reset=("button_fire", 0),
    sizes=Config(checker=CheckerBuild.PARALLEL, lanes=4, map_size=256),
    overrides=OVERRIDES,
    seed=2,
)
_PLANNER = replace(
    _PAPER,
    platform=_PlannerPlatform,
    # 25 MHz to 81.25 MHz.
    pll=Ecp5Pll(feedback_divider=1, second_divider=26, output_divider=8),
    # One cycle a point would take 15 more multipliers, of which 6 are left, and 3,300 more LUTs.
    sizes=_PAPER.sizes.replace(
        core=GeneticCore.PLANNER, altitude_bits=9, max_waypoints=18, point_cycles=2
    ),
    seed=3,
    overrides={
        **PLANNER_OVERRIDES,
        "script_after_read": f"{PLANNER_OVERRIDES['script_after_read']}\n{_RELAXED}",
    },
)

CHIPS = (_PLANNER, _PAPER)
