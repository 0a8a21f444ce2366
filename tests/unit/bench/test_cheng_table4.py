"""The benchmark of table IV."""

import pytest

from bench.cheng_table4 import contradictions, optimize, run
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
