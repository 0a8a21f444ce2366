"""Linear programs, compared with SciPy's."""

import numpy as np
import pytest
from scipy.optimize import linprog

from pathgene.host.planners.grid.linear_program import minimised


FREE = (-np.inf, np.inf)


@pytest.mark.parametrize("seed", range(20))
def test_random_programs_have_the_same_minimum(seed, capfd):
    random = np.random.default_rng(seed)
    rows, columns = 30, 8
    # Half the weights are zero; a feasible point is inside the bounds.
    matrix = random.normal(size=(rows, columns)) * random.integers(0, 2, (rows, columns))
    inside = random.uniform(-1, 1, columns)
    limits = matrix @ inside + random.uniform(0, 1, rows)
    bounds = np.column_stack((inside - 2, inside + 2))
    bounds[0] = inside[0]
    costs = random.normal(size=columns)
    found = minimised(costs, matrix, limits, bounds)
    expected = linprog(costs, A_ub=matrix, b_ub=limits, bounds=bounds, method="highs")
    assert costs @ found == pytest.approx(expected.fun, rel=1e-9)
    assert (matrix @ found <= limits + 1e-6).all()
    assert (found >= bounds[:, 0] - 1e-6).all()
    assert (found <= bounds[:, 1] + 1e-6).all()
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("limits", "bounds"),
    [
        pytest.param((-1.0, -1.0), (FREE,), id="contradiction"),
        pytest.param((1.0, np.inf), (FREE,), id="unbounded"),
    ],
)
def test_a_program_without_minimum_has_no_solution(limits, bounds):
    # x <= limits[0] and -x <= limits[1]
    matrix = np.array([[1.0], [-1.0]])
    assert minimised(np.array([1.0]), matrix, np.array(limits), np.array(bounds)) is None
