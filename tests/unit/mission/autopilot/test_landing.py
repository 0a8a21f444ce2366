"""The landing at the end of a mission: its geometry and its room."""

import dataclasses
import json
import math

import numpy as np
import pytest
from pymavlink import mavwp

from pathgene.host.flight.ground import demanded_m, known_surface_m
from pathgene.host.formats.flight_plan import LAND, LAND_START, LOITER_TO_ALT, WAYPOINT
from pathgene.host.formats.plan import plan_document, read_plan
from pathgene.host.formats.waypoints import waypoints_text
from pathgene.host.mission.autopilot import landing
from pathgene.host.mission.autopilot.ends import NoRoomError
from pathgene.host.problem.aircraft import load
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain
from pathgene.sim.autopilot.pilot import Kind
from tests.support.autopilot.landings import SHARE_OF_HEIGHT, airborne, fly, plan_of, start
from tests.support.host.earth import single
from tests.support.host.missions import flight_of
from tests.unit.mission.autopilot.mavsdk_autopilot import importer


# A landing to the north, and the slope of its glide: 0.6 of the one at idle, 4.54 degrees.
PLACE, SLOPE = (5000.0, 7000.0), 0.6 * math.tan(math.radians(4.543))
LAND_NORTH = (*PLACE, 0.0)


def task(heights=None, goal=(4000.0, 3500.0, 100.0), **options):
    heights = np.zeros((241, 201)) if heights is None else heights
    # On the central meridian, where the grid's north is the true one.
    terrain = Terrain("hills", heights, 50.0, 50.0, "EPSG:32632", (495_000.0, 5e6))
    return Problem(terrain, (1500.0, 1500.0, 150.0), goal, **options)


def hill(height_m, before_m, east_m=0.0):
    """Return land with a hill of one node before the touch-down."""
    heights = np.zeros((241, 201))
    x, y = PLACE[0] + east_m, PLACE[1] - before_m
    heights[round(y / 50), round(x / 50)] = height_m
    return heights


def test_the_glide_is_straight_and_ends_at_the_place():
    plan = plan_of(task(), LAND_NORTH)
    *_, start, loiter, glide, land = plan.items
    commands = [item.command for item in (start, loiter, glide, land)]
    assert commands == [LAND_START, LOITER_TO_ALT, WAYPOINT, LAND]
    end = plan.end
    (x, y, z), touch_down = end.way[-2:]
    assert touch_down == pytest.approx((*PLACE, 0.0))
    assert x == pytest.approx(PLACE[0], abs=8.0)  # Half a millidegree between the two norths.
    assert z / (PLACE[1] - y) == pytest.approx(SLOPE, rel=1e-4)
    assert (loiter.alt_m, loiter.params[1]) == (end.circle.z_m, end.circle.radius_m)
    assert end.circle.z_m == z == glide.alt_m
    # The circle is on the same line, and its disc ends where the aircraft's lag begins.
    assert end.circle.x_m == pytest.approx(PLACE[0], abs=12.0)
    assert y - end.circle.y_m - end.circle.disc_m == pytest.approx(3.0 * 23.0, abs=1.0)
    assert land.params[3] == 0.0
    assert land.params[0] == math.ceil(end.go_around_circle.z_m - plan.home[2])


def places_of(plan):
    """Return places and heights along the glide and along the climb of a missed approach."""
    for begin, stop in (plan.end.way[-2:], plan.end.go_around):
        share = np.linspace(0, 1, 400)[:, None]
        yield (np.array(begin) + share * (np.array(stop) - np.array(begin))).T


@pytest.mark.ci
@pytest.mark.parametrize("seed", range(2))
def test_glide_climb_and_circles_keep_the_clearance_on_random_hills(seed):
    rng = np.random.default_rng(seed)
    heights = np.zeros((241, 201))
    for row, column in rng.integers((90, 60), (170, 140), (40, 2)):
        heights[row, column] = rng.uniform(5, 120)
    problem = task(heights, wind=tuple(rng.uniform(-4, 4, 2)))
    found = 0
    for heading in range(0, 360, 30):
        try:
            plan = plan_of(problem, (*PLACE, float(heading)))
        except NoRoomError:
            continue
        found += 1
        for x, y, z in places_of(plan):
            required = np.minimum(
                demanded_m(problem, x, y), SHARE_OF_HEIGHT * (z - plan.end.way[-1][2])
            )
            assert (z - known_surface_m(problem.terrain, x, y) >= required - 1e-6).all()
        for circle in (plan.end.circle, plan.end.go_around_circle):
            angles, radii = (
                grid.ravel() for grid in np.meshgrid(np.linspace(0, 6.3, 90), np.linspace(0, 1, 9))
            )
            x = circle.x_m + radii * circle.disc_m * np.cos(angles)
            y = circle.y_m + radii * circle.disc_m * np.sin(angles)
            # The points of the disc are a cell apart, so a summit of one node may be between them.
            clearance = circle.z_m - known_surface_m(problem.terrain, x, y)
            assert np.percentile(clearance - demanded_m(problem, x, y), 1) >= -1e-6
    assert found >= 2


