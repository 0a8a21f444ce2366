"""The end of a mission: its items, and the same as data to draw."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.formats.flight_plan import LOITER, RTL
from pathgene.host.mission.autopilot.ends import NoRoomError
from pathgene.host.mission.autopilot.hand_over import USUAL, HandOver
from pathgene.host.mission.autopilot.mission_lists import ARDUPILOT, PX4
from pathgene.host.mission.ending import Ending
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.water import under_water
from pathgene.sim.autopilot_flight import fly_items, give_mission, launched
from tests.support.autopilot.landings import plan_of
from tests.support.host.missions import flight, flight_of, make_mission


def task(heights, goal, **options):
    terrain = Terrain("hills", heights, 50.0, 50.0, "EPSG:32632", (5e5, 5e6))
    start = (600.0, 500.0, np.nanmax(heights) + 100.0)
    return Problem(terrain, start, goal, **options), np.array([start, goal])


@pytest.mark.parametrize("seed", [1, 4, 5])
def test_a_loiter_is_drawn_where_it_is_flown(seed):
    problem, _ = make_mission(seed)
    plan = flight(seed)
    item, end = plan.items[-1], plan.end
    assert (end.kind, item.command) == ("loiter", LOITER)
    x, y = problem.terrain.to_local(item.lat, item.lon)
    assert math.dist((x, y, item.alt_m), (end.circle.x_m, end.circle.y_m, end.circle.z_m)) < 0.01
    assert end.circle.radius_m == item.params[2]
    assert end.way[0] == problem.goal


def pit():
    heights = np.full((161, 161), 3000.0)
    heights[78:83, 78:83] = 0.0
    return heights


def void():
    heights = np.full((161, 161), np.nan)
    heights[78:83, 78:83] = 0.0
    heights[5:20, 5:20] = 0.0
    return heights


@pytest.mark.parametrize(
    ("problem", "reason", "advice"),
    [
        (
            lambda: task(pit(), (4000.0, 4000.0, 60.0)),
            "is over ground 2940 m above it",
            "a goal 2970 m higher, where a circle has room, --end rtl, which has room",
        ),
        (
            lambda: task(void(), (4000.0, 4000.0, 60.0)),
            "is over ground of unknown height",
            "a goal at x 622 m, y 622 m and an altitude of 60 m, where a circle has room",
        ),
        (
            lambda: task(np.zeros((21, 41)), (1800.0, 800.0, 60.0)),
            "leaves the map",
            "a goal at x 1700 m, y 700 m and an altitude of 60 m, where a circle has room, --end "
            "rtl, which has room",
        ),
        (lambda: task(np.zeros((11, 41)), (1800.0, 300.0, 60.0)), "leaves the map", "a larger map"),
        (
            lambda: task(
                np.zeros((161, 161)),
                (4000.0, 4000.0, 60.0),
                zones=[Circle(4000.0, 4300.0, 200.0, name="Fort")],
                wind=(15.0, 0.0),
            ),
            "meets the no-fly zone Fort",
            "a goal at x 3585 m, y 3309 m and an altitude of 60 m, where a circle has room",
        ),
    ],
)
def test_refuses_a_circle_without_room(problem, reason, advice):
    with pytest.raises(NoRoomError) as refusal:
        flight_of(*problem(), wanted=USUAL)
    said = str(refusal.value)
    assert f" m around the goal, which {reason}, and no other circle near it has room; " in said
    assert said.endswith(f"has room; give {advice}, or a landing (--land).")


def gorge():
    """A gorge that is too narrow for a circle, and plateaus beyond the climb of a short way."""
    heights = np.full((161, 161), 500.0)
    heights[78:83, :] = 0.0
    return Terrain("gorge", heights, 50.0, 50.0, "EPSG:32632", (5e5, 5e6))


@pytest.mark.parametrize(
    ("problem", "raise_m"),
    [
        (lambda: task(np.zeros((21, 41)), (1800.0, 800.0, 60.0))[0], 0),
        (lambda: Problem(gorge(), (500.0, 4000.0, 60.0), (7000.0, 4000.0, 60.0)), 0),
        (lambda: Problem(gorge(), (4600.0, 4000.0, 60.0), (7000.0, 4000.0, 60.0)), 24),
    ],
)
def test_the_goal_of_the_advice_has_room(problem, raise_m):
    given = problem()
    with pytest.raises(NoRoomError) as refusal:
        flight_of(given, np.array([given.start, given.goal]), wanted=USUAL)
    goal = refusal.value.goal
    assert goal.raise_m == raise_m
    x, y, z = given.start
    advised = replace(given, start=(x, y, z + raise_m), goal=goal.place)
    assert (f"a start {raise_m} m higher" in str(refusal.value)) == bool(raise_m)
    flight_of(advised, np.array([advised.start, advised.goal]), wanted=USUAL)


def test_the_goal_of_the_advice_keeps_the_ceilings():
    """The rim of the pit is 3,000 m high."""
    rules = Rules(ceiling_agl_m=400.0)
    given, path = task(pit(), (4000.0, 4000.0, 60.0), rules=rules)
    with pytest.raises(NoRoomError) as refusal:
        flight_of(given, path, wanted=USUAL)
    x, y, z = refusal.value.goal.place
    assert (x, y) != given.goal[:2]
    assert z - given.terrain.ground(x, y) <= 400.0


def test_a_return_ends_the_mission_and_names_its_height():
    heights = np.zeros((161, 161))
    heights[60:70, :] = 250.0
    plan = flight_of(*task(heights, (4000.0, 6000.0, 60.0)), wanted=HandOver(ending=Ending("rtl")))
    assert plan.items[-1].command == RTL
    assert plan.end.kind == "rtl"
    assert plan.end.circle is None
    (note,) = (note for note in plan.notes if "straight return" in note)
    assert "ArduPlane needs RTL_ALTITUDE of 280 m or more" in note
    assert "PX4 needs RTL_RETURN_ALT of 280 m or more" in note


@pytest.mark.parametrize(
    ("zone", "autopilot", "reason"),
    [
        ((2300.0, 3000.0, 300.0), None, "it passes through a no-fly zone or off the map, or is s"),
        ((2300.0, 3000.0, 300.0), PX4, "it passes through a no-fly zone or off the map; give --"),
        ((600.0, 800.0, 200.0), None, "no circle around home has room; give --end loiter, which"),
    ],
)
def test_refuses_a_return_without_room(zone, autopilot, reason):
    problem, path = task(np.zeros((161, 161)), (4000.0, 5500.0, 160.0), zones=[Circle(*zone)])
    wanted = HandOver(ending=Ending("rtl"), autopilot=autopilot)
    with pytest.raises(NoRoomError) as refusal:
        flight_of(problem, path, wanted=wanted)
    said = str(refusal.value)
    assert said.startswith("The mission cannot end with a straight return to home at any return")
    assert f" because {reason}" in said
    assert said.endswith("; give --end loiter, which has room, or a landing (--land).")


def test_a_return_of_one_autopilot_is_enough():
    """A wall before the goal is too steep for ArduPlane, which climbs on its way."""
    heights = np.zeros((161, 161))
    heights[98:101, :] = 400.0
    problem, path = task(heights, (4000.0, 5500.0, 100.0))
    wanted = HandOver(ending=Ending("rtl"))
    (note,) = (note for note in flight_of(problem, path, wanted=wanted).notes if "return" in note)
    assert "ArduPlane has room at no return height, PX4 needs RTL_RETURN_ALT of 430 m" in note
    with pytest.raises(NoRoomError, match="or is steeper than the aircraft climbs; give"):
        flight_of(problem, path, wanted=replace(wanted, autopilot=ARDUPILOT))


@pytest.mark.parametrize(("level", "asks"), [(100.0, True), (0.0, False), ("none", False)])
def test_a_landing_on_the_water_is_asked_about(level, asks):
    heights = np.full((161, 161), 100.0)
    terrain = Terrain("coast", heights, 50.0, 50.0, "EPSG:32632", (5e5, 5e6))
    problem = Problem(under_water(terrain, level), (600.0, 500.0, 250.0), (4000.0, 3000.0, 250.0))
    notes = plan_of(problem, (4000.0, 6000.0, 0.0)).notes
    sentence = "The landing ends at 100.0 m, the level of the water; is it on land?"
    assert (sentence in notes) == asks


def test_the_uploaded_mission_returns_to_home():
    """A rally point near the goal would be nearer, and end the mission there."""
    problem, path = task(np.zeros((161, 161)), (4000.0, 6000.0, 160.0))
    plan = flight_of(problem, path, wanted=HandOver(ending=Ending("rtl")))
    autopilot = launched(problem, plan)
    give_mission(autopilot, plan)
    fly_items(autopilot)
    # Home is below the first waypoint.
    assert math.hypot(*autopilot.pilot.vehicle.place) < 2 * problem.aircraft.turn_radius_m
