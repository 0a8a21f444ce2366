"""Safe flight by hand: headings, timed zones, and paths that no aircraft should fly."""

import dataclasses
import math

import numpy as np
import pytest

from pathgene.host.evaluation import Arc, Evaluator, Straight
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.problem import aircraft
from pathgene.host.problem.rules import Rules
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


def test_a_metre_in_several_zones_counts_once_in_the_report(verdicts):
    ends = (500.0, 2500.0, 200.0), (4500.0, 2500.0, 200.0)
    parts = [Polygon(ring(1000.0, 2000.0, 2200.0, 3000.0)), Circle(2200.0, 2500.0, 700.0)]
    apart = Polygon(ring(3500.0, 2000.0, 3600.0, 3000.0))
    _, safe = verdicts(*ends, zones=[*parts, apart])
    # With the margin of 25 m: from 975 to 2,925 m, and from 3,475 to 3,625 m.
    assert safe.distance_in_nofly_m == pytest.approx(1950 + 150, abs=1e-3)
    assert safe.penalty == pytest.approx(1250 + 1450 + 150, abs=1e-3)
    _, whole = verdicts(*ends, zones=parts[:1])
    _, twice = verdicts(*ends, zones=parts[:1] * 2)
    assert twice.distance_in_nofly_m == pytest.approx(whole.distance_in_nofly_m, abs=1e-6)
    assert whole.distance_in_nofly_m == whole.penalty == pytest.approx(1250, abs=1e-3)


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


HIGH_START, HIGH_GOAL = (500.0, 2500.0, 300.0), (4500.0, 2500.0, 300.0)
EAST, NORTH, WEST = (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)


def test_a_turn_at_the_start_is_an_arc_like_any_other():
    """From north to east, it is a quarter turn right that begins a radius before the start."""
    smoothed = smooth(np.array([HIGH_START, HIGH_GOAL]), 150.0, (NORTH, None))
    arc, straight = smoothed.pieces
    assert isinstance(arc, Arc)
    assert isinstance(straight, Straight)
    assert (smoothed.arcs, smoothed.impossible_arcs) == (1, 0)
    assert arc.start == pytest.approx((500, 2350, 300))
    assert arc.turn_rad == pytest.approx(-np.pi / 2)
    assert straight.start == pytest.approx((650, 2500, 300))


def test_a_turn_at_the_goal_ends_beyond_it():
    smoothed = smooth(np.array([HIGH_START, HIGH_GOAL]), 150.0, (None, NORTH))
    assert smoothed.pieces[-1].points(np.ones(1))[0] == pytest.approx((4500, 2650, 300))


@pytest.mark.parametrize("heading", [WEST, (-0.1, 0.995)])
def test_a_turn_beyond_a_right_angle_does_not_fit_at_an_end(heading):
    for headings in ((heading, None), (None, heading)):
        smoothed = smooth(np.array([HIGH_START, HIGH_GOAL]), 150.0, headings)
        assert (smoothed.arcs, smoothed.impossible_arcs) == (1, 1)


def test_a_turn_at_the_start_needs_room_in_the_first_segment():
    for first, impossible in (((740.0, 2500.0, 300.0), 1), ((820.0, 2500.0, 300.0), 0)):
        corner = np.array([HIGH_START, first, (first[0], 3500.0, 300.0)])
        assert bool(smooth(corner, 150.0, (NORTH, None)).impossible_arcs) == impossible


def test_headings_count_in_the_evaluation(make_problem):
    path = np.array([HIGH_START, HIGH_GOAL])
    evaluations = [
        Evaluator(
            make_problem(HIGH_START, HIGH_GOAL, rules=Rules(), start_heading_deg=heading), threads=1
        ).evaluate(path)
        for heading in (None, 90, 0, 180, 270)
    ]
    free, along, left, right, back = evaluations
    assert along.length_m == free.length_m == pytest.approx(4000)
    # A quarter of 150 m instead of 150 m.
    assert left.length_m == pytest.approx(4000 - 150 + 75 * np.pi)
    assert right.length_m == pytest.approx(left.length_m)
    assert [each.feasible for each in evaluations] == [True, True, True, True, False]
    assert back.impossible_arcs == 1
    assert back.limits[0]["limit"] == "turn"


def test_a_zone_counts_while_it_is_active(make_problem):
    """At 23 m/s, the aircraft is in the zone from 1,725 to 2,275 m: from 75.0 to 98.9 s."""
    path = np.array([HIGH_START, HIGH_GOAL])
    lengths = np.array([2])
    for times, inside in (
        ({}, True),
        ({"t0_s": 98}, True),
        ({"t0_s": 99}, False),
        ({"t1_s": 75.1}, True),
        ({"t1_s": 74.9}, False),
        ({"t1_s": 10}, False),
    ):
        zone = Circle(2500, 2500, 250, **times)
        evaluator = Evaluator(
            make_problem(HIGH_START, HIGH_GOAL, zones=[zone], rules=Rules()), threads=1
        )
        evaluation = evaluator.evaluate(path)
        assert evaluation.feasible is not inside, times
        assert bool(evaluation.distance_in_nofly_m > 0) is inside
        fitness = evaluator.fitness(path[None], lengths)[0]
        assert bool(fitness > 1) is not inside


def test_kernels_without_time_take_a_timed_zone_as_always_active(make_problem):
    zone = Circle(2500, 2500, 250, t0_s=1000)
    evaluator = Evaluator(
        make_problem(HIGH_START, HIGH_GOAL, zones=[zone], rules=Rules()), threads=1
    )
    zoned = evaluator.course.zoned
    assert np.isnan(zoned).sum() == evaluator.problem.blocked_raster.sum() > 0
    assert not evaluator.problem.nofly_raster.any()
