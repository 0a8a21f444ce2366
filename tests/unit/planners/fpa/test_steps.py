"""Random numbers compared with published vectors, and steps with NumPy and SciPy."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, stats

from pathgene.host.planners.fpa.steps import (
    Pollination,
    choose_step,
    epsilon_bound,
    global_step,
    levy_step,
    local_step,
    mantegna,
    move,
    philox,
    uniform,
    words,
)

from . import reference


# Known answers of the authors' implementation (Random123, philox4x32-10).
KNOWN = [
    ((0,) * 4, (0,) * 2, (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]


@pytest.mark.parametrize(("counter", "key", "answer"), KNOWN)
def test_known_answers(counter, key, answer):
    assert philox(*map(np.uint64, (*counter, *key))) == answer
    assert tuple(reference.philox(counter, key)) == answer


@given(st.integers(0, 2**64 - 1), st.integers(0, 2**40), st.integers(0, 2**31), st.integers(0, 999))
def test_draws_are_those_of_the_reference(seed, iteration, solution, number):
    drawn = words(np.uint64(seed), iteration, solution, number)
    assert list(drawn) == reference.draw(seed, iteration, solution, number)
    high, low, _, _ = drawn
    assert uniform(high, low) == reference.uniform(int(high), int(low))


def test_uniform_numbers_leave_out_both_ends():
    zero, top = np.uint64(0), np.uint64(0xFFFFFFFF)
    assert uniform(zero, zero) == 2.0**-53
    assert uniform(top, top) == 1 - 2.0**-53
    # The middle, where the sine of Box and Muller is 0, is left out as well.
    assert uniform(np.uint64(1 << 31), zero) == 0.5 + 2.0**-53


def test_numbers_are_uniform():
    seed = np.uint64(5)
    drawn = [
        words(seed, iteration, solution, 0) for iteration in range(50) for solution in range(100)
    ]
    numbers = [uniform(w[i], w[i + 1]) for w in drawn for i in (0, 2)]
    assert stats.kstest(numbers, "uniform").pvalue > 1e-3


SEED = np.uint64(11)
TABLE_3 = Pollination(SEED, 500, 0.5, 0.25, 0.02)


def levy_cdf(x):
    """Return P(u / |v|**(2/3) <= x) for normal u and v, by integration over v."""
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
    # The tail falls as the step to the power of -1.5, which gives long flights.
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


def test_a_probability_of_0_or_1_gives_one_kind():
    for switch, kind in ((0.0, False), (1.0, True)):
        p = TABLE_3._replace(switch=switch)
        assert all(choose_step(p, 3, solution, 9)[0] is kind for solution in range(50))


def test_candidates_match_numpy_and_stay_in_the_box():
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
