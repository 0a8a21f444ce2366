"""Legs that an autopilot flies as a step."""

import numpy as np
import pytest

from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.steps import stepped
from pathgene.host.mission.autopilot.timing import timed


SPEED_M_S, APART_S = 23.0, 1.1


def made_of(*heights, leg_m=400.0):
    points = [RoutePoint(leg_m * n, 0.0, z, 10) for n, z in enumerate(heights)]
    return timed(points, SPEED_M_S, (0.0, 0.0))


def asked(points, at, least_m):
    """Return the heights that an autopilot flies at instants, by the rule of ArduPlane."""
    times, heights = (
        np.array([each.t_s for each in points]),
        np.array([each.point.z_m for each in points]),
    )
    leg = np.clip(np.searchsorted(times, at), 1, len(times) - 1)
    slope = np.interp(at, times, heights)
    return np.where(np.abs(np.diff(heights))[leg - 1] < least_m, heights[leg], slope)


@pytest.mark.parametrize("least_m", [0.0, 15.0])
@pytest.mark.parametrize("seed", range(40))
def test_no_leg_is_flown_lower_with_a_slope_or_a_step(seed, least_m):
    rng = np.random.default_rng(seed)
    heights = 500 + np.cumsum(rng.uniform(-20, 15, 25))
    low = made_of(*heights, leg_m=rng.uniform(60, 900))
    points = stepped(low, low, APART_S)
    assert points[-1] == low[-1]
    # A leg of a second at the end is left.
    at = np.arange(1.0, low[-1].t_s - APART_S - 0.01, 0.1)
    planned = np.interp(at, [each.t_s for each in low], heights)
    assert (asked(points, at, least_m) - planned).min() >= -1.0 - 1e-6
    assert (asked(low, at, 15.0) - planned).min() < -5.0
    gained = np.interp([each.t_s for each in points], [each.t_s for each in low], heights)
    assert (np.array([each.point.z_m for each in points]) - gained).max() < 15.0


def test_small_descents_are_flown_one_leg_later():
    points = stepped(made := made_of(500.0, 494.0, 488.0, 482.0, 400.0), made, APART_S)
    assert [each.point.z_m for each in points] == [500.0, 499.0, 493.0, 487.0, 400.0]


def test_the_height_is_kept_until_before_the_goal():
    points = stepped(made := made_of(500.0, 490.0), made, APART_S)
    assert [each.point.z_m for each in points] == pytest.approx([500.0, 499.0, 490.0])
    assert points[1].point.x_m == pytest.approx(400.0 - APART_S * SPEED_M_S)


def test_slopes_and_climbs_stay():
    made = made_of(500.0, 484.0, 490.0, 504.0, 530.0)
    assert stepped(made, made, APART_S) == made
