"""Dieharder on the raw bits of the random source: all draws of each cycle, in port order.

It takes more than an hour; ``make test-long`` installs the Debian package if it is allowed to. The
published results belong to these seeds.
"""

import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.support.host.processes import Started


pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]

SEEDS = (1, 2)
TWIN = (sys.executable, "-m", "pathgene.sim.model.random_stream", "--seed")
#: Minimum results of ``dieharder -a``; version 3.31 gives 114.
FEWEST_RESULTS = 100


def dieharder(seed):
    """Return the assessment of every test, by name, tuple size and occurrence."""
    with Started([*TWIN, str(seed)], stdout=subprocess.PIPE, cwd=ROOT) as twin:
        report = subprocess.run(
            ["dieharder", "-g", "200", "-a"], stdin=twin.stdout, capture_output=True, check=True
        ).stdout.decode()
        twin.terminate()
    return parse(report)


def parse(report):
    assessments = {}
    for line in report.splitlines():
        fields = [field.strip() for field in line.split("|")]
        if len(fields) == 6 and fields[-1] in ("PASSED", "WEAK", "FAILED"):
            name, tuple_size = fields[:2]
            occurrence = sum(key[:2] == (name, tuple_size) for key in assessments)
            assessments[name, tuple_size, occurrence] = fields[-1]
    return assessments


@pytest.mark.skipif(shutil.which("dieharder") is None, reason="dieharder is not installed")
def test_no_test_fails_twice():
    """A good source fails one test in a million, and no test with both seeds."""
    failed = None
    for seed in SEEDS:
        assessments = dieharder(seed)
        assert len(assessments) >= FEWEST_RESULTS
        now = {test for test, assessment in assessments.items() if assessment == "FAILED"}
        failed = now if failed is None else failed & now
        if not failed:
            return
    pytest.fail(f"FAILED with every seed of {SEEDS}: {sorted(failed)}")


def test_parses_every_line_of_a_report():
    report = """
   rng_name    |rands/second|   Seed   |
stdin_input_raw|  4.23e+06  |2910847918|
#=============================================================================#
        test_name   |ntup| tsamples |psamples|  p-value |Assessment
#=============================================================================#
   diehard_birthdays|   0|       100|     100|0.06335560|  PASSED
      diehard_operm5|   0|   1000000|     100|0.99908496|   WEAK
        diehard_runs|   0|    100000|     100|0.86561960|  PASSED
        diehard_runs|   0|    100000|     100|0.00000000|  FAILED
"""
    assert parse(report) == {
        ("diehard_birthdays", "0", 0): "PASSED",
        ("diehard_operm5", "0", 0): "WEAK",
        ("diehard_runs", "0", 0): "PASSED",
        ("diehard_runs", "0", 1): "FAILED",
    }


def test_stream_is_fast_enough():
    """The stream delivers at least 100 MB/s; a battery reads about 200 GB."""
    with Started([*TWIN, "1"], stdout=subprocess.PIPE, cwd=ROOT) as twin:
        twin.stdout.read(1 << 20)  # Start-up and compilation.
        start = time.perf_counter()
        size = len(twin.stdout.read(1 << 28))
        seconds = time.perf_counter() - start
        twin.terminate()
    assert size == 1 << 28
    assert size / seconds > 100e6
