"""The simulated board: a chip's Verilog with a real TCP port or terminal.

:func:`open_simulated` starts one from a URL. Below it, :mod:`pathgene.sim.board.programs` builds
the program (Verilator, or Icarus as a second opinion), and :mod:`pathgene.sim.board.process` runs
it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from pathgene.sim.board.process import SimulatedBoard
from pathgene.sim.board.programs import Program, build_program, verilate
from pathgene.sim.board.url import BoardOptions, parse_board_url


__all__ = [
    "BoardOptions",
    "Program",
    "SimulatedBoard",
    "build_program",
    "open_simulated",
    "parse_board_url",
    "verilate",
]


def open_simulated(
    url: str,
    verilog: Callable[[int], str],
    *,
    top: str,
    clocks_per_bit: int,
    listen: str = "127.0.0.1:0",
    pty: bool = False,
    keep: bool = False,
    build_dir: Path | None = None,
) -> SimulatedBoard:
    """Start the board of a ``sim:`` URL, after building it if necessary.

    Parameters
    ----------
    url : str
        See :func:`parse_board_url`.
    verilog : Callable[[int], str]
        Returns the chip's Verilog for a UART divisor.
    top : str
        Module of the chip; its ports are as in :func:`verilate`.
    clocks_per_bit : int
        UART divisor if the URL has none; a small divisor makes a fast simulation, 0 a byte-wide
        port.
    listen, pty, keep
        As in :class:`SimulatedBoard`.
    build_dir : Path, optional
        As in :func:`verilate`.

    Raises
    ------
    InputError
        If the URL is wrong.
    JobError
        If a tool is missing, or the simulator does not start.
    """
    options = parse_board_url(url)
    divisor = clocks_per_bit if options.clocks_per_bit is None else options.clocks_per_bit
    program = build_program(
        options.sim,
        verilog(divisor),
        top,
        divisor,
        trace=options.trace is not None,
        build_dir=build_dir,
    )
    return SimulatedBoard(
        program,
        listen=listen,
        pty=pty,
        keep=keep,
        idle_clocks=options.idle_clocks,
        trace=options.trace,
    )
