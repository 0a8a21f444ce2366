"""The two searches of *cheng*, one generation at a time: deterministic crossover, and roulette."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.planners.roulette import roulette
from pathgene.host.planners.routes.field import (
    GOAL,
    MOST_POINTS,
    START,
    Field,
    Floats,
    Graph,
    Ints,
    Route,
    Segments,
)
from pathgene.host.planners.routes.point_sampler import PointSampler


__all__ = [
    "ADDED_POINTS",
    "CHROMOSOMES",
    "ConventionalSearch",
    "DeterministicSearch",
    "Generation",
    "Search",
    "cross",
]

#: Crossover points added per generation, and chromosomes of the conventional GA (table III).
ADDED_POINTS = 8
CHROMOSOMES = 20

_MOST_ADDED = 50  # Labels of the deterministic crossover have a bit for each point.
_MUTATION_RATE = 0.20
_VARIANTS = 64  # Number of variants of the segments of the kept route.
_STRANDS = 24
_VARIANTS_OF_A_STRAND = 16
_FEWEST_CHROMOSOMES, _MOST_CHROMOSOMES = 2, 10_000


@dataclass(frozen=True)
class Generation:
    """The result of a generation.

    Parameters
    ----------
    fitness : ndarray
        Fitness of all whole routes that were compared, (m,) float64.
    """

    best: Route
    fitness: NDArray[np.float64]


class Search(Protocol):
    """A search for the best route of a field."""

    def step(self) -> Generation:
        """Run the next generation."""


class _Survivor:
    """The best route found, and the graph of its points, new points and all their segments."""

    def __init__(
        self,
        field: Field,
        sampler: PointSampler,
        rng: np.random.Generator,
        added: int,
        given: Sequence[Route] = (),
    ) -> None:
        if not 1 <= added <= _MOST_ADDED:
            raise InputError(
                f"The crossover points added per generation must be from 1 to "
                f"{_MOST_ADDED}, not {added}."
            )
        self.route: Route | None = None
        self.fitness = 0.0
        self.field, self.sampler, self.rng = field, sampler, rng
        self._added = added
        if given:
            self.compete(given)

    @property
    def places(self) -> Ints:
        """Indices of the route's points in the next graph, in the order of the route."""
        assert self.route is not None
        return np.array([START, *range(GOAL + 1, GOAL + len(self.route.points) - 1), GOAL])

    def next_graph(self) -> Graph:
        """Add crossover points and connect any two points; the survivor keeps its segments, too."""
        added = self.sampler.points(self.rng, self._added, self.route)
        own = added[:0] if self.route is None else self.route.points[1:-1]
        points = np.concatenate((self.field.ends, own, added))
        tails, heads = np.divmod(np.arange(len(points) ** 2), len(points))
        allowed = (tails != heads) & (heads != START) & (tails != GOAL)
        tails, heads = tails[allowed], heads[allowed]
        graph = Graph(points, tails, heads, self.segments(points[tails], points[heads]))
        if self.route is None:
            return graph
        at = self.places
        return graph.extended(at[:-1], at[1:], self.route.segments)

    def segments(self, tails: Floats, heads: Floats) -> Segments:
        """Draw and measure a segment from each of ``tails`` to each of ``heads``, (m, d)."""
        control, counts = self.sampler.segments(self.rng, tails, heads)
        return Segments(control, counts, self.field.measure(control, counts))

    def variants(self, segments: Segments) -> Segments:
        """Draw and measure a variant of each of some segments."""
        control, counts = self.sampler.variants(self.rng, segments)
        return Segments(control, counts, self.field.measure(control, counts))

    def compete(self, routes: Sequence[Route]) -> NDArray[np.float64]:
        """Keep the best of ``routes`` if it is fitter than the survivor; return their fitness."""
        fitness = self.field.worth(routes)
        best = int(np.argmax(fitness))
        if self.route is None or fitness[best] > self.fitness:
            self.route, self.fitness = routes[best], float(fitness[best])
        return fitness


