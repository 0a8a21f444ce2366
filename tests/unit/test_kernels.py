"""The kernels that a set-up compiles are all that the commands call."""

import json
import subprocess
import sys

import pytest


RECORDED = """
import json
from pathgene import jit

found = set()
load = jit._CheckedFiles.load

def recorded(self, key):
    found.add((*self._place, str(key[0])))
    return load(self, key)

jit._CheckedFiles.load = recorded
{body}
print(json.dumps(sorted(found)))
"""

SET_UP = """
from pathgene.host import kernels
kernels.{part}()
"""

# The paper's loop has no kernels of its own.
PLANS = """
from pathgene import Problem, Terrain, Zone, check, plan, planners

zones = Zone.circle(2500, 2500, 300), Zone.polygon([(900, 100), (1500, 100), (900, 800)])
ends = (300, 300, 60), (4700, 4600, 60)
for as_paper in (False, True):
    problem = Problem(Terrain.load("canyon"), *ends, agl=True, zones=zones, as_paper=as_paper)
    for planner in planners():
        options = {} if planner == "astar" else {"generations": 2}
        if planner == "ga-chip":
            options["board"] = "model:"
        if planner != "ga-fpga":
            check(problem, plan(problem, planner=planner, seed=1, **options).path)
    # Through zones of both kinds, and below the ground.
    for corner in (1000, 300, -100), (2500, 2500, 1000):
        check(problem, [problem.start, corner, problem.goal])
"""

# Under water.
ROUTES = """
from pathgene.host.cli import main

for landscape in ("1", "2"):
    for planner in ("ga-dp", "ga-auv"):
        for more in ([], ["--as-paper"], ["--reading", "sum"], ["--length", "3d"]):
            options = ["--landscape", landscape, "--planner", planner, *more]
            assert main(["auv", *options, "--generations", "3", "--out", "{out}"]) == 0
"""

# Maps of both kinds of chips, and faults of a mission.
CHECKS = """
from pathlib import Path

import numpy as np

from pathgene.host.cli import main

folder = Path("{out}")
np.save(folder / "map.npy", np.zeros((64, 64), dtype=np.uint8))
(folder / "cells.csv").write_text("x,y,z\\n1,1,20\\n30,40,20\\n50,60,20\\n")
for more in ([], ["--count"], ["--mode", "parallel"]):
    files = ["--map", str(folder / "map.npy"), "--path", str(folder / "cells.csv")]
    assert main(["feasible", *files, *more]) == 0
(folder / "path.csv").write_text("x,y,z\\n300,300,900\\n2500,2500,900\\n4700,4600,900\\n")
line = ["check", "--terrain", "canyon", "--path", str(folder / "path.csv")]
assert main([*line, "--nofly-circle", "2500,2500,300"]) == 1
"""


def loaded(body):
    """Return the kernels, with their types, that a program loads or compiles."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", RECORDED.replace("{body}", body)],
        capture_output=True,
        text=True,
        check=True,
    )
    return {tuple(each) for each in json.loads(done.stdout.splitlines()[-1])}


@pytest.fixture(scope="module")
def set_up():
    return [loaded(SET_UP.format(part=part)) for part in ("compile_host", "compile_chip")]


@pytest.mark.parametrize(
    "body",
    [
        pytest.param(PLANS, id="plan"),
        pytest.param(CHECKS, id="check"),
        pytest.param(ROUTES, id="auv", marks=pytest.mark.long),
    ],
)
def test_no_command_compiles_after_a_set_up(set_up, tmp_path, body):
    needed = loaded(body.replace("{out}", str(tmp_path)))
    assert needed
    assert needed <= set.union(*set_up)


def test_the_two_parts_share_nothing(set_up):
    host, chip = set_up
    assert host
    assert chip
    assert not host & chip
