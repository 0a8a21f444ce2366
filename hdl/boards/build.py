"""Bitstreams of real boards: ``python -m pathgene.hdl.boards.build BOARD [--chip planner|paper]``.

Amaranth writes netlist, constraints and commands; this module runs the commands with the tools of
the package index, trying seeds of the placer until timing closes. A different program may be named
in the environment variable that Amaranth's own script reads: ``YOSYS``, ``NEXTPNR_ECP5``, and so
on.
"""

from __future__ import annotations

import argparse
import itertools
import json
import shlex
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from pathgene.hdl.boards import BOARDS, find_board
from pathgene.hdl.boards.board import Board, ChipKind
from pathgene.hdl.boards.board_top import BoardTop
from pathgene.hdl.boards.route import MOST_JOBS, Routed, route
from pathgene.hdl.boards.tools import BuildError, Stamp, run_tool
from pathgene.hdl.verilog import strip_zero_init


__all__ = ["build", "prepare", "try_seeds"]

#: Name of all files in the folder of a board.
NAME = "chip"


def prepare(board: Board, folder: Path) -> list[list[str]]:
    """Write the sources of ``board`` to ``folder``; return the tools' command lines in order.

    Like all simulations, synthesis reads Verilog instead of Amaranth's netlist, because Yosys only
    respects ``no_rw_check`` there; without it, memories with two read ports are doubled.
    """
    plan = board.platform().build(
        BoardTop(board),
        name=NAME,
        do_build=False,
        debug_verilog=True,
        # The netlist, and therefore the routing of a seed, must not depend on the sources' folder.
        emit_src=False,
        **board.overrides,
    )
    files = {
        name: content if isinstance(content, str) else content.decode()
        for name, content in plan.files.items()
    }
    debug = files.pop(f"{NAME}.debug.v")
    if f"{NAME}.ys" in files:
        del files[f"{NAME}.il"]
        files[f"{NAME}.v"] = debug
        script = files[f"{NAME}.ys"]
        files[f"{NAME}.ys"] = script.replace(f"read_rtlil {NAME}.il", f"read_verilog {NAME}.v")
    files[f"{NAME}.v"] = strip_zero_init(files[f"{NAME}.v"])
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (folder / name).write_text(content, encoding="utf-8")
    script = files[f"build_{NAME}.sh"]
    # As in: "$NEXTPNR_ECP5" --quiet ...
    lines = [shlex.split(line) for line in script.splitlines() if line.startswith('"$')]
    return [[line[0].removeprefix("$").lower().replace("_", "-"), *line[1:]] for line in lines]


def build(
    board: Board,
    folder: Path,
    *,
    seeds: int = 8,
    jobs: int | None = None,
    limit_s: float | None = None,
) -> Routed:
    """Make the bitstream of ``board`` in ``folder``, and a report next to it, ``report.json``.

    Parameters
    ----------
    seeds : int
        Number of seeds to try: the board's own seed, then from 1 upwards.
    jobs, limit_s : int, float, optional
        Number of seeds at a time, and time limit of a seed in seconds; see
        :func:`pathgene.hdl.boards.route.route`.

    Raises
    ------
    BuildError
        If a tool is missing or fails, or no seed closes timing.
    """
    routed, packing = try_seeds(board, folder, seeds=seeds, jobs=jobs, limit_s=limit_s)
    if not routed.closed:
        raise BuildError(
            f"No seed closes timing on {board.name}: the best, {routed.seed}, reaches "
            f"{routed.slack:.1%} of what is asked."
        )
    for tool, *arguments in packing:
        run_tool(tool, arguments, folder)
    names = {"board": board.name, "chip": board.chip}
    report = {**names, "build_id": board.config.build_id, **asdict(routed)}
    (folder / "report.json").write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    return routed


