"""Steps and 2-opt, one by one, against NumPy, SciPy and brute force."""

import math

import numpy as np
import pytest
from scipy import integrate, stats

from host.evaluation.kernels import fitness_above, scratch
from host.planners.fpa.kernels import (
    CUT_SHORT,
    EVALUATED,
    Pollination,
    choose_step,
    epsilon_bound,
    global_step,
    levy_step,
    local_step,
    mantegna,
    move,
    reversed_row,
    untangle,
)

from . import reference


SEED = np.uint64(11)
TABLE_3 = Pollination(SEED, 500, 0.5, 0.25, 0.02)


def levy_cdf(x):
    """P(u / |v|**(2/3) <= x) for normal u and v, by integration over v."""
    sigma = 0.696574502557  # Mantegna's deviation for the exponent 1.5.
    value, _ = integrate.quad(
        lambda v: 2 * stats.norm.pdf(v) * stats.norm.cdf(x * v ** (2 / 3) / sigma), 0, 12
    )
    return value


def test_levy_steps_have_mantegna_s_distribution():
    steps = np.array(
        [
            levy_step(SEED, iteration, solution, coordinate)
            for iteration in range(8)
            for solution in range(50)
            for coordinate in range(18)
        ]
    )
    grid = np.concatenate((-np.geomspace(0.01, 50, 25)[::-1], np.geomspace(0.01, 50, 25)))
    found = np.searchsorted(np.sort(steps), grid) / len(steps)
    expected = [levy_cdf(x) for x in grid]
    # Kolmogorov's bound at 0.1 %.
    assert np.abs(found - expected).max() < 1.95 / math.sqrt(len(steps))
    # The tail falls as the step to the power of -1.5: what makes the flights long.
    tail = [np.mean(np.abs(steps) > x) for x in (3, 12)]
    assert tail[0] / tail[1] == pytest.approx(8, rel=0.25)


def test_mantegna_is_finite_for_all_uniform_numbers():
    ends = [2.0**-53, 0.25, 0.5 - 2.0**-53, 0.5 + 2.0**-53, 1 - 2.0**-53]
    for a in ends:
        for b in ends:
            assert mantegna(a, b) == pytest.approx(reference.levy(a, b), rel=1e-9)
            assert math.isfinite(mantegna(a, b))


def test_epsilon_falls_from_first_to_last():
    bounds = [epsilon_bound(TABLE_3, iteration) for iteration in range(1, 501)]
    assert bounds == pytest.approx(np.linspace(0.25, 0.02, 500), rel=1e-14)
    assert epsilon_bound(TABLE_3._replace(iterations=1), 1) == 0.25


def test_steps_follow_the_equations():
    assert global_step(500.0, 300.0, -1.5) == 500.0 + 0.1 * -1.5 * 200.0
    assert local_step(500.0, 300.0, 700.0, 0.25) == 400.0


def test_kinds_of_step_and_partners():
    count = 5
    steps = [
        choose_step(TABLE_3, iteration, solution, count)
        for iteration in range(1, 101)
        for solution in range(50)
    ]
    kinds, ones, others, epsilons = map(np.array, zip(*steps, strict=True))
    assert abs(kinds.mean() - 0.5) < 0.03
    assert (ones != others).all()
    pairs = np.bincount(ones * count + others, minlength=count**2).reshape(count, count)
    off_diagonal = pairs[~np.eye(count, dtype=bool)]
    assert stats.chisquare(off_diagonal).pvalue > 1e-3
    bounds = np.repeat([epsilon_bound(TABLE_3, iteration) for iteration in range(1, 101)], 50)
    assert stats.kstest(epsilons / bounds, "uniform").pvalue > 1e-3


def test_a_probability_of_0_or_1_leaves_one_kind():
    for switch, kind in ((0.0, False), (1.0, True)):
        p = TABLE_3._replace(switch=switch)
        assert all(choose_step(p, 3, solution, 9)[0] is kind for solution in range(50))


def test_candidates_are_those_of_numpy_and_stay_in_the_box():
    rng = np.random.default_rng(3)
    low, high = np.array([0.0, 0.0, 100.0]), np.array([6000.0, 4000.0, 700.0])
    paths = rng.uniform(low, high, (7, 6, 3))
    box = np.stack((low, high))
    clipped = 0
    for iteration in (1, 250, 500):
        for solution in range(7):
            step = choose_step(TABLE_3, iteration, solution, 7)
            moved = np.array(
                [move(TABLE_3, iteration, solution, d, step, paths, 4, box) for d in range(12)]
            ).reshape(4, 3)
            expected = reference.candidate(int(SEED), iteration, 500, solution, paths, 4, low, high)
            assert moved == pytest.approx(expected[1:-1], rel=1e-12)
            clipped += int(((moved == low) | (moved == high)).sum())
    assert clipped > 0


def test_reversals():
    for first in range(1, 7):
        for last in range(first + 1, 8):
            rows = list(range(9))
            rows[first : last + 1] = rows[first : last + 1][::-1]
            assert [reversed_row(row, first, last) for row in range(9)] == rows


@pytest.fixture
def worth(evaluator):
    """Full fitness of one path."""
    return lambda path: evaluator.fitness(path[None], np.array([len(path)]))[0]


def random_paths(evaluator, rng, count, points=8):
    """Paths of all kinds over the ridge: feasible ones, tangled ones, through the ground."""
    problem = evaluator.problem
    along = np.linspace(0, 1, points)
    over = np.array(
        [[500, 500, 200], [2700, 3500, 420], [3700, 3600, 460], [5000, 3300, 380], [5500, 700, 220]]
    )
    smooth = np.stack(
        [np.interp(along, np.linspace(0, 1, 5), over[:, axis]) for axis in range(3)], axis=1
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
def test_early_rejection_changes_nothing(make_evaluator, options):
    evaluator = make_evaluator(**options)
    rng = np.random.default_rng(8)
    paths = random_paths(evaluator, rng, 300)
    full = evaluator.fitness(paths, np.full(len(paths), paths.shape[1]))
    assert 30 < (full > 1).sum() < 270
    turns, pieces = scratch(paths.shape[1])
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
            value, exact = fitness_above(
                path, len(path), *evaluator.kernel_arguments, incumbent, turns, pieces
            )
            assert (value > incumbent) == (fitness > incumbent)
            if exact:
                assert value == fitness
            else:
                assert fitness <= value <= incumbent
            seen.add((exact, value > incumbent, incumbent > 1))
    # Given up, or evaluated in full with and without success; incumbents of both kinds.
    assert seen >= {
        (False, False, False),
        (False, False, True),
        (True, False, False),
        (True, True, False),
        (True, True, True),
    }


def test_early_rejection_of_what_is_no_path(evaluator):
    turns, pieces = scratch(4)
    path = np.array(
        [evaluator.problem.start, (math.nan, 1, 2), (900, 900, 300), evaluator.problem.goal]
    )
    worst = evaluator.fitness(path[None], np.array([4]))[0]
    value, exact = fitness_above(path, 4, *evaluator.kernel_arguments, 0.0, turns, pieces)
    assert (value, exact) == (worst, True)


def test_2_opt_is_that_of_brute_force(evaluator, worth):
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
            *evaluator.kernel_arguments,
            *scratch(7),
            counts,
        )
        assert np.array_equal(found, expected)
        assert value == best
        assert counts.sum() >= 10  # All pairs of five waypoints at the end.
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
            *evaluator.kernel_arguments,
            *scratch(3),
            counts,
        )
        == fitness
    )
    assert counts.sum() == 0
