"""The note before the kernels are compiled."""

import os
import subprocess
import sys

import numpy as np
import pytest

from host.cli.compiling import note_compiling
from host.evaluation import Evaluator
from host.problem import Problem
from host.terrain import Terrain


NOTE = "pathgene: Compiling for this machine, once: about a minute.\n"
ENDS = (500.0, 500.0, 250.0), (2500.0, 2500.0, 250.0)
SCRIPT = f"""
import numpy as np
from host.cli.compiling import note_compiling
from host.problem import Problem
from host.terrain import Terrain

terrain = Terrain("flat", np.full((30, 30), 100.0), 100.0, 100.0)
note_compiling(Problem(terrain, *{ENDS}, as_paper=AS_PAPER))
"""


@pytest.mark.parametrize("as_paper", [False, True])
@pytest.mark.parametrize("off", [False, True])
def test_notes_the_first_compilation(tmp_path, as_paper, off):
    """It notes a cache that is empty, and nothing where there is no compiler."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    environment["NUMBA_DISABLE_JIT"] = str(int(off))
    script = SCRIPT.replace("AS_PAPER", str(as_paper))
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stderr == ("" if off else NOTE)
    assert done.stdout == ""


@pytest.mark.parametrize("as_paper", [False, True])
def test_notes_nothing_once_the_kernels_are_kept(capsys, as_paper):
    terrain = Terrain("flat", np.full((30, 30), 100.0), 100.0, 100.0)
    problem = Problem(terrain, *ENDS, as_paper=as_paper)
    Evaluator(problem, threads=1).evaluate(np.array(ENDS))
    note_compiling(problem)
    assert capsys.readouterr().err == ""
