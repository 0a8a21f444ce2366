"""Cases in which one condition of the strict rule decides alone; `make coverage` counts them."""

import dataclasses
import math

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator, reference
from pathgene.host.evaluation import laying as fields
from pathgene.host.evaluation.aircraft_limits import CLIMB, POWER, STALL, line_limits
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.evaluation.kernels import fitness_above, path_terms, scratch
from pathgene.host.evaluation.laid_track import lay_pieces
from pathgene.host.evaluation.pieces import collided_m, parts_of, piece_hits
from pathgene.host.evaluation.zones import pack_zones, zone_metres
from pathgene.host.problem import aircraft
from pathgene.host.problem.rings import EDGE_M
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from tests.support.host.random_flights import CRUISE_M_S, piece_rows, piece_times


START, GOAL = (500.0, 2500.0, 300.0), (4500.0, 2500.0, 300.0)
MIDDLE = (2500.0, 2500.0, 300.0)
FOX = aircraft.load("silver-fox")


@pytest.fixture
def judge(make_problem):
    """Function that returns an evaluator under rules, of one thread."""

    def evaluator(start=START, goal=GOAL, heights=None, *, rules=None, **options):
        problem = make_problem(start, goal, heights, rules=rules or Rules(), **options)
        return Evaluator(problem, threads=1)

    return evaluator


def broken(evaluator, *inner):
    """Return the stretches of a path through some points that break a limit."""
    problem = evaluator.problem
    path = np.array([problem.start, *inner, problem.goal])
    found = evaluator.broken(path)
    assert (not found) == evaluator.evaluate(path).feasible
    return [(each.limit, pytest.approx((each.from_m, each.to_m), abs=1e-3)) for each in found]


def names(evaluator, *inner):
    return [name for name, _ in broken(evaluator, *inner)]


# --- Terrain -------------------------------------------------------------------------------------


def test_a_take_off_needs_less_clearance_than_the_flight(judge):
    start = (500.0, 2500.0, 110.0)
    assert names(judge(start), (1700.0, 2500.0, 280.0)) == []
    # As low over the middle of the way.
    low = [(1500.0, 2500.0, 300.0), (2500.0, 2500.0, 110.0), (3800.0, 2500.0, 300.0)]
    assert names(judge(), *low) == ["clearance"]


def test_two_hills_are_two_stretches(judge):
    heights = np.full((51, 51), 100.0)
    heights[:, [20, 30]] = 280.0
    found = broken(judge(heights=heights, rules=Rules(corridor_m=0), ds_m=10.0))
    assert [name for name, _ in found] == ["clearance", "clearance"]


def test_an_arc_over_a_slope_keeps_its_clearance_to_a_centimetre(judge):
    """The slope rises to the east, and the arc ends at x = 990 m, over ground at 297 m."""
    heights = np.tile(120.0 * np.arange(11), (11, 1))
    for z, is_kept in ((327.005, True), (326.995, False)):
        start, goal = (300.0, 900.0, z), (990.0, 2900.0, z)
        evaluator = judge(start, goal, heights, rules=Rules(corridor_m=0), dx_m=400.0, dy_m=400.0)
        found = names(evaluator, (990.0, 900.0, z))
        assert set(found) == (set() if is_kept else {"clearance"})


@pytest.mark.parametrize("wind", [(0.0, 0.0), (5.0, 0.0)])
def test_a_climb_on_the_spot_is_a_piece(judge, wind):
    rules = Rules(ceiling_agl_m=300)
    for high, too_high in ((390.0, False), (410.0, True)):
        evaluator = judge(rules=rules, wind=wind)
        found = names(evaluator, MIDDLE, (2500.0, 2500.0, high), (2510.0, 2500.0, 300.0))
        assert ("ceiling-agl" in found) == too_high
        assert "climb" in found
        assert "turn" in found


