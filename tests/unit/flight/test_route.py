"""Places near straights and arcs, compared with dense points."""

import math

import numpy as np
import pytest

from pathgene.host.evaluation.geometry import smooth
from pathgene.host.flight.route import Route
from tests.unit.flight.conftest import arc, straight


PATH = np.array(
    [(0, 0, 100), (900, 100, 150), (1500, 900, 120), (800, 1700, 300), (-500, 1500, 250)],
    dtype=float,
)
PIECES = smooth(PATH, 150.0).pieces


def test_length_is_horizontal_without_lead_in():
    route = Route(PIECES, 500.0)
    assert route.length_m == pytest.approx(sum(piece.run_m for piece in PIECES))


def test_points_and_heights_are_those_of_the_pieces():
    route = Route(PIECES, 500.0)
    along = 0.0
    for piece in PIECES:
        for share in (0.0, 0.25, 0.5, 0.999):
            x, y, z = piece.points(np.array([share]))[0]
            assert route.point(along + share * piece.run_m) == pytest.approx((x, y), abs=1e-6)
            height, slope = route.height(along + share * piece.run_m)
            assert height == pytest.approx(z)
            assert slope == pytest.approx(piece.rise_m / piece.run_m)
        along += piece.run_m


@pytest.mark.parametrize("cross", [-40.0, 0.0, 25.0])
def test_locates_points_beside_the_route(cross):
    route = Route(PIECES, 500.0)
    leg = 0
    for along in np.arange(-400.0, route.length_m, 7.0):
        (x0, y0), (x1, y1) = route.point(along - 0.01), route.point(along + 0.01)
        (x, y), step = route.point(along), math.hypot(x1 - x0, y1 - y0)
        left = (-(y1 - y0) / step, (x1 - x0) / step)
        at = (x + cross * left[0], y + cross * left[1])
        place = route.locate(*at, leg)
        leg = place.leg
        # Kinks of the differences at the joints of pieces.
        assert place.along_m == pytest.approx(along, abs=0.01 * abs(cross) + 0.02)
        assert place.cross_m == pytest.approx(cross, abs=0.01)


def test_arc_of_more_than_a_half_circle_of_lead():
    route = Route([arc((0.0, 0.0, 0.0), 100.0, 170.0)])
    x, y = route.point(math.radians(165) * 100)
    assert route.locate(x, y).along_m == pytest.approx(math.radians(165) * 100)


def test_lead_in_and_run_out_go_straight_on():
    route = Route([straight((10.0, 20.0, 100.0), 1000.0, rise_m=50.0)], 200.0)
    assert route.start == pytest.approx((-190.0, 20.0, 90.0, 1.0, 0.0))
    assert route.point(1300.0) == pytest.approx((1310.0, 20.0))
    assert route.height(1300.0) == pytest.approx((165.0, 0.05))


def test_refuses_what_is_no_route():
    with pytest.raises(ValueError, match=r"^Route must have a piece with a horizontal length$"):
        Route([])
    with pytest.raises(ValueError, match=r"^Lead-in must be 0 m or more, not -1$"):
        Route(PIECES, -1)
