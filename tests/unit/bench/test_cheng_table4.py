"""The benchmark of table IV."""

import itertools

import numpy as np
import pytest

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
