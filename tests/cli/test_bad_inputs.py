"""Random bad inputs: each ends with one sentence, soon, and in little memory."""

import json
import subprocess
import sys

import pytest

from tests.bad_inputs import cases

from .conftest import ROOT


SEED = 1


def faults(first, last):
    """Run cases in a process of their own; return those that break the rule."""
    command = [sys.executable, "-m", "tests.bad_input_runs", str(SEED), str(first), str(last)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *found, kinds = map(json.loads, done.stdout.splitlines())
    assert sum(kinds.values()) == last - first
    return found


def test_a_sample(kept_kernels):
    assert faults(0, 60) == []


@pytest.mark.ci
@pytest.mark.parametrize("first", range(60, 1000, 200))
def test_a_thousand(kept_kernels, first):
    assert faults(first, min(first + 200, 1000)) == []


def test_the_cases_are_mixed():
    """The sample has all kinds; the same seed gives the same cases."""
    made = list(cases(SEED, 60))
    assert made == list(cases(SEED, 60))
    kinds = {case.kind.split()[0].rstrip(",") for case in made}
    assert {"terrain", "zones", "path", "summary", "problem", "number", "option"} <= kinds