@pytest.mark.parametrize(
    ("height_m", "before_m", "east_m", "refused"),
    [
        # The hill counts to 375 m before the touch-down. The glide is 17.9 m high there, and
        # ArduPlane's 17.0 m, so the surface may be 8.1 m.
        (8.0, 400.0, 0.0, False),
        (8.5, 400.0, 0.0, True),
        # Beside the strip, which is 31 m wide on either side.
        (16.0, 400.0, 100.0, False),
    ],
)
def test_a_hill_under_the_glide_is_refused(height_m, before_m, east_m, refused):
    problem = task(hill(height_m, before_m, east_m))
    if not refused:
        plan_of(problem, LAND_NORTH)
        return
    with pytest.raises(NoRoomError) as refusal:
        plan_of(problem, LAND_NORTH)
    assert str(refusal.value) == (
        "The mission cannot land at 5000, 7000 with a heading of 0 degrees: the glide meets "
        "ground, a no-fly zone or the ceiling; there is room with a heading of 15, else give "
        "another place (--land), or --end rtl."
    )
    plan_of(problem, (*PLACE, 15.0))


def wall(north_m, height_m):
    heights = np.zeros((241, 201))
    heights[round((PLACE[1] + north_m) / 50) :, :] = height_m
    return heights


@pytest.mark.parametrize(
    ("problem", "land", "reason"),
    [
        (lambda: task(wall(700.0, 500.0)), LAND_NORTH, "there is no room for a go-around"),
        (lambda: task(), (5000.0, 12100.0, 0.0), "it is off the map, or the ground is unknown"),
        (
            lambda: task(zones=[Circle(5000.0, 6700.0, 20.0)]),
            LAND_NORTH,
            "the glide meets ground, a no-fly zone or the ceiling",
        ),
        (
            lambda: task(rules=Rules(ceiling_m=38.0, clearance_m=30.0), goal=(4000, 3500, 35)),
            LAND_NORTH,
            "the glide meets ground, a no-fly zone or the ceiling",
        ),
        (
            lambda: task(rules=Rules(ceiling_agl_m=80.0, clearance_m=30.0)),
            LAND_NORTH,
            "there is no way from the goal to its circle",
        ),
        (
            lambda: task(np.where(np.arange(241)[:, None] == 90, 900.0, np.zeros((241, 201)))),
            LAND_NORTH,
            "there is no way from the goal to its circle",
        ),
    ],
)
def test_refuses_a_landing_without_room(problem, land, reason):
    with pytest.raises(NoRoomError, match=reason):
        plan_of(problem(), land)


def test_a_zone_below_the_glide_by_more_than_its_margin_is_no_obstacle():
    for upper_m, refused in ((1.0, False), (10.0, True)):
        problem = task(zones=[Circle(5000.0, 6250.0, 20.0, upper_m=upper_m, name="Fort")])
        try:
            plan = plan_of(problem, LAND_NORTH)
        except NoRoomError:
            assert refused
        else:
            assert not refused
            # A fence would forbid the glide over it.
            assert not plan.fence
            assert any(note.startswith("No fence for Fort: ") for note in plan.notes)


def test_a_high_goal_loses_its_height_on_the_circle():
    plan = plan_of(task(goal=(4000.0, 3500.0, 600.0)), LAND_NORTH)
    heights = [z for _, _, z in plan.end.way]
    assert heights[-3] == 600.0
    assert heights[-2] == plan.end.circle.z_m < 100.0


def test_a_low_goal_climbs_to_the_circle_no_steeper_than_the_aircraft():
    heights = np.zeros((241, 201))
    heights[110:, :] = 200.0
    problem = task(heights, goal=(4000.0, 3000.0, 60.0))
    plan = plan_of(problem, LAND_NORTH)
    (x, y, low), *_, (to_x, to_y, high) = plan.end.way[:-2]
    assert high >= 230.0
    assert (high - low) / math.hypot(to_x - x, to_y - y) < math.tan(math.radians(10.0))


def test_the_glide_is_no_steeper_than_the_aircraft_descends():
    aircraft = dataclasses.replace(load("silver-fox"), max_descent_deg=2.0)
    plan = plan_of(task(aircraft=aircraft), LAND_NORTH)
    (_, y, z), (_, to_y, ground) = plan.end.way[-2:]
    assert math.degrees(math.atan2(z - ground, to_y - y)) == pytest.approx(2.0, abs=0.01)


