import math

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from pathgene.host.planners.grid.shortest_paths import Graph, shortest_paths


def drawn(seed, points, links, whole_numbers=False):
    rng = np.random.default_rng(seed)
    pairs = np.unique(rng.integers(0, points, (links, 2)), axis=0)
    tails, heads = rng.permutation(pairs).T
    if whole_numbers:  # Many paths have the same cost.
        return tails, heads, rng.integers(1, 4, len(tails)).astype(np.float64)
    costs = rng.uniform(0, 1, len(tails))
    costs[rng.uniform(size=len(tails)) < 0.1] = math.inf
    return tails, heads, costs


@pytest.mark.parametrize("whole_numbers", [False, True])
@pytest.mark.parametrize(("points", "links"), [(1, 1), (2, 2), (40, 60), (300, 4_000)])
def test_costs_are_those_of_scipy(points, links, whole_numbers):
    for seed in range(5):
        tails, heads, costs = drawn(seed, points, links, whole_numbers)
        found, before = shortest_paths(*Graph.of_pairs(tails, heads, costs, points), 0)
        expected = dijkstra(csr_array((costs, (tails, heads)), shape=(points, points)), indices=0)
        np.testing.assert_array_equal(found, expected)
        # The last links add up to the costs.
        reached = np.flatnonzero(before >= 0)
        cost = dict(zip(zip(tails.tolist(), heads.tolist(), strict=True), costs, strict=True))
        for point in reached.tolist():
            previous = int(before[point])
            assert found[previous] + cost[previous, point] == found[point]
        assert set(reached) == set(np.flatnonzero(np.isfinite(found))) - {0}


def test_the_first_of_equal_paths_stays():
    tails, heads = np.array([0, 0, 1, 2]), np.array([1, 2, 3, 3])
    graph = Graph.of_pairs(tails, heads, np.array([1.0, 2.0, 2.0, 1.0]), 4)
    found, before = shortest_paths(*graph, 0)
    assert found.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert before.tolist() == [-1, 0, 0, 1]
