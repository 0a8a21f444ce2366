"""Sentences that say why a path must not be flown."""

import numpy as np
import pytest

from pathgene.host.checking import check, evaluator_of
from pathgene.host.errors import InputError
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


START, GOAL = (500.0, 1500.0, 300.0), (2500.0, 1500.0, 300.0)
MIDDLE = (1500.0, 1500.0, 300.0)


def fault(*inner, **options):
    heights = np.full((31, 31), 100.0)
    problem = Problem(Terrain("flat", heights, 100.0, 100.0), START, GOAL, **options)
    return check(problem, [START, *inner, GOAL]).fault


def test_a_safe_path_has_no_fault():
    assert fault() is None
    assert fault(as_paper=True) is None


def test_the_broken_limit_is_named():
    assert "the limit clearance" in fault((1500.0, 1500.0, 120.0))
    assert "zone lake" in fault(zones=[Circle(1500, 1500, 100, name="lake")])
    assert "ceiling" in fault(rules=Rules(ceiling_m=250))


@pytest.mark.parametrize(
    ("inner", "words"),
    [
        ([(1500.0, 1500.0, 50.0)], "m under the terrain"),
        ([(1000.0, 1500.0, 900.0)], "m too steep"),
        ([MIDDLE, (1500.0, 1510.0, 300.0)], "turns tighter than the aircraft can fly"),
    ],
)
def test_as_paper_the_metres_are_named(inner, words):
    assert words in fault(*inner, as_paper=True)


def test_a_problem_is_a_problem():
    with pytest.raises(InputError, match="not of the type dict"):
        evaluator_of({})
