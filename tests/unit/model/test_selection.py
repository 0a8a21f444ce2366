"""The model of the selection unit: exact probabilities, then samples of the real source."""

import copy
import itertools
import math
import random
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from scipy import stats

from pathgene.hdl.config import CheckerBuild, Config, SurvivorSelection
from pathgene.hdl.protocol.random_words import RandomWordLayout
from pathgene.sim.model.random_source import RandomSource
from pathgene.sim.model.random_stream import RandomStream
from pathgene.sim.model.selection import DistinctDraw, Selection
from tests.support.gateware.chips import TINY


DEFAULT = Config(checker=CheckerBuild.NONE)
BY_RANK = Config(survivor_selection=SurvivorSelection.RANK)
LARGE = Config(population=256, children=240, elites=8)
WITH_MAP = Config()

#: A sample with a smaller p contradicts its distribution. Seeds are fixed, so no test is flaky.
P_VALUE = 1e-4


class Script:
    """Source of given words, followed by zeros, that counts its steps."""

    def __init__(self, words=()):
        self._words = iter(words)
        self.steps = 0

    def step(self):
        self.steps += 1
        return next(self._words, (0, 0))


class Stream:
    """The real source, in its compiled form."""

    def __init__(self, seed, steps):
        self._words = map(tuple, RandomStream(seed).words(steps).tolist())

    def step(self):
        return next(self._words)


def sample(config, seed, generations):
    """Return parents, survivors, children, waypoints and offsets, one row per generation."""
    unit, source = Selection(config), Stream(seed, generations * config.draw_steps)
    draws = [unit.draw(source) for _ in range(generations)]
    names = ("parents", "survivors", "children", "waypoints", "offsets")
    return {name: np.array([getattr(draw, name) for draw in draws]) for name in names}


@pytest.fixture(scope="module")
def default_sample():
    return sample(DEFAULT, seed=2008, generations=10_000)


