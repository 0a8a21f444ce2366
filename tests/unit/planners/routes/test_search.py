"""The two searches on the AUV problem."""

import itertools

import numpy as np
import pytest

from pathgene.host.auv.field import AuvField, Base, delta
from pathgene.host.errors import InputError
from pathgene.host.planners.routes.field import GOAL, MOST_POINTS, START, Graph, Route, Segments
from pathgene.host.planners.routes.point_sampler import PointSampler
from pathgene.host.planners.routes.search import (
    ConventionalSearch,
    DeterministicSearch,
    _Chromosome,
    _Survivor,
    cross,
)


SEARCHES = [DeterministicSearch, ConventionalSearch]


def searched(kind, seed=0, reading="route", draws="near", landscape=1, **options):
    field = AuvField(landscape, reading=reading)
    return field, kind(field, PointSampler(Base(), draws), np.random.default_rng(seed), **options)


@pytest.mark.parametrize("kind", SEARCHES)
@pytest.mark.parametrize("reading", ["route", "sum"])
@pytest.mark.parametrize("draws", ["near", "uniform"])
def test_best_never_rises_and_routes_are_whole(kind, reading, draws):
    field, search = searched(kind, reading=reading, draws=draws)
    costs = []
    for _ in range(25):
        generation = search.step()
        route = generation.best
        costs.append(field.cost(route))
        assert 1 / costs[-1] >= generation.fitness.max() * (1 - 1e-12)
        assert 2 <= len(route.points) <= MOST_POINTS
        assert np.array_equal(route.points[[0, -1]], field.ends)
        segments = route.segments
        assert np.array_equal(segments.control[:, 0], route.points[:-1])
        rows = np.arange(len(segments))
        assert np.array_equal(segments.control[rows, segments.counts - 1], route.points[1:])
        assert np.array_equal(field.measure(segments.control, segments.counts), segments.terms)
    assert (np.diff(costs) <= 0).all()
    assert costs[-1] < costs[0] or draws == "uniform"


@pytest.mark.parametrize("kind", SEARCHES)
def test_same_seed_same_routes(kind):
    runs = []
    for seed in (4, 4, 5):
        _, search = searched(kind, seed)
        runs.append([search.step().best.segments.control.tolist() for _ in range(6)])
    assert runs[0] == runs[1] != runs[2]


@pytest.mark.parametrize("reading", ["route", "sum"])
def test_first_generation_is_the_best_of_all_routes(reading):
    """The test repeats the draws and enumerates the routes."""
    field, search = searched(DeterministicSearch, seed=3, reading=reading, draws="uniform", added=4)
    best = search.step().best

    rng = np.random.default_rng(3)
    sampler = PointSampler(Base(), "uniform")
    points = np.concatenate((field.ends, sampler.points(rng, 4, None)))
    pairs = [(i, j) for i in range(6) for j in range(6) if i != j and j != START and i != GOAL]
    tails, heads = np.array(pairs).T
    control, counts = sampler.segments(rng, points[tails], points[heads])
    segments = Segments(control, counts, field.measure(control, counts))
    costs = []
    for size in range(5):
        for inner in itertools.permutations(range(2, 6), size):
            legs = itertools.pairwise((START, *inner, GOAL))
            edges = [pairs.index(leg) for leg in legs]
            costs.append(field.cost(Route(points[[START, *inner, GOAL]], segments.take(edges))))
    assert field.cost(best) == pytest.approx(min(costs), rel=1e-12)


def test_replaces_a_kept_segment_only_if_the_route_gains():
    field = AuvField(1)
    terms = np.array(
        [
            [0.5, 0.1, 1.0],  # To the middle: kept.
            [0.5, 0.6, 0.3],  # From the middle to the goal: kept.
            [0.2, 0.5, 0.6],  # New, to the middle: the route becomes better.
            [0.45, 0.0, 1.02],  # Fitter than the kept segment, but the route becomes worse.
        ]
    )
    assert delta(terms[3]) < delta(terms[0])
    segments = Segments(np.zeros((4, 10, 2)), np.full(4, 4), terms)
    tails, heads = np.array([START, 2, START, START]), np.array([2, GOAL, 2, 2])
    graph = Graph(np.zeros((3, 2)), tails, heads, segments)
    assert field.best_routes(graph)[0].tolist() == [2, 1]
    without = Graph(graph.points, tails[[0, 1, 3]], heads[[0, 1, 3]], segments.take([0, 1, 3]))
    assert field.best_routes(without)[0].tolist() == [0, 1]


def test_only_a_fitter_route_replaces_the_survivor():
    field = AuvField(1)
    survivor = _Survivor(field, PointSampler(Base()), np.random.default_rng(0), 8)
    graph = survivor.next_graph()
    direct = np.flatnonzero((graph.tails == START) & (graph.heads == GOAL))
    others = [
        graph.route([i, j])
        for i in np.flatnonzero(graph.tails == START)
        for j in np.flatnonzero((graph.heads == GOAL) & (graph.tails == graph.heads[i]))
    ]
    routes = sorted([graph.route(direct), *others], key=field.cost)
    for given, kept in ((3, 3), (5, 3), (1, 1), (2, 1), (0, 0)):
        assert survivor.compete([routes[-1], routes[given]]) == pytest.approx(
            [1 / field.cost(routes[-1]), 1 / field.cost(routes[given])]
        )
        assert survivor.route is routes[kept]