@pytest.mark.parametrize(
    ("name", "wind", "least", "most"),
    [
        # 0.6 of 4.5 degrees without thrust, over the ground in a tail wind.
        ("silver-fox", (0.0, 0.0), 2.70, 2.75),
        ("silver-fox", (0.0, 8.0), 2.0, 2.05),
        ("silver-fox", (0.0, -8.0), 2.70, 2.75),
        ("predator", (0.0, 0.0), 1.7, 1.75),
        ("sperwer", (0.0, 0.0), 3.99, 4.01),
    ],
)
def test_the_glide_needs_no_brakes(name, wind, least, most):
    heights = np.zeros((481, 401))
    terrain = Terrain("plain", heights, 50.0, 50.0, "EPSG:32632", (495_000.0, 5e6))
    problem = Problem(
        *(terrain, (5000.0, 5000.0, 150.0), (9000.0, 9000.0, 150.0)), load(name), wind=wind
    )
    plan = plan_of(problem, (10_000.0, 15_000.0, 0.0))
    (_, y, z), (_, to_y, ground) = plan.end.way[-2:]
    assert least < math.degrees(math.atan2(z - ground, to_y - y)) < most
    notes = [note for note in plan.notes if "tail wind of 8 m/s" in note]
    assert len(notes) == (wind == (0.0, 8.0))
    assert all(note.endswith("against the wind, its heading is 180.") for note in notes)


def test_ground_stations_read_the_same_items(tmp_path):
    plan = plan_of(task(), (*PLACE, 250.0))
    file = tmp_path / "path.waypoints"
    file.write_text(waypoints_text(plan))
    loader = mavwp.MAVWPLoader()
    assert loader.load(str(file)) == len(plan.items) + 1
    with importer() as read:
        imported = read(json.dumps(plan_document(plan))).mission_items
    again = read_plan_of(plan, tmp_path)
    for number, item in enumerate(plan.items):
        row = loader.wp(number + 1)
        params = [row.param1, row.param2, row.param3, row.param4]
        assert (row.command, params) == (item.command, [param or 0 for param in item.params])
        assert (imported[number].command, imported[number].z) == (item.command, single(item.alt_m))
        theirs = [getattr(imported[number], f"param{n}") for n in (1, 2, 3, 4)]
        assert theirs == pytest.approx(
            [math.nan if param is None else single(param) for param in item.params], nan_ok=True
        )
        assert again.items[number] == item


def read_plan_of(plan, folder):
    file = folder / "path.plan"
    file.write_text(json.dumps(plan_document(plan)))
    return read_plan(file)


@pytest.mark.parametrize("kind", Kind)
def test_the_autopilot_lands_there(kind):
    problem = task(hill(8.0, 400.0))
    plan = plan_of(problem, LAND_NORTH)
    flight = fly(problem, plan, kind)
    assert abs(flight.touch_down_m[1]) < 1.0
    assert flight.over_m < {Kind.ARDUPLANE: 2.0, Kind.PX4: 9.0}[kind]
    assert np.nanmin(flight.share) >= 0.5


def test_px4_starts_a_mission_with_a_landing_alone():
    problem = task()
    path = np.array([problem.start, problem.goal])
    for plan, result in ((plan_of(problem, LAND_NORTH), 0), (flight_of(problem, path), 2)):
        autopilot = airborne(problem, plan, Kind.PX4)
        assert start(autopilot) == result
        refused = "Mission rejected: Landing waypoint/pattern required."
        assert (autopilot.mission_refusal() == refused) == (result == 2)


@pytest.mark.ci
def test_a_hill_under_a_glide_without_the_rule_is_noticed(monkeypatch):
    """The flight is judged by a rule of its own."""
    monkeypatch.setattr(landing, "SHARE_OF_HEIGHT", -9.0)
    problem = task(hill(26.0, 400.0))
    flight = fly(problem, plan_of(problem, LAND_NORTH), Kind.ARDUPLANE)
    assert np.nanmin(flight.share) < 0.5


@pytest.mark.ci
def test_a_glide_that_begins_too_high_is_noticed():
    problem = task(goal=(4000.0, 3500.0, 150.0))
    plan = plan_of(problem, LAND_NORTH)
    # The height is not lost on the circle, which comes first.
    items = tuple(
        dataclasses.replace(item, alt_m=150.0) if item.command == LOITER_TO_ALT else item
        for item in plan.items
    )
    flight = fly(problem, dataclasses.replace(plan, items=items), Kind.ARDUPLANE)
    assert max(flight.over_m, flight.touch_down_m[0]) > 30.0