def frequencies(total, bits):
    """Return the number of raw draws that give each ``raw * total >> bits``."""
    borders = [-(-(result << bits) // total) for result in range(total + 1)]
    return np.diff(borders)


def linear_ranking(total):
    """Return P(r) = (2 (N - r) - 1) / N**2, times N**2."""
    return np.array([2 * (total - rank) - 1 for rank in range(total)])


def assert_follows(counts, weights):
    """Assert by a chi-square test that counts follow ``weights``."""
    counts, weights = np.ravel(counts), np.ravel(np.asarray(weights, dtype=float))
    expected = weights / weights.sum() * counts.sum()
    # Cells too rare for the test are merged.
    rare = expected < 5
    if rare.any():
        counts = np.append(counts[~rare], counts[rare].sum())
        expected = np.append(expected[~rare], expected[rare].sum())
    assert stats.chisquare(counts, expected).pvalue > P_VALUE


def pairs(first, second, total):
    return np.bincount(np.ravel(first) * total + np.ravel(second), minlength=total * total)


# --- Exact ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("config", [TINY, DEFAULT, LARGE], ids=["8", "32", "256"])
def test_parents_have_the_published_distribution(config):
    """Exactly 2 (N - r) - 1 of all pairs of uniform draws give rank r."""
    layout, total = RandomWordLayout(config), config.population
    unit = Selection(config)
    words = [
        (first << layout.rank_first[0] | second << layout.rank_second[0], 0)
        for first, second in itertools.product(range(total), repeat=2)
    ]
    ranks = []
    for start in range(0, len(words), config.crossovers):
        batch = words[start : start + config.crossovers]
        ranks += unit.draw(Script(batch)).parents[: len(batch)]
    assert np.bincount(ranks, minlength=total).tolist() == linear_ranking(total).tolist()


def test_distinct_draw_gives_every_remaining_number_once():
    """The claim holds after any draws of up to four of 22 numbers."""
    _visit(DistinctDraw(22), list(range(22)), depth=4, latest=-1)


def _visit(pool, left, depth, latest):
    pools = [copy.copy(pool) for _ in left]
    assert [following.take(draw) for draw, following in enumerate(pools)] == left
    for draw, (number, following) in enumerate(zip(left, pools, strict=True)):
        if depth and number > latest:
            _visit(following, left[:draw] + left[draw + 1 :], depth - 1, number)


def test_distinct_draw_can_exhaust_the_numbers():
    rng = random.Random(3)
    for _ in range(200):
        order, left = rng.sample(range(30), 30), list(range(30))
        pool = DistinctDraw(30)
        for number in order:
            assert pool.left == len(left)
            assert pool.take(left.index(number)) == number
            left.remove(number)
        assert pool.left == 0


@pytest.mark.parametrize("unit", ["children", "survivors"])
def test_scales_raw_draws_to_the_remaining_numbers(unit):
    """The first and the last raw draw of each number yield it, so all draws in between do, too."""
    layout = RandomWordLayout(DEFAULT)
    lane, (low, high), lowest, total, count = {
        "children": (1, layout.child, 0, 22, 5),
        "survivors": (0, layout.survivor_first, 2, 30, 8),
    }[unit]
    assert high - low == 24
    for k in range(count):
        ends = np.cumsum([0, *frequencies(total - k, 24)]).tolist()
        for draw, (first, stop) in enumerate(itertools.pairwise(ends)):
            for raw in (first, stop - 1):
                # Earlier draws of 0 have removed the k lowest numbers.
                words = [(0, 0)] * k
                words.append((raw << low, 0) if lane == 0 else (0, raw << low))
                drawn = getattr(Selection(DEFAULT).draw(Script(words)), unit)
                assert drawn[k] == lowest + k + draw


@pytest.mark.parametrize(("total", "count"), [(22, 5), (30, 8)], ids=["children", "survivors"])
def test_ordered_choices_are_equally_likely(total, count):
    """The most and the least likely choice are within 1e-4 of the mean.

    A choice is a sequence of draws, tested above, whose probabilities multiply.
    """
    likeliest = least = Fraction(1)
    for left in range(total, total - count, -1):
        times = frequencies(left, 24)
        assert times.sum() == 1 << 24
        likeliest *= Fraction(int(times.max()), 1 << 24)
        least *= Fraction(int(times.min()), 1 << 24)
    choices = math.perm(total, count)
    assert 1 - Fraction(1, 10_000) < least * choices < 1 < likeliest * choices
    assert likeliest * choices < 1 + Fraction(1, 10_000)


@pytest.mark.parametrize("config", [TINY, DEFAULT, BY_RANK, LARGE, WITH_MAP])
def test_steps_do_not_depend_on_draws(config):
    """The state at the start of a generation therefore depends only on the seed and its number."""
    unit = Selection(config)
    ones = (1 << 64) - 1
    for words in ([], [(ones, ones)] * config.draw_steps, [(ones, 0), (0, ones)]):
        source = Script(words)
        unit.draw(source)
        assert source.steps == config.draw_steps
    source, skipped = RandomSource(5), RandomSource(5)
    unit.draw(source)
    for _ in range(config.draw_steps):
        skipped.step()
    assert unit.draw(source) == Selection(config).draw(skipped)


def test_extreme_words_stay_in_range():
    ones = (1 << 64) - 1
    lowest, highest = (
        Selection(DEFAULT).draw(Script([words] * DEFAULT.draw_steps))
        for words in ((0, 0), (ones, ones))
    )
    assert lowest.parents == (0,) * 11
    assert highest.parents == (31,) * 11
    assert lowest.survivors == tuple(range(2, 10))
    assert highest.survivors == tuple(range(31, 23, -1))
    assert lowest.children == tuple(range(5))
    assert highest.children == tuple(range(21, 16, -1))
    assert lowest.waypoints == (0,) * 5
    assert highest.waypoints == (65535,) * 5
    assert lowest.offsets == ((-38, -38, -307),) * 3
    assert highest.offsets == ((38, 38, 307),) * 3


def test_candidates_come_in_rounds_after_all_other_draws():
    """A round takes a step; the draws before equal the draws of a chip without a map."""
    assert (DEFAULT.candidates, DEFAULT.draw_steps) == (1, 11)
    for redraws, steps in ((0, 11), (1, 11), (2, 14), (7, 29)):
        config = WITH_MAP.replace(redraws=redraws)
        assert (config.candidates, config.draw_steps) == (1 + redraws, steps)
        # Offsets in x at step i of the highest words: i cells from the lowest.
        scale = (1 << 16) // 77 + 1
        words = [(i, (i * scale) << RandomWordLayout(config).offsets[0][0]) for i in range(steps)]
        drawn = Selection(config).draw(Script(words))
        expected = [step - 38 for step in range(5, 5 + 3 * (1 + redraws))]
        assert [x for x, _, _ in drawn.offsets] == expected
        without = Selection(DEFAULT).draw(Script(words))
        assert drawn.offsets[:3] == without.offsets
        for name in ("parents", "survivors", "children", "waypoints"):
            assert getattr(drawn, name) == getattr(without, name)


# --- Sampled -------------------------------------------------------------------------------------


def test_parents(default_sample):
    weights = linear_ranking(32)
    for ranks in default_sample["parents"].T:
        assert_follows(np.bincount(ranks, minlength=32), weights)


def test_parents_are_independent(default_sample):
    """Pairs within a generation, and in successive generations, follow the product."""
    ranks = default_sample["parents"]
    weights = np.outer(linear_ranking(32), linear_ranking(32))
    assert_follows(pairs(ranks[:, 0:10:2], ranks[:, 1:11:2], 32), weights)
    assert_follows(pairs(ranks[0::2, :], ranks[1::2, :], 32), weights)


def test_children(default_sample):
    children = default_sample["children"]
    assert all(len(set(row)) == 5 for row in children.tolist())
    assert children.min() == 0
    assert children.max() == 21
    for column in children.T:
        assert_follows(np.bincount(column, minlength=22), np.ones(22))
    different = ~np.eye(22, dtype=bool).ravel()
    for i, j in itertools.combinations(range(5), 2):
        counts = pairs(children[:, i], children[:, j], 22)
        assert_follows(counts[different], np.ones(22 * 21))


def test_survivors(default_sample):
    survivors = default_sample["survivors"]
    assert all(len(set(row)) == 8 for row in survivors.tolist())
    assert survivors.min() == 2
    assert survivors.max() == 31
    for column in survivors.T:
        assert_follows(np.bincount(column, minlength=32)[2:], np.ones(30))
    different = ~np.eye(30, dtype=bool).ravel()
    for i, j in itertools.pairwise(range(8)):
        counts = pairs(survivors[:, i] - 2, survivors[:, j] - 2, 30)
        assert_follows(counts[different], np.ones(30 * 29))


def test_waypoints(default_sample):
    waypoints = default_sample["waypoints"]
    for length in (2, 3, 11, 16):
        for column in waypoints.T:
            counts = np.bincount(column * length >> 16, minlength=length)
            assert_follows(counts, frequencies(length, 16))


def test_offsets(default_sample):
    x, y, altitude = np.moveaxis(default_sample["offsets"], 2, 0)
    for steps, box in ((x, 38), (y, 38), (altitude, 307)):
        for column in (*steps.T, steps.ravel()):
            counts = np.bincount(column + box, minlength=2 * box + 1)
            assert_follows(counts, frequencies(2 * box + 1, 16))


def test_candidates_are_independent():
    """Every candidate has the distribution of the first, given the previous round."""
    x = sample(WITH_MAP, seed=2024, generations=4_000)["offsets"][:, :, 0]
    assert x.shape == (4_000, 9)
    for column in x.T:
        assert_follows(np.bincount(column + 38, minlength=77), frequencies(77, 16))
    coarse = (x + 38) // 11
    shares = np.add.reduceat(frequencies(77, 16), range(0, 77, 11)) / (1 << 16)
    assert_follows(pairs(coarse[:, :6], coarse[:, 3:], 7), np.outer(shares, shares))


def test_units_are_independent(default_sample):
    """Draws that share a word or a step are independent."""
    first = {name: values[:, 0] for name, values in default_sample.items() if name != "offsets"}
    coarse = {
        "parents": (first["parents"] // 4, linear_ranking(32).reshape(8, 4).sum(axis=1)),
        "survivors": ((first["survivors"] - 2) // 6, np.ones(5)),
        "children": (first["children"] // 2, np.ones(11)),
        "waypoints": (first["waypoints"] >> 13, np.ones(8)),
    }
    for (one, one_weights), (other, other_weights) in itertools.combinations(coarse.values(), 2):
        counts = np.bincount(one * len(other_weights) + other)
        assert_follows(counts, np.outer(one_weights, other_weights))


def test_every_ordered_choice_of_a_small_size():
    """These are all 24 orders of three of four children, and all 30 of two of six survivors."""
    drawn = sample(TINY, seed=77, generations=10_000)
    for name, lowest, total in (("children", 0, 4), ("survivors", 2, 6)):
        times = Counter(map(tuple, (drawn[name] - lowest).tolist()))
        orders = list(itertools.permutations(range(total), drawn[name].shape[1]))
        assert_follows([times[order] for order in orders], np.ones(len(orders)))


def test_survivors_by_rank_of_a_small_size():
    """Ordered choices of two of six follow linear ranking of six, then of the remaining five."""
    config = TINY.replace(survivor_selection=SurvivorSelection.RANK)
    drawn = sample(config, seed=78, generations=10_000)
    times = Counter(map(tuple, (drawn["survivors"] - 2).tolist()))
    orders = list(itertools.permutations(range(6), 2))
    weights = [
        linear_ranking(6)[first] / 36 * linear_ranking(5)[second - (second > first)] / 25
        for first, second in orders
    ]
    assert math.isclose(sum(weights), 1)
    assert_follows([times[order] for order in orders], weights)


def test_survivors_by_rank():
    survivors = sample(BY_RANK, seed=79, generations=6_000)["survivors"]
    assert all(len(set(row)) == 8 for row in survivors.tolist())
    assert_follows(np.bincount(survivors[:, 0], minlength=32)[2:], linear_ranking(30))
    # The rank among the remaining slots has the same distribution in every draw.
    for k in range(1, 8):
        below = (survivors[:, :k] < survivors[:, k : k + 1]).sum(axis=1)
        counts = np.bincount(survivors[:, k] - 2 - below, minlength=30 - k)
        assert_follows(counts, linear_ranking(30 - k))


def test_first_generation_of_successive_seeds():
    """Runs of seeds 0, 1, 2, ... are as good a sample as a long run."""
    unit = Selection(DEFAULT)
    draws = [unit.draw(RandomSource(seed)) for seed in range(3000)]
    ranks = np.array([draw.parents for draw in draws])
    assert_follows(np.bincount(ranks.ravel(), minlength=32), linear_ranking(32))
    weights = np.outer(linear_ranking(32), linear_ranking(32))
    assert_follows(pairs(ranks[0::2], ranks[1::2], 32), weights)
    children = np.array([draw.children for draw in draws])
    assert_follows(np.bincount(children[:, 0], minlength=22), np.ones(22))


def test_the_statistics_can_fail():
    """An off-by-one rank, and two equal parents, fail the tests."""
    rng = np.random.default_rng(1)
    uniform = rng.integers(0, 32, size=(2, 132_000))
    ranks = np.minimum(*uniform)
    assert_follows(np.bincount(ranks, minlength=32), linear_ranking(32))
    slightly_off = np.where(rng.random(ranks.size) < 0.02, uniform[0], ranks)
    with pytest.raises(AssertionError):
        assert_follows(np.bincount(slightly_off, minlength=32), linear_ranking(32))
    tied = np.where(rng.random(ranks.size) < 0.02, ranks, np.roll(ranks, 1))
    weights = np.outer(linear_ranking(32), linear_ranking(32))
    with pytest.raises(AssertionError):
        assert_follows(pairs(ranks, tied, 32), weights)
