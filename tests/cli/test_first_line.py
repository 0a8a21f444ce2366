"""The first line at a terminal, before anything heavy is loaded."""

import subprocess
import sys

import pytest


# Ends the command at the first line on its terminal; prints the line, and whether NumPy is loaded.
SCRIPT = """
import io, os, sys
from pathgene.host.cli import main

class Terminal(io.StringIO):
    def isatty(self):
        return True

    def write(self, text):
        heavy = [name for name in ("numpy", "amaranth", "nicegui") if name in sys.modules]
        os.write(1, f"{text} {heavy}".encode())
        os._exit(0)

sys.stderr = Terminal()
main(sys.argv[1:])
"""


@pytest.mark.parametrize(
    ("line", "first"),
    [
        ("plan --terrain canyon", "Reading the problem."),
        ("check --path path.csv", "Reading the problem."),
        ("compare --planners astar", "Reading the problem."),
        ("diagnose --terrain canyon", "Reading the problem."),
        ("batch a.toml", "Reading the problems."),
        ("fly summary.json", "Reading the plan."),
        ("export summary.json", "Reading the plan."),
        ("upload summary.json --to udp:localhost:14550", "Reading the mission."),
        ("mend a.plan --out b.plan", "Reading the mission."),
        ("feasible --map map.npy --path path.csv", "Reading the map."),
        ("auv", "Loading the planner."),
        ("verilog --top chip --out chip.v", "Elaborating the design."),
        ("desk", "Loading the desk."),
    ],
)
def test_says_at_once_that_work_has_begun(tmp_path, line, first):
    command = [sys.executable, "-c", SCRIPT, *line.split()]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stdout == f"pathgene: {first} []"
