"""Searches for narrow ways, on problems that the quick searches do not solve."""

import itertools

import pytest

from bench.planted import planted
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options, Run
from pathgene.host.planners.grid.astar import QUICK_SEARCHES, AstarPlanner, searches
from pathgene.host.planners.grid.narrow import narrow_searches
from pathgene.host.replanning.planner import InFlightPlanner


ALL = Options(generations=400)


@pytest.mark.parametrize(
    ("family", "seed"),
    [
        ("maze", 0),  # More turns than 16 waypoints can make.
        ("pit", 0),  # Circuits at the start gain height.
        pytest.param("circles-1000", 9, marks=pytest.mark.ci),  # Moved waypoints, finer nodes.
    ],
)
def test_finds_planted_ways_that_the_quick_searches_miss(family, seed):
    evaluator = Evaluator(planted(family, seed).problem, threads=1)
    quick = searches(Run(evaluator, ALL), 16)
    assert all(fitness <= 1 for paths in quick for fitness, _ in paths)
    result = AstarPlanner().plan(evaluator, ALL)
    assert result.evaluation.feasible
    assert len(result.path) - 2 <= 64


def test_an_aircraft_does_not_wait_for_narrow_searches():
    plan = InFlightPlanner("astar").prepare(Evaluator(planted("maze", 0).problem, threads=1))
    assert not plan.evaluation.feasible
    assert plan.result.generations <= QUICK_SEARCHES


@pytest.mark.ci  # Searches in vain.
def test_keeps_the_maximum_of_waypoints():
    evaluator = Evaluator(planted("maze", 0).problem, threads=1)
    made = itertools.chain.from_iterable(
        itertools.islice(narrow_searches(Run(evaluator, ALL), 5), 2)
    )
    lengths = {len(path) - 2 for _, path in made}
    assert lengths
    assert max(lengths) <= 5