def test_the_ceiling_over_ground_counts_along_given_pieces(judge):
    path = np.array([START, GOAL])
    for rules, too_high in ((Rules(ceiling_agl_m=150), True), (Rules(), False)):
        rows, _ = lay_pieces(smooth(path, 150.0).pieces, 23.0)
        metres = judge(rules=rules)._strict.off_demand_m(rows)
        assert metres == pytest.approx(4000.0 if too_high else 0.0)


def test_a_ceiling_is_broken_where_the_path_is_above_it(judge):
    inner = [(1000.0, 300.0), (2000.0, 450.0), (3000.0, 450.0), (4200.0, 300.0)]
    evaluator = judge(rules=Rules(ceiling_m=400))
    ((name, _),) = broken(evaluator, *((x, 2500.0, z) for x, z in inner))
    assert name == "ceiling"


# --- Zones ---------------------------------------------------------------------------------------


def test_a_zone_that_the_path_touches_at_a_place_is_not_entered(judge):
    """Both crossings with the border are the same place."""
    radius = 2400.0
    centre = 2500.0 - (radius + EDGE_M)
    assert 2500.0 - centre == radius + EDGE_M
    zone = Circle(2500.0, centre, radius, name="lake")
    evaluator = judge(goal=(4600.0, 2300.0, 300.0), zones=[zone], rules=Rules(zone_margin_m=0))
    assert names(evaluator, (4000.0, 2500.0, 300.0)) == []
    assert (
        evaluator.entered(np.array([START, (4000.0, 2500.0, 300.0), evaluator.problem.goal])) == []
    )
    # It is entered afterwards.
    inner = (4000.0, 2500.0, 300.0), (3300.0, 1500.0, 300.0)
    assert "zone lake" in names(evaluator, *inner)
    assert evaluator.entered(np.array([START, *inner, evaluator.problem.goal])) == [zone]


def test_a_zone_of_no_height_is_not_lost():
    path = np.array([(0.0, 0.0, 50.0), (400.0, 0.0, 50.0)])
    pieces, rows = piece_rows(path, 30.0)
    times = piece_times(pieces, rows)
    for upper_m, expected in ((50 + 1e-6, 200.0), (50 - 0.5e-6, 0.0)):
        packed = pack_zones([Circle(200, 0, 100, lower_m=50 - 1e-6, upper_m=upper_m)], 0)
        assert zone_metres(pieces, rows, times, packed) == pytest.approx(expected, abs=1e-4)


def test_an_arc_without_an_air_distance_counts_whole_while_the_zone_is_active():
    path = np.array([(0.0, 0.0, 50.0), (400.0, 0.0, 50.0), (400.0, 400.0, 50.0)])
    pieces, times = lay_pieces(smooth(path, 100.0).pieces, 20.0)
    arc = 50 * math.pi
    # The arc takes from 15.0 to 22.9 s, the path 37.9 s.
    for (t0, t1), expected in (
        ((None, 10.0), 200.0),
        ((16.0, 17.0), arc),
        ((14.0, 15.5), 20.0 + arc),
        ((30.0, None), 20 * (times[-1] - 30)),
    ):
        packed = pack_zones([Circle(200, 200, 5000, t0_s=t0, t1_s=t1)], 0)
        found = zone_metres(pieces, len(pieces), times, packed)
        assert found == pytest.approx(expected, abs=1e-4)


def test_an_arc_that_no_part_of_can_be_timed_counts_whole():
    path = np.array([(0.0, 0.0, 50.0), (400.0, 0.0, 50.0), (400.0, 400.0, 50.0)])
    pieces, rows = piece_rows(path, 100.0)
    times = piece_times(pieces, rows)
    pieces[2, fields.AIR] *= 0.9
    arc, begin = 50 * math.pi, times[2]
    for wind, (t0, t1), expected in (
        ((0.0, 1.0), (1e6, None), 0.0),
        ((0.0, 99.0), (1e6, None), arc),
        ((0.0, 1.0), (0.0, 1e6), pieces[:rows, fields.LENGTH].sum()),
        # The first part of eight.
        ((0.0, 1.0), (begin, begin + 0.01), arc / 8),
        ((0.0, 1.0), (None, begin - 1), begin * CRUISE_M_S - CRUISE_M_S),
    ):
        packed = pack_zones([Circle(200, 200, 5000, t0_s=t0, t1_s=t1)], 0, wind)
        assert zone_metres(pieces, rows, times, packed) == pytest.approx(expected)


