"""Costs over land below sea level: altitudes are measured from the lowest ground."""

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.reference import evaluate
from pathgene.host.planners.base import Options
from pathgene.host.planners.registry import make
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


def land(lowest):
    """Return hills whose lowest ground is ``lowest``, and a problem over them."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[0:60, 0:80] / 10
    hills = 60 + 30 * np.sin(x + rng.uniform()) * np.cos(y) + 25 * np.sin(2 * y + 1)
    return hills - hills.min() + lowest


def problem(lowest, **options):
    heights = land(lowest)
    terrain = Terrain("made", heights, 40.0, 40.0)
    ends = ((200.0, 300.0, lowest + 200), (2900.0, 2000.0, lowest + 180))
    return Problem(terrain, *ends, **options)


def paths(made, count=20):
    rng = np.random.default_rng(3)
    lowest = made.terrain.lowest
    for _ in range(count):
        inner = rng.uniform((300, 300, lowest + 90), (2800, 2000, lowest + 260), (3, 3))
        yield np.vstack((made.start, inner, made.goal))


@pytest.mark.parametrize("lowest", [-423.0, -5.0])
def test_costs_are_those_of_the_same_land_at_the_sea(lowest):
    below, at_sea = problem(lowest), problem(0.0)
    assert (below.cost_base_m, at_sea.cost_base_m) == (lowest, 0.0)
    first, second = Evaluator(below, threads=1), Evaluator(at_sea, threads=1)
    for path in paths(at_sea):
        lowered = path + np.array((0.0, 0.0, lowest))
        found, expected = first.evaluate(lowered), second.evaluate(path)
        assert found.cost == pytest.approx(expected.cost, rel=1e-9)
        assert found.mean_altitude_m == pytest.approx(expected.mean_altitude_m + lowest, rel=1e-9)
        assert evaluate(below, lowered).cost == pytest.approx(found.cost, rel=1e-9)


@pytest.mark.parametrize("lowest", [0.0, 12.5, 300.0])
def test_ground_above_the_sea_has_no_base(lowest):
    made = problem(lowest)
    assert made.cost_base_m == 0.0
    (path,) = paths(made, 1)
    terms = Evaluator(made, threads=1).evaluate(path)
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    # The corners are cut by arcs, which lie between the altitudes of their ends.
    polyline = (steps * (path[1:, 2] + path[:-1, 2]) / 2).sum() / steps.sum()
    assert terms.mean_altitude_m == pytest.approx(polyline, rel=0.05)


def test_the_papers_have_no_base():
    assert problem(-5.0, as_paper=True).cost_base_m == 0.0


@pytest.mark.parametrize(("name", "generations"), [("astar", 40), ("ga-pc", 60), ("ga-chip", 2000)])
def test_planners_plan_below_the_sea(name, generations):
    """Plans over the same land are as good at -423 m as at sea level."""
    found = []
    for lowest in (-423.0, 0.0):
        evaluator = Evaluator(problem(lowest), threads=1)
        options = Options(seed=1, generations=generations)
        result = make(name).plan(evaluator, options)
        assert result.evaluation.feasible
        found.append(result.evaluation)
    assert found[0].fitness == pytest.approx(found[1].fitness, abs=0.02)
    assert found[0].mean_altitude_m < 0 < found[1].mean_altitude_m