class DeterministicSearch:
    """The proposed planner: dynamic programming over all segments instead of a random crossover.

    In each generation, crossover points are added to the kept ones, any two are connected by a new
    segment, and the deterministic crossover finds the best route among new and kept segments. The
    points and segments of that route are kept; the rest is discarded.

    Source: *cheng*, section IV. The paper leaves a point open; here, a kept segment and the new one
    between the same points are both offered to the dynamic programming, which takes the fitter; if
    the fitness applies to the whole route, a segment that is fitter on its own may be worse in it.

    Additions for near draws: 64 variants of the kept segments compete with them, and 24 segments
    from start to goal, the strands, are always kept. Each strand has 16 variants in a generation;
    the fittest variant replaces the strand if it is fitter.

    Parameters
    ----------
    added : int
        Crossover points added per generation, 1 to 50.
    given : sequence of Route
        Routes to start from; the best is kept before the first generation.

    Raises
    ------
    InputError
        If ``added`` is outside its range.
    """

    def __init__(
        self,
        field: Field,
        sampler: PointSampler,
        rng: np.random.Generator,
        *,
        added: int = ADDED_POINTS,
        given: Sequence[Route] = (),
    ) -> None:
        self._survivor = _Survivor(field, sampler, rng, added, given)
        self._strands: Segments | None = None

    def step(self) -> Generation:
        """Run the next generation."""
        survivor = self._survivor
        graph = survivor.next_graph()
        if survivor.sampler.near:
            graph = self._with_strands(self._with_variants(graph))
        routes = [graph.route(edges) for edges in survivor.field.best_routes(graph)]
        fitness = survivor.compete(routes)
        assert survivor.route is not None
        return Generation(survivor.route, fitness)

    def _with_variants(self, graph: Graph) -> Graph:
        survivor = self._survivor
        if survivor.route is None:
            return graph
        kept = survivor.route.segments
        which = survivor.rng.integers(len(kept), size=_VARIANTS)
        at = survivor.places
        return graph.extended(at[which], at[which + 1], survivor.variants(kept.take(which)))

    def _with_strands(self, graph: Graph) -> Graph:
        survivor = self._survivor
        start, goal = (np.full(_STRANDS, end) for end in (START, GOAL))
        if self._strands is None:
            self._strands = survivor.segments(graph.points[start], graph.points[goal])
        else:
            variants = survivor.variants(
                self._strands.take(np.repeat(np.arange(_STRANDS), _VARIANTS_OF_A_STRAND))
            )
            costs = survivor.field.costs(variants.terms).reshape(_STRANDS, -1)
            fittest = costs.argmin(axis=1)
            gains = costs.min(axis=1) < survivor.field.costs(self._strands.terms)
            places = np.where(
                gains,
                _STRANDS + np.arange(_STRANDS) * _VARIANTS_OF_A_STRAND + fittest,
                np.arange(_STRANDS),
            )
            self._strands = Segments.joined(self._strands, variants).take(places)
        return graph.extended(start, goal, self._strands)


@dataclass(frozen=True)
class _Chromosome:
    """A route of a graph: its points from start to goal, and the segments between them."""

    points: tuple[int, ...]
    edges: tuple[int, ...]


