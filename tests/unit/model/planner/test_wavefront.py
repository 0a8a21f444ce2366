"""Routes: the compiled wavefront equals the definition, and the definition equals Dijkstra's."""

import dataclasses
import heapq
import itertools

import numpy as np
import pytest

from pathgene.hdl.protocol.planner import ALTITUDE_FRACTION, FAR
from pathgene.sim.model.planner.course import problem_vector, sizes_vector
from pathgene.sim.model.planner.definition import wavefront as plain
from pathgene.sim.model.planner.definition.score import corner_of, piece_cost
from pathgene.sim.model.planner.wavefront import (
    LEAST,
    LOWEST_X,
    LOWEST_Y,
    PRICES,
    descend,
    find_turns,
    limit_slopes,
    measure_blocks,
    measure_distances,
    measure_prices,
    spread,
)
from tests.support.planner.cases import LARGE, SMALL, USUAL, any_record, ground, record


#: Configuration, share of blocked corners, corners along the edge of a block as a power of two.
CASES = [(SMALL, 0.0, 0), (SMALL, 0.3, 0), (USUAL, 0.0, 4), (USUAL, 0.002, 4), (USUAL, 0.01, 3)]


def cases(config, blocked, shift):
    rng = np.random.default_rng(shift + int(1000 * blocked))
    problem, heights = record(config, rng), ground(config, rng, blocked=blocked)
    problem = dataclasses.replace(problem, block_shift=shift)
    assert problem.blocks == config.map_size >> shift
    return problem, heights, plain.blocks_of(problem, heights, config.blocked_altitude)


def array(values, none, edge):
    """A dictionary of blocks as (edge, edge), ``none`` elsewhere."""
    layer = np.full((edge, edge), none, dtype=np.int64)
    for (x, y), value in values.items():
        layer[y, x] = value
    return layer


def vector_of(prices):
    """Constants of steps in the form of the compiled kernels."""
    return [
        *prices.factors,
        *prices.levels,
        *prices.pulls,
        prices.climb,
        prices.fraction,
    ]


@pytest.mark.parametrize("slope", [0, 1, 3])
@pytest.mark.parametrize("case", CASES)
def test_compiled_wavefront_is_the_defined_one(case, slope):
    config, *_ = case
    problem, heights, blocks = cases(*case)
    edge = problem.blocks
    vector, distances = problem_vector(config, problem), np.zeros(3, dtype=np.int64)
    ends = [*corner_of(problem, "start"), *corner_of(problem, "goal")]
    layers = np.zeros((3, edge, edge), dtype=np.int64)
    measure_distances(vector, distances)
    measure_blocks(vector, heights, config.blocked_altitude, np.array(ends), layers)
    assert tuple(distances) == blocks.distances
    assert np.array_equal(layers[LEAST], array(blocks.least, -1, edge))
    assert all(
        (layers[LOWEST_X, y, x], layers[LOWEST_Y, y, x]) == lowest
        for (x, y), lowest in blocks.lowest.items()
    )

    surface, expected = layers[LEAST].copy(), dict(blocks.least)
    if slope:
        passes = plain.limit_slopes(problem, blocks, expected, slope)
        assert limit_slopes(vector, distances, surface, slope) == passes
        assert np.array_equal(surface, array(expected, -1, edge))
    field = np.zeros((edge, edge), dtype=np.int64)
    start, goal = (y * edge + x for x, y in (blocks.start, blocks.goal))
    prices = np.zeros(PRICES, dtype=np.int64)
    measure_prices(vector, sizes_vector(config, 0), distances, prices)
    expected_prices = plain.prices_of(config, problem, blocks.distances)
    assert prices.tolist() == vector_of(expected_prices)
    costs, passes = plain.spread(expected_prices, blocks, expected)
    assert spread(prices, surface, goal, field) == passes
    assert np.array_equal(field, array(costs, FAR, edge))
    route = np.zeros((edge * edge, 2), dtype=np.int64)
    length = descend(prices, surface, field, start, goal, route)
    expected_route = plain.descend(expected_prices, blocks, expected, costs)
    assert [tuple(block) for block in route[:length].tolist()] == expected_route
    turns = plain.turns_of(expected_route)
    assert turns_found(route, length, edge) == turns
    if blocks.start in costs:
        # Where the route is straight, it is near the line.
        for one, other in itertools.pairwise([blocks.start, *turns, blocks.goal]):
            between = expected_route[expected_route.index(one) : expected_route.index(other)]
            assert all(away(block, one, other) < 1.5 for block in between)


def turns_found(route, length, most):
    """The turns that the kernel finds, with room for ``most``."""
    turns = np.zeros((most, 2), dtype=np.int64)
    return [tuple(block) for block in turns[: find_turns(route, length, turns)].tolist()]


def walk(rng, steps, edge):
    """A route of blocks that keeps its direction for a while and visits no block twice."""
    ways = [(x, y) for y in (-1, 0, 1) for x in (-1, 0, 1) if x or y]
    route, way = [tuple(rng.integers(edge, size=2).tolist())], ways[0]
    while len(route) < steps:
        if rng.random() < rng.choice([0.1, 0.5]):
            way = ways[rng.integers(8)]
        block = route[-1][0] + way[0], route[-1][1] + way[1]
        if block in route or not all(0 <= each < edge for each in block):
            return route
        route.append(block)
    return route


