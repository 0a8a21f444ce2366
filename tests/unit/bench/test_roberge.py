"""The benchmarks of *roberge*, at a size that takes seconds."""

import os

import pytest

from bench import roberge_speed, roberge_table4
from bench.report import Options


pytestmark = pytest.mark.ci  # Smoke test of a benchmark.


@pytest.mark.long
def test_speed_has_every_engine_and_the_machine_limits():
    report = roberge_speed.run(Options(), iterations=4, population=8, solutions=(8, 16))
    rows = {(row[0], row[1], row[2]): row for row in report.rows}
    sequential = rows["sequential", 1, 8]
    assert sequential[5] == 1
    # All engines find the same path.
    assert rows["cores", 1, 8][8] == rows["all in full", 1, 8][8] == sequential[8]
    assert rows["all in full", 1, 8][7] == 0 < sequential[7]
    cores = os.cpu_count()
    assert ("cores", cores, 16) in rows
    assert (("sequential, one a core", cores, 8) in rows) == (cores > 1)
    assert rows["paper: Xeon W-2195, 1 thread", 1, 512][3] == 78.4


@pytest.mark.long
def test_table_4_compares_at_equal_iterations_and_at_equal_work():
    report = roberge_table4.run(Options(trials=2), iterations=20, population=8)
    ways = [row[1] for row in report.rows if row[0] == "canyon"]
    assert ways == ["fpa", "fpa, equal evaluations", "fpa-2opt"]
    plain, equal, hybrid = (row[2] for row in report.rows if row[0] == "canyon")
    assert plain < hybrid <= equal
