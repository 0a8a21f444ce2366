"""The modules that commands load: nothing heavy for help, and only necessary ones for a plan."""

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
heavy = ("numpy", "scipy", "numba", "matplotlib", "rasterio", "pyproj", "amaranth", "serial",
         "distributed", "nicegui", "pathgene.host.diagnosis", "pathgene.host.web.page")
print(*(name for name in heavy if name in sys.modules), file=sys.stderr)
"""
PLAN = "plan --terrain canyon --agl --start 300,300,60 --goal 4700,4600,60 --planner astar"


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
        (f"{PLAN} --no-picture --out out", {"numpy", "scipy", "numba"}),
    ],
)
def test_a_command_loads_what_it_needs(tmp_path, line, modules):
    assert loaded(tmp_path, line) == modules
