"""Crossings of lines and arcs with circles and lines at known places."""

import functools
import math

import numpy as np
import pytest

from pathgene.host.evaluation.crossings import (
    Line,
    box_of,
    centre_of,
    cross_circle,
    cross_line,
    mark_parallel,
    mark_towards,
    place,
)
from pathgene.host.evaluation.kernels import scratch
from pathgene.host.evaluation.laying import lay_piece


def straight(ax, ay, bx, by):
    _, pieces = scratch(1)
    run = math.hypot(bx - ax, by - ay)
    ux, uy = ((bx - ax) / run, (by - ay) / run) if run > 0 else (0.0, 0.0)
    lay_piece(pieces, 0, (ax, ay, 0.0), (bx, by, 0.0), (ux, uy), (1.0, 0.0), run, 0.0)
    return pieces


def arc(x, y, heading_deg, radius, angle_deg, side=1.0):
    """Return an arc that starts at (x, y), its heading from the east to the north."""
    _, pieces = scratch(1)
    heading, angle = math.radians(heading_deg), math.radians(angle_deg)
    ux, uy = math.cos(heading), math.sin(heading)
    lay_piece(pieces, 0, (x, y, 0.0), (0.0, 0.0, 0.0), (ux, uy), (side, angle), radius * angle, 0.0)
    return pieces


def marks_of(function, pieces, *where, low=0.0, high=1.0):
    """Return the marks of a function, in order."""
    marks = np.full(8, math.nan)
    where = [float(value) for value in where]
    places = {cross_circle: lambda: [tuple(where)], cross_line: lambda: [Line(*where)]}
    count = function(pieces, 0, *places.get(function, lambda: where)(), low, high, marks, 0)
    assert np.isnan(marks[count:]).all()
    return sorted(marks[:count].tolist())


def around(parts):
    """Return fractions of an arc of 270 degrees, given in degrees."""
    return pytest.approx([part / 270 for part in parts])


@functools.cache
def left():
    """Return an arc around (0, 0), from (100, 0) through the north and the west to (0, -100)."""
    return arc(100.0, 0.0, 90.0, 100.0, 270.0)


@functools.cache
def right():
    """Return the same arc mirrored: through the south and the west to (0, 100)."""
    return arc(100.0, 0.0, -90.0, 100.0, 270.0, -1.0)


def test_places_and_boxes():
    assert place(left(), 0, 1 / 3) == pytest.approx((0, 100))
    assert place(right(), 0, 1 / 3) == pytest.approx((0, -100))
    assert place(left(), 0, 1) == pytest.approx((0, -100))
    assert place(straight(1.0, 2.0, 5.0, 10.0), 0, 0.25) == (2, 4)
    assert box_of(left(), 0) == pytest.approx((-100, -100, 100, 100))
    assert box_of(straight(1.0, 9.0, 5.0, 2.0), 0) == (1, 2, 5, 9)
    # A short arc to the north of its tangent is no farther from its start than its length.
    short = arc(0.0, 0.0, 0.0, 1000.0, 1.0)
    length = math.radians(1000)
    assert box_of(short, 0) == pytest.approx((-length, 0, length, length))


def test_straight_and_circle():
    line = straight(0.0, 0.0, 100.0, 0.0)
    assert marks_of(cross_circle, line, 50, 0, 10) == pytest.approx([0.4, 0.6])
    assert marks_of(cross_circle, line, 50, 8, 10) == pytest.approx([0.44, 0.56])
    assert marks_of(cross_circle, line, 50, 11, 10) == []
    assert marks_of(cross_circle, line, 95, 0, 10) == pytest.approx([0.85])
    assert marks_of(cross_circle, line, 50, 0, 10, low=0.5) == pytest.approx([0.6])
    assert marks_of(cross_circle, straight(5.0, 5.0, 5.0, 5.0), 5, 5, 1) == []


def test_arc_and_circle():
    # The chord of 60 degrees is as long as the radius; the circle is around the arc's west.
    assert marks_of(cross_circle, left(), -100, 0, 100) == around([120, 240])
    assert marks_of(cross_circle, right(), -100, 0, 100) == around([120, 240])
    assert marks_of(cross_circle, left(), 0, -100, 100) == around([210])
    # Inside, outside and around the same centre, nothing is crossed.
    for x, radius in ((0, 50), (0, 100), (-300, 150), (30, 40), (-50, 250)):
        assert marks_of(cross_circle, left(), x, 0, radius) == []
    _, exact = scratch(1)
    lay_piece(exact, 0, (100.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 1.0), (1.0, 2.0), 200.0, 0.0)
    assert centre_of(exact, 0) == (0, 0, 100)
    assert marks_of(cross_circle, exact, 0, 0, 100) == []


def test_straight_and_line():
    line = straight(0.0, 0.0, 100.0, 100.0)
    east = (0, 50, 1, 0)
    assert marks_of(cross_line, line, *east, 0, 0, 60) == pytest.approx([0.5])
    assert marks_of(cross_line, line, *east, 20, 0, 80) == pytest.approx([0.7])
    assert marks_of(cross_line, line, *east, 20, 0, 60) == []
    assert marks_of(cross_line, line, *east, 60, 0, 200) == []
    along = math.sqrt(0.5)
    assert marks_of(cross_line, line, 0, 0, along, along, 0, -9, 999) == []


def test_arc_and_line():
    south = (-50, 0, 0, -1)
    # Crossed at x = -50: at 120 and 240 degrees, 87 m to the north and to the south.
    assert marks_of(cross_line, left(), *south, 0, -99, 99) == around([120, 240])
    assert marks_of(cross_line, right(), *south, 0, -99, 99) == around([120, 240])
    assert marks_of(cross_line, left(), *south, 0, 0, 99) == around([240])
    assert marks_of(cross_line, left(), *south, 0, 90, 999) == []
    assert marks_of(cross_line, left(), *south, 0, -999, -90) == []
    # The left of south is east.
    assert marks_of(cross_line, left(), *south, 50, -101, 101) == around([90])
    assert marks_of(cross_line, left(), *south, 151, -101, 101) == []


def test_nearest_places():
    assert marks_of(mark_towards, straight(0.0, 0.0, 100.0, 0.0), 30, 70) == [0.3]
    assert marks_of(mark_towards, straight(0.0, 0.0, 100.0, 0.0), -30, 70) == []
    assert marks_of(mark_towards, straight(0.0, 0.0, 0.0, 0.0), -30, 70) == []
    assert marks_of(mark_towards, left(), -1, 0) == around([180])
    assert marks_of(mark_towards, left(), 900, -900) == []
    half = math.sqrt(0.5)
    assert marks_of(mark_parallel, left(), half, half) == around([135])
    assert marks_of(mark_parallel, left(), half, -half) == around([45, 225])
    assert marks_of(mark_parallel, straight(0.0, 0.0, 9.0, 0.0), 1, 0) == []
