"""Compiled kernels compared with the reference on random paths; bounds of the fitness."""

import math

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator, reference
from pathgene.host.evaluation.geometry import Arc, smooth
from pathgene.host.evaluation.kernels import BELOW_TWO, WORST_FITNESS, fitness_of
from pathgene.host.evaluation.laying import turn
from pathgene.host.evaluation.pieces import ARC_PARTS_IN_WIND
from pathgene.host.problem.zones import Circle, Polygon


ZONES = (Circle(2000, 2500, 700), Polygon(((3000, 500), (4500, 800), (3500, 2500))))
CLOSED_FORMS = ("length_m", "mean_altitude_m", "fuel_N", "distance_too_steep_m", "cost")
SAMPLED = ("distance_under_terrain_m", "distance_in_nofly_m", "void_crossed_m")

SETTINGS = {
    "plain": {},
    "zones": {"zones": ZONES},
    "wind": {"wind": (12.0, -9.0)},
    "everything": {"zones": ZONES, "wind": (-5.0, 3.0)},
    "coarse": {"ds_m": 333.0},
}


def hills(rng):
    """Return rough ground of 0 to 1000 m, 60 x 45 nodes of 100 x 120 m, with voids."""
    elevation = rng.uniform(0, 1000, (45, 60))
    elevation[rng.random(elevation.shape) < 0.03] = np.nan
    elevation[[0, -1], [0, -1]] = 100.0
    return elevation


def random_path(rng, start, goal):
    """Return a path of up to 14 waypoints near the map, with every degenerate case."""
    count = int(rng.integers(0, 15))
    spread = rng.choice([0.03, 0.3, 1.0])
    along = np.sort(rng.random(count))[:, None]
    points = np.array(start) + along * (np.array(goal) - np.array(start))
    points += spread * rng.uniform(-1, 1, (count, 3)) * (2000, 2000, 500)
    if rng.random() < 0.8:
        points[:, 0] = points[:, 0].clip(0, 5900)
        points[:, 1] = points[:, 1].clip(0, 5280)
    for i in range(1, count):
        kind = rng.random()
        if kind < 0.05:
            points[i] = points[i - 1]  # Repeated.
        elif kind < 0.1:
            points[i, :2] = points[i - 1, :2]  # A vertical hop.
        elif kind < 0.15 and i > 1:
            points[i] = points[i - 2]  # A reversal.
        elif kind < 0.2 and i > 1:
            points[i] = 2 * points[i - 1] - points[i - 2]  # Straight on.
        elif kind < 0.3:
            points[i] = points[i].round(-2)  # On nodes.
    return np.array([start, *points, goal])


@pytest.mark.parametrize("world", SETTINGS.values(), ids=SETTINGS.keys())
@pytest.mark.parametrize(
    ("seed", "count"),
    [(2024, 150), pytest.param(2025, 3000, marks=pytest.mark.long)],
    ids=["short", "long"],
)
def test_kernels_match_the_reference(make_problem, world, seed, count):
    rng = np.random.default_rng(seed)
    problem = make_problem((0, 0, 400), (5900, 5280, 500), hills(rng), dy_m=120.0, **world)
    evaluator = Evaluator(problem, threads=1)
    flips = 0
    for _ in range(count):
        path = random_path(rng, problem.start, problem.goal)
        expected = reference.evaluate(problem, path)
        terms = evaluator.evaluate(path)
        pieces = smooth(path, problem.aircraft.turn_radius_m).pieces
        for name in CLOSED_FORMS:
            assert getattr(terms, name) == pytest.approx(getattr(expected, name), rel=1e-12), name
        assert terms.impossible_arcs == expected.impossible_arcs
        # Samples on straight pieces are equal up to rounding, which rarely moves one across the
        # border of a cell; on arcs the sine may differ.
        arcs = sum(isinstance(piece, Arc) for piece in pieces)
        errors = [abs(getattr(terms, name) - getattr(expected, name)) for name in SAMPLED]
        assert max(errors) <= 1e-6 + (arcs + 1) * problem.ds_m
        flipped = max(errors) > 1e-6 + arcs * problem.ds_m
        flips += flipped
        if arcs == 0 and not flipped:
            assert terms.fitness == pytest.approx(expected.fitness, rel=1e-12)
    assert flips <= count // 1000