# --- Headings and slopes -------------------------------------------------------------------------


def test_headings_of_both_ends_turn_the_path(judge):
    lengths = {
        heading: judge(goal_heading_deg=heading).evaluate(np.array([START, GOAL])).length_m
        for heading in (None, 90, 0, 180)
    }
    assert lengths[None] == pytest.approx(4000)
    assert lengths[90] == pytest.approx(4000)
    assert lengths[0] == lengths[180] == pytest.approx(4000 - 150 + 75 * math.pi)
    assert names(judge(goal_heading_deg=0)) == []


def test_a_turn_that_does_not_fit_at_an_end_is_broken_there(judge):
    assert broken(judge(start_heading_deg=270)) == [("turn", (0, 150))]
    assert broken(judge(goal_heading_deg=270)) == [("turn", (3850, 4000))]


def test_given_pieces_are_laid_as_the_kernels_lay_a_path(judge):
    evaluator = judge(goal_heading_deg=0)
    path = np.array([START, (1500.0, 3000.0, 310.0), (3000.0, 2200.0, 320.0), GOAL])
    smoothed = smooth(path, 150.0, evaluator.problem.headings)
    rows, times = lay_pieces(smoothed.pieces, 23.0)
    track = evaluator._strict.lay(path)
    flown = track.pieces[: track.rows][track.pieces[: track.rows, fields.LENGTH] > 0]
    geometry = [fields.X, fields.Y, fields.Z, fields.UX, fields.UY, fields.SIDE, fields.ANGLE]
    assert rows[:, geometry] == pytest.approx(flown[:, geometry], abs=1e-6)
    assert set(rows[:, fields.SIDE]) == {-1.0, 1.0}
    assert times[-1] == pytest.approx(track.time_s)


@pytest.mark.parametrize(
    ("wind", "slope_deg", "flyable"),
    [
        ((22.9, 0.0), 0.0, True),
        ((22.9, 0.0), 5.0, True),
        # Through the air, 23 m/s are less than 22.9 m/s over the ground.
        ((22.9, 0.0), 6.0, False),
        ((0.0, -22.9), 6.0, False),
    ],
)
def test_a_climb_across_or_against_the_wind_may_be_impossible(judge, wind, slope_deg, flyable):
    """To the north, within the steepest climb of 10 degrees."""
    top = 300 + 1000 * math.tan(math.radians(slope_deg))
    evaluator = judge((2500.0, 500.0, 300.0), (2500.0, 2500.0, 300.0), wind=wind)
    path = np.array([evaluator.problem.start, (2500.0, 1500.0, top), evaluator.problem.goal])
    evaluation = evaluator.evaluate(path)
    assert (evaluation.distance_too_steep_m == 0) == flyable


@pytest.mark.parametrize("is_left", [True, False])
def test_a_climbing_arc_may_be_impossible_at_an_end_alone(judge, is_left):
    """The arc is steeper than its legs, and across the wind at its start or at its end."""
    slope = math.tan(math.radians(5))
    corner = (2500.0, 1000.0, 200 + 2000 * slope)
    start, goal = (500.0, 1000.0, 200.0), (2500.0, 3500.0, corner[2] + 2500 * slope)
    if not is_left:
        start, corner, goal = (
            (x, y, z)
            for x, y, z in (
                (1000.0, 500.0, 200.0),
                (1000.0, 2500.0, 200 + 2000 * slope),
                (3500.0, 2500.0, 200 + 4500 * slope),
            )
        )
    evaluator = judge(start, goal, wind=(0.0, 22.9))
    path = np.array([start, corner, goal])
    evaluation = evaluator.evaluate(path)
    assert evaluation.impossible_arcs == 0
    expected = reference.evaluate(evaluator.problem, path).distance_too_steep_m
    assert evaluation.distance_too_steep_m == pytest.approx(expected)
    assert expected > 0


