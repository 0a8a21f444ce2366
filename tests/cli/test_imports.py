"""The modules that commands load: nothing heavy for help, and only necessary ones for a plan."""

import os
import subprocess
import sys

import pytest


# Prints which heavy modules a command has loaded, on the last line of standard error.
SCRIPT = """
import sys
from pathgene.host.cli import main
try:
    main(sys.argv[1:])
except SystemExit:
    pass
heavy = ("numpy", "scipy", "scipy.linalg", "scipy.ndimage", "scipy.optimize", "scipy.sparse",
         "highspy", "numba", "matplotlib",
         "rasterio", "pyproj", "amaranth", "serial", "distributed", "nicegui",
         "pathgene.host.diagnosis", "pathgene.host.web.page")
print(*(name for name in heavy if name in sys.modules), file=sys.stderr)
"""
PLAN = "plan --terrain canyon --agl --start 300,300,60 --goal 4700,4600,60 --planner astar"
PATH = "x,y,z\n300,300,1900\n4700,4600,1900\n"


def loaded(tmp_path, line):
    command = [sys.executable, "-c", SCRIPT, *line.split()]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    return set(done.stderr.splitlines()[-1].split())


@pytest.mark.parametrize("command", ["", "plan", "compare", "verilog", "desk", "board serve"])
def test_help_loads_nothing_heavy(tmp_path, command):
    assert loaded(tmp_path, f"{command} --help") == set()


@pytest.mark.parametrize(
    ("line", "modules"),
    [
        ("planners", set()),
        ("problem new mine.toml", set()),
        ("terrain list", {"numpy"}),
        # numba asks SciPy for its version.
        ("check --terrain canyon --path path.csv", {"numpy", "scipy", "numba"}),
        (f"{PLAN} --no-picture --out out", {"numpy", "scipy", "highspy", "numba"}),
    ],
)
def test_a_command_loads_what_it_needs(tmp_path, line, modules):
    (tmp_path / "path.csv").write_text(PATH)
    assert loaded(tmp_path, line) == modules


def test_a_command_starts_no_threads(tmp_path):
    script = (
        "import os, pathgene.__main__ as m; m.main(); print(len(os.listdir('/proc/self/task')))"
    )
    line = ["check", "--terrain", "canyon", "--path", "path.csv"]
    (tmp_path / "path.csv").write_text(PATH)
    done = subprocess.run(
        [sys.executable, "-c", script, *line],
        cwd=tmp_path,
        env={name: os.environ[name] for name in os.environ if name != "OPENBLAS_NUM_THREADS"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines()[-1] == "1"
