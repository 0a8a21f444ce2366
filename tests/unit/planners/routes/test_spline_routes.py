"""The planners ga-dp and ga-auv over terrain."""

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.planners import make
from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.base import Options, Run, Stop
from pathgene.host.planners.routes.field import Graph, Route, Segments
from pathgene.host.planners.routes.point_sampler import PointSampler
from pathgene.host.planners.routes.search import DeterministicSearch
from pathgene.host.planners.routes.spline_routes import WAYPOINTS, TerrainField


OPTIONS = Options(generations=25, seed=2)


def straight(*points):
    """Return a route of straight segments without terms."""
    points = np.array(points, dtype=float)
    control = np.zeros((len(points) - 1, 10, 3))
    control[:, :4] = np.linspace(points[:-1], points[1:], 4, axis=1)
    counts = np.full(len(control), 4)
    return Route(points, Segments(control, counts, np.zeros((len(control), 2))))


def measured(field, route):
    segments = route.segments
    terms = field.measure(segments.control, segments.counts)
    return Route(route.points, Segments(segments.control, segments.counts, terms))


@pytest.fixture
def field(evaluator):
    return TerrainField(Run(evaluator, Options()))


@pytest.mark.parametrize(
    ("planner", "own", "feasible"),
    [
        ("ga-dp", {}, True),
        ("ga-dp", {"reading": "sum"}, True),
        # They do not find the gap within this number of generations.
        ("ga-dp", {"draws": "uniform"}, False),
        ("ga-auv", {}, False),
    ],
)
def test_plans_the_same_path_again(evaluator, planner, own, feasible):
    result = make(planner, **own).plan(evaluator, OPTIONS)
    assert result.evaluation.feasible == feasible
    assert evaluator.evaluate(result.path) == result.evaluation
    assert (len(result.path) - 1) % WAYPOINTS == 0
    best = [best for _, best, _ in result.history]
    assert best == sorted(best)
    assert [generation for generation, _, _ in result.history] == list(range(26))
    assert result.stopped_by == "generations"
    again = make(planner, **own).plan(evaluator, OPTIONS)
    assert np.array_equal(again.path, result.path)
    assert again.history == result.history
    assert again.evaluations == result.evaluations


def test_waypoints_of_a_route(evaluator, field):
    start, goal = evaluator.problem.start, evaluator.problem.goal
    path = field.path(straight(start, (2000, 3500, 400), goal))
    assert path.shape == (2 * WAYPOINTS + 1, 3)
    assert np.array_equal(path[0], start)
    assert np.array_equal(path[-1], goal)
    assert path[WAYPOINTS].tolist() == [2000, 3500, 400]
    legs = np.sqrt((np.diff(path, axis=0) ** 2).sum(axis=1))
    assert np.ptp(legs[:WAYPOINTS]) < 1e-6
    assert np.ptp(legs[WAYPOINTS:]) < 1e-6


def test_estimate_of_one_segment_is_exact(evaluator, field):
    route = measured(field, straight(evaluator.problem.start, evaluator.problem.goal))
    evaluation = evaluator.evaluate(field.path(route))
    assert evaluation.penalty > 0  # Through the wall.
    assert route.segments.terms[0] == pytest.approx([evaluation.penalty, evaluation.cost])


def test_estimate_of_segments_in_a_row_adds_up(evaluator, field):
    """Without a turn between the segments only the fuel differs, by the burned weight."""
    start, goal = (np.array(end) for end in (evaluator.problem.start, evaluator.problem.goal))
    route = measured(field, straight(start, start + 0.4 * (goal - start), goal))
    evaluation = evaluator.evaluate(field.path(route))
    penalty, cost = route.segments.terms.sum(axis=0)
    assert penalty == pytest.approx(evaluation.penalty, abs=2 * evaluator.ds_m)
    assert cost == pytest.approx(evaluation.cost, rel=2e-3)
    assert cost > evaluation.cost


def test_crossover_prefers_less_penalty_then_less_cost(field):
    def best(*terms):
        # Either straight to the goal or through a third point.
        graph = Graph(
            np.zeros((3, 3)),
            np.array([0, 0, 2]),
            np.array([1, 2, 1]),
            Segments(np.zeros((3, 10, 3)), np.full(3, 4), np.array(terms)),
        )
        return field.best_routes(graph)[0].tolist()

    assert best([1.0, 0.5], [0.0, 9.0], [0.0, 9.0]) == [1, 2]
    assert best([0.0, 1.0], [0.0, 0.4], [0.0, 0.5]) == [1, 2]
    assert best([0.0, 0.8], [0.0, 0.4], [0.0, 0.5]) == [0]


def test_chooses_the_route_by_full_evaluation(evaluator):
    counts = {}
    for reading in ("route", "sum"):
        run = Run(evaluator, Options())
        field = TerrainField(run, reading=reading)
        sampler = PointSampler(Airspace(evaluator.problem), "near")
        rng = np.random.default_rng(0)
        points = np.concatenate((field.ends, sampler.points(rng, 6, None)))
        tails, heads = np.array(
            [(i, j) for i in range(8) for j in range(8) if i != j and j != 0 and i != 1]
        ).T
        control, number = sampler.segments(rng, points[tails], points[heads])
        graph = Graph(
            points, tails, heads, Segments(control, number, field.measure(control, number))
        )
        routes = [graph.route(edges) for edges in field.best_routes(graph)]
        counts[reading] = len(routes)
        assert run.evaluations == len(tails)
        assert field.worth(routes) == pytest.approx(
            [evaluator.evaluate(field.path(route)).fitness for route in routes]
        )
        assert run.evaluations == len(tails) + len(routes)
    assert counts == {"route": 16, "sum": 1}


@pytest.mark.parametrize("reading", ["route", "sum"])
def test_kept_route_never_gets_worse(evaluator, reading):
    field = TerrainField(Run(evaluator, Options()), reading=reading)
    search = DeterministicSearch(
        field, PointSampler(Airspace(evaluator.problem), "uniform"), np.random.default_rng(0)
    )
    generations = [search.step() for _ in range(25)]
    fitness = field.worth([generation.best for generation in generations])
    assert (np.diff(fitness) >= 0).all()


def test_interruption_and_stop_criteria(evaluator):
    stop = Stop()
    stop.request()
    result = make("ga-dp").plan(evaluator, OPTIONS, stop=stop)
    assert (result.generations, result.interrupted) == (0, True)
    target = make("ga-auv").plan(
        evaluator, Options(generations=500, target_fitness=1.01, population=30)
    )
    assert target.stopped_by == "target-fitness"
    assert target.history[-1][1] >= 1.01 > target.history[-2][1]


@pytest.mark.parametrize(
    ("planner", "own", "options", "sentence"),
    [
        ("ga-dp", {}, {"population": 20}, "ga-dp has no population; leave it out (--population)."),
        (
            "ga-auv",
            {},
            {"population": 1},
            "The population of ga-auv must be from 2 to 10000, not 1.",
        ),
        ("ga-dp", {"reading": "both"}, {}, "The reading must be one of route, sum, not 'both'."),
        ("ga-auv", {"draws": "far"}, {}, "The draws must be one of near, uniform, not 'far'."),
        (
            "ga-dp",
            {"added_points": 0},
            {},
            "The crossover points added per generation must be from 1 to 50, not 0.",
        ),
    ],
)
def test_refuses_bad_options(evaluator, planner, own, options, sentence):
    with pytest.raises(InputError) as caught:
        make(planner, **own).plan(evaluator, Options(**options))
    assert str(caught.value) == sentence
