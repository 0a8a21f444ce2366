"""The circle at the end of a mission."""

import math
from itertools import pairwise

import numpy as np
import pytest

from pathgene.host.flight.ground import demanded_m, known_surface_m
from pathgene.host.mission.autopilot.loiter import loiter
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


APART_M = 25.3
EAST = (1.0, 0.0)


def problem(heights, goal, **options):
    terrain = Terrain("hills", heights, 50.0, 50.0, "EPSG:32632", (5e5, 5e6))
    return Problem(terrain, (200.0, 200.0, heights.max() + 100.0), goal, **options)


def ridge(height_m, east_m):
    heights = np.zeros((161, 161))
    heights[:, round(east_m / 50) :] = height_m
    return heights


def disc(end):
    """Return points of the disc of a circle."""
    steps = np.linspace(-end.disc_m, end.disc_m, 121)
    x, y = (grid.ravel() for grid in np.meshgrid(steps, steps))
    inside = np.hypot(x, y) <= end.disc_m
    return end.x_m + x[inside], end.y_m + y[inside]


def test_a_goal_with_room_is_the_centre():
    end = loiter(problem(np.zeros((161, 161)), (4000.0, 4000.0, 60.0)), EAST, APART_M)
    assert (end.x_m, end.y_m, end.z_m, end.radius_m) == (4000.0, 4000.0, 60.0, 150)
    assert (end.way, end.has_room, end.disc_m) == ((), True, 300.0)


@pytest.mark.parametrize(("wind", "east_m"), [((0.0, 0.0), 4300.0), ((8.0, 0.0), 4450.0)])
@pytest.mark.parametrize("height_m", [60.0, 200.0])
def test_a_disc_of_twice_the_radius_keeps_the_clearance(height_m, wind, east_m):
    task = problem(ridge(height_m, east_m), (4000.0, 4000.0, 70.0), wind=wind)
    end = loiter(task, EAST, APART_M)
    assert end.has_room
    assert end.way
    assert end.disc_m >= 2 * end.radius_m
    x, y = disc(end)
    clearance = end.z_m - known_surface_m(task.terrain, x, y)
    assert (clearance >= demanded_m(task, x, y) - 1e-6).all()


def test_the_way_there_turns_no_tighter_than_planned_and_climbs_no_steeper():
    task = problem(ridge(200.0, 4300.0), (4000.0, 4000.0, 70.0))
    end = loiter(task, EAST, APART_M)
    places = [(4000.0, 4000.0, 70.0), *((p.x_m, p.y_m, p.z_m) for p in end.way)]
    for a, b in pairwise(places):
        way_m = math.dist(a[:2], b[:2])
        assert way_m >= APART_M
        assert (b[2] - a[2]) / way_m <= math.tan(math.radians(10.0))
    assert places[-1][2] == end.z_m
    # The lag of the height is left before the disc.
    assert math.dist(places[-1][:2], (end.x_m, end.y_m)) >= end.disc_m + 3.0 * 23.0 - 1.0


def test_no_zone_is_in_the_disc():
    zones = (Circle(4230.0, 4000.0, 60.0),)
    end = loiter(problem(np.zeros((161, 161)), (4000.0, 4000.0, 60.0), zones=zones), EAST, APART_M)
    assert end.has_room
    assert math.dist((end.x_m, end.y_m), (4230.0, 4000.0)) >= end.disc_m + 60.0
    # A zone that ends below the circle by more than the margin does not count.
    for upper_m, counts in ((34.0, False), (36.0, True)):
        zones = (Circle(4230.0, 4000.0, 60.0, upper_m=upper_m),)
        task = problem(np.zeros((161, 161)), (4000.0, 4000.0, 60.0), zones=zones)
        assert bool(loiter(task, EAST, APART_M).way) == counts


@pytest.mark.parametrize(("ceiling_m", "highest_m"), [(89.0, 88.7), (80.0, 63.1)])
def test_a_circle_after_a_climb_keeps_the_ceiling_above_the_ground(ceiling_m, highest_m):
    y, x = 50.0 * np.mgrid[:161, :161]
    basin = np.clip(0.1 * (np.hypot(x - 4000.0, y - 4000.0) - 100.0), 0.0, 90.0)
    rules = Rules(clearance_m=30.0, ceiling_agl_m=ceiling_m)
    task = problem(basin, (4000.0, 4000.0, 48.0), rules=rules)
    end = loiter(task, EAST, APART_M)
    assert end.has_room
    assert end.z_m > 48.0
    above = end.z_m - known_surface_m(task.terrain, *disc(end))
    assert above.max() == pytest.approx(highest_m, abs=0.1)


def test_a_goal_in_a_pit_has_no_room():
    heights = np.full((161, 161), 3000.0)
    heights[78:83, 78:83] = 0.0
    end = loiter(problem(heights, (4000.0, 4000.0, 60.0)), EAST, APART_M)
    assert (end.has_room, end.way, end.z_m) == (False, (), 60.0)


def test_a_circle_that_no_turn_by_a_multiple_of_30_degrees_leads_to(monkeypatch):
    heights = np.full((201, 201), 500.0)
    y, x = 50.0 * np.mgrid[:201, :201]
    place = (4530.0, 6095.0)
    along = np.clip(((x - 5000.0) * -470.0 + (y - 5000.0) * 1095.0) / (470.0**2 + 1095.0**2), 0, 1)
    heights[np.hypot(x - 5000.0 + 470.0 * along, y - 5000.0 - 1095.0 * along) <= 250.0] = 0.0
    heights[np.hypot(x - 5000.0, y - 5150.0) <= 240.0] = 0.0
    heights[np.hypot(x - place[0], y - place[1]) <= 400.0] = 0.0
    task = problem(heights, (5000.0, 5000.0, 60.0))
    end = loiter(task, EAST, APART_M)
    assert end.has_room
    assert math.dist((end.x_m, end.y_m), place) < 400.0
    assert (known_surface_m(task.terrain, *disc(end)) == 0.0).all()
    monkeypatch.setattr("pathgene.host.mission.autopilot.loiter._ACROSS", 0)
    assert not loiter(task, EAST, APART_M).has_room


def test_the_disc_is_wider_in_thin_air():
    """ArduPlane flies the radius times the squared ratio of true and equivalent airspeed."""
    heights = np.full((161, 161), 5000.0)
    end = loiter(problem(heights, (4000.0, 4000.0, 5060.0)), EAST, APART_M)
    assert end.disc_m > 1.66 * 1.3 * end.radius_m
