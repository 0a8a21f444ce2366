"""A small terrain on disk, and plans over it from the command line."""

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pathgene.host.cli import main
from tests.support.host.kernels import compile_evaluation
from tests.support.host.processes import Started


ROOT = Path(__file__).resolve().parents[2]
#: A flight over the hills around a no-fly circle.
ENDS = (
    "--start",
    "500,500,100",
    "--goal",
    "5500,3500,100",
    "--agl",
    "--nofly-circle",
    "3000,2000,400",
)
#: No-fly zones that block the map from edge to edge.
WALL = [part for y in range(0, 4001, 400) for part in ("--nofly-circle", f"3000,{y},300")]
#: A plan by the planner for the chip with the paper core.
PAPER = ("--planner", "ga-fpga", "--generations", "60", "--seed", "1")
#: Files of a plan.
FILES = ["path.geojson", "path.png", "summary.json", "terrain.npz"]


#: Terms of a path that ``pathgene check`` must repeat.
TERMS = (
    "fitness",
    "penalty",
    "cost",
    "length_m",
    "mean_altitude_m",
    "fuel_N",
    "feasible",
    "feasible_at_ds",
    "minimum_clearance_m",
    "impossible_arcs",
    "waypoints",
)


def plan(hills, out, *options):
    """Run ``pathgene plan`` over the hills in this process; return its exit status."""
    return main(["plan", "--terrain", str(hills), *ENDS, *map(str, options), "--out", str(out)])


def assert_check_agrees(out, summary, capsys):
    """Assert that ``pathgene check`` of the summary in ``out`` repeats its terms."""
    capsys.readouterr()
    main(["check", "--path", str(out / "summary.json"), "--json"])
    report = json.loads(capsys.readouterr().out)
    assert {term: report[term] for term in TERMS} == {term: summary[term] for term in TERMS}


def wait_for(process, begin):
    """Read standard error up to a line; notes on compilation may precede it."""
    assert any(line.startswith(begin) for line in process.stderr), begin


@pytest.fixture(scope="session")
def straight_flight(tmp_path_factory):
    """The summary of a straight plan over hills, to be flown."""
    folder = tmp_path_factory.mktemp("plan")
    y, x = np.mgrid[:101, :101]
    hills = 100 + 30 * (np.sin(x / 11) * np.cos(y / 9) + 1)
    np.savez(folder / "hills.npz", elevation=hills, dx_m=60.0, dy_m=60.0)
    arguments = f"plan --terrain {folder / 'hills.npz'} --start 800,3000,250 --goal 5200,3000,250"
    arguments += f" --planner astar --no-picture --out {folder}"
    assert main(arguments.split()) == 0
    return str(folder / "summary.json")


def started(*arguments, program=("-m", "pathgene"), **options):
    """Start a command; return its process."""
    return Started(
        [sys.executable, *program, *map(str, arguments)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def is_gone(group):
    """Wait until no process of a group is left; return False after a limit."""
    for _ in range(100):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


def interrupted(arguments, line):
    """Send Ctrl-C after a line that starts with ``line``; return the JSON."""
    command = [sys.executable, "-m", "pathgene", *map(str, arguments), "--generations", "10000000"]
    with Started(
        [*command, "--json"], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        wait_for(process, line)
        process.send_signal(signal.SIGINT)
        output, error = process.communicate(timeout=60)
    assert process.returncode == 130
    assert error.splitlines()[-1] == "pathgene: Interrupted; the best path so far is written."
    return json.loads(output)


def summary_in(out):
    return json.loads((out / "summary.json").read_text())


@pytest.fixture(scope="session")
def kept_kernels():
    """Compile the kernels, so that no command notes that it compiles them."""
    compile_evaluation()


@pytest.fixture(scope="session")
def hills(tmp_path_factory, kept_kernels):
    """File of a terrain of 61 x 41 nodes at 100 m; its south-east corner is void."""
    y, x = np.mgrid[:41, :61]
    elevation = 300 + 150 * np.sin(x / 8) * np.cos(y / 6)
    elevation[:5, 50:] = np.nan
    file = tmp_path_factory.mktemp("terrain") / "hills.npz"
    np.savez(file, elevation=elevation, dx_m=100.0, dy_m=100.0)
    return file


def run_here(*arguments):
    """Run ``pathgene`` in this process; return its status and output as of a finished process."""
    output, error = (io.TextIOWrapper(io.BytesIO(), write_through=True) for _ in range(2))
    words = list(map(str, arguments))
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(error):
        status = main(words)
    told = [stream.buffer.getvalue().decode() for stream in (output, error)]
    return subprocess.CompletedProcess(words, status, *told)


@pytest.fixture(scope="session")
def pathgene():
    """Function that runs ``pathgene`` in a new process and returns the finished process."""

    def run(*arguments, timeout_s=120):
        return subprocess.run(
            [sys.executable, "-m", "pathgene", *map(str, arguments)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )

    return run


@pytest.fixture(scope="session")
def planned(hills, tmp_path_factory):
    """Directory, finished command and summary of a plan by ``PAPER``."""
    out = tmp_path_factory.mktemp("plan") / "out"
    done = run_here("plan", "--terrain", hills, *ENDS, *PAPER, "--out", out, "--json")
    return out, done, json.loads(done.stdout) if done.returncode == 0 else None


def last_line(error: str) -> str:
    """Return the last line of standard error, after the report on the terrain that was read."""
    *report, last = error.splitlines(keepends=True)
    assert all(line.startswith("pathgene: Terrain ") for line in report)
    return last
