"""Ways of an autopilot beyond a planned path."""

import math
from itertools import pairwise

import pytest

from pathgene.host.mission.autopilot.way import Way


@pytest.mark.parametrize("is_gusty", [False, True])
@pytest.mark.parametrize("turn_deg", [60, 95, 180, 254, -350])
def test_no_corner_of_a_slow_aircraft_is_far_outside_its_turn(turn_deg, is_gusty):
    """Legs of the usual length would turn by 180 degrees at a corner, which lies at infinity."""
    way = Way((0.0, 0.0, 60.0), (1.0, 0.0), 10.0, math.radians(turn_deg), 100.0, 12.0)
    *corners, _ = way.points(30.0, 60.0, is_gusty=is_gusty)
    side = math.copysign(10.0, turn_deg)
    assert all(math.dist((point.x_m, point.y_m), (0.0, side)) <= 20.1 for point in corners)
    assert len(corners) >= math.floor(abs(turn_deg) / 120)


@pytest.mark.parametrize("turn_deg", [25, 90, -170])
def test_corners_are_nearer_in_gusts_and_never_too_near(turn_deg):
    way = Way((0.0, 0.0, 60.0), (1.0, 0.0), 600.0, math.radians(turn_deg), 400.0, 60.0)
    counts = []
    for is_gusty in (False, True):
        places = [(0.0, 0.0), *((p.x_m, p.y_m) for p in way.points(30.0, 60.0, is_gusty=is_gusty))]
        assert min(math.dist(a, b) for a, b in pairwise(places)) >= 60.0
        headings = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(places)]
        turns = [abs(math.remainder(b - a, math.tau)) for a, b in pairwise([0.0, *headings])]
        limit_deg = 8.5 if is_gusty else 13.0
        assert math.degrees(max(turns)) <= limit_deg
        counts.append(len(places))
    assert counts[1] >= 1.5 * counts[0] - 2