class ConventionalSearch:
    """The conventional genetic algorithm that the proposed planner is compared with.

    In each generation, crossover points are added to the kept ones and any two are connected, as in
    :class:`DeterministicSearch`. Chromosomes are random concatenations of points and segments.
    Pairs drawn by roulette are cut at a common crossover point and exchange their tails; a fifth of
    the children have a segment replaced by a new one. Only the fittest chromosome survives, with
    its points and segments.

    Source: *cheng*, section V, and III.A for the operators. The paper leaves some points open;
    here, a chromosome has 0 to 8 crossover points between start and goal, uniformly distributed and
    in random order; the survivor is one of the next chromosomes; the common point is drawn from the
    points at which both children pass no point twice and keep the limit, and if there is none, the
    parents are copied; parents and children compete for survival. If only children survived, the
    best would be lost repeatedly, without progress in 100 generations.

    Parameters
    ----------
    added : int
        Crossover points added per generation, 1 to 50.
    chromosomes : int
        Paths in the population, 2 to 10,000; an odd number breeds one child fewer.
    given : sequence of Route
        Routes to start from; the best is kept before the first generation.

    Raises
    ------
    InputError
        If a parameter is outside its range.
    """

    def __init__(
        self,
        field: Field,
        sampler: PointSampler,
        rng: np.random.Generator,
        *,
        added: int = ADDED_POINTS,
        chromosomes: int = CHROMOSOMES,
        given: Sequence[Route] = (),
    ) -> None:
        if not _FEWEST_CHROMOSOMES <= chromosomes <= _MOST_CHROMOSOMES:
            raise InputError(
                f"The population of ga-auv must be from {_FEWEST_CHROMOSOMES} to "
                f"{_MOST_CHROMOSOMES}, not {chromosomes}."
            )
        self._survivor = _Survivor(field, sampler, rng, added, given)
        self._chromosomes = chromosomes

    def step(self) -> Generation:
        """Run the next generation."""
        survivor = self._survivor
        kept = survivor.route
        graph = survivor.next_graph()
        parents = self._population(graph, kept)
        fitness = survivor.compete([graph.route(parent.edges) for parent in parents])
        graph, children = self._children(graph, parents, fitness)
        of_children = survivor.compete([graph.route(child.edges) for child in children])
        assert survivor.route is not None
        return Generation(survivor.route, np.concatenate((fitness, of_children)))

    def _population(self, graph: Graph, kept: Route | None) -> list[_Chromosome]:
        """Return the survivor and random concatenations of points and segments."""
        rng = self._survivor.rng
        total = len(graph.points)
        new = len(graph.tails) - (0 if kept is None else len(kept.segments))
        between = np.full((total, total), -1, dtype=np.int64)
        between[graph.tails[:new], graph.heads[:new]] = np.arange(new)
        population = []
        if kept is not None:
            population.append(
                _Chromosome(
                    tuple(self._survivor.places.tolist()), tuple(range(new, len(graph.tails)))
                )
            )
        while len(population) < self._chromosomes:
            size = int(rng.integers(min(MOST_POINTS, total) - 1))
            inner_points = rng.permutation(np.arange(GOAL + 1, total))[:size].tolist()
            points = (START, *inner_points, GOAL)
            edges = between[list(points[:-1]), list(points[1:])]
            population.append(_Chromosome(points, tuple(edges.tolist())))
        return population

    def _children(
        self, graph: Graph, parents: list[_Chromosome], fitness: NDArray[np.float64]
    ) -> tuple[Graph, list[_Chromosome]]:
        """Breed; return the graph with the segments of the mutations."""
        rng = self._survivor.rng
        drawn = roulette(fitness, 2 * (len(parents) // 2), rng)
        children: list[_Chromosome] = []
        for one, other in zip(drawn[::2], drawn[1::2], strict=True):
            children += cross(parents[one], parents[other], rng)
        mutated = np.flatnonzero(rng.random(len(children)) < _MUTATION_RATE)
        if not len(mutated):
            return graph, children
        places = [int(rng.integers(len(children[i].edges))) for i in mutated]
        replaced = [children[i].edges[at] for i, at in zip(mutated, places, strict=True)]
        tails, heads = graph.tails[replaced], graph.heads[replaced]
        segments = self._survivor.segments(graph.points[tails], graph.points[heads])
        for edge, (i, at) in enumerate(zip(mutated, places, strict=True), len(graph.tails)):
            edges = children[i].edges
            children[i] = _Chromosome(children[i].points, (*edges[:at], edge, *edges[at + 1 :]))
        return graph.extended(tails, heads, segments), children


def cross(
    one: _Chromosome, other: _Chromosome, rng: np.random.Generator
) -> tuple[_Chromosome, _Chromosome]:
    """Exchange the tails of two chromosomes past a common crossover point drawn at random.

    The point must leave neither child with a repeated point or more than 10 points; if there is no
    such point, the parents are returned.
    """
    pairs = []
    for point in one.points[1:-1]:
        if point not in other.points:
            continue
        i, j = one.points.index(point), other.points.index(point)
        children = (
            _Chromosome(one.points[:i] + other.points[j:], one.edges[:i] + other.edges[j:]),
            _Chromosome(other.points[:j] + one.points[i:], other.edges[:j] + one.edges[i:]),
        )
        if all(len(set(child.points)) == len(child.points) <= MOST_POINTS for child in children):
            pairs.append(children)
    return pairs[int(rng.integers(len(pairs)))] if pairs else (one, other)
