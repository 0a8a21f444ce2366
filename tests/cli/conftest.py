"""A small terrain on disk, and the command line as a user runs it."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest


ROOT = Path(__file__).resolve().parents[2]
#: A flight over the hills, around the one no-fly circle.
ENDS = (
    "--start",
    "500,500,100",
    "--goal",
    "5500,3500,100",
    "--agl",
    "--nofly-circle",
    "3000,2000,400",
)
#: No-fly zones from edge to edge.
WALL = [part for y in range(0, 4001, 400) for part in ("--nofly-circle", f"3000,{y},300")]
#: What a plan writes.
FILES = ["path.geojson", "path.png", "summary.json", "terrain.npz"]


def summary_in(out):
    return json.loads((out / "summary.json").read_text())


@pytest.fixture(scope="session")
def hills(tmp_path_factory):
    """File of a terrain of 61 x 41 nodes at 100 m; its south-east corner is void."""
    y, x = np.mgrid[:41, :61]
    elevation = 300 + 150 * np.sin(x / 8) * np.cos(y / 6)
    elevation[:5, 50:] = np.nan
    file = tmp_path_factory.mktemp("terrain") / "hills.npz"
    np.savez(file, elevation=elevation, dx_m=100.0, dy_m=100.0)
    return file


@pytest.fixture(scope="session")
def pathgene():
    """Run ``pathgene`` in a separate process; return the finished process."""

    def run(*arguments, timeout_s=120):
        return subprocess.run(
            [sys.executable, "-m", "host", *map(str, arguments)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )

    return run


@pytest.fixture(scope="session")
def planned(hills, pathgene, tmp_path_factory):
    """Directory, process and summary of one plan."""
    out = tmp_path_factory.mktemp("plan") / "out"
    done = pathgene(
        "plan", "--terrain", hills, *ENDS, "--generations", 60, "--seed", 1, "--out", out, "--json"
    )
    return out, done, json.loads(done.stdout) if done.returncode == 0 else None
