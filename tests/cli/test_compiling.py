"""The note before the kernels are compiled."""

import os
import subprocess
import sys

import numpy as np
import pytest

from pathgene.host.cli.output import note_compiling
from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


ENDS = (500.0, 500.0, 250.0), (2500.0, 2500.0, 250.0)
SCRIPTS = {
    "by the rules": "note_compiling(as_paper=False)",
    "as paper": "note_compiling(as_paper=True)",
    "under water": "note_compiling_routes()",
}


@pytest.mark.parametrize("kernels", SCRIPTS)
@pytest.mark.parametrize("off", [False, True])
def test_notes_the_first_compilation(tmp_path, kernels, off):
    """It notes an empty cache, and nothing if there is no compiler."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    environment["NUMBA_DISABLE_JIT"] = str(int(off))
    script = f"from pathgene.host.cli.output import *; {SCRIPTS[kernels]}"
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    duration = "some ten seconds" if kernels == "under water" else "about a minute"
    note = f"pathgene: Compiling for this machine, once: {duration}.\n"
    assert done.stderr == ("" if off else note)
    assert done.stdout == ""


@pytest.mark.parametrize("as_paper", [False, True])
def test_notes_nothing_once_the_kernels_are_kept(capsys, as_paper):
    terrain = Terrain("flat", np.full((30, 30), 100.0), 100.0, 100.0)
    problem = Problem(terrain, *ENDS, as_paper=as_paper)
    Evaluator(problem, threads=1).evaluate(np.array(ENDS))
    note_compiling(as_paper=as_paper)
    assert capsys.readouterr().err == ""
