"""The benchmarks that repeat tables of papers, at a size that takes seconds."""

import itertools

import numpy as np
import pytest

from bench import allaire_table1, roberge_speed, roberge_table4
from bench.allaire_table1 import PHASES
from bench.cheng_table4 import (
    PAPER,
    _compared,
    _compared_with_paper,
    _Outcome,
    _with_dense_samples,
    contradictions,
    optimize,
    run,
)
from bench.report import Options
from pathgene.host.machine import available_cores


pytestmark = pytest.mark.ci  # Smoke test of a benchmark.


def test_where_the_paper_contradicts_itself():
    said = contradictions()
    ours, theirs = said[0], said[3]
    assert ours.startswith("The paper, landscape 1, ga-dp: ")
    assert "1.221 to 1.248" in ours
    assert ours.endswith("generations alike: 30 and 40, 60 and 70.")
    assert theirs.startswith("The paper, landscape 2, ga-auv: ")
    assert theirs.endswith("generations alike: 60 and 70, 70 and 80.")
    assert said[4].startswith("On landscape 1 its conventional GA has no higher delta than ")
    assert said[4].endswith("generations 70, 90, 100.")


def test_direct_optimizer_improves_with_evaluations():
    few, many = (optimize(2, 4, evaluations, 0) for evaluations in (120, 6000))
    assert many < few
    # The best straight line costs far more.
    assert many < 1.5


def test_short_tables_are_means_of_the_runs():
    """Runs with the terms of the paper's table have its delta."""
    outcomes = {}
    for samples, landscape in itertools.product((21, None), (1, 2)):
        for case in _compared(samples, landscape):
            rows = PAPER[landscape, case.planner]
            terms = np.array([(length, 1 - turn / 180, rate) for length, rate, turn in rows])
            outcomes[case] = [_Outcome(terms, terms, False, 1)] * 2
    paper = _compared_with_paper(outcomes)
    assert [row[:2] for row in paper.rows] == [*itertools.product((1, 2), (20, 50, 100))]
    assert [row[2:4] for row in paper.rows] == [row[4:] for row in paper.rows]
    dense = _with_dense_samples(outcomes)
    assert [row[:4] for row in dense.rows] == [row[:4] for row in paper.rows]
    assert [bool(row[4]) for row in dense.rows] == [False, False, True] * 2


@pytest.mark.long
def test_two_runs_fill_the_table():
    report = run(Options(trials=2))
    assert len(report.rows) == 2 * 2 * 2 * 3 * 10
    assert set(report.data["direct"]) == {
        f"{samples}, landscape {landscape}" for samples in ("21", "dense") for landscape in (1, 2)
    }
    said = " ".join(report.notes)
    assert said.count("by Welch's t-test") == said.count("by Mann-Whitney") == 2 * 2 * 2
    assert "landscape" in report.text()


pytestmark = pytest.mark.ci  # Smoke test of a benchmark.


GENERATIONS = 4


def test_every_phase_on_both():
    report = allaire_table1.run(Options(seeds=2), generations=GENERATIONS, board="model:")
    rows = {row[0]: row[1:] for row in report.rows}
    assert list(rows) == [*PHASES, "evaluation and sorting"]
    for name, phase in PHASES.items():
        paper_ms, paper_us, times, pc_ms, cycles, chip_us, faster = rows[name]
        assert (paper_ms, paper_us) == pytest.approx((1e3 * phase.pc_s, 1e6 * phase.fpga_s))
        assert times == pytest.approx(1e3 * paper_ms / paper_us)
        assert chip_us == pytest.approx(cycles / 100)  # At 100 MHz.
        assert faster == pytest.approx(1e3 * pc_ms / chip_us)
        assert pc_ms > 0
        assert cycles >= GENERATIONS
    assert rows["population update"][4] == GENERATIONS  # Each takes one cycle.
    assert rows["evaluation and sorting"][4] == "on the host"


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
