"""The genetic algorithm on the PC."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pathgene.host.errors import InputError
from pathgene.host.planners.allaire.ga_pc import (
    PcGeneticPlanner,
    _kept,
    crossover,
    smooth_turn,
)
from pathgene.host.planners.base import Options, Stop


def numbered(count, first):
    return np.arange(first, first + count)[:, None] * [1.0, 10.0, 100.0]


@given(st.integers(2, 20), st.integers(2, 20), st.integers(0, 99))
def test_crossover_exchanges_tails_past_the_middle(one, other, seed):
    a, b = numbered(one, 1), numbered(other, 101)
    first, second = crossover(a, b, 20, np.random.default_rng(seed))
    cut = int((first[:, 0] < 100).sum())
    other_cut = int((second[:, 0] > 100).sum())
    assert cut in ({one // 2} if one % 2 == 0 else {one // 2, one // 2 + 1})
    assert other_cut in ({other // 2} if other % 2 == 0 else {other // 2, other // 2 + 1})
    assert np.array_equal(first, np.concatenate((a[:cut], b[other_cut:])))
    assert np.array_equal(second, np.concatenate((b[:other_cut], a[cut:])))
    assert all(2 <= len(child) <= 20 for child in (first, second))


@given(st.integers(2, 5), st.integers(2, 5), st.integers(0, 99))
def test_crossover_keeps_an_odd_limit(one, other, seed):
    children = crossover(numbered(one, 1), numbered(other, 101), 5, np.random.default_rng(seed))
    assert all(2 <= len(child) <= 5 for child in children)
    assert sum(map(len, children)) == one + other


def test_cuts_odd_parents_on_both_sides_of_the_middle():
    rng = np.random.default_rng(0)
    cuts = [
        int((crossover(numbered(5, 1), numbered(4, 101), 20, rng)[0][:, 0] < 100).sum())
        for _ in range(400)
    ]
    assert set(cuts) == {2, 3}
    assert abs(cuts.count(2) - 200) < 60  # Six standard deviations.


def test_keeps_the_elite_and_others_without_repeats():
    fitness = np.linspace(0.1, 1.6, 32)
    rng = np.random.default_rng(2)
    counts = np.zeros(32)
    for _ in range(3000):
        kept = _kept(fitness, 10, rng)
        assert kept[:2].tolist() == [31, 30]
        assert len(set(kept.tolist())) == 10
        counts[kept] += 1
    # Fitter paths are more frequent among the randomly kept ones.
    assert counts[29] > 1.8 * counts[2] > 1.8 * counts[0]


def space(start, goal, free=True):
    return SimpleNamespace(
        start=start, goal=goal, is_free=lambda points: np.full(len(points), free)
    )


def turns(points):
    legs = np.diff(points[:, :2], axis=0)
    headings = np.arctan2(legs[:, 1], legs[:, 0])
    return np.abs((np.diff(headings) + math.pi) % (2 * math.pi) - math.pi)


@settings(max_examples=200)
@given(
    st.lists(
        st.tuples(st.integers(0, 9000), st.integers(0, 9000), st.integers(100, 900)),
        min_size=2,
        max_size=8,
    )
)
def test_smooth_turn_halves_the_sharpest_turn(inner):
    start, goal = (-500.0, -500.0, 100.0), (9500.0, 9500.0, 100.0)
    path = np.array(inner, dtype=float)
    points = np.array([start, *inner, goal])
    assume((np.hypot(*np.diff(points[:, :2], axis=0).T) > 1).all())
    before = turns(points)
    softened = smooth_turn(path, space(start, goal))
    sharpest = int(before.argmax())
    if before[sharpest] <= math.radians(45):
        assert softened is path
        return
    assert np.array_equal(np.delete(softened, sharpest + 1, axis=0), path)
    after = turns(np.array([start, *softened, goal]))
    assert after[sharpest] == pytest.approx(before[sharpest] / 2, abs=1e-6)
    assert after[sharpest + 1] < before[sharpest]


def test_smooth_turn_keeps_the_path_if_the_new_waypoint_is_blocked():
    path = np.array([[1000.0, 0, 100], [1000, 1000, 100]])
    ends = (0.0, 0.0, 100.0), (0.0, 1500.0, 100.0)
    assert len(smooth_turn(path, space(*ends))) == 3
    assert smooth_turn(path, space(*ends, free=False)) is path


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"max_waypoints": 2}, "The most waypoints of a path must be from 3 to 1000, not 2."),
        (
            {"max_waypoints": 10**9},
            "The most waypoints of a path must be from 3 to 1000, not 1000000000.",
        ),
        ({"mutation_rate": 1.5}, "The mutation rate must be from 0 to 1, not 1.5."),
    ],
)
def test_refuses_bad_parameters(options, sentence):
    with pytest.raises(InputError) as caught:
        PcGeneticPlanner(**options)
    assert str(caught.value) == sentence


def test_finds_a_way_and_repeats_it(evaluator):
    results = [
        PcGeneticPlanner().plan(evaluator, Options(generations=60, seed=seed)) for seed in (3, 3, 4)
    ]
    first, again, other = results
    assert first.evaluation.feasible
    assert np.array_equal(first.path, again.path)
    assert first.history == again.history
    assert not np.array_equal(first.path, other.path)
    best = [best for _, best, _ in first.history]
    assert best == sorted(best)
    assert (first.generations, first.stopped_by, first.hardware) == (60, "generations", None)
    assert first.evaluations == 32 + 60 * 22
    assert np.array_equal(first.path[[0, -1]], [evaluator.problem.start, evaluator.problem.goal])


def test_waypoints_stay_within_map_ground_and_limits(evaluator):
    result = PcGeneticPlanner(max_waypoints=5, mutation_rate=1.0).plan(
        evaluator, Options(generations=40)
    )
    assert result.archive
    for _, path in result.archive:
        assert 4 <= len(path) <= 7
        assert (path >= 0).all()
        assert (path <= (6000, 4000, 700)).all()


def test_population_and_stop_criteria(evaluator):
    stop = Stop()
    stop.request()
    result = PcGeneticPlanner().plan(evaluator, Options(population=40), stop=stop)
    assert (result.generations, result.evaluations, result.interrupted) == (0, 40, True)
    target = PcGeneticPlanner().plan(evaluator, Options(target_fitness=1.01))
    assert target.stopped_by == "target-fitness"
    assert target.history[-1][1] >= 1.01 > target.history[-2][1]
    for count in (7, 100_001):
        sentence = rf"^The population of ga-pc must be from 8 to 100000, not {count}\.$"
        with pytest.raises(InputError, match=sentence):
            PcGeneticPlanner().plan(evaluator, Options(population=count))
