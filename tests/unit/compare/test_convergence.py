"""Bands of convergence."""

import numpy as np
import pytest

from pathgene.host.compare.convergence import band, same_generations, work_of

from .conftest import made_up_runs


def run_of(best, spent):
    return {
        "history": [[i, value, 0.0] for i, value in enumerate(best)],
        "history_evaluations": spent,
        "evaluations": 60,
        "generations": len(best) - 1,
    }


ONE = run_of([0.1, 0.2, 0.3], [10, 20, 60])
OTHER = run_of([0.5, 0.9], [20, 30])


def test_quartiles_at_every_point():
    found = band([ONE, OTHER], by_generation=False, logarithmic=False)
    assert (found.x[0], found.x[-1]) == (20, 60)  # The first point at which both have a value.
    for x, low, median, high in zip(found.x, found.low, found.median, found.high, strict=True):
        values = [0.2 if x < 60 else 0.3, 0.5 if x < 30 else 0.9]
        assert [low, median, high] == pytest.approx(np.quantile(values, [0.25, 0.5, 0.75]))


def test_over_generations():
    found = band([ONE, OTHER], by_generation=True, logarithmic=False)
    assert (found.x[0], found.x[-1]) == (0, 2)
    assert found.median[0] == pytest.approx(0.3)
    assert found.median[-1] == pytest.approx(0.6)  # The shorter run keeps its 0.9.


def test_logarithmic_points_end_where_the_others_do():
    found = band([ONE, OTHER], by_generation=False, logarithmic=True)
    assert (found.x[0], found.x[-1]) == (20, 60)
    assert np.diff(np.log(found.x)) == pytest.approx(np.log(3) / (len(found.x) - 1))
    assert found.high[-1] == pytest.approx(0.75)


def test_a_run_of_one_entry():
    found = band([run_of([1.5], [0])], by_generation=False, logarithmic=True)
    assert set(found.x) == {1.0}
    assert set(found.median) == {1.5}


def test_spreads_unknown_work_evenly():
    assert work_of({**ONE, "history_evaluations": []}).tolist() == [20, 40, 60]


def test_same_generations_need_equal_work():
    few, many = made_up_runs([1.4], first=32), made_up_runs([1.4], first=128, generations=90)
    assert same_generations([*few, *many])
    assert not same_generations([*few, *made_up_runs([1.4], each=23)])
    assert not same_generations([*few, *made_up_runs([1.5], generations=0)])
