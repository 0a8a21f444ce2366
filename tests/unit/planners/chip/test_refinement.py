"""Trials of the refinement."""

import numpy as np
import pytest

from pathgene.host.planners.base import Options, Run
from pathgene.host.planners.chip import refinement
from pathgene.host.planners.grid.astar import AstarPlanner


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
