"""2-opt and early rejection compared with brute force."""

import math

import numpy as np
import pytest

from pathgene.host.evaluation.kernels import fitness_above, scratch
from pathgene.host.planners.fpa.steps import Pollination
from pathgene.host.planners.fpa.two_opt import CUT_SHORT, EVALUATED, reversed_row, untangle

from . import reference


SEED = np.uint64(11)
TABLE_3 = Pollination(SEED, 500, 0.5, 0.25, 0.02)


def test_reversals():
    for first in range(1, 7):
        for last in range(first + 1, 8):
            rows = list(range(9))
            rows[first : last + 1] = rows[first : last + 1][::-1]
            assert [reversed_row(row, first, last) for row in range(9)] == rows


@pytest.fixture
def worth(evaluator):
    """Function that returns the full fitness of a path."""
    return lambda path: evaluator.fitness(path[None], np.array([len(path)]))[0]


def random_paths(evaluator, rng, count, points=8):
    """Return feasible, tangled and colliding paths over the ridge."""
    problem = evaluator.problem
    along = np.linspace(0, 1, points)
    via = np.array(
        [[500, 500, 200], [2700, 3500, 420], [3700, 3600, 460], [5000, 3300, 380], [5500, 700, 220]]
    )
    smooth = np.stack(
        [np.interp(along, np.linspace(0, 1, 5), via[:, axis]) for axis in range(3)], axis=1
    )
    paths = smooth + rng.normal(0, 1, (count, points, 3)) * rng.choice([10, 40, 200], (count, 1, 1))
    wild = rng.random(count) < 0.2
    paths[wild] = rng.uniform((0, 0, 50), (6000, 4000, 700), (int(wild.sum()), points, 3))
    for i in np.flatnonzero(rng.random(count) < 0.15):
        paths[i, 3] = paths[i, 2]  # Repeated.
    for i in np.flatnonzero(rng.random(count) < 0.15):
        paths[i, 1:-1] = rng.permutation(paths[i, 1:-1])  # Tangled.
    paths[:, 0], paths[:, -1] = problem.start, problem.goal
    return paths


@pytest.mark.parametrize(
    "options", [{}, {"zones": ()}, {"wind": (9.0, -7.0)}, {"ds_m": 10.0}], ids=str
)
def test_early_rejection_changes_no_result(make_evaluator, options):
    evaluator = make_evaluator(**options)
    rng = np.random.default_rng(8)
    paths = random_paths(evaluator, rng, 300)
    full = evaluator.fitness(paths, np.full(len(paths), paths.shape[1]))
    assert 30 < (full > 1).sum() < 270
    space = scratch(paths.shape[1])
    seen = set()
    for path, fitness in zip(paths, full.tolist(), strict=True):
        others = rng.choice(full, 6).tolist()
        for incumbent in (
            0.0,
            1.0,
            fitness,
            math.nextafter(fitness, 0),
            math.nextafter(fitness, 2),
            *others,
        ):
            value, exact = fitness_above(path, len(path), evaluator.course, space, incumbent)
            assert (value > incumbent) == (fitness > incumbent)
            if exact:
                assert value == fitness
            else:
                assert fitness <= value <= incumbent
            seen.add((exact, value > incumbent, incumbent > 1))
    # Rejected early, or evaluated in full with and without success; both kinds of incumbents.
    assert seen >= {
        (False, False, False),
        (False, False, True),
        (True, False, False),
        (True, True, False),
        (True, True, True),
    }


def test_early_rejection_of_invalid_paths(evaluator):
    space = scratch(4)
    path = np.array(
        [evaluator.problem.start, (math.nan, 1, 2), (900, 900, 300), evaluator.problem.goal]
    )
    worst = evaluator.fitness(path[None], np.array([4]))[0]
    value, exact = fitness_above(path, 4, evaluator.course, space, 0.0)
    assert (value, exact) == (worst, True)


def test_2_opt_matches_brute_force(evaluator, worth):
    rng = np.random.default_rng(4)
    changed = 0
    for path in random_paths(evaluator, rng, 25, points=7):
        fitness = worth(path)
        expected, best = reference.untangled(path, fitness, worth)
        counts = np.zeros(2, dtype=np.int64)
        found = path.copy()
        value = untangle(
            TABLE_3,
            found,
            fitness,
            np.empty_like(path),
            evaluator.course,
            scratch(7),
            counts,
        )
        assert np.array_equal(found, expected)
        assert value == best
        assert counts.sum() >= 10  # In the end all pairs of five waypoints have been tried.
        assert counts[CUT_SHORT] > 0
        changed += not np.array_equal(found, path)
        assert counts[EVALUATED] >= (value > fitness)
    assert changed > 5


def test_2_opt_of_too_few_waypoints_does_nothing(evaluator, worth):
    path = np.array([evaluator.problem.start, (900, 900, 300), evaluator.problem.goal])
    counts = np.zeros(2, dtype=np.int64)
    fitness = worth(path)
    assert (
        untangle(
            TABLE_3,
            path,
            fitness,
            np.empty_like(path),
            evaluator.course,
            scratch(3),
            counts,
        )
        == fitness
    )
    assert counts.sum() == 0
