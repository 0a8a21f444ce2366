"""Commands on a warm machine: processor seconds, and the first line at a terminal."""

from __future__ import annotations

import os
import pty
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from bench.report import Options, Report


__all__ = ["run"]

#: Runs of each command that are measured, after a first one.
RUNS = 7
#: Runs of each command before these.
FIRST = 1
_PLAN = (
    *("plan", "--terrain", "jacksboro", "--agl", "--start", "2300,2500,100"),
    *("--goal", "26900,28400,100", "--nofly-circle", "10900,11600,2100"),
    *("--nofly-circle", "18300,19400,2100", "--planner", "astar", "--seed", "1"),
)
# The first command writes the files that the next ones read.
_COMMANDS = {
    "plan --planner astar": (*_PLAN, "--out", "out"),
    "the same with --no-picture": (*_PLAN, "--no-picture", "--out", "bare"),
    "check of the path": ("check", "--terrain", "jacksboro", "--path", "out/path.geojson"),
    "check of the summary": ("check", "--path", "out/summary.json"),
    "export": ("export", "out/summary.json", "--out", "exported"),
    "diagnose": ("diagnose", *_PLAN[1:-4]),
}


def run(options: Options) -> Report:
    """Measure each command in processes of its own."""
    report = Report(
        "Commands on a warm machine",
        ("command", "processor, s", "median, s", "first line, s"),
        notes=[
            f"Processor seconds, of user and system, of a process for each command: minimum and "
            f"median of {RUNS} runs after a first one. The last column is the minimum wall time "
            "from the start of the process to the first line at a terminal."
        ],
    )
    with tempfile.TemporaryDirectory() as folder:
        for name, command in _COMMANDS.items():
            runs = [_measured(command, Path(folder)) for _ in range(FIRST + RUNS)][FIRST:]
            processor, first = zip(*runs, strict=True)
            report.rows.append((name, min(processor), median(processor), min(first)))
    return report


def _measured(command: tuple[str, ...], folder: Path) -> tuple[float, float]:
    """Return the processor seconds of a command, and the wall seconds to its first line."""
    ours, theirs = pty.openpty()
    spent, began = _children_s(), time.monotonic()
    with subprocess.Popen(
        [sys.executable, "-m", "pathgene", *command],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=theirs,
    ) as process:
        os.close(theirs)
        os.read(ours, 1)
        first_s = time.monotonic() - began
        try:
            while os.read(ours, 4096):
                pass
        except OSError:  # The terminal closes with the process.
            pass
        status = process.wait()
    os.close(ours)
    assert status == 0, command
    return _children_s() - spent, first_s


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
