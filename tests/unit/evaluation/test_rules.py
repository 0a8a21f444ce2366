"""Headings and timed zones under the rules of safe flight, by hand."""

import numpy as np
import pytest

from pathgene.host.evaluation import Arc, Evaluator, Straight
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle


START, GOAL = (500.0, 2500.0, 300.0), (4500.0, 2500.0, 300.0)
EAST, NORTH, WEST = (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)


def test_a_turn_at_the_start_is_an_arc_like_any_other():
    """From north to east, it is a quarter turn right that begins a radius before the start."""
    smoothed = smooth(np.array([START, GOAL]), 150.0, (NORTH, None))
    arc, straight = smoothed.pieces
    assert isinstance(arc, Arc)
    assert isinstance(straight, Straight)
    assert (smoothed.arcs, smoothed.impossible_arcs) == (1, 0)
    assert arc.start == pytest.approx((500, 2350, 300))
    assert arc.turn_rad == pytest.approx(-np.pi / 2)
    assert straight.start == pytest.approx((650, 2500, 300))


def test_a_turn_at_the_goal_ends_beyond_it():
    smoothed = smooth(np.array([START, GOAL]), 150.0, (None, NORTH))
    assert smoothed.pieces[-1].points(np.ones(1))[0] == pytest.approx((4500, 2650, 300))


@pytest.mark.parametrize("heading", [WEST, (-0.1, 0.995)])
def test_a_turn_beyond_a_right_angle_does_not_fit_at_an_end(heading):
    for headings in ((heading, None), (None, heading)):
        smoothed = smooth(np.array([START, GOAL]), 150.0, headings)
        assert (smoothed.arcs, smoothed.impossible_arcs) == (1, 1)


def test_a_turn_at_the_start_needs_room_in_the_first_segment():
    for first, impossible in (((740.0, 2500.0, 300.0), 1), ((820.0, 2500.0, 300.0), 0)):
        corner = np.array([START, first, (first[0], 3500.0, 300.0)])
        assert bool(smooth(corner, 150.0, (NORTH, None)).impossible_arcs) == impossible


def test_headings_count_in_the_evaluation(make_problem):
    path = np.array([START, GOAL])
    evaluations = [
        Evaluator(
            make_problem(START, GOAL, rules=Rules(), start_heading_deg=heading), threads=1
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
    path = np.array([START, GOAL])
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
        evaluator = Evaluator(make_problem(START, GOAL, zones=[zone], rules=Rules()), threads=1)
        evaluation = evaluator.evaluate(path)
        assert evaluation.feasible is not inside, times
        assert (evaluation.distance_in_nofly_m > 0) is inside
        fitness = evaluator.fitness(path[None], lengths)[0]
        assert (fitness > 1) is not inside


def test_kernels_without_time_take_a_timed_zone_as_always_active(make_problem):
    zone = Circle(2500, 2500, 250, t0_s=1000)
    evaluator = Evaluator(make_problem(START, GOAL, zones=[zone], rules=Rules()), threads=1)
    zoned = evaluator.course.zoned
    assert np.isnan(zoned).sum() == evaluator.problem.blocked_raster.sum() > 0
    assert not evaluator.problem.nofly_raster.any()
