"""Trials of the refinement, and the further routes of a path that a planner has found."""

from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.planners.base import Options, Run, Stop
from pathgene.host.planners.grid import further, refinement
from pathgene.host.planners.grid.astar import AstarPlanner
from pathgene.host.planners.grid.further import improved


@pytest.fixture
def found(evaluator):
    """The result of one search by ``astar``."""
    return AstarPlanner().plan(evaluator, Options(generations=1))


def crossings(evaluator, found, monkeypatch):
    """Return for each trial how many more blocked cells it crosses than the path."""
    problem, more, real = evaluator.problem, [], refinement.lowest_altitudes
    before = refinement._blocked(problem, found.path[:, :2])

    def lowest(problem, prices, places):
        more.append(refinement._blocked(problem, places) - before)
        return real(problem, prices, places)

    with monkeypatch.context() as patch:
        patch.setattr(refinement, "lowest_altitudes", lowest)
        run = Run(evaluator, Options(seed=1))
        refinement.refined(run, found.path, found.evaluation.fitness)
    return np.array(more)


def test_trials_avoid_blocked_cells(evaluator, found, monkeypatch):
    avoided = crossings(evaluator, found, monkeypatch)
    monkeypatch.setattr(refinement, "_DRAWS", 1)
    drawn = crossings(evaluator, found, monkeypatch)
    assert len(avoided) == len(drawn) == refinement.TRIALS
    assert (drawn > 0).sum() > 3
    assert not (avoided > 0).any()


def test_cells_off_the_map_are_blocked(make_evaluator):
    problem = make_evaluator(zones=()).problem
    inside = np.array([(500.0, 500.0), (3000.0, 500.0)])
    assert refinement._blocked(problem, inside) == 0
    assert refinement._blocked(problem, inside - (0.0, 600.0)) == 25


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
