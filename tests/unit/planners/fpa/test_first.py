"""The first population of flower pollination."""

import numpy as np
import pytest

from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.fpa.first import first_population, with_more_waypoints


def test_draws_free_paths_with_the_given_ends(evaluator):
    space = Airspace(evaluator.problem)
    paths = first_population(space, np.random.default_rng(1), 40, 6)
    assert paths.shape == (40, 8, 3)
    assert (paths[:, 0] == evaluator.problem.start).all()
    assert (paths[:, -1] == evaluator.problem.goal).all()
    assert space.is_free(paths[:, 1:-1].reshape(-1, 3)).all()
    again = first_population(space, np.random.default_rng(1), 40, 6)
    assert np.array_equal(paths, again)


@pytest.mark.parametrize("waypoints", [2, 6])
def test_given_paths_come_first_with_the_same_course(evaluator, waypoints):
    problem = evaluator.problem
    straight = np.array([problem.start, problem.goal])
    bent = np.array(
        [problem.start, (1000, 3000, 300), (2000, 3500, 400), (4000, 3500, 400), problem.goal]
    )
    paths = first_population(
        Airspace(problem), np.random.default_rng(1), 3, waypoints, [straight, bent]
    )
    assert paths.shape == (3, max(waypoints, 3) + 2, 3)
    for path, given in zip(paths, (straight, bent), strict=False):
        # It has every given point in order, and all further points lie on its legs.
        where = [int(np.flatnonzero((path == point).all(axis=1))[0]) for point in given]
        assert where == sorted(where)
        length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        assert length == pytest.approx(np.linalg.norm(np.diff(given, axis=0), axis=1).sum())


def test_takes_the_best_of_too_many_given_paths(evaluator):
    straight = np.array([evaluator.problem.start, evaluator.problem.goal])
    paths = first_population(
        Airspace(evaluator.problem), np.random.default_rng(1), 2, 1, [straight] * 5
    )
    assert paths.shape == (2, 3, 3)
    assert np.array_equal(paths[0], paths[1])


def test_new_waypoints_halve_the_longest_leg():
    path = np.array([(0, 0, 0), (100, 0, 0), (400, 0, 30)], dtype=float)
    assert with_more_waypoints(path, 5).tolist() == [
        [0, 0, 0],
        [100, 0, 0],
        [175, 0, 7.5],
        [250, 0, 15],
        [400, 0, 30],
    ]
    assert with_more_waypoints(path, 3) is path
