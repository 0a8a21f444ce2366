"""Area and speed on real devices: every board, every unit alone, the papers' own families.

Runs the synthesis and place-and-route tools, for hours; ``make setup-synth`` installs them. Writes
``docs/results.md``.
"""

from __future__ import annotations

import dataclasses
import importlib
import itertools
import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from bench.feasibility import cells_per_clock
from bench.report import Options, Report
from hdl.boards import BOARDS, find_board
from hdl.boards.build import build, try_seeds
from hdl.boards.ecp5 import KEEP_COPIES, PLACEMENT, SYNTHESIS
from hdl.boards.ecp5_floor_plan import floor_plan
from hdl.boards.harness import Harness
from hdl.boards.route import Routed, route
from hdl.boards.tools import BuildError, run_tool
from hdl.config import CheckerBuild, Config
from hdl.memories import without_contents
from host.errors import PathgeneError


__all__ = ["run"]

_ROOT = Path(__file__).parents[1]
_FOLDER = _ROOT / "build" / "fpga"
_RESULTS = _ROOT / "docs" / "results.md"

#: Synthesis and routing of units alone on the devices of two boards.
_ECP5 = (
    "ecp5",
    (f"{KEEP_COPIES};", "synth_ecp5", SYNTHESIS),
    (
        "nextpnr-ecp5",
        *("--85k", "--package", "CABGA381", "--speed", "6", "--lpf-allow-unconstrained"),
        *PLACEMENT.split(),
    ),
)
_ICE40 = (
    "ice40",
    ("synth_ice40", "-device", "u", "-spram", "-dsp"),
    ("nextpnr-ice40", "--up5k", "--package", "sg48"),
)
#: What the units are asked for, MHz: more than they can, so that the router shows what that is.
_ASKED = {"ecp5": 150, "ice40": 50}
#: Boards with the full design, and the lanes that it is tried with.
_LANES_BOARDS = ("ulx3s-85f", "ecpix5-85f")
_LANES = (4, 8, 16)
_PLAIN = Config(checker=CheckerBuild.NONE)
_UNITS: Mapping[str, tuple[str, Config]] = MappingProxyType(
    {
        "GA core": ("hdl.ga_core.core.Core", _PLAIN),
        "selection": ("hdl.ga_core.selection.Selection", _PLAIN),
        "population, 11 crossovers": ("hdl.ga_core.population.Population", _PLAIN),
        "mutation": ("hdl.ga_core.mutation.Mutation", _PLAIN),
        "random source": ("hdl.ga_core.random_source.RandomSource", _PLAIN),
        "receiving": ("hdl.ga_core.receiving.ReceivingUnit", _PLAIN),
        "transmitting": ("hdl.ga_core.transmitting.TransmittingUnit", _PLAIN),
        "line": ("hdl.link.line.Line", _PLAIN),
        "checker, two-tier": (
            "hdl.feasibility.checker.Checker",
            _PLAIN.replace(checker=CheckerBuild.TWO_TIER, lanes=1),
        ),
        "checker, parallel, 8 lanes": (
            "hdl.feasibility.checker.Checker",
            _PLAIN.replace(checker=CheckerBuild.PARALLEL, lanes=8),
        ),
        "checker, parallel, 16 lanes": (
            "hdl.feasibility.checker.Checker",
            _PLAIN.replace(checker=CheckerBuild.PARALLEL, lanes=16),
        ),
        "checker, hierarchical, 8 lanes": (
            "hdl.feasibility.checker.Checker",
            _PLAIN.replace(checker=CheckerBuild.HIERARCHICAL, lanes=8),
        ),
    }
)


@dataclass(frozen=True)
class _Family:
    """Cells of a family, by what they are.

    Parameters
    ----------
    luts, registers, memories, multipliers : dict of str to int
        Kinds of cells, and how many of the thing one of them is.
    """

    luts: Mapping[str, int]
    registers: Mapping[str, int]
    memories: Mapping[str, int]
    multipliers: Mapping[str, int]

    def count(self, cells: Mapping[str, int]) -> tuple[int, int, int, int]:
        """Return LUTs, flip-flops, block RAMs and multipliers of so many cells of each kind."""
        kinds = (self.luts, self.registers, self.memories, self.multipliers)
        lut, register, memory, multiplier = (
            sum(weight * cells.get(cell, 0) for cell, weight in kind.items()) for kind in kinds
        )
        return lut, register, memory, multiplier