def away(block, one, other):
    """The distance of a block from the straight line between two blocks, in blocks."""
    a, b, at = (np.array(each, dtype=float) for each in (one, other, block))
    share = np.clip((at - a) @ (b - a) / max((b - a) @ (b - a), 1), 0, 1)
    return float(np.hypot(*(at - a - share * (b - a))))


def test_turns_of_random_walks():
    rng = np.random.default_rng(5)
    counts = []
    for _ in range(400):
        route = walk(rng, 60, 64)
        turns = plain.turns_of(route)
        rows = np.array(route, dtype=np.int64)
        assert turns_found(rows, len(route), 64) == turns
        assert turns_found(rows, len(route), 3) == turns[:3]
        assert [block for block in route[1:-1] if block in turns] == turns
        counts.append(len(turns))
    assert min(counts) == 0
    assert max(counts) > 5


@pytest.mark.parametrize(
    ("route", "turns"),
    [
        ([(0, 0)], []),
        ([(0, 0), (1, 0), (2, 0), (3, 0)], []),
        # A line between two directions of steps is straight.
        ([(x, x // 3) for x in range(60)], []),
        # One block aside is still within the wedge.
        ([*[(x, 0) for x in range(9)], *[(8, y) for y in range(1, 9)]], [(8, 1)]),
    ],
)
def test_turns_of_plain_routes(route, turns):
    assert plain.turns_of(route) == turns


@pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])
def test_constants_of_any_problem(config):
    """The compiled constants and the bounds of the costs are right, whatever the fields contain."""
    rng = np.random.default_rng(config.map_size)
    top = config.blocked_altitude
    for _ in range(300):
        problem = any_record(config, rng)
        vector, distances = problem_vector(config, problem), np.zeros(3, dtype=np.int64)
        measure_distances(vector, distances)
        expected = plain.prices_of(config, problem, tuple(distances.tolist()))
        prices = np.zeros(PRICES, dtype=np.int64)
        measure_prices(vector, sizes_vector(config, 0), distances, prices)
        assert prices.tolist() == vector_of(expected)
        assert max(expected.factors) < 1 << 18
        assert 2 * top * max(expected.factors) >> expected.fraction < 1 << 23
        assert expected.climb * top << 6 >> expected.fraction < 1 << 28
        for way in range(3):
            for step in ((0, 0), (0, top), (top, 0), (top, top)):
                assert 1 <= expected.cost(*step, way) < FAR


@pytest.mark.parametrize("config", [USUAL, LARGE], ids=["usual", "large"])
def test_costs_are_those_of_pieces(config):
    """If nothing is clamped, they are equal within the rounding of the constants."""
    rng = np.random.default_rng(config.map_size)
    for _ in range(20):
        problem = record(config, rng, key_shift=10 + (config is LARGE) * 7)
        distances = np.zeros(3, dtype=np.int64)
        measure_distances(problem_vector(config, problem), distances)
        prices = plain.prices_of(config, problem, tuple(distances.tolist()))
        for before, after in rng.integers(config.blocked_altitude, size=(50, 2)).tolist():
            for way, distance in enumerate(distances.tolist()):
                ends = before << ALTITUDE_FRACTION, after << ALTITUDE_FRACTION
                exact = max(piece_cost(problem, *ends, distance) >> problem.key_shift, 1)
                # The rounding of both factors, of weight and climb, and of the sums.
                rise = abs(after - before)
                lost = (before + after >> prices.fraction) + (rise << 6 >> prices.fraction)
                lost += (distance + (rise << ALTITUDE_FRACTION) >> problem.key_shift) + 6
                assert abs(prices.cost(before, after, way) - exact) <= lost


@pytest.mark.parametrize("case", CASES)
def test_costs_are_the_least(case):
    problem, _, blocks = cases(*case)
    prices = plain.prices_of(case[0], problem, blocks.distances)
    field, _ = plain.spread(prices, blocks, blocks.least)
    least, queue = {}, [(0, blocks.goal)]
    while queue:
        cost, (x, y) = heapq.heappop(queue)
        if (x, y) in least:
            continue
        least[x, y] = cost
        for u, v in ((x + i, y + j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j):
            if (u, v) in blocks.least and (u, v) not in least:
                way = 2 if u != x and v != y else int(u == x)
                step = prices.cost(blocks.least[u, v], blocks.least[x, y], way)
                heapq.heappush(queue, (cost + step, (u, v)))
    assert field == least


def test_slopes_are_limited():
    problem, _, blocks = cases(*CASES[2])
    surface = dict(blocks.least)
    plain.limit_slopes(problem, blocks, surface, 2)
    falls = [max(problem.climb * distance >> 16, 1) for distance in blocks.distances]
    for (x, y), height in surface.items():
        assert height >= blocks.least[x, y]
        for other, fall in (
            ((x + 1, y), falls[0]),
            ((x, y + 1), falls[1]),
            ((x + 1, y + 1), falls[2]),
        ):
            if other in surface:
                assert abs(surface[other] - height) <= fall


def test_a_goal_behind_a_wall_is_approached_in_a_straight_line():
    rng = np.random.default_rng(16)
    problem, heights = record(SMALL, rng), ground(SMALL, rng, blocked=0)
    heights[12] = SMALL.blocked_altitude
    blocks = plain.blocks_of(problem, heights, SMALL.blocked_altitude)
    prices = plain.prices_of(SMALL, problem, blocks.distances)
    field, _ = plain.spread(prices, blocks, blocks.least)
    route = plain.descend(prices, blocks, blocks.least, field)
    assert len(route) == 64
    assert route[0] == blocks.start
    assert np.abs(np.diff(route, axis=0)).max() <= 1
