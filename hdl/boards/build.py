"""Bitstreams of real boards: ``python -m hdl.boards.build BOARD [--seeds N] [--out FOLDER]``.

Amaranth writes netlist, constraints and commands; this runs the commands with the tools of the
package index, trying seeds of the placer until timing closes. Another program may be named in the
environment variable that Amaranth's own script looks at: ``YOSYS``, ``NEXTPNR_ECP5``, and so on.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from hdl.boards import BOARDS, find_board
from hdl.boards.board import Board
from hdl.boards.chip import Chip
from hdl.memories import without_contents


__all__ = ["BuildError", "Routed", "build", "prepare", "route", "run_tool", "tool_path"]

#: Name of all files in the folder of a board.
NAME = "chip"
#: The router that finishes (router2 stalls on the full design), and `closed` judges the timing.
ROUTER = ("--router", "router1", "--timing-allow-fail")


class BuildError(Exception):
    """No bitstream; the message is one sentence."""


@dataclass(frozen=True)
class Routed:
    """A placed and routed design.

    Parameters
    ----------
    seed : int
        Of the placer.
    clocks : dict of str to (float, float)
        Of each clock: what was achieved and what was asked for, MHz.
    cells : dict of str to (int, int)
        Of each kind of cell: used, and there on the device.
    """

    seed: int
    clocks: dict[str, tuple[float, float]]
    cells: dict[str, tuple[int, int]]

    @property
    def closed(self) -> bool:
        """Whether every clock is as fast as asked."""
        return all(achieved >= asked for achieved, asked in self.clocks.values())

    @property
    def slack(self) -> float:
        """Achieved frequency of the worst clock as a part of what was asked for."""
        return min(achieved / asked for achieved, asked in self.clocks.values())

    @classmethod
    def read(cls, report: Path, seed: int) -> Routed:
        """Return what nextpnr wrote to ``report``."""
        content = json.loads(report.read_text(encoding="utf-8"))
        return cls(
            seed=seed,
            clocks={
                name: (clock["achieved"], clock["constraint"])
                for name, clock in content["fmax"].items()
            },
            cells={
                name: (cell["used"], cell["available"])
                for name, cell in content["utilization"].items()
            },
        )


def tool_path(tool: str) -> str:
    """Return the program that is run as ``tool``, such as ``nextpnr-ecp5``.

    Raises
    ------
    BuildError
        If there is none.
    """
    named = os.environ.get(tool.upper().replace("-", "_"))
    path = shutil.which(
        named or f"yowasp-{tool}", path=None if named else sysconfig.get_path("scripts")
    )
    path = path or shutil.which(tool)
    if path is None:
        raise BuildError(f"{named or tool} is missing; `make bitstream` installs the open tools.")
    return path


def run_tool(tool: str, arguments: Sequence[str], folder: Path) -> None:
    """Run ``tool`` in ``folder``, its output in a log file there.

    Raises
    ------
    BuildError
        If it fails; the end of its output is on standard error.
    """
    log = folder / f"{tool}.log"
    with log.open("w", encoding="utf-8") as output:
        status = subprocess.run(
            [tool_path(tool), *arguments],
            cwd=folder,
            stdout=output,
            stderr=subprocess.STDOUT,
            check=False,
        ).returncode
    if status != 0:
        sys.stderr.write("".join(log.read_text(errors="replace").splitlines(True)[-20:]))
        raise BuildError(f"{tool} failed with status {status}; its output is in {log}.")


def prepare(board: Board, folder: Path) -> list[list[str]]:
    """Write the sources of ``board`` to ``folder``; return the tools' command lines in order.

    Synthesis reads Verilog, as all simulations do, and not Amaranth's netlist: only there yosys
    minds ``no_rw_check``, without which it doubles the memories of two read ports.
    """
    plan = board.platform().build(
        Chip(board), name=NAME, do_build=False, debug_verilog=True, **board.overrides
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
    files[f"{NAME}.v"] = without_contents(files[f"{NAME}.v"])
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (folder / name).write_text(content, encoding="utf-8")
    script = files[f"build_{NAME}.sh"]
    # As in: "$NEXTPNR_ECP5" --quiet ...
    lines = [shlex.split(line) for line in script.splitlines() if line.startswith('"$')]
    return [[line[0].removeprefix("$").lower().replace("_", "-"), *line[1:]] for line in lines]


def route(
    command: Sequence[str], folder: Path, seeds: Iterable[int], *, enough: float = 1.0
) -> Routed:
    """Run ``command``, a nextpnr with its arguments, with each seed until timing closes.

    Parameters
    ----------
    enough : float
        Part of the asked frequency at which to stop.

    Returns
    -------
    Routed
        The first that closes, or the best of all. What lies in ``folder`` is of the latest seed.
    """
    tried = []
    for seed in seeds:
        report = folder / f"seed-{seed}.json"
        run_tool(
            command[0],
            [*command[1:], *ROUTER, "--seed", str(seed), "--report", report.name],
            folder,
        )
        tried.append(Routed.read(report, seed))
        sys.stderr.write(
            f"seed {seed}: "
            + ", ".join(
                f"{name} {achieved:.1f} of {asked:.1f} MHz"
                for name, (achieved, asked) in tried[-1].clocks.items()
            )
            + "\n"
        )
        if tried[-1].slack >= enough:
            break
    return max(tried, key=lambda routed: routed.slack)


def build(board: Board, folder: Path, *, seeds: Iterable[int] = range(1, 9)) -> Routed:
    """Make the bitstream of ``board`` in ``folder``, and a report beside it, ``chip.json``.

    Raises
    ------
    BuildError
        If a tool is missing or fails, or no seed closes timing.
    """
    commands = prepare(board, folder)
    if not any(command[0].startswith("nextpnr") for command in commands):
        raise BuildError(
            f"{board.name} needs {commands[0][0]}, which does not come with the project: "
            f"run build_{NAME}.sh in {folder}."
        )
    routed = None
    for command in commands:
        if command[0].startswith("nextpnr"):
            routed = route(command, folder, seeds)
            if not routed.closed:
                raise BuildError(
                    f"No seed closes timing on {board.name}: the best, {routed.seed}, reaches "
                    f"{routed.slack:.1%} of what is asked."
                )
        else:
            run_tool(command[0], command[1:], folder)
    assert routed is not None
    report = {"board": board.name, "build_id": board.config.build_id, **asdict(routed)}
    (folder / f"{NAME}.json").write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    return routed


def main(arguments: Sequence[str] | None = None) -> int:
    """Build what the command line says; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m hdl.boards.build", description=__doc__)
    parser.add_argument("board", metavar="BOARD", help=", ".join(BOARDS))
    parser.add_argument("--seeds", type=int, default=8, help="seeds to try (default 8)")
    parser.add_argument("--out", type=Path, default=Path("build/bitstream"), help="folder")
    options = parser.parse_args(arguments)
    if options.board not in BOARDS:
        sys.stderr.write(f"bitstream: BOARD must be one of {', '.join(BOARDS)}.\n")
        return 2
    folder = options.out / options.board
    try:
        routed = build(find_board(options.board), folder, seeds=range(1, options.seeds + 1))
    except BuildError as error:
        sys.stderr.write(f"bitstream: {error}\n")
        return 1
    for name, (achieved, asked) in routed.clocks.items():
        sys.stdout.write(f"{name}: {achieved:.1f} MHz, {asked:.1f} asked, seed {routed.seed}\n")
    for file in sorted((*folder.glob("*.bit"), *folder.glob("*.bin"), *folder.glob("*.svf"))):
        sys.stdout.write(f"{file}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
