"""Stretches of paths that break limits, compared with hand calculations and the verdict."""

import dataclasses

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem import aircraft
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon


START, GOAL = (500.0, 2500.0, 300.0), (4500.0, 2500.0, 300.0)
STRAIGHT = np.array([START, GOAL])


def broken(problem, path=STRAIGHT):
    evaluator = Evaluator(problem, threads=1)
    stretches = evaluator.broken(np.array(path))
    assert (not stretches) == evaluator.evaluate(np.array(path)).feasible
    return [(each.limit, pytest.approx((each.from_m, each.to_m))) for each in stretches]


def test_nothing_is_broken_by_a_feasible_path_or_as_paper(make_problem):
    assert broken(make_problem(START, GOAL, rules=Rules())) == []
    paper = make_problem(START, GOAL, zones=[Circle(2500, 2500, 300)])
    assert Evaluator(paper, threads=1).broken(STRAIGHT) == []


def test_zones_are_left_where_they_end_with_their_margin(make_problem):
    zones = [
        Circle(2500, 2500, 300, name="town"),
        Polygon(((3500, 2400), (3600, 2400), (3600, 2600), (3500, 2600))),
        Circle(1500, 2500, 300, upper_m=200),
    ]
    assert broken(make_problem(START, GOAL, zones=zones, rules=Rules())) == [
        ("zone town", (1675, 2325)),
        ("zone 2", (2975, 3125)),
    ]


def test_a_hill_is_too_high_in_whole_parts(make_problem):
    heights = np.full((51, 51), 100.0)
    heights[:, 25] = 280.0
    problem = make_problem(START, GOAL, heights, rules=Rules(corridor_m=0), ds_m=50)
    ((name, span),) = broken(problem)
    assert name == "clearance"
    # The square reaches 50 m from its node, its western edge included; parts of 50 m count whole.
    assert span == (1900, 2050)


def test_ceilings_are_exact(make_problem):
    path = [START, (2500.0, 2500.0, 500.0), GOAL]
    problem = make_problem(START, GOAL, rules=Rules(ceiling_m=400))
    half = np.hypot(2000, 200)
    assert broken(problem, path) == [("ceiling", (half / 2, 1.5 * half))]
    low = dataclasses.replace(aircraft.load("silver-fox"), service_ceiling_m=400)
    problem = make_problem(START, GOAL, aircraft=low, rules=Rules())
    assert broken(problem, path) == [("service-ceiling", (half / 2, 1.5 * half))]


def test_slopes_are_named_by_their_direction(make_problem):
    path = [START, (1500.0, 2500.0, 900.0), GOAL]
    problem = make_problem(START, GOAL, rules=Rules())
    assert broken(problem, path) == [
        ("climb", (0, np.hypot(1000, 600))),
        ("power", (0, np.hypot(1000, 600))),
    ]
    path = [START, (3500.0, 2500.0, 900.0), GOAL]
    assert "descent" in [name for name, _ in broken(problem, path)]


def test_fuel_and_power(make_problem):
    fox = aircraft.load("silver-fox")
    burned = Evaluator(make_problem(START, GOAL, rules=Rules()), threads=1).evaluate(STRAIGHT)
    small = dataclasses.replace(fox, fuel_weight_N=burned.fuel_N / 2)
    problem = make_problem(START, GOAL, rules=Rules(reserve=0.0), aircraft=small)
    ((name, span),) = broken(problem)
    assert name == "fuel"
    assert span == (2000, 4000)
    weak = dataclasses.replace(fox, engine_power_W=10.0)
    assert broken(make_problem(START, GOAL, rules=Rules(), aircraft=weak)) == [("power", (0, 4000))]


def test_a_turn_that_does_not_fit_is_marked_around_its_waypoint(make_problem):
    path = [START, (2500.0, 2500.0, 300.0), (2500.0, 2520.0, 300.0), GOAL]
    names = {name for name, _ in broken(make_problem(START, GOAL, rules=Rules()), path)}
    assert names == {"turn"}


def test_off_the_map(make_problem):
    path = [START, (2500.0, -900.0, 300.0), GOAL]
    names = {name for name, _ in broken(make_problem(START, GOAL, rules=Rules()), path)}
    assert "map" in names


def test_agrees_with_the_verdict_on_random_paths(make_problem):
    rng = np.random.default_rng(5)
    zones = [
        Circle(1500, 1500, 300),
        Circle(3300, 2500, 500, upper_m=420, t0_s=20, t1_s=90),
        Polygon(((2000, 3000), (2600, 3300), (2200, 4000)), lower_m=350),
    ]
    heights = 100 + 150 * rng.random((51, 51))
    problem = make_problem(
        START, GOAL, heights, zones=zones, rules=Rules(ceiling_agl_m=350), wind=(5.0, 3.0)
    )
    evaluator = Evaluator(problem, threads=1)
    feasible = 0
    for _ in range(300):
        inner = rng.uniform((1000, 1500, 280), (4200, 4000, 420), (2, 3))
        inner = inner[np.argsort(inner[:, 0])]
        path = np.array([START, *inner, GOAL])
        evaluation = evaluator.evaluate(path)
        stretches = evaluator.broken(path)
        assert (not stretches) == evaluation.feasible
        feasible += evaluation.feasible
        named = {each.limit for each in stretches}
        assert all(0 <= s.from_m < s.to_m <= evaluation.length_m + 1e-6 for s in stretches)
        zone_m = sum(s.to_m - s.from_m for s in stretches if s.limit.startswith("zone"))
        assert zone_m == pytest.approx(evaluation.distance_in_nofly_m, abs=1e-3)
        assert ("turn" in named) == (evaluation.impossible_arcs > 0)
    assert 10 < feasible < 290
