"""Arcs as polygons: distances computed by PROJ."""

from itertools import pairwise

import numpy as np
import pytest
from pyproj import Geod

from pathgene.host.formats.arcs import Arc, around, bearing, corner


EARTH = Geod(ellps="WGS84")


def distances(centre, chain):
    """Return the distances of points on a chain, its edges straight in degrees, from the centre."""
    corners = np.array(chain)
    shares = np.linspace(0, 1, 21)[:, None]
    points = np.concatenate(
        [first + shares * (second - first) for first, second in pairwise(corners)]
    )
    start = np.full(len(points), centre[0]), np.full(len(points), centre[1])
    return EARTH.inv(*start, *points.T)[2]


@pytest.mark.parametrize("latitude", [0, -45, 75])
@pytest.mark.parametrize("radius_m", [50, 1852, 185_200])
@pytest.mark.parametrize("clockwise", [True, False])
def test_a_chain_lies_on_one_side_of_its_arc_within_half_a_metre(latitude, radius_m, clockwise):
    centre = (10.0, latitude)
    arc = Arc(centre, (20.0, radius_m), (310.0, radius_m), clockwise=clockwise)
    inner = distances(centre, arc.corners(grown=False))
    # Edges are straight in degrees, which lie up to 3 cm from the shortest lines of this length.
    assert inner.max() < radius_m + 0.05
    assert inner.min() > radius_m - 0.5
    grown = distances(centre, arc.corners(grown=True))
    assert grown.min() > radius_m - 1e-6
    assert grown.max() < radius_m + 0.5


def test_begins_and_ends_at_its_ends_in_its_direction():
    centre = (10.0, 60.0)
    for clockwise, sweep in ((True, 90), (False, -270)):
        arc = Arc(centre, (30.0, 1000.0), (120.0, 2000.0), clockwise=clockwise)
        for grown in (True, False):
            chain = arc.corners(grown=grown)
            assert bearing(centre, chain[0]) == pytest.approx((30, 1000))
            assert bearing(centre, chain[-1]) == pytest.approx((120, 2000))
            turns = np.unwrap([bearing(centre, place)[0] for place in chain], period=360)
            assert turns[-1] - turns[0] == pytest.approx(sweep)
            assert np.all(np.diff(turns) * sweep > 0)


def test_equal_bearings_make_a_circle():
    chain = Arc((0.0, 0.0), (45.0, 500.0), (45.0, 500.0), clockwise=True).corners(grown=False)
    assert chain[0] == pytest.approx(chain[-1])
    turns = np.unwrap([bearing((0.0, 0.0), place)[0] for place in chain], period=360)
    assert turns[-1] - turns[0] == pytest.approx(360)


def test_a_line_has_its_width_on_both_sides():
    first, second = (179.9, 60.0), (-179.9, 60.1)
    ring = around(first, second, 926.0)
    for centre, sides in ((first, (ring[0], ring[3])), (second, (ring[1], ring[2]))):
        (one, left_m), (other, right_m) = (bearing(centre, place) for place in sides)
        assert (left_m, right_m) == pytest.approx((926, 926))
        assert (one - other) % 360 == pytest.approx(180)


def test_longitudes_stay_near_the_centre():
    assert corner((179.99, 0.0), 90.0, 5000.0)[0] > 180
    assert corner((-179.99, 0.0), 270.0, 5000.0)[0] < -180