def try_seeds(
    board: Board,
    folder: Path,
    *,
    seeds: int,
    jobs: int | None = None,
    limit_s: float | None = None,
) -> tuple[Routed, list[list[str]]]:
    """Synthesize and route ``board`` as :func:`build` does, whether or not timing closes.

    Returns
    -------
    Routed
        The seed that closes timing, or the best one.
    list of list of str
        The remaining command lines, which run the packer.

    Raises
    ------
    BuildError
        If a tool is missing or fails.
    """
    commands = prepare(board, folder)
    tools = [command[0] for command in commands]
    at = next((number for number, tool in enumerate(tools) if tool.startswith("nextpnr")), None)
    if at is None:
        raise BuildError(
            f"{board.name} needs {tools[0]}, which does not come with the project: "
            f"run build_{NAME}.sh in {folder}."
        )
    for command in commands[:at]:
        _run_once(command, folder)
    others = (seed for seed in itertools.count(1) if seed != board.seed)
    order = [board.seed, *itertools.islice(others, seeds - 1)]
    routed = route(commands[at], folder, order, jobs=jobs, limit_s=limit_s)
    return routed, commands[at + 1 :]


def _run_once(command: Sequence[str], folder: Path) -> None:
    """Run ``command``, which synthesizes, unless its inputs are unchanged."""
    tool, *arguments = command
    inputs, outputs = [f"{NAME}.ys", f"{NAME}.v"], [f"{NAME}.json"]
    stamp = Stamp(tool, arguments, folder, inputs, outputs)
    if not stamp.matches():
        stamp.clear()
        run_tool(tool, arguments, folder)
        stamp.set()


def main(arguments: Sequence[str] | None = None) -> int:
    """Build the board that the command line names; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m pathgene.hdl.boards.build", description=__doc__
    )
    parser.add_argument("board", metavar="BOARD", help=", ".join(BOARDS))
    parser.add_argument(
        "--chip", metavar="CHIP", help=f"{', '.join(ChipKind)} (default the first that fits)"
    )
    parser.add_argument("--seeds", type=int, default=8, help="seeds to try (default 8)")
    parser.add_argument(
        "--jobs", type=int, help=f"seeds at a time (default one a core, at most {MOST_JOBS})"
    )
    parser.add_argument("--hours", type=float, help="longest time of a seed (default: no limit)")
    parser.add_argument("--out", type=Path, default=Path("build/bitstream"), help="folder")
    parser.add_argument(
        "--sources", action="store_true", help="write Verilog, constraints and scripts, run no tool"
    )
    options = parser.parse_args(arguments)
    if options.board not in BOARDS:
        sys.stderr.write(f"bitstream: BOARD must be one of {', '.join(BOARDS)}.\n")
        return 2
    for name in ("seeds", "jobs"):
        if (value := getattr(options, name)) is not None and value < 1:
            sys.stderr.write(f"bitstream: --{name} must be at least 1, not {value}.\n")
            return 2
    if options.hours is not None and not options.hours > 0:
        sys.stderr.write(f"bitstream: --hours must be more than 0, not {options.hours:g}.\n")
        return 2
    try:
        board = find_board(options.board, options.chip or None)
    except ValueError as error:
        sys.stderr.write(f"bitstream: {error}.\n")
        return 2
    limit_s = None if options.hours is None else 3600 * options.hours
    folder = options.out / board.name / board.chip
    if options.sources:
        prepare(board, folder)
        sys.stdout.write(f"{folder / f'{NAME}.v'}\n")
        return 0
    try:
        routed = build(
            board,
            folder,
            seeds=options.seeds,
            jobs=options.jobs,
            limit_s=limit_s,
        )
    except BuildError as error:
        sys.stderr.write(f"bitstream: {error}\n")
        return 1
    except KeyboardInterrupt:
        sys.stderr.write(
            "bitstream: interrupted. What has been synthesized and the seeds that have been routed "
            "are kept: the same command goes on from there.\n"
        )
        return 130
    for name, (achieved, asked) in routed.clocks.items():
        sys.stdout.write(f"{name}: {achieved:.1f} MHz, {asked:.1f} asked, seed {routed.seed}\n")
    for file in sorted((*folder.glob("*.bit"), *folder.glob("*.bin"), *folder.glob("*.svf"))):
        sys.stdout.write(f"{file}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
