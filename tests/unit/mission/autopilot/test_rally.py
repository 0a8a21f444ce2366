"""Rally points of missions, judged by ground, zones and straight lines of the test's own."""

import math

import numpy as np
import pytest

from pathgene.host.flight.ground import demanded_m, known_surface_m
from pathgene.host.mission.autopilot.rally import rally_points
from pathgene.host.mission.autopilot.returns import needed_m
from pathgene.host.mission.autopilot.room import climb_slope
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


# A ridge from south to north at 4,000 m east, 600 m high, on a plain at 100 m.
RIDGE = Terrain("ridge", np.tile(np.where(np.arange(101) == 50, 600.0, 100.0), (41, 1)), 80.0, 80.0)


def points_of(*places):
    return [RoutePoint(float(x), float(y), float(z), 10) for x, y, z in places]


def problem_of(start, goal, zones=()):
    return Problem(RIDGE, start, goal, zones=zones)


def ground(x, y):
    """Return the height of the ridge by its corners: 600 m at 4,000 m east, 100 m a cell away."""
    del y
    return 100.0 + 500.0 * max(0.0, 1 - abs(x - 4000.0) / 80.0)


def test_circles_have_room_and_are_near_every_place():
    start, goal = (400.0, 1600.0, 750.0), (7600.0, 1600.0, 750.0)
    problem = problem_of(start, goal)
    found = rally_points(problem, points_of(start, goal))
    assert 3 <= len(found) <= 8
    radius_m = 2 * problem.aircraft.turn_radius_m
    clearance_m = problem.rules.clearance_m
    for point in found:
        for angle in np.linspace(0, 2 * math.pi, 24):
            x, y = (
                point.x_m + radius_m * math.cos(angle),
                point.y_m + radius_m * math.sin(angle),
            )
            assert ground(x, y) + clearance_m <= point.z_m + 1e-6
    for x in np.linspace(400, 7600, 50):
        assert min(math.dist((x, 1600.0), (point.x_m, point.y_m)) for point in found) < 1500


def test_no_circle_is_in_a_zone():
    start, goal = (400.0, 1600.0, 750.0), (7600.0, 1600.0, 750.0)
    zone = Circle(2800.0, 1600.0, 500.0)
    with_zone = rally_points(problem_of(start, goal, (zone,)), points_of(start, goal))
    assert all(math.dist((p.x_m, p.y_m), (2800.0, 1600.0)) > 500 for p in with_zone)
    without = rally_points(problem_of(start, goal), points_of(start, goal))
    assert any(math.dist((p.x_m, p.y_m), (2800.0, 1600.0)) < 500 for p in without)


def test_a_circle_is_as_high_as_the_returns_to_it_need():
    """The mission passes the ridge at its north end; the return to the first circle crosses it."""
    start, goal = (3000.0, 1600.0, 300.0), (5000.0, 1600.0, 300.0)
    problem = problem_of(start, goal)
    way = points_of(start, (3000.0, 2500.0, 700.0), (5000.0, 2500.0, 700.0), goal)
    found = rally_points(problem, way)
    assert max(point.z_m for point in found) >= 600 + problem.rules.clearance_m


@pytest.mark.parametrize("from_m", [650.0, 900.0, 1500.0])
def test_the_return_height_is_the_least_that_keeps_the_clearance(from_m):
    problem = problem_of((400.0, 1600.0, 750.0), (7600.0, 1600.0, 750.0))
    place = np.array([[3000.0, 1600.0, from_m]])
    (needed,) = needed_m(problem, place, (6000.0, 1600.0))
    clearance_m = problem.rules.clearance_m

    def least(end_m):
        """Return the clearance of an even descent."""
        shares = np.linspace(0, 1, 3001)
        return min(from_m + s * (end_m - from_m) - ground(3000 + 3000 * s, 0) for s in shares)

    assert least(needed) == pytest.approx(clearance_m, abs=2.0)
    assert least(needed - 20.0) < clearance_m - 2.0


def test_a_climb_that_is_too_steep_has_no_return_height():
    problem = problem_of((400.0, 1600.0, 750.0), (7600.0, 1600.0, 750.0))
    slope = climb_slope(problem)
    clearance_m = problem.rules.clearance_m
    far_m = (600 + clearance_m - 200) / slope + 300
    near, far = (np.array([[4000.0 - away, 1600.0, 200.0]]) for away in (500.0, far_m))
    assert math.isinf(needed_m(problem, near, (6000.0, 1600.0))[0])
    assert needed_m(problem, near, (6000.0, 1600.0), climbs_first=True)[0] == pytest.approx(
        600 + clearance_m, abs=15.0
    )
    if far_m < 3900:
        assert needed_m(problem, far, (6000.0, 1600.0))[0] == pytest.approx(
            600 + clearance_m, abs=15.0
        )


@pytest.mark.parametrize(("north_m", "counts"), [(1620.0, True), (1500.0, False)])
def test_the_ground_in_the_corridor_beside_a_return_counts(north_m, counts):
    """A wall from 1,640 m north on, its foot included, beside a return from west to east."""
    wall = Terrain(
        "wall",
        np.where(np.arange(161)[:, None] * 20.0 >= 1640.0, 600.0, np.zeros((161, 401))),
        20,
        20,
    )
    problem = Problem(wall, (400.0, 1600.0, 750.0), (7600.0, 1600.0, 750.0))
    place = np.array([[1000.0, north_m, 900.0]])
    (needed,) = needed_m(problem, place, (6000.0, north_m), climbs_first=True)
    assert (needed > 600.0) == counts


def test_a_return_through_a_zone_has_no_height():
    zone = Circle(5000.0, 1600.0, 200.0)
    problem = problem_of((400.0, 1600.0, 750.0), (7600.0, 1600.0, 750.0), (zone,))
    places = np.array([[4500.0, 1600.0, 900.0], [4500.0, 2600.0, 900.0]])
    assert np.isinf(needed_m(problem, places, (6000.0, 1600.0))[0])
    assert np.isfinite(needed_m(problem, places, (6000.0, 2600.0))[1])


@pytest.mark.parametrize("seed", [1, 3, 4, 5])
def test_one_return_keeps_the_clearance_everywhere_in_its_corridor(seed):
    rng = np.random.default_rng(seed)
    land = Terrain("rough", 300 + rng.exponential(20.0, (101, 301)), 8.0, 8.0)
    home, goal = (60.0, 200.0, 500.0), (2300.0, 600.0, 500.0)
    problem = Problem(land, home, goal)
    (needed,) = needed_m(problem, np.array([goal]), home[:2], climbs_first=True)
    share, beside = rng.random(40_000), rng.uniform(-25.0, 25.0, 40_000)
    east, north = np.subtract(goal[:2], home[:2]) / math.dist(goal[:2], home[:2])
    x = home[0] + share * (goal[0] - home[0]) - beside * north
    y = home[1] + share * (goal[1] - home[1]) + beside * east
    highest = float((known_surface_m(land, x, y) + demanded_m(problem, x, y)).max())
    assert highest - 0.1 <= needed <= highest + 0.5
