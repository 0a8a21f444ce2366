"""First populations from a grid search."""

import warnings
from functools import partial

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.host.errors import InputError
from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.allaire.ga_fpga import FpgaGeneticPlanner
from pathgene.host.planners.allaire.ga_pc import PcGeneticPlanner
from pathgene.host.planners.base import Options, Run
from pathgene.host.planners.fpa.planner import FlowerPollinationPlanner
from pathgene.host.planners.grid.astar import AstarPlanner
from pathgene.host.planners.grid.initial import Variation, astar_paths, check_init, on_lattice
from pathgene.host.planners.grid.polylines import lengthened
from pathgene.host.planners.routes.spline_routes import (
    ConventionalRoutePlanner,
    DeterministicRoutePlanner,
)
from pathgene.host.problem.chip_map import ChipMap
from pathgene.host.problem.zones import Circle


WALLS = tuple(Circle(3000, y, 300) for y in range(0, 4001, 400))


@pytest.fixture
def start(evaluator):
    """Function that draws first paths over the ridge and evaluates them."""

    def draw(count=16, most=8, seed=1, **options):
        run = Run(evaluator, Options())
        paths = astar_paths(run, np.random.default_rng(seed), count, most, **options)
        return paths, np.array([evaluator.evaluate(path).fitness for path in paths])

    return draw


#: Options with as many paths as draws, for quick tests, and the planners' numbers of waypoints.
PLANNERS = {
    "ga-fpga": (partial(FpgaGeneticPlanner, initial_draws=1), 16),
    "ga-pc": (partial(PcGeneticPlanner, refits=2), 16),
    "fpa": (partial(FlowerPollinationPlanner, two_opt_every=0), 16),
    "fpa-2opt": (partial(FlowerPollinationPlanner, two_opt_every=5), 16),
    "ga-dp": (DeterministicRoutePlanner, 8),
    "ga-auv": (ConventionalRoutePlanner, 8),
}


def test_has_the_best_path_unchanged(evaluator, start):
    paths, fitness = start()
    best = AstarPlanner(max_waypoints=8).plan(evaluator, Options(generations=8))
    assert np.array_equal(paths[0], best.path)
    assert fitness[0] == best.evaluation.fitness


def test_has_varied_feasible_copies_and_random_paths(evaluator, start):
    paths, fitness = start(count=64)
    assert len(paths) == 64
    assert len({path.tobytes() for path in paths}) > 60
    assert (fitness > 1).sum() > 24
    assert len({len(path) for path in paths}) >= 3
    moved = [
        np.hypot(*(path[1:-1, :2] - paths[0][1:-1, :2]).T)
        for path in paths
        if len(path) == len(paths[0])
    ]
    least = [shift[shift > 0].min() for shift in moved if shift.any()]
    # Moves range from a thousandth of the 5 km to thirty times that.
    assert min(least) < 20
    assert max(shift.max() for shift in moved) > 100
    space = Airspace(evaluator.problem)
    for path in paths:
        assert np.array_equal(path[[0, -1]], [evaluator.problem.start, evaluator.problem.goal])
        assert ((path >= space.low) & (path <= space.high)).all()
    # The last eighth has two waypoints each.
    assert [len(path) for path in paths[-8:]] == [4] * 8
    assert (fitness[-8:] < 1).sum() >= 6


def test_a_fixed_number_of_waypoints(start):
    for count in (1, 7):
        paths, fitness = start(most=count, fewest=count)
        assert {len(path) for path in paths} == {count + 2}
        assert len(paths) == 16
    # One waypoint is not enough for this flight.
    assert fitness.max() > 1


def test_the_number_of_waypoints_stays_within_limits(start):
    paths, _ = start(count=60, most=4, fewest=2)
    assert {len(path) - 2 for path in paths} == {2, 3, 4}


def test_lengthened_paths_keep_their_fitness(evaluator, start):
    path, *_ = start()[0]
    flown = evaluator.evaluate(path)
    for more in (len(path) - 1, 20, 40):
        longer = lengthened(path, more, evaluator.problem.aircraft.turn_radius_m)
        assert len(longer) == more + 2
        again = evaluator.evaluate(longer)
        assert again.feasible
        assert again.fitness == pytest.approx(flown.fitness, rel=1e-9)
    assert lengthened(path, 1, 150.0) is path


def test_rounds_waypoints_up_to_the_lattice(evaluator, start):
    grid = ChipMap(Config(), evaluator.problem)
    paths, fitness = start(lattice=grid, fewest=2)
    assert paths
    for path in paths:
        inner = path[1:-1]
        assert np.array_equal(grid.to_metres(grid.to_cells(inner)), inner)
    # Rounding costs the best path at most one step of altitude.
    assert fitness[0] > 1
    assert fitness[0] > start(fewest=2)[1][0] - 0.01
    rng = np.random.default_rng(4)
    points = rng.uniform((0, 0, 100), (6000, 4000, 790), size=(200, 3))
    placed = on_lattice(points, grid)
    assert (np.abs(placed - points)[:, :2] <= 50).all()
    assert ((placed - points)[:, 2] >= 0).all()
    assert ((placed - points)[:, 2] < grid.step_m).all()
    outside = on_lattice(np.array([[-300.0, 9999.0, 5000.0]]), grid)
    assert outside.tolist() == [[0.0, 4000.0, grid.top_m]]


