"""Breeding: its limits, its operators, and the shares in which they are drawn."""

import collections
import itertools

import numpy as np
import pytest

from pathgene.sim.model.planner.definition.score import corner_of
from pathgene.sim.model.random_source import RandomSource
from tests.support.planner.cases import SMALL, USUAL, path, record
from tests.support.planner.plain import Waypoint, breed, cross, mutate


def population(config, rng):
    return [
        [Waypoint(*point, int(rng.integers(-99, 99))) for point in path(config, rng)[1:-1]]
        for _ in range(config.population)
    ]


@pytest.mark.parametrize("config", [SMALL, USUAL], ids=["small", "usual"])
def test_children_of_each_length_and_different_survivors(config):
    rng = np.random.default_rng(12)
    for seed in range(30):
        problem = record(config, rng)
        ends = corner_of(problem, "start"), corner_of(problem, "goal")
        children, survivors = breed(
            config, problem, ends, population(config, rng), RandomSource(seed)
        )
        assert len(set(survivors)) == config.survivors
        assert config.elites <= min(survivors) <= max(survivors) < config.population
        assert len(children) == config.children
        for child in children:
            assert config.MIN_WAYPOINTS <= len(child) <= config.max_waypoints


def test_compiled_breeding_is_the_interpreted_one():
    """The compiled source and the definition of the source give the same words."""
    rng = np.random.default_rng(12)
    for seed in range(30):
        problem = record(USUAL, rng)
        ends = corner_of(problem, "start"), corner_of(problem, "goal")
        parents = population(USUAL, rng)
        assert breed(USUAL, problem, ends, parents, RandomSource(seed)) == breed(
            USUAL, problem, ends, parents, seed
        )


def test_children_stay_within_the_limits():
    rng = np.random.default_rng(13)
    problem = record(SMALL, rng, x_limit=20, y_limit=11, altitude_limit=99)
    ends = corner_of(problem, "start"), corner_of(problem, "goal")
    inside = [[Waypoint(20, 11, 99), Waypoint(0, 0, 0)]] * SMALL.population
    random = RandomSource(3)
    for _ in range(50):
        for child in breed(SMALL, problem, ends, inside, random)[0]:
            for x, y, z, _ in child:
                assert 0 <= x <= 20
                assert 0 <= y <= 11
                assert 0 <= z <= 99


@pytest.mark.parametrize(
    ("cut", "head", "tail", "child"),
    [
        (0, "abcdefgh", "stuvwxyz", "atuvwxyz"),
        (1, "abcdefgh", "stuvwxyz", "abcvwxyz"),
        (2, "abcdefgh", "stuvwxyz", "abcdexyz"),
        (3, "abcdefgh", "stuvwxyz", "abcdefgz"),
        (0, "ab", "yz", "yz"),
        (3, "ab", "vwxyz", "az"),
        (2, "abcde", "yz", "abcz"),
    ],
)
def test_crossover_takes_head_and_tail(cut, head, tail, child):
    assert cross(head, tail, cut << 62 | (1 << 62) - 1) == list(child)


@pytest.mark.parametrize("most", [3, 18, 64])
def test_crossover_keeps_the_limits_of_the_length(most):
    for head, tail, cut in itertools.product(range(2, most + 1), range(2, most + 1), range(4)):
        assert 2 <= len(cross("h" * head, "t" * tail, cut << 62)) <= most


def test_shares_of_the_operators():
    """8 of 18 perturb, 3 insert, 3 delete, 4 settle; the draw of 8 bits is accurate to 1/256."""
    rng = np.random.default_rng(14)
    problem = record(USUAL, rng)
    ends = corner_of(problem, "start"), corner_of(problem, "goal")
    before = [Waypoint(100 + i, 100, 2000, 64) for i in range(6)]
    kinds = collections.Counter()
    for operator in range(256):
        # The maximum offset, at full size: every operator changes the path.
        word = operator | (1 << 62) - (1 << 20)
        after = mutate(USUAL, problem, ends, before, word)
        if len(after) != len(before):
            kinds["insert" if len(after) > len(before) else "delete"] += 1
        else:
            moved = [b for a, b in zip(before, after, strict=True) if a != b]
            kinds["settle" if moved[0].x == 100 else "perturb"] += 1
    for kind, share in {"perturb": 8, "insert": 3, "delete": 3, "settle": 4}.items():
        assert abs(kinds[kind] / 256 - share / 18) < 1 / 256, kind


@pytest.mark.parametrize(
    ("margin", "size", "fall"),
    [(10, 0, 5), (10, 6, 10), (10, 11, 20), (-10, 0, -10), (-10, 15, -10), (0, 15, 0)],
)
def test_settle_lowers_by_the_margin_or_raises_out_of_the_ground(margin, size, fall):
    rng = np.random.default_rng(15)
    problem = record(USUAL, rng)
    ends = corner_of(problem, "start"), corner_of(problem, "goal")
    before = [Waypoint(5, 5, 1000, margin), Waypoint(9, 9, 1000, margin)]
    after = mutate(USUAL, problem, ends, before, 255 | size << 16)
    assert after == [Waypoint(5, 5, 1000 - fall, 0), before[1]]
