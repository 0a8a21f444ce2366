"""LambdaConcept ECPIX-5 with an LFE5UM5G-85F of speed grade 8: the full design, 16 lanes."""

from dataclasses import replace

from amaranth.build import Attrs, Pins, Resource
from amaranth_boards.ecpix5 import ECPIX585Platform

from pathgene.hdl.boards.board import Board
from pathgene.hdl.boards.ecp5 import (
    MAP_SITES,
    OVERRIDES,
    PLANNER_MAP_SITES,
    PLANNER_OVERRIDES,
    floor_plan,
)
from pathgene.hdl.boards.ecp5_cells import Ecp5Cells
from pathgene.hdl.boards.pll import Ecp5Pll
from pathgene.hdl.config import CheckerBuild, Config, GeneticCore


__all__ = ["CHIPS"]

_SIZES = Config(checker=CheckerBuild.PARALLEL, lanes=16)


class _Platform(ECPIX585Platform):
    """Platform with the cells of an ECP5 and an active-high reset pin: pin 1 of PMOD 0."""

    cells = Ecp5Cells(MAP_SITES)

    resources = [
        *ECPIX585Platform.resources,
        Resource(
            "reset_pin",
            0,
            Pins("1", dir="i", conn=("pmod", 0)),
            Attrs(IO_TYPE="LVCMOS33", PULLMODE="DOWN"),
        ),
    ]


class _PlannerPlatform(_Platform):
    """Platform with the map's block RAMs around the middle of the die."""

    cells = Ecp5Cells(PLANNER_MAP_SITES)


_PAPER = Board(
    name="ecpix5-85f",
    platform=_Platform,
    # 100 MHz to 120 MHz; its USB bridge is an FT2232H.
    pll=Ecp5Pll(input_divider=5, feedback_divider=6, output_divider=5),
    reset=("reset_pin", 0),
    sizes=_SIZES,
    overrides={**OVERRIDES, "script_after_synth": floor_plan(_SIZES)},
)
_PLANNER = replace(
    _PAPER,
    platform=_PlannerPlatform,
    # 100 MHz to 110 MHz.
    pll=Ecp5Pll(input_divider=10, feedback_divider=11, output_divider=5),
    # Banks of 4096 rows take three block RAMs each with altitudes of 10 to 13 bits, in total 192 of
    # the 208, and the planner needs 24 more. With 9 bits they take two each.
    sizes=_SIZES.replace(core=GeneticCore.PLANNER, altitude_bits=9),
    overrides=PLANNER_OVERRIDES,
)

CHIPS = (_PLANNER, _PAPER)
