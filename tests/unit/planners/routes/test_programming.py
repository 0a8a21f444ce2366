"""The deterministic crossover compared with an enumeration of all simple routes."""

import itertools

import numpy as np
import pytest

from pathgene.host.planners.routes.field import GOAL, MOST_POINTS, START
from pathgene.host.planners.routes.programming import best_by_sum, best_by_whole, segments_of


WEIGHTS = np.array([1.0, 2.0, 4.0])


def random_graph(rng, points, whole_numbers):
    """Return segments between any two points, some twice, in random order."""
    tails, heads = np.divmod(np.arange(points * points), points)
    allowed = (tails != heads) & (heads != START) & (tails != GOAL)
    allowed &= rng.random(len(tails)) < rng.choice([0.5, 1.0])  # Some segments are missing.
    twice = np.flatnonzero(allowed & (rng.random(len(tails)) < 0.3))
    edges = rng.permutation(np.concatenate((np.flatnonzero(allowed), twice)))
    # With whole numbers many routes are equal, and a loop may cost nothing.
    terms = (
        rng.integers(0, 3, (len(edges), 3)).astype(float)
        if whole_numbers
        else rng.gamma(1.0, size=(len(edges), 3))
    )
    return tails[edges], heads[edges], terms


def simple_routes(tails, heads, points):
    """Yield every route that does not pass a point twice, as a list of segments."""
    between = {}
    for edge, ends in enumerate(zip(tails.tolist(), heads.tolist(), strict=True)):
        between.setdefault(ends, []).append(edge)
    others = range(GOAL + 1, points)
    for size in range(min(len(others), MOST_POINTS - 2) + 1):
        for inner in itertools.permutations(others, size):
            legs = itertools.pairwise((START, *inner, GOAL))
            yield from itertools.product(*(between.get(leg, ()) for leg in legs))


def whole(terms, route):
    part = terms[list(route)]
    return (
        np.array([part[:, 0].sum(), part[:, 1].max(), part[:, 2].max()]) @ WEIGHTS / WEIGHTS.sum()
    )


def check_is_route(route, tails, heads):
    """Assert that a route connects start and goal and does not pass a point twice."""
    assert tails[route[0]] == START
    assert heads[route[-1]] == GOAL
    assert np.array_equal(tails[route[1:]], heads[route[:-1]])
    passed = [START, *heads[route]]
    assert len(set(passed)) == len(passed) <= MOST_POINTS


@pytest.mark.parametrize("whole_numbers", [False, True])
@pytest.mark.parametrize("points", [2, 3, 4, 5, 6])
def test_both_readings_find_the_best_of_all_simple_routes(points, whole_numbers):
    rng = np.random.default_rng(points)
    found = 0
    for _ in range(25):
        tails, heads, terms = random_graph(rng, points, whole_numbers)
        every = list(simple_routes(tails, heads, points))
        costs = terms[:, 0]
        routes, totals = best_by_sum(tails, heads, costs, points, 1)
        by_whole, total = best_by_whole(tails, heads, terms, WEIGHTS, points)
        if not every:
            assert totals[0] == total == np.inf
            continue
        found += 1
        for route, cost, value in (
            (segments_of(routes[0]), totals[0], lambda edges, c=costs: c[list(edges)].sum()),
            (segments_of(by_whole), total, lambda edges, t=terms: whole(t, edges)),
        ):
            check_is_route(route, tails, heads)
            assert cost == pytest.approx(value(route), rel=1e-12)
            assert cost == pytest.approx(min(map(value, every)), rel=1e-12)
    assert found >= 10


def test_prefers_the_fewest_segments_among_equal_routes():
    rng = np.random.default_rng(7)
    for _ in range(20):
        tails, heads, terms = random_graph(rng, 5, whole_numbers=True)
        every = list(simple_routes(tails, heads, 5))
        if not every:
            continue
        best = min(whole(terms, route) for route in every)
        fewest = min(len(route) for route in every if whole(terms, route) == best)
        route, _ = best_by_whole(tails, heads, terms, WEIGHTS, 5)
        assert len(segments_of(route)) == fewest


def test_a_long_list_has_all_routes_in_order():
    rng = np.random.default_rng(1)
    for _ in range(5):
        tails, heads, terms = random_graph(rng, 5, whole_numbers=False)
        costs = terms[:, 0]
        every = sorted(costs[list(route)].sum() for route in simple_routes(tails, heads, 5))
        routes, totals = best_by_sum(tails, heads, costs, 5, 400)
        assert totals[: len(every)] == pytest.approx(np.array(every), rel=1e-12)
        assert np.isinf(totals[len(every) :]).all()
        listed = [tuple(segments_of(route)) for route in routes[: len(every)]]
        assert len(set(listed)) == len(listed)
        for route in listed:
            check_is_route(np.array(route), tails, heads)


@pytest.mark.parametrize(("inner", "possible"), [(MOST_POINTS - 2, True), (MOST_POINTS - 1, False)])
def test_routes_have_at_most_ten_points(inner, possible):
    """The points form a chain, which is the only route."""
    chain = np.array([START, *range(GOAL + 1, GOAL + 1 + inner), GOAL])
    terms = np.ones((inner + 1, 3))
    routes, totals = best_by_sum(chain[:-1], chain[1:], terms[:, 0], inner + 2, 3)
    route, total = best_by_whole(chain[:-1], chain[1:], terms, WEIGHTS, inner + 2)
    if possible:
        assert np.array_equal(segments_of(routes[0]), np.arange(inner + 1))
        assert np.array_equal(segments_of(route), np.arange(inner + 1))
    else:
        assert totals[0] == total == np.inf


def test_keeps_a_worse_way_of_fewer_segments():
    """A cheap detour to the first point of a chain makes the route one segment too long."""
    chain = [2, *range(4, 4 + MOST_POINTS - 3), GOAL]
    tails = np.array([START, 3, START, *chain[:-1]])
    heads = np.array([3, 2, 2, *chain[1:]])
    costs = np.array([0.1, 0.1, 5.0, *[1.0] * (len(chain) - 1)])
    terms = np.stack((costs, costs, costs), axis=1)
    expected = [2, *range(3, 3 + len(chain) - 1)]
    points = 4 + len(chain) - 2
    routes, _ = best_by_sum(tails, heads, costs, points, 1)
    route, _ = best_by_whole(tails, heads, terms, WEIGHTS, points)
    assert segments_of(routes[0]).tolist() == segments_of(route).tolist() == expected


def test_keeps_all_undominated_ways():
    """With two opposing terms every route to a point is kept, and memory grows."""
    points = MOST_POINTS
    chain = np.array([START, *range(GOAL + 1, points), GOAL])
    rng = np.random.default_rng(3)
    tails, heads = np.repeat(chain[:-1], 8), np.repeat(chain[1:], 8)
    length = rng.random(len(tails))
    terms = np.stack((length, 1 - length, rng.random(len(tails))), axis=1)
    _, total = best_by_whole(tails, heads, terms, WEIGHTS, points)
    # The best for every pair of bounds on the second and third terms, leg by leg.
    legs = terms.reshape(len(chain) - 1, 8, 3)
    best = np.inf
    for turning, rate in itertools.product(np.unique(terms[:, 1]), np.unique(terms[:, 2])):
        fits = (legs[:, :, 1] <= turning) & (legs[:, :, 2] <= rate)
        shortest = np.where(fits, legs[:, :, 0], np.inf).min(axis=1).sum()
        best = min(best, (shortest + 2 * turning + 4 * rate) / 7)
    assert total == pytest.approx(best, rel=1e-12)
