"""Heights for an autopilot that climbs late."""

import numpy as np
import pytest

from pathgene.host.mission.autopilot.climbs import SUSTAINED, led
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.timing import timed


SPEED_M_S, LAG_S, APART_S = 23.0, 3.0, 1.1


def heights_at(points, along):
    """Return the heights of waypoints on one line, at metres along it."""
    return np.interp(along, [p.x_m for p in points], [p.z_m for p in points])


def led_points(*arguments):
    """Return the waypoints of :func:`led` without their times."""
    return [each.point for each in led(*arguments)]


def profile(seed, slopes=None):
    """Return waypoints on one line with random heights, or with random slopes of some."""
    rng = np.random.default_rng(seed)
    along = np.cumsum(rng.uniform(30, 900, 30))
    slope = rng.uniform(-0.4, 0.17, 29) if slopes is None else rng.choice(slopes, 29)
    rise = np.diff(along) * slope
    heights = 500 + np.concatenate(([0.0], np.cumsum(rise)))
    places = np.column_stack((along, heights)).tolist()
    return [RoutePoint(x, 0.0, z, 10) for x, z in places]


@pytest.mark.parametrize("seed", range(50))
def test_a_late_autopilot_stays_above_the_plan_in_every_climb(seed):
    planned = timed(profile(seed), SPEED_M_S, (0.0, 0.0))
    made = led_points(planned, planned, LAG_S, APART_S)
    points = [each.point for each in planned]
    along = np.arange(points[0].x_m + LAG_S * SPEED_M_S + 30, points[-1].x_m - 100, 1.0)
    late = heights_at(made, along - LAG_S * SPEED_M_S)
    # A waypoint that is not inserted because another one is near leaves less than it could climb.
    assert (late - heights_at(points, along)).min() > -1.0 - APART_S * SPEED_M_S * 0.17
    # Without the lead, the same autopilot is metres lower.
    plain = heights_at(points, along - LAG_S * SPEED_M_S)
    assert (plain - heights_at(points, along)).min() < -5


def weak(points, climb_m_s):
    """Return the deficit of an aircraft with a low rate of climb, which is delayed by the lag."""
    seconds = np.arange(0, (points[-1].x_m - points[0].x_m) / SPEED_M_S, 0.1)
    asked = heights_at(points, points[0].x_m + SPEED_M_S * seconds)
    height, flown = asked[0], []
    for wanted in asked:
        height = min(wanted, height + 0.1 * climb_m_s)
        flown.append(height)
    late = round(LAG_S / 0.1)
    return seconds, np.concatenate((np.full(late, asked[0]), flown[:-late]))


@pytest.mark.parametrize("seed", range(20))
def test_an_aircraft_that_holds_three_quarters_of_its_climb_stays_above_the_plan(seed):
    climb_m_s = 0.17 * SPEED_M_S
    points = profile(seed, (-0.17, 0.0, 0.17))
    planned = timed(points, SPEED_M_S, (0.0, 0.0))
    made = led_points(planned, planned, LAG_S, APART_S, climb_m_s)
    seconds, flown = weak(made, SUSTAINED * climb_m_s)
    wanted = heights_at(points, points[0].x_m + SPEED_M_S * seconds)
    # After the start, the aircraft may be below, because it climbs from there.
    start = flown[0] + SUSTAINED * climb_m_s * np.maximum(seconds - LAG_S, 0.0)
    assert (flown - np.minimum(wanted, start)).min() > -4.0
    assert SUSTAINED == 0.75
    # A lead by the lag alone is not enough.
    late = led_points(planned, planned, LAG_S, APART_S)
    seconds, flown = weak(late, SUSTAINED * climb_m_s)
    assert (flown - np.minimum(wanted, start)).min() < -5.0


@pytest.mark.parametrize("seed", range(20))
def test_heights_after_the_start_can_be_reached(seed):
    climb_m_s = 0.17 * SPEED_M_S
    points = [
        RoutePoint(p.x_m, 0.0, p.z_m + 20 * number, 10) for number, p in enumerate(profile(seed))
    ]
    planned = timed(points, SPEED_M_S, (0.0, 0.0))
    made = led(planned, planned, LAG_S, APART_S, climb_m_s)
    rises = [each.point.z_m - points[0].z_m for each in made[1:-1]]
    reached = [climb_m_s * (each.t_s + LAG_S) for each in made[1:-1]]
    assert (np.array(rises) <= np.array(reached) + 1e-6).all()


@pytest.mark.parametrize("seed", range(10))
def test_start_and_goal_keep_their_heights_and_inserted_points_their_distance(seed):
    planned = timed(profile(seed), SPEED_M_S, (8.0, 0.0))
    made = led_points(planned, planned, LAG_S, APART_S)
    assert (made[0], made[-1]) == (planned[0].point, planned[-1].point)
    given = {each.point.x_m for each in planned}
    added = [number for number, point in enumerate(made) if point.x_m not in given]
    assert added
    for number in added:
        gaps = np.diff([point.x_m for point in made[number - 1 : number + 2]])
        assert gaps.min() >= APART_S * (SPEED_M_S + 8.0) - 1e-6


def test_without_a_lag_the_heights_stay():
    planned = timed(profile(3), SPEED_M_S, (0.0, 0.0))
    assert led_points(planned, planned, 0.0, APART_S) == [each.point for each in planned]


def test_a_head_wind_lengthens_the_time_of_a_leg():
    points = profile(1)[:2]
    length = points[1].x_m - points[0].x_m
    assert timed(points, SPEED_M_S, (-8.0, 3.0))[1].t_s == pytest.approx(length / 15.0)
    assert timed(points, SPEED_M_S, (8.0, 0.0))[1].t_s == pytest.approx(length / 31.0)