def test_same_seed_same_paths(start):
    first, again, other = (start(seed=seed)[0] for seed in (5, 5, 6))
    assert all(map(np.array_equal, first, again))
    assert np.array_equal(first[0], other[0])
    assert not all(map(np.array_equal, first, other))


def test_evaluates_and_keeps_the_found_path(evaluator):
    run = Run(evaluator, Options())
    paths = astar_paths(run, np.random.default_rng(0), 8, 8)
    assert run.evaluations > 4
    assert set(run.seconds) == {"search", "evaluation", "variation"}
    run.record(0, np.array([1.0]))
    assert np.array_equal(run.result().path, paths[0])


@pytest.mark.parametrize("name", PLANNERS)
def test_planners_start_from_the_search(evaluator, name):
    planner, waypoints = PLANNERS[name]
    alone = AstarPlanner(max_waypoints=waypoints).plan(evaluator, Options(generations=8)).evaluation
    options = Options(generations=20, seed=2)
    started, again = (planner(init="astar").plan(evaluator, options) for _ in range(2))
    assert np.array_equal(started.path, again.path)
    assert started.history == again.history
    best = [best for _, best, _ in started.history]
    # The chip's altitude steps cost a little.
    assert best[0] > alone.fitness - 0.002
    assert best == sorted(best)
    assert started.evaluation.feasible
    assert started.evaluation.fitness > alone.fitness
    assert planner().plan(evaluator, options).history[0][1] < alone.fitness - 0.02


@pytest.mark.parametrize(("waypoints", "most"), [(None, 16), (6, 6), (20, 20)])
def test_waypoints_of_a_fixed_number(evaluator, waypoints, most):
    """A found path with fewer waypoints keeps its course."""
    planner = FlowerPollinationPlanner(init="astar", waypoints=waypoints)
    result = planner.plan(evaluator, Options(generations=2, population=24))
    lengths = {len(path) - 2 for _, path in result.archive}
    assert max(lengths) == most


@pytest.mark.parametrize("name", PLANNERS)
def test_starts_at_random_without_a_way(make_evaluator, name):
    planner, _ = PLANNERS[name]
    evaluator = make_evaluator(zones=WALLS)
    options = Options(generations=2, seed=3)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        started = planner(init="astar").plan(evaluator, options)
    # It is proven that there is no path, and the plan's reason says so.
    assert caught == []
    assert started.history == planner().plan(evaluator, options).history


def test_refuses_another_start():
    assert check_init("astar")
    assert not check_init("random")
    for planner, _ in PLANNERS.values():
        with pytest.raises(InputError) as caught:
            planner(init="best")
        assert str(caught.value) == "The start must be random or astar, not 'best'."


def test_a_nudge_moves_one_or_two_neighbours_and_fits_the_altitudes(evaluator, start):
    paths, fitness = start()
    best, problem = paths[0], evaluator.problem
    vary = Variation(problem, np.random.default_rng(4), most=len(best), fewest=2)
    nudged = [vary.nudged(best) for _ in range(200)]
    assert {len(path) - len(best) for path in nudged} == {-1, 0, 1}
    sizes = []
    for path in nudged:
        if len(path) == len(best):
            moved = np.flatnonzero((path[:, :2] != best[:, :2]).any(axis=1))
            assert moved[-1] - moved[0] <= 1
            assert 0 < moved[0] <= moved[-1] < len(best) - 1
            sizes += np.hypot(*(path - best)[moved, :2].T).tolist()
    # Moves range from a ten-thousandth of the 5 km to three hundred times that.
    assert min(sizes) < 5
    assert max(sizes) > 100
    worth = np.array([evaluator.evaluate(path).fitness for path in nudged])
    assert (worth > 1).mean() > 0.8
    assert worth.max() > fitness[0]
    again = Variation(problem, np.random.default_rng(4), most=len(best), fewest=2)
    assert np.array_equal(again.nudged(best), nudged[0])


def test_a_nudge_stays_within_the_limits(evaluator, start):
    paths, _ = start()
    inner = len(paths[0]) - 2
    vary = Variation(evaluator.problem, np.random.default_rng(0), most=inner, fewest=inner)
    assert {len(vary.nudged(paths[0])) for _ in range(50)} == {inner + 2}


def test_refits_improve_the_found_path(evaluator):
    options = Options(generations=40, seed=5)
    alone = AstarPlanner().plan(evaluator, Options(generations=8)).evaluation.fitness
    with_refits, without = (
        PcGeneticPlanner(init="astar", refits=refits).plan(evaluator, options) for refits in (4, 0)
    )
    assert with_refits.evaluation.fitness > alone + 0.002
    assert with_refits.evaluation.fitness > without.evaluation.fitness + 0.001
    assert with_refits.evaluations == without.evaluations
    assert with_refits.seconds["refits"] > 0
    assert "refits" not in without.seconds
    assert PcGeneticPlanner(init="astar").refits == 2
    assert PcGeneticPlanner().refits == 0


@pytest.mark.parametrize(
    ("refits", "sentence"),
    [
        (-1, "The refits of a generation must be 0 or more, not -1."),
        (7, "A generation has 6 children, so there can be at most as many refits, not 7."),
    ],
)
def test_refuses_bad_refits(evaluator, refits, sentence):
    with pytest.raises(InputError) as caught:
        PcGeneticPlanner(refits=refits).plan(evaluator, Options(population=8))
    assert str(caught.value) == sentence
