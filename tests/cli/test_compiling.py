"""The note before the kernels are compiled."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest

from pathgene.host.cli.output import note_compiling
from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from tests.support.host.processes import Started


ENDS = (500.0, 500.0, 250.0), (2500.0, 2500.0, 250.0)
SCRIPTS = {
    "by the rules": "note_compiling(as_paper=False)",
    "as paper": "note_compiling(as_paper=True)",
    "under water": "note_compiling_routes()",
}


@pytest.fixture
def script(tmp_path):
    """Function that starts one of ``SCRIPTS`` with an empty cache; returns its process."""

    def start(kernels, off="0"):
        script = f"from pathgene.host.cli.output import *; {SCRIPTS[kernels]}"
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_DISABLE_JIT": off}
        return Started(
            [sys.executable, "-c", script],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    return start


def note(kernels):
    duration = "some ten seconds" if kernels == "under water" else "about a minute"
    return f"pathgene: Compiling for this machine, once: {duration}.\n"


@pytest.mark.parametrize("kernels", SCRIPTS)
def test_notes_the_first_compilation(script, kernels):
    """The note comes before the compilation, whose end this test does not wait for."""
    with script(kernels) as process:
        assert process.stderr.readline() == note(kernels)
        process.send_signal(signal.SIGINT)


@pytest.mark.ci
def test_the_first_compilation_keeps_the_kernels(script):
    """The note is all that is written, and a second start writes nothing."""
    for expected in (note("as paper"), ""):
        with script("as paper") as process:
            assert process.communicate() == ("", expected)
        assert process.returncode == 0


@pytest.mark.parametrize("kernels", SCRIPTS)
def test_notes_nothing_without_a_compiler(script, kernels):
    with script(kernels, off="1") as process:
        assert process.communicate() == ("", "")
    assert process.returncode == 0


@pytest.mark.parametrize("as_paper", [False, True])
def test_notes_nothing_once_the_kernels_are_kept(capsys, as_paper):
    terrain = Terrain("flat", np.full((30, 30), 100.0), 100.0, 100.0)
    problem = Problem(terrain, *ENDS, as_paper=as_paper)
    Evaluator(problem, threads=1).evaluate(np.array(ENDS))
    note_compiling(as_paper=as_paper)
    assert capsys.readouterr().err == ""
