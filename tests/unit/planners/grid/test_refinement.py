"""Trials of the refinement, and the further routes of a path that a planner has found."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.planners.base import Options, Run, Stop
from pathgene.host.planners.grid import further, refinement
from pathgene.host.planners.grid.astar import AstarPlanner
from pathgene.host.planners.grid.fine_grid import covered_cells
from pathgene.host.planners.grid.further import improved
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Polygon


@pytest.fixture
def found(evaluator):
    """The result of one search by ``astar``."""
    return AstarPlanner().plan(evaluator, Options(generations=1))


def crossings(evaluator, found, monkeypatch):
    """Return for each trial how many more cells of zones it crosses than the path."""
    problem, more, real = evaluator.problem, [], refinement.lowest_altitudes
    zones = problem.terrain, covered_cells(problem)
    before = refinement._crossed(*zones, found.path[:, :2])

    def lowest(problem, prices, places):
        more.append(refinement._crossed(*zones, places) - before)
        return real(problem, prices, places)

    with monkeypatch.context() as patch:
        patch.setattr(refinement, "lowest_altitudes", lowest)
        run = Run(evaluator, Options(seed=1))
        refinement.refined(run, found.path, found.evaluation.fitness)
    return np.array(more)


def test_trials_avoid_zones(evaluator, found, monkeypatch):
    avoided = crossings(evaluator, found, monkeypatch)
    monkeypatch.setattr(refinement, "_DRAWS", 1)
    drawn = crossings(evaluator, found, monkeypatch)
    assert len(avoided) == len(drawn) == refinement.TRIALS
    assert (drawn > 0).sum() > 3
    assert not (avoided > 0).any()


def test_a_line_off_the_map_counts_as_one_in_a_zone(make_evaluator):
    problem = make_evaluator(zones=()).problem
    zones = problem.terrain, covered_cells(problem)
    inside = np.array([(500.0, 500.0), (3000.0, 500.0)])
    assert refinement._crossed(*zones, inside) == 0
    assert refinement._crossed(*zones, inside - (0.0, 600.0)) == 25


def test_a_found_path_is_improved(evaluator, found):
    result, again, other = (improved(evaluator, found, seed) for seed in (1, 1, 2))
    assert result.evaluation.fitness > found.evaluation.fitness
    assert evaluator.evaluate(result.path) == result.evaluation
    assert result.evaluation.feasible
    assert np.array_equal(result.path, again.path)
    assert not np.array_equal(result.path, other.path)
    assert result.evaluations > found.evaluations + refinement.TRIALS / 2
    assert result.seconds["total"] > found.seconds["total"]
    assert (result.history, result.generations) == (found.history, found.generations)


def test_an_interrupt_keeps_the_found_path(evaluator, found):
    stop = Stop()
    stop.request()
    result = improved(evaluator, found, 1, stop)
    assert result.evaluation.fitness >= found.evaluation.fitness

    stop, seen = Stop(), []

    def interrupted(*_):
        seen.append(True)
        stop.request()
        raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(further, "fine_searches", interrupted)
        result = improved(evaluator, found, 1, stop)
    assert seen == [True]
    assert np.array_equal(result.path, found.path)
    assert result.evaluation == found.evaluation


def test_a_worse_path_does_not_replace_the_found_one(evaluator, found, monkeypatch):
    monkeypatch.setattr(refinement, "TRIALS", 0)
    best = improved(evaluator, found, 1)
    same = improved(evaluator, replace(best, archive=found.archive), 1)
    assert np.array_equal(same.path, best.path)
    assert same.archive is found.archive


def test_cells_at_the_border_of_a_zone_are_not_covered(make_evaluator):
    """The search avoids all cells that a zone touches, and the strict rule does not."""
    ring = ((1930, 1930), (2270, 1930), (2270, 2270), (1930, 2270))
    above = Polygon(ring, lower_m=2_000.0)
    problem = make_evaluator(zones=(Polygon(ring), above), rules=Rules()).problem
    covered = covered_cells(problem)
    assert set(zip(*np.nonzero(covered), strict=True)) == set(
        itertools.product((20, 21, 22), repeat=2)
    )
    assert problem.nofly_raster.sum() > covered.sum()
    assert not covered_cells(make_evaluator(zones=(above,), rules=Rules()).problem).any()