def test_a_climbing_arc_may_be_impossible_in_its_middle(judge):
    """There the arc is across the wind, and its legs are not."""
    tangent = math.tan(math.radians(15))
    path = np.array(
        [
            (500.0, 900.0, 200.0),
            (2000.0, 900.0 - 1500 * tangent, 420.0),
            (3500.0, 900.0, 640.0),
            (3500.0, 4500.0, 640.0),
        ]
    )
    evaluator = judge(tuple(path[0]), tuple(path[-1]), wind=(0.0, 22.9))
    evaluation = evaluator.evaluate(path)
    assert evaluation.impossible_arcs == 0
    expected = reference.evaluate(evaluator.problem, path).distance_too_steep_m
    assert evaluation.distance_too_steep_m == pytest.approx(expected)
    assert expected > 0


# --- Several paths -------------------------------------------------------------------------------


def test_the_first_kept_path_breaks_no_limit_at_all(judge):
    good = [START, MIDDLE, (3500.0, 2500.0, 300.0), GOAL]
    bad = {
        "length": [START] * 4,
        "turn": [START, MIDDLE, (2500.0, 2520.0, 300.0), GOAL],
        "descent": [START, MIDDLE, (2600.0, 2500.0, 210.0), GOAL],
        "ceiling": [START, MIDDLE, (3500.0, 2500.0, 420.0), GOAL],
        "zone": [START, (1500.0, 2700.0, 300.0), (3500.0, 2700.0, 300.0), GOAL],
        "clearance": [START, (1700.0, 2500.0, 120.0), (3000.0, 2500.0, 300.0), GOAL],
        "ceiling-agl": [START, (1500.0, 2500.0, 350.0), (2500.0, 2500.0, 390.0), GOAL],
    }
    zone = Circle(2500.0, 2900.0, 300.0)
    for agl in (280.0, None):
        evaluator = judge(zones=[zone], rules=Rules(ceiling_m=410, ceiling_agl_m=agl))
        lengths = np.array([4, 4])
        for name, path in bad.items():
            is_bad = agl is not None or name != "ceiling-agl"
            both = np.array([path, good])
            assert evaluator.first_feasible(both, lengths) == int(is_bad), name
            assert (evaluator.first_feasible(both[:1], lengths[:1]) is None) == is_bad
            penalty, cost = evaluator.penalty_cost(both, lengths, fine=True)
            assert (penalty > 0).tolist() == [is_bad, False], name
            assert np.isinf(cost[0]) == (name == "length")


def test_a_path_that_is_no_path_has_an_infinite_penalty(judge):
    good = np.array([START, MIDDLE, GOAL])
    for zones in ((), [Circle(2500.0, 2500.0, 100.0, t0_s=1000.0)]):
        evaluator = judge(zones=zones)
        assert bool(evaluator.problem.zones_at_times) == bool(zones)
        wrong = good.copy()
        wrong[1, 2] = math.nan
        paths, lengths = np.array([wrong, good, [START] * 3]), np.full(3, 3)
        for fine in (False, True):
            penalty, cost = evaluator.penalty_cost(paths, lengths, fine=fine)
            assert np.isinf(penalty).tolist() == np.isinf(cost).tolist() == [True, False, True]
            assert penalty[1] == 0


def test_a_candidate_is_left_at_the_first_term_that_is_too_much(make_problem):
    """The value is a bound until the last term that can be broken has been summed."""
    heights = np.full((51, 51), 100.0)
    heights[:, 25] = 350.0
    turn_back = [START, MIDDLE, (2500.0, 2520.0, 300.0), GOAL]
    steep = [START, MIDDLE, (2600.0, 2500.0, 900.0), GOAL]
    hill = [START, MIDDLE, (3500.0, 2500.0, 300.0), GOAL]
    for goal_heading_deg in (None, 0):
        problem = make_problem(
            START, GOAL, heights, rules=Rules(), goal_heading_deg=goal_heading_deg
        )
        evaluator = Evaluator(problem, threads=1)
        for path in (turn_back, steep, hill, [START] * 4):
            path = np.array(path)
            (whole,) = evaluator.fitness(path[None], np.array([4]))
            for incumbent in (0.0, whole, 0.5, 1.5, 1.999):
                value, is_exact = fitness_above(path, 4, evaluator.course, scratch(4), incumbent)
                assert is_exact or whole <= value <= incumbent
                assert not is_exact or value == whole
                assert (value > incumbent) == (whole > incumbent)


