"""Missions of few waypoints."""

import numpy as np
import pytest
from shapely.geometry import LineString

from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.thinning import RAISED_M, thinned
from pathgene.host.mission.autopilot.timing import timed


SPEED_M_S, CLIMB_M_S = 23.0, 3.2


def way(seed, count=60):
    """Return waypoints of a way that bends, climbs and sinks a little at most of them."""
    rng = np.random.default_rng(seed)
    legs = rng.uniform(60, 600, count)
    turns = np.where(rng.random(count) < 0.3, rng.uniform(-0.6, 0.6, count), 0.0)
    heading = np.cumsum(turns + rng.normal(0, 2e-4, count))
    x, y = np.cumsum(legs * np.cos(heading)), np.cumsum(legs * np.sin(heading))
    slopes = rng.choice([0.0, 0.1, 0.1, -0.2], count) + rng.normal(0, 0.004, count)
    z = 500 + np.cumsum(legs * np.minimum(slopes, CLIMB_M_S / SPEED_M_S))
    return timed([RoutePoint(*each, 10) for each in zip(x, y, z, strict=True)], SPEED_M_S, (0, 0))


def places(points):
    return np.array([(each.point.x_m, each.point.y_m, each.point.z_m) for each in points])


@pytest.mark.parametrize("seed", range(30))
@pytest.mark.parametrize("tolerance_m", [0.3, 1.0])
def test_fewer_legs_stay_close_and_nowhere_below(seed, tolerance_m):
    """Shapely judges the distance."""
    points = way(seed)
    made = thinned(points, tolerance_m, CLIMB_M_S)
    assert len(made) < 0.95 * len(points)
    assert (made[0], made[-1]) == (points[0], points[-1])
    before, after = places(points), places(made)
    assert LineString(after[:, :2]).hausdorff_distance(LineString(before[:, :2])) <= tolerance_m
    at = np.linspace(0, points[-1].t_s, 4000)
    low = np.interp(at, [each.t_s for each in points], before[:, 2])
    high = np.interp(at, [each.t_s for each in made], after[:, 2])
    assert (high - low).min() > -1e-6
    assert (high - low).max() < RAISED_M[-1] + 1e-6
    rates = np.diff(after[:, 2]) / np.diff([each.t_s for each in made])
    old = np.diff(before[:, 2]) / np.diff([each.t_s for each in points])
    assert rates.max() <= max(CLIMB_M_S, old.max()) + 1e-6
    assert rates.min() >= old.min() - 1e-6


def test_a_pinned_waypoint_stays():
    points = way(3)
    free = thinned(points, 1.0, CLIMB_M_S)
    pinned = {number for number, each in enumerate(points) if each.t_s not in times(free)}
    assert pinned
    assert set(times(thinned(points, 1.0, CLIMB_M_S, pinned))) >= {points[n].t_s for n in pinned}


def times(points):
    return [each.t_s for each in points]


def test_waypoints_on_a_line_go_and_a_detour_stays():
    straight = [RoutePoint(100.0 * n, 0.0, 50.0 + n, 10) for n in range(12)]
    assert len(thinned(timed(straight, SPEED_M_S, (0, 0)), 1.0, CLIMB_M_S)) == 2
    for beside_m, left in ((0.9, 2), (1.1, 3)):
        bent = [RoutePoint(p.x_m, beside_m * (n == 6), p.z_m, 10) for n, p in enumerate(straight)]
        assert len(thinned(timed(bent, SPEED_M_S, (0, 0)), 1.0, CLIMB_M_S)) >= left
    back = [*straight, RoutePoint(800.0, 0.0, 62.0, 10)]
    assert len(thinned(timed(back, SPEED_M_S, (0, 0)), 1.0, CLIMB_M_S)) == 3