#: As nextpnr counts them: a carry or a bit of LUT RAM takes a TRELLIS_COMB as a LUT does.
_ROUTED = {
    "ecp5": _Family({"TRELLIS_COMB": 1}, {"TRELLIS_FF": 1}, {"DP16KD": 1}, {"MULT18X18D": 1}),
    "ice40": _Family(
        {"ICESTORM_LC": 1},
        {},
        {"ICESTORM_RAM": 1, "ICESTORM_SPRAM": 1},
        {"ICESTORM_DSP": 1},
    ),
}
_LUTS = {f"LUT{inputs}": 1 for inputs in range(1, 7)}
# 16 rows of a bit take a LUT, 32 two; a memory with a second port holds its rows twice.
_LUT_RAMS = {"RAM16X1S": 1, "RAM16X1D": 2, "RAM32X1D": 2, "RAM64X1D": 2, "RAM32M": 4, "RAM64M": 4}
_XILINX = _Family(
    {**_LUTS, **_LUT_RAMS, "SRL16E": 1, "SRLC32E": 1},
    dict.fromkeys(("FDRE", "FDSE", "FDCE", "FDPE"), 1),
    # In blocks of 18 kbit.
    {
        "RAMB16_S1_S1": 1,
        **{f"RAMB16_S{a}_S{b}": 1 for a in (1, 2, 4, 9, 18, 36) for b in (1, 2, 4, 9, 18, 36)},
        "RAMB18": 1,
        "RAMB18E1": 1,
        "RAMB36": 2,
        "RAMB36E1": 2,
    },
    {"MULT18X18": 1, "MULT18X18S": 1, "DSP48E": 1, "DSP48E1": 1},
)


@dataclass(frozen=True)
class _PaperDevice:
    """The device of a paper, what is put there, and what the paper says of its own design."""

    device: str
    family: str
    name: str
    top: str
    config: Config
    luts: int
    memories: int
    paper: str


_PAPER_DEVICES = (
    _PaperDevice(
        "XC2VP30",
        "xc2vp",
        "GA core",
        "hdl.ga_core.core.Core",
        _PLAIN,
        27_392,
        136,
        "not given",
    ),
    _PaperDevice(
        "XC5VLX330",
        "xc5v",
        "checker, two-tier",
        "hdl.feasibility.checker.Checker",
        _PLAIN.replace(checker=CheckerBuild.TWO_TIER, lanes=1),
        207_360,
        576,
        "0.1 % of the logic, 34 % of the block RAM",
    ),
)


def run(options: Options) -> Report:
    """Build everything, write the results page, and return the boards' table."""
    try:
        boards = _boards()
        lanes = _lanes()
        units = _units()
        papers = _papers()
    except BuildError as error:
        raise PathgeneError(str(error)) from None
    text = "\n\n".join(
        [
            "# Results of synthesis, place and route",
            "Made by `make bench BENCH=fpga`: yosys 0.70 and nextpnr 0.11 as the package index has "
            "them. Nothing here has run on a board.",
            *(report.text() for report in (boards, lanes, units, papers)),
        ]
    )
    _RESULTS.parent.mkdir(exist_ok=True)
    _RESULTS.write_text(text.rstrip() + "\n", encoding="utf-8")
    boards.data = {"lanes": lanes.rows, "units": units.rows, "papers": papers.rows}
    return boards


def _boards() -> Report:
    report = Report(
        "Boards",
        (
            "board",
            "device",
            "LUTs",
            "flip-flops",
            "block RAMs",
            "multipliers",
            "asked, MHz",
            "routed, MHz",
            "seed",
        ),
        notes=[
            "The whole bitstream, from `make bitstream BOARD=...`. Block RAMs: of 18 kbit on "
            "ECP5; of 4 and of 256 kbit, together, on iCE40."
        ],
    )
    for name in BOARDS:
        board = find_board(name)
        platform = board.platform()
        family = getattr(platform, "family", "").lower()
        if family not in _ROUTED:
            report.notes.append(f"{name}: build script only; its tool does not come along.")
            continue
        print(f"{name} ...", file=sys.stderr, flush=True)
        try:
            routed = build(board, _FOLDER / name)
        except BuildError as error:
            report.notes.append(str(error))
            continue
        achieved, asked = _chip_clock(routed)
        report.rows.append(
            (
                name,
                f"{platform.device}-{platform.speed}",
                *_used(routed, family),
                asked,
                achieved,
                routed.seed,
            )
        )
    return report


