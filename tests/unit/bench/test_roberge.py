"""The benchmarks of *roberge*, at a size that takes seconds."""

import pytest

from bench import roberge_speed, roberge_table4
from bench.report import Options
from pathgene.host.cores import available_cores


pytestmark = pytest.mark.ci  # Smoke test of a benchmark.


@pytest.mark.long
def test_speed_has_every_engine_and_the_machine_limits():
    report = roberge_speed.run(Options(), iterations=4, population=8, solutions=(8, 16), together=2)
    columns = report.columns
    rows = {row[:4]: dict(zip(columns, row, strict=True)) for row in report.rows}
    sequential = rows["sequential", 1, 8, 1]
    assert sequential["times as fast"] == 1
    # All engines of the processor find the same path.
    cores = available_cores()
    in_full = rows["all in full", cores, 8, 1]
    assert rows["threads", 1, 8, 1]["mean F"] == in_full["mean F"] == sequential["mean F"]
    assert in_full["all candidates/s"] == in_full["full evaluations/s"]
    assert sequential["all candidates/s"] > sequential["full evaluations/s"]
    assert ("threads", cores, 16, 1) in rows
    assert (("sequential, one a core", cores, 8, cores) in rows) == (cores > 1)
    assert rows["paper: Xeon W-2195, 1 thread", 1, 512, 1]["seconds"] == 78.4
    # The GPU's rows, one run and two at once, if there is a GPU.
    measured = {row[2:4] for row in report.rows if row[0] == "gpu"}
    if any("No GPU was measured" in note for note in report.notes):
        assert not measured
    else:
        assert measured == {(8, 1), (16, 1), (8, 2), (16, 2)}


@pytest.mark.long
def test_table_4_compares_at_equal_iterations_and_at_equal_work():
    report = roberge_table4.run(Options(trials=2), iterations=20, population=8)
    ways = [row[1] for row in report.rows if row[0] == "canyon"]
    assert ways == ["fpa", "fpa, equal evaluations", "fpa-2opt"]
    plain, equal, hybrid = (row[2] for row in report.rows if row[0] == "canyon")
    assert plain < hybrid <= equal
