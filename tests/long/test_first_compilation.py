"""The first command on a machine compiles no kernel in its own process."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pathgene.host.planners.registry import PLANNERS


pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]
# Runs a command and prints the kernels that its process has compiled.
SCRIPT = """
import gc, sys
from numba.core.dispatcher import Dispatcher
from pathgene.host.cli import main
assert main(sys.argv[1:]) in (0, 1)
kernels = [each for each in gc.get_objects() if isinstance(each, Dispatcher)]
assert any(kernel.stats.cache_hits for kernel in kernels)
print([kernel.__name__ for kernel in kernels if kernel.stats.cache_misses], file=sys.stderr)
"""
FLIGHT = "--start 500,500,100 --goal 5500,3500,100 --agl --nofly-circle 3000,2000,400"


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.mark.parametrize("planner", [*PLANNERS, "auv"])
def test_no_command_compiles_in_its_own_process(cache, tmp_path, planner):
    y, x = np.mgrid[:41, :61]
    hills = 300 + 150 * np.sin(x / 8) * np.cos(y / 6)
    np.savez(tmp_path / "hills.npz", elevation=hills, dx_m=100.0, dy_m=100.0)
    plan = f"plan --terrain {tmp_path / 'hills.npz'} {FLIGHT} --planner {planner} --no-picture"
    command = f"{'auv' if planner == 'auv' else plan} --generations 2 --out {tmp_path}"
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *command.split()],
        cwd=ROOT,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr.splitlines()[-1] == "[]"