def _lanes() -> Report:
    """Route the full design with more and fewer lanes: which of them checks most."""
    report = Report(
        "Lanes and clock",
        (
            "board",
            "lanes",
            "LUTs",
            "flip-flops",
            "routed, MHz",
            "cells per clock",
            "cells per microsecond",
        ),
        notes=[
            "The chip of `make bitstream`, with these lanes, one seed. Cells per clock is the "
            "sustained rate over open ground of `make bench BENCH=feasibility`. Paper: about 100 "
            "cells per microsecond.",
        ],
    )
    for name, count in itertools.product(_LANES_BOARDS, _LANES):
        print(f"{name}, {count} lanes ...", file=sys.stderr, flush=True)
        board = find_board(name)
        sizes, folder = board.sizes.replace(lanes=count), _FOLDER / name
        if sizes != board.sizes:
            overrides = {**board.overrides, "script_after_synth": floor_plan(sizes)}
            board = dataclasses.replace(board, sizes=sizes, overrides=overrides)
            folder = _FOLDER / f"{name}-{count}-lanes"
        routed, _ = try_seeds(board, folder, seeds=1)
        clock, rate = _chip_clock(routed)[0], cells_per_clock(sizes)
        lut, register, *_ = _used(routed, "ecp5")
        report.rows.append((name, count, lut, register, clock, rate, clock * rate))
    return report


def _units() -> Report:
    report = Report(
        "Units alone",
        ("unit", "LUTs", "flip-flops", "block RAMs", "multipliers", "routed, MHz"),
        notes=[
            f"LFE5U-85F of speed grade 6, one seed, {_ASKED['ecp5']} MHz asked of each; the "
            "registers around every port are counted. LUTs are those of carry chains and LUT RAMs, "
            "too; on the UP5K they are logic cells with their flip-flops, and block RAMs include "
            "4 SPRAMs.",
        ],
    )
    for unit, (top, config) in _UNITS.items():
        report.rows.append((unit, *_alone(unit, top, config, _ECP5)))
    small = _PLAIN.replace(checker=CheckerBuild.TWO_TIER, lanes=1, map_size=256)
    name = "checker, two-tier, 256 x 256, on the UP5K"
    report.rows.append((name, *_alone(name, "hdl.feasibility.checker.Checker", small, _ICE40)))
    return report


def _alone(
    unit: str, top: str, config: Config, device: tuple[str, tuple[str, ...], tuple[str, ...]]
) -> tuple[int, int, int, int, float]:
    """Route a unit with nothing but registers around it; return its cells and its clock."""
    print(f"{unit} ...", file=sys.stderr, flush=True)
    family, synthesis, routing = device
    folder = _FOLDER / unit.replace(" ", "-").replace(",", "")
    # With the primitives that the device has.
    platform = find_board("ulx3s-85f").platform() if family == "ecp5" else None
    _write(Harness(_component(top, config)), folder, platform)
    _synthesize(folder, " ".join(synthesis), "-json unit.json")
    asked = ("--json", "unit.json", "--freq", str(_ASKED[family]))
    routed = route([*routing, "--quiet", *asked], folder, [1])
    return *_used(routed, family), _chip_clock(routed)[0]


def _papers() -> Report:
    report = Report(
        "On the papers' devices",
        (
            "design",
            "device",
            "LUTs",
            "of all, %",
            "flip-flops",
            "block RAMs",
            "of all, %",
            "multipliers",
            "paper",
        ),
        notes=[
            "Synthesis only (`synth_xilinx`), units with their ports as they are; block RAMs of 18 "
            "kbit.",
        ],
    )
    for each in _PAPER_DEVICES:
        print(f"{each.name} on {each.device} ...", file=sys.stderr, flush=True)
        folder = _FOLDER / each.device.lower()
        _write(_component(each.top, each.config), folder)
        _synthesize(folder, f"synth_xilinx -family {each.family} -noiopad -flatten")
        cells = json.loads((folder / "cells.json").read_text())["design"]["num_cells_by_type"]
        lut, register, memory, multiplier = _XILINX.count(cells)
        report.rows.append(
            (
                each.name,
                each.device,
                lut,
                100 * lut / each.luts,
                register,
                memory,
                100 * memory / each.memories,
                multiplier,
                each.paper,
            )
        )
    return report


def _component(path: str, config: Config) -> Any:
    """Return a component by the path of its class."""
    module, _, name = path.rpartition(".")
    return getattr(importlib.import_module(module), name)(config)


def _write(unit: Any, folder: Path, platform: Any = None) -> None:
    """Write the Verilog of ``unit`` to ``folder``."""
    from amaranth.back import verilog

    text = without_contents(verilog.convert(unit, platform=platform, name="unit", emit_src=False))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "unit.v").write_text(text, encoding="utf-8")


def _synthesize(folder: Path, command: str, outputs: str = "") -> None:
    script = f"read_verilog unit.v; {command} -top unit {outputs}; tee -q -o cells.json stat -json"
    run_tool("yosys", ["-q", "-p", script], folder)


def _used(routed: Routed, family: str) -> tuple[int, int, int, int]:
    return _ROUTED[family].count({name: used for name, (used, _) in routed.cells.items()})


def _chip_clock(routed: Routed) -> tuple[float, float]:
    """Return what the chip's clock achieves, and what it was asked for, MHz."""
    return min(routed.clocks.values(), key=lambda clock: clock[0] / clock[1])