def test_strands_lead_to_the_goal_and_never_get_worse():
    """Strands improve separately, so they stay different."""
    field, search = searched(DeterministicSearch, landscape=2)
    costs, best = [], []
    for _ in range(12):
        best.append(field.cost(search.step().best))
        strands = search._strands
        assert np.array_equal(strands.control[:, 0], np.tile(field.ends[0], (24, 1)))
        assert np.array_equal(
            strands.control[np.arange(24), strands.counts - 1], np.tile(field.ends[1], (24, 1))
        )
        assert np.array_equal(field.measure(strands.control, strands.counts), strands.terms)
        costs.append(field.costs(strands.terms))
    gains = -np.diff(costs, axis=0)
    assert gains.min() == 0
    assert (np.sum(gains, axis=0) > 0).all()
    assert len(np.unique(costs[-1])) == 24
    # A strand is a route as well.
    assert (best <= np.min(costs, axis=1) * (1 + 1e-12)).all()


def test_uniform_draws_have_no_strands():
    field, search = searched(DeterministicSearch, draws="uniform")
    search.step()
    assert search._strands is None
    # 10 points: 9 ways from the start, and 9 from each of the 8 inner points.
    assert field.evaluations == 9 + 8 * 8


def chromosome(*points):
    first = 100 * len(points)
    return _Chromosome((START, *points, GOAL), tuple(range(first, first + len(points) + 1)))


def test_crossover_exchanges_tails_at_a_common_point():
    one, other = chromosome(5, 6, 7), chromosome(8, 6)
    first, second = cross(one, other, np.random.default_rng(0))
    assert (first.points, second.points) == ((START, 5, 6, GOAL), (START, 8, 6, 7, GOAL))
    assert first.edges == (*one.edges[:2], *other.edges[2:])
    assert second.edges == (*other.edges[:2], *one.edges[2:])


def test_parents_are_copied_without_a_common_point():
    one, other = chromosome(5, 6), chromosome(7)
    assert cross(one, other, np.random.default_rng(0)) == (one, other)


def test_crossover_makes_no_loop_and_no_long_path():
    # At 6 a child would pass 5 twice.
    one, other = chromosome(5, 6), chromosome(6, 5)
    assert cross(one, other, np.random.default_rng(0)) == (one, other)
    long = chromosome(2, 3, 4, 5, 6, 7, 8, 9), chromosome(9, 12, 13)
    assert cross(*long, np.random.default_rng(0)) == long


def test_crossover_point_is_drawn_at_random():
    one, other = chromosome(5, 6, 7), chromosome(5, 8, 7)
    rng = np.random.default_rng(0)
    children = {cross(one, other, rng)[0].points for _ in range(40)}
    assert children == {(START, 5, 8, 7, GOAL), (START, 5, 6, 7, GOAL)}


def test_roulette_and_mutation_of_the_conventional_search():
    """There are as many children as parents; a fifth has a segment that no parent has."""
    _, search = searched(ConventionalSearch, chromosomes=200)
    survivor = search._survivor
    graph = survivor.next_graph()
    parents = search._population(graph, None)
    sizes = np.bincount([len(parent.points) for parent in parents], minlength=11)[2:]
    assert (sizes > 8).all()  # 2 to 10 points, 22 of each on average.
    fitness = survivor.compete([graph.route(parent.edges) for parent in parents])
    extended, children = search._children(graph, parents, fitness)
    assert len(children) == 200
    new = len(extended.tails) - len(graph.tails)
    assert new == pytest.approx(40, abs=20)
    assert sum(max(child.edges) >= len(graph.tails) for child in children) == new
    for child in children:
        at = np.array([START, *extended.heads[list(child.edges)]])
        assert at.tolist() == list(child.points)


def test_a_child_that_is_fitter_than_all_parents_survives():
    field, search = searched(ConventionalSearch)
    survived = 0
    for _ in range(25):
        generation = search.step()
        parents, children = np.split(generation.fitness, 2)
        if children.max() > parents.max():
            survived += 1
            assert 1 / field.cost(generation.best) == pytest.approx(children.max(), rel=1e-12)
    assert survived > 0


@pytest.mark.parametrize(
    ("kind", "options", "sentence"),
    [
        (
            DeterministicSearch,
            {"added": 0},
            "The crossover points added per generation must be from 1 to 50, not 0.",
        ),
        (
            ConventionalSearch,
            {"added": 51},
            "The crossover points added per generation must be from 1 to 50, not 51.",
        ),
        (
            ConventionalSearch,
            {"chromosomes": 1},
            "The population of ga-auv must be from 2 to 10000, not 1.",
        ),
    ],
)
def test_refuses_options_out_of_range(kind, options, sentence):
    with pytest.raises(InputError) as caught:
        searched(kind, **options)
    assert str(caught.value) == sentence
