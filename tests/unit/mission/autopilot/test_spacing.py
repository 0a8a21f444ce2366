"""Waypoints at least a second of flight apart."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from pathgene.host.formats.flight_plan import WAYPOINT
from pathgene.host.formats.places import degrees
from pathgene.host.mission.autopilot.ends import NoRoomError
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.spacing import accepted, spaced
from pathgene.host.mission.autopilot.timing import timed
from pathgene.sim.autopilot.places import Plane
from tests.support.host.missions import SEEDS, flight, make_mission


def points_of(*places):
    return [RoutePoint(x, y, 100.0, 10) for x, y in places]


def kept(points, apart_m=25.0):
    return [each.point for each in spaced(timed(points, 23.0, (0.0, 0.0)), apart_m)]


def test_a_dip_between_places_on_a_line_is_kept():
    """Flown at the height of its ends, the path could meet a zone or a ceiling over the dip."""
    heights = (95.0, 40.0, 30.0, 30.2, 30.0, 45.0, 95.0)
    points = [RoutePoint(500.0 * n, 0.0, z, 10) for n, z in enumerate(heights)]
    left = kept(points)
    assert [point.z_m for point in left] == [95.0, 40.0, 30.0, 30.0, 45.0, 95.0]
    slow = [replace(point, z_m=100.0 - 0.9 * (n % 2)) for n, point in enumerate(points)]
    assert len(kept(slow)) == 2


def test_many_small_changes_of_height_do_not_add_up():
    """The sag of a shallow curve is more than each of its points changes."""
    points = [RoutePoint(100.0 * n, 0.0, 0.02 * (n - 30) ** 2, 10) for n in range(61)]
    left = kept(points)
    x, z = np.array([(point.x_m, point.z_m) for point in left]).T
    planned = np.array([point.z_m for point in points])
    assert abs(np.interp([point.x_m for point in points], x, z) - planned).max() < 1.0
    assert len(left) < 30


def test_a_waypoint_next_to_another_one_is_left_out():
    points = points_of((0, 0), (500, 0), (501.5, 0.5), (1000, 400), (1500, 400))
    assert [(p.x_m, p.y_m) for p in kept(points)] == [
        (0, 0),
        (501.5, 0.5),
        (1000, 400),
        (1500, 400),
    ]


def test_corners_of_an_arc_stay_and_its_tangent_points_go():
    angles = np.radians([0, 10, 20, 30])
    corners = [(1000 + 300 * math.sin(a), 300 - 300 * math.cos(a)) for a in angles]
    middles = [tuple(np.mean(pair, axis=0)) for pair in pairwise(corners)]
    points = points_of((0, 0), corners[0], middles[0], corners[1], middles[1], *corners[2:])
    assert kept(points) == points_of((0, 0), *corners)


def test_start_and_goal_stay():
    points = points_of((0, 0), (5, 0), (10, 0))
    assert kept(points) == points_of((0, 0), (10, 0))


def test_acceptance_radii_are_ten_metres_or_more_where_neighbours_allow():
    points = [RoutePoint(x, 0.0, 100.0, radius) for x, radius in ((0, 3), (40, 60), (400, 255))]
    assert [point.acceptance_m for point in accepted(points)] == [10, 39, 255]
    # The way of the roll makes turns earlier, and no radius larger that is not one of a turn.
    assert [point.acceptance_m for point in accepted(points, 9.3)] == [10, 39, 255]
    turns = [replace(point, acceptance_m=20) for point in points]
    assert [point.acceptance_m for point in accepted(turns, 9.3)] == [29, 29, 29]


@pytest.mark.parametrize(
    "seeds", [SEEDS, pytest.param(range(60, 1060), marks=pytest.mark.long)], ids=["few", "many"]
)
def test_exported_waypoints_are_a_second_of_flight_apart(seeds):
    for seed in seeds:
        problem, _ = make_mission(seed)
        try:
            plan = flight(seed)
        except NoRoomError:
            assert seed not in SEEDS
            continue
        plane = Plane(plan.home[0], plan.home[1])
        places = [plane.local(i.lat, i.lon) for i in plan.items if i.command == WAYPOINT]
        x, y = np.array(problem.goal[:2])[:, None]
        goal = plane.local(*degrees(problem.terrain, x, y)[0])
        for number, (a, b) in enumerate(pairwise(places)):
            leg = np.subtract(b, a)
            gap = math.hypot(*leg)
            wind = np.dot(leg, problem.wind) / gap if gap else 0.0
            is_end = number == 0 or min(math.dist(a, goal), math.dist(b, goal)) < 1.0
            assert gap >= 0.97 * (problem.aircraft.cruise_speed_m_s + wind) or is_end, seed