def test_shares_of_pieces_have_the_hits_of_the_whole(make_problem):
    """Straights and arcs, below a hill that both meet."""
    heights = np.full((51, 51), 100.0)
    heights[20:30, 15:30] = 320.0
    evaluator = Evaluator(make_problem(START, GOAL, heights), threads=1)
    space = scratch(4)
    path = np.array([START, (2500.0, 2500.0, 300.0), (2500.0, 3200.0, 300.0), GOAL])
    path_terms(path, 4, evaluator.course, space)
    found = {}
    for row in np.flatnonzero(space.pieces[:7, fields.LENGTH] > 0).tolist():
        parts = parts_of(evaluator.course.c, space.pieces, row)
        part_m = space.pieces[row, fields.LENGTH] / parts
        hits = sum(
            piece_hits(evaluator.course, space.pieces, row, parts, first, 3) for first in range(3)
        )
        whole = sum(collided_m(evaluator.course, space.pieces, row))
        assert hits * part_m == pytest.approx(whole)
        found[bool(space.pieces[row, fields.ANGLE] > 0)] = whole
    assert set(found) == {False, True}


# --- Limits of the aircraft ----------------------------------------------------------------------


def test_limits_that_the_aircraft_does_not_have_are_not_listed(judge):
    for without, limit in (
        ({"engine_power_W": None}, "power"),
        ({"fuel_weight_N": None}, "fuel"),
        ({"lift_coefficient_max": None}, "stall"),
        ({"service_ceiling_m": None}, "service-ceiling"),
    ):
        path = np.array([START, (1500.0, 2500.0, 300.0), (2500.0, 3000.0, 300.0), GOAL])
        has = dataclasses.replace(FOX, service_ceiling_m=350.0)
        for plane, listed in ((has, True), (dataclasses.replace(has, **without), False)):
            evaluator = judge(aircraft=plane)
            found = [each["limit"] for each in evaluator.evaluate(path).limits]
            assert (limit in found) == listed
            assert evaluator.broken(path) == []
            assert (len(list(line_limits(evaluator.problem))) == 1) == (
                plane.service_ceiling_m is not None
            )


def test_the_stall_and_the_turn_are_two_limits(judge):
    tight = [(1500.0, 2500.0, 300.0), (1500.0, 2520.0, 300.0)]
    assert set(names(judge(), *tight)) == {"turn"}
    heavy = dataclasses.replace(FOX, lift_coefficient_max=0.46)
    assert set(names(judge(aircraft=heavy), *tight)) == {"stall"}


def test_a_speed_that_ends_the_stall_may_not_exist(judge):
    for lift, exists in ((0.46, True), (0.05, False)):
        problem = judge(aircraft=dataclasses.replace(FOX, lift_coefficient_max=lift)).problem
        speed = STALL.least_speed_m_s(problem)
        assert (speed is not None) == exists
        if speed is not None:
            faster = dataclasses.replace(problem.aircraft, cruise_speed_m_s=speed * 1.001)
            limits = dataclasses.replace(problem, aircraft=faster).limits
            assert limits.stall_speed_m_s < faster.cruise_speed_m_s


def test_advice_says_that_there_may_be_room_to_circle(judge):
    problem = judge().problem
    for proven, words in ((True, "there is no room to circle."), (False, "may be room to circle")):
        assert words in CLIMB.advice(problem, 12.0, (1.0, 2.0), proven=proven)
    assert "12.0 degrees near (1, 2) m, 99 W" in POWER.climb_advice(problem, 12, (1, 2), 99)
