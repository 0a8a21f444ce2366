"""Builds the programs of the simulated board: a chip's Verilog in a bridge to its line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pathgene.host.errors import InputError
from pathgene.sim.cache import BuildCache, build_root
from pathgene.sim.compiler import compile_object
from pathgene.sim.icarus import build_icarus, build_icarus_module
from pathgene.sim.verilator import build_verilator


__all__ = ["Program", "Simulator", "build_program", "verilate"]

Simulator = Literal["verilator", "icarus"]

_HERE = Path(__file__).parent


@dataclass(frozen=True)
class Program:
    """A simulator of one chip, ready to start.

    Parameters
    ----------
    simulator : {"verilator", "icarus"}
        Simulator that the program was built with.
    path : Path
        The program (Verilator) or the compiled design (Icarus).
    clocks_per_bit : int
        UART divisor of the chip, cycles; 0 for a byte-wide port.
    traced : bool
        The program can write a waveform.
    module : Path, optional
        The bridge as an Icarus module.
    """

    simulator: Simulator
    path: Path
    clocks_per_bit: int
    traced: bool = False
    module: Path | None = None

    def command(
        self,
        *,
        listen: str = "127.0.0.1:0",
        pty: bool = False,
        keep: bool = False,
        idle_clocks: int | None = None,
        trace: Path | None = None,
    ) -> list[str]:
        """Return the command line that starts the program; ``bridge.hpp`` explains its options.

        Raises
        ------
        InputError
            If ``trace`` is given and the program cannot write a waveform.
        """
        if trace is not None and not self.traced:
            raise InputError("This simulator was built without waveforms; build it with trace set.")
        options = ["--clocks-per-bit", str(self.clocks_per_bit)]
        options += ["--pty"] if pty else ["--listen", listen]
        options += ["--keep"] if keep else []
        options += [] if idle_clocks is None else ["--idle-clocks", str(idle_clocks)]
        if self.simulator == "verilator":
            waves = [] if trace is None else ["--trace", str(trace)]
            return [str(self.path), *options, *waves]
        waves = [] if trace is None else [f"+trace={trace}"]
        # -n ends a simulation that stops and would otherwise wait for the terminal.
        assert self.module is not None
        start = ["vvp", "-n", "-M", str(self.module.parent), "-m", self.module.stem]
        return [*start, str(self.path), *options, *waves]


def verilate(
    verilog: str,
    top: str,
    clocks_per_bit: int,
    *,
    trace: bool = False,
    build_dir: Path | None = None,
) -> Program:
    """Return the simulated board, built with Verilator if necessary.

    Parameters
    ----------
    verilog : str
        Self-contained text of the chip.
    top : str
        Module of the chip, with the ports ``clk``, ``rst`` (active high, synchronous), ``rx`` and
        ``tx``, or with the byte-wide port of :class:`pathgene.hdl.top.Chip`.
    clocks_per_bit : int
        UART divisor of the chip, cycles, 2 or more; 0 for a byte-wide port.
    trace : bool
        Let the program write a VCD file. Such a program is slower even if it does not write one.
    build_dir : Path, optional
        Keeps the builds; default ``sim/`` in :func:`pathgene.sim.cache.build_root`.

    Raises
    ------
    JobError
        If a tool is missing or refuses the chip.
    """
    builds = _cache(build_dir)
    path = build_verilator(
        builds,
        verilog,
        top,
        main=_HERE / "verilator_main.cpp",
        objects=[compile_object(builds, _HERE / "bridge.cpp")],
        trace=trace,
    )
    return Program("verilator", path, clocks_per_bit, trace)


def build_program(
    simulator: Simulator,
    verilog: str,
    top: str,
    clocks_per_bit: int,
    *,
    trace: bool = False,
    build_dir: Path | None = None,
) -> Program:
    """Build the simulated board with either simulator; parameters as in :func:`verilate`.

    Icarus interprets the Verilog and runs a chip a thousand times slower. It models undefined
    values, and therefore gives a second opinion on short runs.
    """
    if simulator == "verilator":
        return verilate(verilog, top, clocks_per_bit, trace=trace, build_dir=build_dir)
    builds = _cache(build_dir)
    bench = (_HERE / "icarus_top.v").read_text()
    defines = f"`define BOARD_TOP {top}\n" + ("" if clocks_per_bit else "`define BOARD_BYTES\n")
    text = f"`timescale 1ns / 1ns\n{verilog}\n{defines}{bench}"
    return Program(
        "icarus",
        build_icarus(builds, text, ["board_bench"]),
        clocks_per_bit,
        traced=True,
        module=build_icarus_module(builds, [_HERE / "icarus_vpi.cpp", _HERE / "bridge.cpp"]),
    )


def _cache(build_dir: Path | None) -> BuildCache:
    return BuildCache(build_root() / "sim" if build_dir is None else build_dir)