def test_samples_on_straight_pieces_are_the_same(make_problem):
    rng = np.random.default_rng(7)
    problem = make_problem(
        (0, 0, 400), (5900, 5280, 500), hills(rng), dy_m=120.0, zones=ZONES, ds_m=10.0
    )
    evaluator = Evaluator(problem, threads=1)
    line = np.array([problem.start, problem.goal])
    for _ in range(60):
        # Corners of such short legs are all impossible: straight pieces only, many on node borders.
        points = rng.integers(0, 59, (12, 3)) * (100, 60, 17.0) + rng.choice([0, 50, 0.5], (12, 1))
        path = np.concatenate((line[:1], points.repeat(2, axis=0), line[1:]))
        expected = reference.evaluate(problem, path)
        terms = evaluator.evaluate(path)
        assert terms.impossible_arcs == 24
        for name in SAMPLED:
            assert getattr(terms, name) == pytest.approx(getattr(expected, name), rel=1e-12), name


@pytest.mark.parametrize("angle", [1e-9, 1e-3, 0.7, 1.57, math.pi / 2, 1.58, 2.5, 3.14])
@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("lengths", [(1000.0, 0.01), (3.0, 20000.0)])
def test_tangent_of_a_turn(angle, side, lengths):
    """The tangent of sharp and slight turns is the radius times the tangent of half the angle."""
    for heading in np.linspace(0, 2 * math.pi, 50):
        (ax, ay), (bx, by) = (
            (run * math.cos(to), run * math.sin(to))
            for run, to in zip(lengths, (heading, heading + side * angle), strict=True)
        )
        found = turn(ax, ay, bx, by, *lengths, 150.0)
        # Error of the angle by rounding of the headings.
        error = 4e-16 / angle + 4e-16 / (math.pi - angle)
        expected = angle, side, 150 * math.tan(angle / 2)
        assert found == pytest.approx(expected, rel=4 * error)


@pytest.mark.parametrize("length_m", [10.0, 1e3, 1e5, 1e6])
@pytest.mark.parametrize("slope", [-0.3, -0.07, 0.0, 0.0729, 0.073, 0.2, 5.0])
def test_fuel_by_the_series_and_in_closed_form(make_problem, length_m, slope):
    """Both agree on glides, at the sign change of the discriminant, and on hour-long pieces."""
    problem = make_problem((0, 0, 200), (4000, 0, 250), ds_m=50.0)
    path = np.array([problem.start, (length_m, 0.0, 200 + slope * length_m), problem.goal])
    terms = Evaluator(problem, threads=1).evaluate(path)
    expected = reference.evaluate(problem, path)
    assert terms.fuel_N == pytest.approx(expected.fuel_N, rel=1e-13)
    assert terms.distance_too_steep_m == expected.distance_too_steep_m


@pytest.mark.parametrize("beyond", [-2e-9, -1e-12, 0.0, 0.9e-9, 1.1e-9, 1e-6])
def test_slopes_about_the_limits(make_problem, beyond):
    """A climb or descent within the tolerance of the limit can be flown."""
    problem = make_problem((0, 0, 800), (4000, 0, 800), ds_m=50.0)
    climb, descent = (
        math.radians(limit) + beyond
        for limit in (problem.aircraft.max_climb_deg, problem.aircraft.max_descent_deg)
    )
    for rise in (200 * math.tan(climb), -200 * math.tan(descent)):
        path = np.array([problem.start, (200, 0, 800 + rise), problem.goal])
        steep = Evaluator(problem, threads=1).evaluate(path).distance_too_steep_m
        assert (steep > 200) == (beyond > 1e-9)


def test_parts_of_an_arc_are_those_of_the_reference():
    assert ARC_PARTS_IN_WIND == Arc.PARTS_IN_WIND


@pytest.mark.parametrize(
    ("penalty", "cost", "fitness"),
    [
        (0.0, 1.0, 1.5),
        (0.0, 3.0, 1.25),
        (1.0, 1.0, 0.5),
        (999.0, 0.1, 0.001),
        (1e-300, 1.0, 1.0),
        (0.0, 1e300, 1.0),
        (0.0, math.inf, 1.0),
        (0.0, 1e-300, BELOW_TWO),
        (0.0, 0.0, BELOW_TWO),
        (0.0, -1.0, BELOW_TWO),
        (math.inf, math.inf, WORST_FITNESS),
        (math.nan, 1.0, WORST_FITNESS),
        (0.0, math.nan, WORST_FITNESS),
        (1.0, math.nan, WORST_FITNESS),
    ],
)
def test_fitness_stays_inside_its_range(penalty, cost, fitness):
    assert fitness_of(penalty, cost) == fitness
    assert 0 < fitness < 2
