"""Heights for an autopilot that climbs late."""

import numpy as np
import pytest

from pathgene.host.mission.autopilot.climbs import led
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.timing import timed


SPEED_M_S, LAG_S, APART_S = 23.0, 3.0, 1.1


def heights_at(points, along):
    """Return the heights of waypoints on one line, at metres along it."""
    return np.interp(along, [p.x_m for p in points], [p.z_m for p in points])


def profile(seed):
    """Return waypoints on one line with random heights."""
    rng = np.random.default_rng(seed)
    along = np.cumsum(rng.uniform(30, 900, 30))
    rise = np.diff(along) * rng.uniform(-0.4, 0.17, 29)
    heights = 500 + np.concatenate(([0.0], np.cumsum(rise)))
    places = np.column_stack((along, heights)).tolist()
    return [RoutePoint(x, 0.0, z, 10) for x, z in places]


@pytest.mark.parametrize("seed", range(50))
def test_a_late_autopilot_stays_above_the_plan_in_every_climb(seed):
    planned = timed(profile(seed), SPEED_M_S, (0.0, 0.0))
    made = led(planned, planned, LAG_S, APART_S)
    points = [each.point for each in planned]
    along = np.arange(points[0].x_m + LAG_S * SPEED_M_S + 30, points[-1].x_m - 100, 1.0)
    late = heights_at(made, along - LAG_S * SPEED_M_S)
    # A waypoint that is not inserted because another one is near leaves less than it could climb.
    assert (late - heights_at(points, along)).min() > -1.0 - APART_S * SPEED_M_S * 0.17
    # Without the lead, the same autopilot is metres lower.
    plain = heights_at(points, along - LAG_S * SPEED_M_S)
    assert (plain - heights_at(points, along)).min() < -5


@pytest.mark.parametrize("seed", range(10))
def test_start_and_goal_keep_their_heights_and_inserted_points_their_distance(seed):
    planned = timed(profile(seed), SPEED_M_S, (8.0, 0.0))
    made = led(planned, planned, LAG_S, APART_S)
    assert (made[0], made[-1]) == (planned[0].point, planned[-1].point)
    given = {each.point.x_m for each in planned}
    added = [number for number, point in enumerate(made) if point.x_m not in given]
    assert added
    for number in added:
        gaps = np.diff([point.x_m for point in made[number - 1 : number + 2]])
        assert gaps.min() >= APART_S * (SPEED_M_S + 8.0) - 1e-6


def test_without_a_lag_the_heights_stay():
    planned = timed(profile(3), SPEED_M_S, (0.0, 0.0))
    assert led(planned, planned, 0.0, APART_S) == [each.point for each in planned]


def test_a_head_wind_lengthens_the_time_of_a_leg():
    points = profile(1)[:2]
    length = points[1].x_m - points[0].x_m
    assert timed(points, SPEED_M_S, (-8.0, 3.0))[1].t_s == pytest.approx(length / 15.0)
    assert timed(points, SPEED_M_S, (8.0, 0.0))[1].t_s == pytest.approx(length / 31.0)
