"""Smoothing compared with plane geometry."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pathgene.host.evaluation.geometry import Arc, Straight, smooth


R = 150.0


def path(*points):
    return np.array([point if len(point) == 3 else (*point, 0.0) for point in points], dtype=float)


def ends(piece):
    return piece.points(np.array([0.0, 1.0]))


@pytest.mark.parametrize("side", [1, -1], ids=["left", "right"])
def test_quarter_turn(side):
    smoothed = smooth(path((0, 0), (1000, 0), (1000, side * 1000)), R)
    first, arc, last = smoothed.pieces
    assert (smoothed.arcs, smoothed.impossible_arcs) == (1, 0)
    assert (first.run_m, last.run_m) == pytest.approx((850, 850))
    assert arc.run_m == pytest.approx(R * math.pi / 2)
    assert arc.turn_rad == pytest.approx(side * math.pi / 2)
    np.testing.assert_allclose(ends(arc), [(850, 0, 0), (1000, side * 150, 0)], atol=1e-9)
    points = arc.points(np.linspace(0, 1, 17))
    np.testing.assert_allclose(np.hypot(points[:, 0] - 850, points[:, 1] - side * 150), R)
    middle = (850 + R * math.sin(math.pi / 4), side * R * (1 - math.cos(math.pi / 4)), 0)
    np.testing.assert_allclose(points[8], middle, atol=1e-9)


def test_altitude_follows_the_segments_and_is_linear_along_the_arc():
    first, arc, last = smooth(path((0, 0, 0), (1000, 0, 100), (1000, 1000, 300)), R).pieces
    assert ends(first)[:, 2] == pytest.approx([0, 85])
    assert ends(arc)[:, 2] == pytest.approx([85, 130])
    assert ends(last)[:, 2] == pytest.approx([130, 300])
    assert arc.points(np.array([0.5]))[0, 2] == pytest.approx(107.5)
    assert [piece.rise_m for piece in (first, arc, last)] == pytest.approx([85, 45, 170])
    assert arc.length_m == pytest.approx(math.hypot(R * math.pi / 2, 45))


def test_arc_is_steeper_than_its_legs():
    climb = math.tan(math.radians(10))
    _, arc, _ = smooth(
        path((0, 0, 0), (1000, 0, 1000 * climb), (1000, 1000, 2000 * climb)), R
    ).pieces
    # The arc is shorter than the two tangents it replaces: tan(phi/2) / (phi/2) = 4 / pi here.
    assert arc.rise_m / arc.run_m == pytest.approx(climb * 4 / math.pi)
    assert math.degrees(math.atan2(arc.rise_m, arc.run_m)) > 12.6


# A staircase: two quarter turns with R = 150 need tangents of 150 m each.
@pytest.mark.parametrize(("middle", "impossible"), [(301.0, 0), (299.99, 2)])
def test_neighbours_share_a_segment(middle, impossible):
    smoothed = smooth(path((0, 0), (1000, 0), (1000, middle), (2000, middle)), R)
    assert smoothed.impossible_arcs == impossible
    assert sum(isinstance(piece, Arc) for piece in smoothed.pieces) == 2 - impossible


@pytest.mark.parametrize(("first", "impossible"), [(150.01, 0), (149.99, 1)])
def test_start_and_goal_need_no_tangent(first, impossible):
    corner = path((0, 0), (first, 0), (first, 1000))
    assert smooth(corner, R).impossible_arcs == impossible
    assert smooth(corner[::-1], R).impossible_arcs == impossible


def test_tangents_that_use_up_a_segment_leave_no_straight_piece():
    # Turns of 90 degrees have tangents of R up to rounding; the segment has exactly this length.
    tangent = 200.0 * math.tan(0.5 * math.atan2(1.0, 0.0))
    smoothed = smooth(path((0, 0), (1000, 0), (1000, 2 * tangent), (2000, 2 * tangent)), 200.0)
    assert smoothed.impossible_arcs == 0
    assert (
        sum(
            piece.length_m
            for piece in smoothed.pieces
            if isinstance(piece, Straight) and piece.heading[1] == 1.0
        )
        < 1e-9
    )


def test_impossible_arc_leaves_the_corner():
    smoothed = smooth(path((0, 0), (100, 0), (100, 100)), R)
    assert [type(piece) for piece in smoothed.pieces] == [Straight, Straight]
    np.testing.assert_array_equal(ends(smoothed.pieces[0])[1], (100, 0, 0))


def test_an_impossible_neighbour_rules_out_an_arc():
    # The reversal at the third point needs an infinite tangent, on the segment before it as well.
    smoothed = smooth(path((0, 0), (1000, 0), (1000, 5000), (1000, 2000), (3000, 2000)), R)
    assert (smoothed.arcs, smoothed.impossible_arcs) == (3, 3)


@pytest.mark.parametrize(
    "points",
    [
        pytest.param([(0, 0), (1000, 0), (500, 0)], id="reversal"),
        pytest.param([(0, 0), (0, 0), (500, 0)], id="repeated start"),
        pytest.param([(0, 0), (500, 0), (500, 0)], id="repeated goal"),
        pytest.param([(0, 0, 0), (0, 0, 90), (500, 0, 90)], id="vertical hop"),
    ],
)
def test_no_tangent_length(points):
    smoothed = smooth(path(*points), R)
    assert (smoothed.arcs, smoothed.impossible_arcs) == (1, 1)
    assert smoothed.pieces
    assert all(isinstance(piece, Straight) for piece in smoothed.pieces)


def test_repeated_waypoint_makes_both_arcs_impossible():
    smoothed = smooth(path((0, 0), (1000, 0), (1000, 0), (2000, 0)), R)
    assert (smoothed.arcs, smoothed.impossible_arcs) == (2, 2)
    assert [piece.length_m for piece in smoothed.pieces] == [1000, 1000]


def test_vertical_hop_is_a_piece():
    hop = smooth(path((0, 0, 0), (1000, 0, 0), (1000, 0, 40), (2000, 0, 40)), R).pieces[1]
    assert (hop.run_m, hop.rise_m, hop.length_m) == (0, 40, 40)
    assert list(hop.directions()) == []


def test_straight_on_is_possible_and_has_no_arc():
    smoothed = smooth(path((0, 0), (10, 3), (20, 6), (40, 12)), R)
    assert (smoothed.arcs, smoothed.impossible_arcs) == (2, 0)
    assert smoothed.pieces
    assert all(isinstance(piece, Straight) for piece in smoothed.pieces)


def test_straight_on_is_possible_beside_a_reversal():
    # Because thirds are rounded, the turn at the first waypoint is not exactly 0.
    smoothed = smooth(path((0, 0), (1 / 3, 0.1), (1, 0.3), (0, 0)), R)
    assert (smoothed.arcs, smoothed.impossible_arcs) == (2, 1)


def test_straight_line_without_waypoints():
    (line,) = smooth(path((0, 0, 0), (300, 400, 1200)), R).pieces
    assert (line.run_m, line.rise_m, line.length_m) == (500, 1200, 1300)
    assert list(line.directions()) == [(0.6, 0.8, 500)]


def test_slight_turn_keeps_the_slope_of_its_legs():
    # The arc is so short that the difference of its end altitudes has no correct digit.
    climb = math.tan(math.radians(10))
    _, arc, _ = smooth(
        path((0, 0, 2000), (5000, 0, 2000 + 5000 * climb), (10000, 1e-6, 2000 + 10000 * climb)), R
    ).pieces
    assert arc.run_m < 1e-6
    assert arc.rise_m / arc.run_m == pytest.approx(climb, rel=1e-12)


coordinate = st.floats(0, 5000).map(lambda value: round(value, 2))
paths = st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=2, max_size=9, unique=True)


@given(paths)
def test_pieces_join_and_stay_in_the_hull(points):
    way = path(*points)
    smoothed = smooth(way, R)
    joints = np.array([ends(piece) for piece in smoothed.pieces])
    np.testing.assert_allclose(joints[0, 0], way[0])
    np.testing.assert_allclose(joints[-1, 1], way[-1])
    np.testing.assert_allclose(joints[1:, 0], joints[:-1, 1], atol=1e-6)
    polyline = np.hypot(*np.diff(way[:, :2], axis=0).T).sum()
    assert sum(piece.run_m for piece in smoothed.pieces) <= polyline * (1 + 1e-12)
    for piece in smoothed.pieces:
        points = piece.points(np.linspace(0, 1, 9))
        assert (points[:, :2] >= way[:, :2].min(axis=0) - 1e-6).all()
        assert (points[:, :2] <= way[:, :2].max(axis=0) + 1e-6).all()
        steps = np.diff(points, axis=0)
        if isinstance(piece, Straight):
            np.testing.assert_allclose(
                np.linalg.norm(steps, axis=1).sum(), piece.length_m, atol=1e-6
            )


@given(paths)
def test_headings_are_continuous_through_arcs(points):
    pieces = smooth(path(*points), R).pieces
    for before, after in pairwise(pieces):
        if isinstance(after, Arc) and before.run_m > 0:
            assert before.heading == pytest.approx(after.heading)
        if isinstance(before, Arc) and isinstance(after, Straight) and after.run_m > 0:
            cos, sin = math.cos(before.turn_rad), math.sin(before.turn_rad)
            east, north = before.heading
            turned = (east * cos - north * sin, east * sin + north * cos)
            assert turned == pytest.approx(after.heading, abs=1e-9)


@pytest.mark.parametrize("run", [5e-324, 2e-311, 1e-200])
def test_a_run_whose_square_is_0_is_vertical(run):
    path = np.array([(0, 0, 100), (0, run, 300), (0, 1000, 300)])
    vertical, level = smooth(path, 150.0).pieces
    assert (vertical.run_m, vertical.length_m, vertical.heading) == (0.0, 200.0, (0.0, 0.0))
    assert (level.run_m, level.rise_m) == (1000.0, 0.0)
