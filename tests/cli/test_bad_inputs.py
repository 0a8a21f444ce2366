"""Random bad inputs: each ends quickly with one sentence, using little memory."""

import json
import subprocess
import sys

import pytest

from tests.support.bad_input.inputs import cases

from .conftest import ROOT


SEED = 1
# Number of cases, and the minimum share of refused ones, because damage may hit bytes that nobody
# reads.
CASES, REFUSED = 1200, 0.84


def assert_refused(first, last):
    """Run cases in a separate process; none breaks the rule, and few turn out to be valid."""
    command = [
        sys.executable,
        "-m",
        "tests.support.bad_input.runs",
        str(SEED),
        str(first),
        str(last),
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *found, (surely_bad, refused, accepted) = map(json.loads, done.stdout.splitlines())
    assert found == []
    bad = sum(refused.values())
    print(f"{surely_bad} surely bad, {bad} refused, not refused: {accepted}")
    assert bad + sum(accepted.values()) == last - first
    assert bad >= surely_bad > 0.25 * (last - first)
    assert bad >= REFUSED * (last - first)


@pytest.mark.ci
def test_a_sample(kept_kernels):
    assert_refused(0, 60)


@pytest.mark.long
@pytest.mark.parametrize("first", range(0, CASES, 200))
def test_a_thousand(kept_kernels, first):
    assert CASES * REFUSED > 1000
    assert_refused(first, first + 200)


def test_the_cases_are_mixed():
    """The sample has all kinds; the same seed gives the same cases."""
    made = list(cases(SEED, 60))
    assert made == list(cases(SEED, 60))
    kinds = {case.kind.split()[0].rstrip(",") for case in made}
    assert {"terrain", "zones", "path", "summary", "problem", "number", "option"} <= kinds
