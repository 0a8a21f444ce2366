"""Paths that the evaluation of the papers calls feasible and no aircraft should fly."""

import dataclasses
import math

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.problem import aircraft
from pathgene.host.problem.zones import Circle, Polygon


START, GOAL = (500.0, 2500.0, 200.0), (4500.0, 2500.0, 200.0)
FOX = aircraft.load("silver-fox")


@pytest.fixture
def verdicts(make_problem):
    """Function that returns evaluations of a straight flight in paper mode and by the rules."""

    def judge(start=START, goal=GOAL, path=None, **options):
        found = []
        for as_paper in (True, False):
            problem = make_problem(start, goal, as_paper=as_paper, **options)
            flown = np.array([start, goal] if path is None else path)
            found.append(Evaluator(problem, threads=1).evaluate(flown))
        return found

    return judge


def broken(evaluation):
    """Return the names of broken limits, worst first."""
    at_least = ("clearance", "zone", "turn", "stall")
    return [
        limit["limit"]
        for limit in evaluation.limits
        if (limit["worst"] < limit["allowed"] - 1e-6) == (limit["limit"].split()[0] in at_least)
        and abs(limit["worst"] - limit["allowed"]) > 1e-6
    ]


def ring(west, south, east, north):
    return ((west, south), (east, south), (east, north), (west, north))


@pytest.mark.parametrize(
    ("zone", "y"),
    [
        (Circle(2550.0, 2550.0, 70.0, name="mast"), 2500.0),
        (Polygon(ring(2510.0, -100.0, 2590.0, 5100.0), name="mast"), 2500.0),
        (Polygon(ring(2000.0, 2401.0, 3000.0, 2499.0), name="mast"), 2454.0),
    ],
    ids=["circle of 70 m between nodes", "wall 80 m wide", "45 m inside an edge"],
)
def test_zones_between_nodes(verdicts, zone, y):
    paper, safe = verdicts((500.0, y, 200.0), (4500.0, y, 200.0), zones=[zone])
    assert paper.feasible
    assert not safe.feasible
    assert safe.distance_in_nofly_m > 70
    assert broken(safe) == ["zone mast"]


def test_heights_of_zones(verdicts):
    for limits, feasible in (
        ({"upper_m": 170.0}, True),
        ({"upper_m": 180.0}, False),
        ({"lower_m": 230.0}, True),
        ({"lower_m": 220.0}, False),
    ):
        paper, safe = verdicts(zones=[Circle(2500.0, 2500.0, 400.0, **limits)])
        assert not paper.feasible
        assert safe.feasible == feasible, limits


def test_fuel_and_power(verdicts):
    paper, safe = verdicts(aircraft=dataclasses.replace(FOX, fuel_weight_N=0.02))
    assert paper.feasible
    assert broken(safe) == ["fuel"]
    assert safe.fuel_left_N < 0
    # With a reserve of a tenth, the whole tank is not enough.
    paper, safe = verdicts(aircraft=dataclasses.replace(FOX, fuel_weight_N=paper.fuel_N))
    assert broken(safe) == ["fuel"]
    assert safe.distance_beyond_limits_m == pytest.approx(0.1 * safe.length_m)
    weak = dataclasses.replace(FOX, engine_power_W=10.0)
    paper, safe = verdicts(goal=(4500.0, 2500.0, 500.0), aircraft=weak)
    assert paper.feasible
    assert broken(safe) == ["power"]
    assert safe.distance_beyond_limits_m == pytest.approx(safe.length_m)


def test_wind_changes_climb_and_turns(verdicts):
    climb = (4500.0, 2500.0, 200.0 + 4000 * math.tan(math.radians(9.9)))
    for wind, feasible in (((21.6, 0.0), False), ((-21.6, 0.0), True), ((0.0, 0.0), True)):
        paper, safe = verdicts(goal=climb, wind=wind)
        assert paper.feasible
        assert safe.feasible == feasible, wind
        assert broken(safe) == ([] if feasible else ["climb"])
    # A right angle with room for 150 m, but not for 150 * (1 + 21.6 / 23)^2 = 564 m.
    corner = [(500.0, 2500.0, 200.0), (1000.0, 2500.0, 200.0), (1000.0, 3000.0, 200.0)]
    paper, safe = verdicts(corner[0], corner[2], corner, wind=(0.0, 21.6))
    assert paper.feasible
    assert broken(safe) == ["turn"]
    (turn,) = (limit for limit in safe.limits if limit["limit"] == "turn")
    assert (turn["worst"], turn["allowed"]) == pytest.approx((500.0, 150 * (1 + 21.6 / 23) ** 2))


def test_stall_forbids_turns_alone(verdicts):
    heavy = dataclasses.replace(FOX, lift_coefficient_max=0.46)
    corner = [(500.0, 2500.0, 200.0), (2500.0, 2500.0, 200.0), (2500.0, 4500.0, 200.0)]
    paper, safe = verdicts(corner[0], corner[2], corner, aircraft=heavy)
    assert paper.feasible
    assert broken(safe) == ["stall"]
    assert verdicts(aircraft=heavy)[1].feasible


@pytest.mark.parametrize(
    "zones",
    [
        [Circle(2550.0, 2550.0, 70.0)],
        [Polygon(ring(2510.0, 1000.0, 2590.0, 4000.0))],
        [Polygon(ring(2510.0, -100.0, 2590.0, 5100.0), upper_m=250.0)],
    ],
    ids=["circle", "wall with ways around", "wall to fly over"],
)
def test_planner_avoids_what_it_did_not_see(make_problem, zones):
    problem = make_problem(START, GOAL, as_paper=False, zones=zones)
    result = make("astar").plan(Evaluator(problem, threads=1), Options())
    assert result.evaluation.feasible
