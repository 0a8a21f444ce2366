"""Single units on the device of a board and on the papers' devices."""

from __future__ import annotations

import importlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from bench.fpga.job import CELLS, LIMIT_S, XILINX, Job, Table, chip_clock, digest_of, used
from pathgene.hdl.boards import find_board
from pathgene.hdl.boards.board import ChipKind
from pathgene.hdl.boards.ecp5 import KEEP_FANOUT, PLACEMENT, PLANNER_OVERRIDES, SYNTHESIS
from pathgene.hdl.boards.harness import Harness
from pathgene.hdl.boards.route import route
from pathgene.hdl.boards.tools import run_tool
from pathgene.hdl.config import CheckerBuild, Config, GeneticCore
from pathgene.hdl.protocol.runs import ISLANDS
from pathgene.hdl.verilog import convert
from tools.netlist import Netlist


_CORE, _CHECKER = (
    "pathgene.hdl.ga_core_top.PaperCoreTop",
    "pathgene.hdl.feasibility.checker.Checker",
)
_PLAIN = Config(checker=CheckerBuild.NONE)
_PLANNER_CHIP = Config(core=GeneticCore.PLANNER)
_TWO_TIER = _PLAIN.replace(checker=CheckerBuild.TWO_TIER, lanes=1)


@dataclass(frozen=True)
class _Device:
    """Synthesis and routing of a single unit, and the clock requested for it.

    The requested clock usually exceeds the unit's limit, so that the router shows the limit.
    """

    family: str
    board: str
    synthesis: str
    routing: tuple[str, ...]
    asked_mhz: int
    #: Commands after synthesis, and the chip whose cells are used. They are not in a row's digest,
    #: because they are determined by ``synthesis``, which is.
    finish: str = field(default="", repr=False)
    chip: ChipKind = field(default=ChipKind.PAPER, repr=False)


_ECP5 = _Device(
    "ecp5",
    "ulx3s-85f",
    f"{KEEP_FANOUT}; synth_ecp5 {SYNTHESIS}",
    (
        "nextpnr-ecp5",
        *("--85k", "--package", "CABGA381", "--speed", "6", "--lpf-allow-unconstrained"),
        *PLACEMENT.split(),
    ),
    150,
)
_PLANNER = replace(
    _ECP5,
    synthesis=(
        f"{PLANNER_OVERRIDES['script_after_read']}\nsynth_ecp5 {PLANNER_OVERRIDES['synth_opts']}"
    ),
    finish=PLANNER_OVERRIDES["script_after_synth"],
    chip=ChipKind.PLANNER,
)
# With 150 MHz requested, routing did not terminate within hours.
_LESS_ASKED = replace(_ECP5, asked_mhz=100)
_UNITS: Mapping[str, tuple[str, tuple[Any, ...], _Device]] = MappingProxyType(
    {
        "GA core": (_CORE, (_PLAIN,), _ECP5),
        "population, 11 crossovers": (
            "pathgene.hdl.ga_core.population.Population",
            (_PLAIN,),
            _LESS_ASKED,
        ),
        "selection": ("pathgene.hdl.ga_core.selection.Selection", (_PLAIN,), _ECP5),
        "mutation": ("pathgene.hdl.ga_core.mutation.Mutation", (_PLAIN,), _ECP5),
        "random source": ("pathgene.hdl.ga_core.random_source.RandomSource", (), _ECP5),
        "receiving": ("pathgene.hdl.command.receiver.CommandReceiver", (_PLAIN,), _ECP5),
        "transmitting": ("pathgene.hdl.command.transmitter.ReplyTransmitter", (_PLAIN,), _ECP5),
        "line": (
            "pathgene.hdl.link.line.Line",
            (_PLAIN.clocks_per_bit, _PLAIN.receive_buffer),
            _ECP5,
        ),
        "checker, two-tier": (_CHECKER, (_TWO_TIER,), _ECP5),
        "checker, parallel, 8 lanes": (
            _CHECKER,
            (_PLAIN.replace(checker=CheckerBuild.PARALLEL, lanes=8),),
            _ECP5,
        ),
        "checker, parallel, 16 lanes": (
            _CHECKER,
            (_PLAIN.replace(checker=CheckerBuild.PARALLEL, lanes=16),),
            _ECP5,
        ),
        "evolver": ("pathgene.hdl.planner.evolver.Evolver", (_PLANNER_CHIP, ISLANDS), _PLANNER),
        "scorer": ("pathgene.hdl.planner.scorer.scorer.Scorer", (_PLANNER_CHIP,), _PLANNER),
        "walker with memo, 8 lanes": (
            "pathgene.hdl.planner.walker.path_walker.PathWalker",
            (_PLANNER_CHIP,),
            _PLANNER,
        ),
        "wavefront": (
            "pathgene.hdl.planner.wavefront.wavefront.Wavefront",
            (_PLANNER_CHIP,),
            _PLANNER,
        ),
        "drawer of shapes": (
            "pathgene.hdl.planner.shape_drawer.ShapeDrawer",
            (_PLANNER_CHIP.coordinate_bits, _PLANNER_CHIP.altitude_bits),
            _PLANNER,
        ),
        "planner core, 8 lanes": (
            "pathgene.hdl.planner.core.PlannerCore",
            (_PLANNER_CHIP.replace(altitude_bits=10, max_waypoints=18),),
            _PLANNER,
        ),
    }
)


@dataclass(frozen=True)
class _PaperDevice:
    """The device of a paper, our unit for it, and the paper's figures for its own design."""

    device: str
    family: str
    top: str
    config: Config
    luts: int
    block_rams: int
    paper: str


