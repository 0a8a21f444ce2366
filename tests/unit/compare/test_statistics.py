"""Statistics compared with SciPy and with counting, and samples to which no test applies."""

import itertools
import math
import statistics as standard

import numpy as np
import pytest
from scipy import stats

from pathgene.host.compare.statistics import compare_two, describe

from .conftest import made_up_runs


RNG = np.random.default_rng(5)
SPREAD = RNG.normal(1.45, 0.02, 30).tolist()
LOWER = RNG.normal(1.44, 0.05, 20).tolist()


def test_statistics_of_a_planner():
    final = [1.4, 0.001, 1.5, 1.45]
    found = describe(made_up_runs(final))
    assert found["runs"] == 4
    assert (found["feasible"], found["feasible_share"]) == (3, 0.75)
    assert found["fitness"]["mean"] == pytest.approx(standard.mean(final))
    assert found["fitness"]["std"] == pytest.approx(standard.stdev(final))
    assert found["fitness"]["best"] == 1.5
    assert found["fitness"]["median"] == pytest.approx(standard.median(final))
    assert found["seconds"]["mean"] == pytest.approx(0.625)
    assert found["seconds"]["best"] == 0.25
    assert found["evaluations"] == 32 + 22 * 30


def test_feasible_holds_between_the_samples_as_well():
    runs = made_up_runs([1.4, 1.45])
    runs[1]["feasible"] = False
    assert describe(runs)["feasible_share"] == 0.5


def test_statistics_of_one_run_and_none():
    one = describe(made_up_runs([1.4]))
    assert (one["fitness"]["mean"], one["fitness"]["std"]) == (1.4, None)
    none = describe([])
    assert none["runs"] == 0
    assert none["feasible_share"] is none["evaluations"] is none["fitness"]["mean"] is None


def test_matches_scipy():
    found = compare_two(SPREAD, LOWER)
    welch = stats.ttest_ind(SPREAD, LOWER, equal_var=False)
    ranks = stats.mannwhitneyu(SPREAD, LOWER)
    assert found["welch"]["p"] == pytest.approx(welch.pvalue, rel=1e-9)
    assert found["welch"]["statistic"] == pytest.approx(welch.statistic, rel=1e-9)
    assert found["mann_whitney"]["p"] == pytest.approx(ranks.pvalue, rel=1e-12)
    assert found["welch"]["p"] != stats.ttest_ind(SPREAD, LOWER).pvalue  # Student's test differs.


def test_welch_by_its_definition():
    a, b = SPREAD, LOWER
    shares = [standard.variance(values) / len(values) for values in (a, b)]
    t = (standard.mean(a) - standard.mean(b)) / math.sqrt(sum(shares))
    freedom = sum(shares) ** 2 / sum(
        share**2 / (len(values) - 1) for share, values in zip(shares, (a, b), strict=True)
    )
    assert compare_two(a, b)["welch"]["p"] == pytest.approx(2 * stats.t.sf(abs(t), freedom))


def test_mann_whitney_by_counting_all_arrangements():
    a, b = [1.1, 1.5, 1.6, 1.7], [1.2, 1.05, 1.3]
    pooled = sorted(a + b)

    def u(some):
        others = [value for value in pooled if value not in some]
        return sum(x > y for x in some for y in others)

    middle = len(a) * len(b) / 2
    away = abs(u(a) - middle)
    arrangements = list(itertools.combinations(pooled, len(a)))
    p = sum(abs(u(some) - middle) >= away for some in arrangements) / len(arrangements)
    found = compare_two(a, b)
    assert found["mann_whitney"]["p"] == pytest.approx(p)
    assert found["mann_whitney"]["statistic"] == u(a)
    assert found["superiority"] == u(a) / 12


def test_ties_count_half():
    assert compare_two([1.0, 2.0], [1.0, 1.0])["superiority"] == 0.75


def test_swapped_samples_give_the_same_p():
    one, other = compare_two(SPREAD, LOWER), compare_two(LOWER, SPREAD)
    assert one["mean_difference"] == -other["mean_difference"]
    assert one["superiority"] == pytest.approx(1 - other["superiority"])
    for test in ("welch", "mann_whitney"):
        assert one[test]["p"] == pytest.approx(other[test]["p"])


@pytest.mark.parametrize(
    ("a", "b", "welch", "mann_whitney"),
    [
        ([1.5] * 5, [1.5] * 9, "no difference", "no difference"),
        ([1.5] * 5, [1.5 + 1e-15] * 5, "no difference", "no difference"),
        ([1.5] * 5, [1.4] * 5, "no spread in either", None),
        ([1.5], [1.4, 1.3], "fewer than two runs", "fewer than two runs"),
        ([], [1.4, 1.3], "there are no runs", "there are no runs"),
    ],
)
def test_gives_the_reason_if_no_test_applies(a, b, welch, mann_whitney):
    found = compare_two(a, b)
    for test, note in ((found["welch"], welch), (found["mann_whitney"], mann_whitney)):
        assert test["note"] == note
        assert (test["p"] is None) == (test["statistic"] is None) == (note is not None)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("constant", [1.5, 1.51])
def test_a_planner_without_spread_gives_no_warning(constant):
    found = compare_two([constant] * 30, SPREAD)
    assert 0 < found["welch"]["p"] < 1e-6
    one_sample = stats.ttest_1samp(SPREAD, constant)
    assert found["welch"]["p"] == pytest.approx(one_sample.pvalue, rel=1e-6)
