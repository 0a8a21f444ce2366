"""Early climbs, and limits above them."""

from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.mission.autopilot.early import climb_m_s, early
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.timing import timed
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


APART_S = 1.1
LEVEL_M, TOP_M = 300.0, 700.0


def make(**options):
    """Return a problem over a plain, and its plan: level, a climb at the limit, level."""
    terrain = Terrain("plain", np.zeros((30, 101)), 100.0, 100.0)
    start, goal = (500.0, 1500.0, LEVEL_M), (9500.0, 1500.0, TOP_M)
    problem = Problem(terrain, start, goal, **options)
    run = (TOP_M - LEVEL_M) / np.tan(problem.limits.climb_rad)
    places = ((500.0, LEVEL_M), (5000.0, LEVEL_M), (5000.0 + run, TOP_M), (9500.0, TOP_M))
    points = [RoutePoint(x, 1500.0, z, 10) for x, z in places]
    return problem, timed(points, problem.aircraft.cruise_speed_m_s, (0.0, 0.0))


def heights(points, along):
    """Return the heights of waypoints at metres along the x axis."""
    return np.interp(along, [p.point.x_m for p in points], [p.point.z_m for p in points])


def test_a_long_climb_begins_earlier_by_the_lag_and_a_reserve():
    problem, planned = make()
    points = early(problem, planned, planned, APART_S)
    seconds = (TOP_M - LEVEL_M) / climb_m_s(problem)
    speed = problem.aircraft.cruise_speed_m_s
    begins = 5000.0 - speed * (problem.aircraft.height_lag_s + (1 / 0.75 - 1) * seconds)
    assert heights(points, begins - 50) == pytest.approx(LEVEL_M, abs=0.1)
    assert heights(points, begins + 100) > LEVEL_M + 10


@pytest.mark.parametrize("floor_m", [LEVEL_M + 40, TOP_M + 40])
def test_a_climb_does_not_begin_below_a_zone_that_the_plan_passes_below(floor_m):
    zone = Circle(4850.0, 1500.0, 60.0, lower_m=floor_m)
    problem, planned = make(zones=(zone,))
    points = early(problem, planned, planned, APART_S)
    highest = heights(points, 4850.0 + 60 + 25)
    is_free = floor_m > TOP_M
    assert (highest > LEVEL_M + 15) == is_free
    # The climb begins earlier by the lag where that is possible.
    beside = replace(zone, x_m=4000.0)
    problem, planned = make(zones=(beside,))
    assert heights(early(problem, planned, planned, APART_S), 4970.0) > LEVEL_M + 1


def test_a_climb_keeps_the_ceiling_above_the_ground():
    land = np.zeros((30, 101))
    land[:, 53:] = TOP_M - 200
    rules = Rules(ceiling_agl_m=LEVEL_M + 50)
    problem, planned = make(rules=rules)
    problem = replace(problem, terrain=Terrain("step", land, 100.0, 100.0))
    points = early(problem, planned, planned, APART_S)
    assert heights(points, 4950.0) <= LEVEL_M + 50
    free = early(replace(problem, rules=Rules()), planned, planned, APART_S)
    assert heights(free, 4950.0) > LEVEL_M + 50
