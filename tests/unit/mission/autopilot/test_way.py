"""Ways of an autopilot beyond a planned path."""

import math

import pytest

from pathgene.host.mission.autopilot.way import Way


@pytest.mark.parametrize("turn_deg", [60, 95, 180, 254, -350])
def test_no_corner_of_a_slow_aircraft_is_far_outside_its_turn(turn_deg):
    """Legs of the usual length would turn by 180 degrees at a corner, which lies at infinity."""
    way = Way((0.0, 0.0, 60.0), (1.0, 0.0), 10.0, math.radians(turn_deg), 100.0, 12.0)
    *corners, _ = way.points(30.0, 60.0)
    side = math.copysign(10.0, turn_deg)
    assert all(math.dist((point.x_m, point.y_m), (0.0, side)) <= 20.1 for point in corners)
    assert len(corners) >= math.floor(abs(turn_deg) / 120)