_PAPER_DEVICES: Mapping[str, _PaperDevice] = MappingProxyType(
    {
        "GA core": _PaperDevice("XC2VP30", "xc2vp", _CORE, _PLAIN, 27_392, 136, "not given"),
        "checker, two-tier": _PaperDevice(
            "XC5VLX330",
            "xc5v",
            _CHECKER,
            _TWO_TIER,
            207_360,
            576,
            "0.1 % of the logic, 34 % of the block RAM",
        ),
    }
)


@dataclass(frozen=True)
class _UnitJob(Job):
    """A routed unit, surrounded only by registers."""

    @property
    def folder(self) -> str:
        """See :class:`~bench.fpga.job.Job`."""
        return self.name.replace(" ", "-").replace(",", "")

    def prepare(self, folder: Path) -> str:
        """Write the sources; see :class:`~bench.fpga.job.Job`."""
        top, arguments, device = _UNITS[self.name]
        # With the device's own cells.
        platform = find_board(device.board, device.chip).platform()
        _write(Harness(_component(top, *arguments)), folder, platform)
        return digest_of(Netlist.read(folder / "unit.v", "unit"), device)

    def measure(self, folder: Path) -> dict[str, Any]:
        """Route it; see :class:`~bench.fpga.job.Job`."""
        device = _UNITS[self.name][2]
        _synthesize(folder, device.synthesis, device.finish, "write_json unit.json")
        asked = ("--json", "unit.json", "--freq", str(device.asked_mhz))
        routed = route([*device.routing, "--quiet", *asked], folder, [1], limit_s=LIMIT_S)
        return {**used(routed, device.family), "routed, MHz": chip_clock(routed)[0]}


@dataclass(frozen=True)
class _PaperJob(Job):
    """A unit synthesized for the device of its paper."""

    @property
    def folder(self) -> str:
        """See :class:`~bench.fpga.job.Job`."""
        return _PAPER_DEVICES[self.name].device.lower()

    def prepare(self, folder: Path) -> str:
        """Write the sources; see :class:`~bench.fpga.job.Job`."""
        device = _PAPER_DEVICES[self.name]
        _write(_component(device.top, device.config), folder)
        # Its ports are the unit's ports, which may be renamed.
        netlist = Netlist.read(folder / "unit.v", "unit", port_names=False)
        return digest_of(netlist, device.family)

    def measure(self, folder: Path) -> dict[str, Any]:
        """Synthesize it; see :class:`~bench.fpga.job.Job`."""
        device = _PAPER_DEVICES[self.name]
        _synthesize(folder, f"synth_xilinx -family {device.family} -noiopad -flatten")
        statistics = json.loads((folder / "cells.json").read_text(encoding="utf-8"))
        cells = XILINX.count(statistics["design"]["num_cells_by_type"])
        return {
            "device": device.device,
            **cells,
            "of all LUTs, %": 100 * cells["LUTs"] / device.luts,
            "of all block RAMs, %": 100 * cells["block RAMs"] / device.block_rams,
            "paper": device.paper,
        }


def unit_jobs() -> Iterator[Job]:
    """Yield a row for each unit."""
    return (_UnitJob(UNITS_TABLE.name, name) for name in UNITS_TABLE.order)


def paper_jobs() -> Iterator[Job]:
    """Yield a row for each paper's device."""
    return (_PaperJob(PAPERS_TABLE.name, name) for name in PAPERS_TABLE.order)


def _component(path: str, *arguments: Any) -> Any:
    """Return the component with ``arguments``, by the path of its class."""
    module, _, name = path.rpartition(".")
    component = getattr(importlib.import_module(module), name)
    return component(*arguments)


def _write(unit: Any, folder: Path, platform: Any = None) -> None:
    """Write the Verilog of ``unit`` to ``folder``."""
    (folder / "unit.v").write_text(convert(unit, "unit", platform), encoding="utf-8")


def _synthesize(folder: Path, command: str, *further: str) -> None:
    """Synthesize the unit with ``command``, run the remaining commands, and count its cells."""
    script = ["read_verilog unit.v", f"{command} -top unit", *further]
    script.append("tee -q -o cells.json stat -json")
    (folder / "unit.ys").write_text("\n".join(script) + "\n", encoding="utf-8")
    run_tool("yosys", ["-q", "unit.ys"], folder)


UNITS_TABLE = Table(
    name="units",
    title="Units alone",
    columns=("unit", *CELLS, "routed, MHz"),
    order=tuple(_UNITS),
    notes=[
        f"LFE5U-85F of speed grade 6, one seed, {_ECP5.asked_mhz} MHz asked of each, "
        f"{_LESS_ASKED.asked_mhz} of the population; the registers around every port are counted. "
        "LUTs include carry chains and LUT RAMs. The chip of the board icebreaker is a two-tier "
        "checker of a map of 256 x 256 with a link, on a UP5K. Selection is synthesized by the "
        "yosys 0.23 of Debian (`YOSYS=yosys`): the ABC of 0.70, which maps logic, crashes on it."
    ],
)
PAPERS_TABLE = Table(
    name="papers",
    title="On the papers' devices",
    columns=(
        "design",
        "device",
        "LUTs",
        "of all LUTs, %",
        "flip-flops",
        "block RAMs",
        "of all block RAMs, %",
        "multipliers",
        "paper",
    ),
    order=tuple(_PAPER_DEVICES),
    notes=[
        "Synthesis only (`synth_xilinx`), units with their ports as they are; block RAMs of 18 "
        "kbit."
    ],
)
