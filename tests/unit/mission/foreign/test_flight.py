"""Missions as they are flown: commands, frames, home, jumps, circles, returns and landings."""

import numpy as np
import pytest

from pathgene.host.evaluation.laying import Z
from tests.support.host.foreign import PLAIN, item
from tests.support.host.planted_missions import NODES, degrees


AMSL, HOME, GROUND = 0, 3, 10
WAYPOINT, UNLIMITED, TURNS, TIME, RETURN, LAND, TAKEOFF, TO_ALT = 16, 17, 18, 19, 20, 21, 22, 31
JUMP, SPEED, LAND_START = 177, 178, 189


def points(check):
    """Return names and rounded places of all chains."""
    return [
        [(p.name, round(p.x_m), round(p.y_m), round(p.z_m)) for p in chain.points]
        for chain in check.flight.chains
    ]


def texts(check):
    return [remark.text for remark in check.reading.remarks]


NOWHERE = ", as its latitude and longitude are 0 or missing; give it one."
A, B, C, D = (600, 3000), (2000, 3000), (3400, 3200), (4800, 3000)


def test_heights_count_from_their_frames(check):
    slope = PLAIN + np.arange(NODES)[None, :]
    items = [item(WAYPOINT, A, 450), item(WAYPOINT, B, 100, HOME), item(WAYPOINT, C, 90, GROUND)]
    found = check(items, slope, home=(900, 3000, 333.0))
    # The ground rises by a metre each 30 m.
    assert points(found) == [
        [("item 1", 600, 3000, 450), ("item 2", 2000, 3000, 433), ("item 3", 3400, 3200, 503)]
    ]
    assert found.reading.facts["heights"] == [
        "above mean sea level",
        "above home",
        "above the ground, straight between the items",
    ]
    assert found.feasible


@pytest.mark.parametrize(("frame", "same"), [(5, AMSL), (6, HOME), (11, GROUND)])
def test_the_newer_frames_mean_the_same(frame, same, check):
    both = [
        points(check([item(WAYPOINT, A, 90, each), item(WAYPOINT, B, 90, each)], home=(*A, 300)))
        for each in (frame, same)
    ]
    assert both[0] == both[1]


@pytest.mark.parametrize(
    ("stated", "used", "grade"),
    [(None, 300, "note"), (0, 300, "warning"), (250, 250, "warning"), (400, 300, "warning")],
)
def test_the_lower_of_two_heights_of_home_counts(stated, used, grade, check):
    items = [item(WAYPOINT, A, 100, HOME), item(WAYPOINT, B, 100, HOME)]
    found = check(items, home=(*A, stated))
    assert points(found)[0][0][3] == used + 100
    text = "no altitude" if stated is None else f"the altitude {stated} m"
    (remark, _) = found.reading.remarks
    assert (str(remark.grade), remark.text) == (
        grade,
        f"home has {text}, and the ground there is at 300.0 m; heights above home are judged from "
        f"{used:.1f} m.",
    )


def test_home_that_is_missing_is_the_ground_below_the_first_place(check):
    items = [item(206), item(WAYPOINT, A, 100, HOME), item(WAYPOINT, B, 100, HOME)]
    found = check(items)
    assert points(found)[0][0][3] == 400
    assert texts(found) == [
        "no home; home is taken to be the ground below item 2, at 300.0 m.",
    ]
    assert found.flight.ignored == ("item 1 DO_SET_CAM_TRIGG_DIST (206)",)


def test_a_take_off_begins_on_the_ground_at_home(check):
    items = [item(TAKEOFF, B, 100, HOME), item(WAYPOINT, C, 100, HOME)]
    found = check(items, home=(*A, 300))
    assert points(found)[0][:2] == [("home", 600, 3000, 300), ("item 1", 2000, 3000, 400)]
    # Less clearance is required on the climb, and its start is no least clearance.
    assert found.feasible
    assert found.report["minimum_clearance_m"] == pytest.approx(100, abs=0.02)


def test_a_take_off_without_a_place_climbs_towards_the_next_item(check):
    items = [item(TAKEOFF, None, 100, HOME), item(WAYPOINT, B, 100, HOME)]
    found = check(items, home=(*A, 300))
    home, start, _ = found.flight.chains[0].points
    run = 100 / (0.9 * np.tan(np.radians(10)))
    assert start.x_m - home.x_m == pytest.approx(run, abs=0.1)
    assert texts(found) == [
        "item 1 (NAV_TAKEOFF (22)) has no place; the aircraft is taken to climb towards item 2."
    ]
    assert found.feasible


def test_a_landing_ends_on_the_ground(check):
    items = [item(LAND_START), item(WAYPOINT, A, 400), item(LAND, C, 300)]
    assert check(items).feasible
    # A runway far below the ground of the map excuses nothing.
    buried = check([item(WAYPOINT, A, 400), item(LAND, C, 280)])
    assert [fault.limit for fault in buried.faults] == ["clearance"]


def test_the_first_item_excuses_nothing_below_the_ground(check):
    found = check([item(WAYPOINT, A, 295), item(WAYPOINT, C, 400)])
    assert [(fault.limit, round(fault.metres)) for fault in found.faults] == [("clearance", 35)]


def test_a_return_flies_at_its_height_and_circles_over_home(check):
    items = [item(TAKEOFF, B, 100, HOME), item(WAYPOINT, C, 80, HOME), item(RETURN)]
    found = check(items, home=(*A, 300))
    assert points(found)[0][-1] == ("home", 600, 3000, 400)
    assert found.flight.chains[0].points[-1].circle_m == 150
    assert texts(found) == [
        "item 3 (NAV_RETURN_TO_LAUNCH (20)) returns to home at 100 m above home.",
        "the height of the return, 100 m above home, is the default of ArduPilot; "
        "--return-height states another one.",
    ]
    # The climb comes first.
    track = found.judge.track(found.flight.chains[0].points)
    assert list(track.rows[track.legs == 2][:, Z].round()) == [380, 400]
    px4 = check(items, home=(*A, 300), firmware=12)
    assert points(px4)[0][-1][3] == 360
    stated = check(items, home=(*A, 300), return_m=55.0)
    assert points(stated)[0][-1][3] == 355
    assert len(stated.reading.remarks) == 1


def test_a_return_goes_to_the_nearest_rally_point(check):
    items = [item(WAYPOINT, A, 400), item(WAYPOINT, C, 400), item(RETURN)]
    found = check(items, home=(*A, 300), rally=[(600, 600, 90), (3000, 1500, 70)])
    assert points(found)[0][-1] == ("rally point 2", 3000, 1500, 370)
    assert found.reading.facts["rally_points"] == 2
    hill = PLAIN.copy()
    hill[47:54, 97:104] = 380
    low = check(items, hill, home=(*A, 300), rally=[(3000, 1500, 70)])
    assert low.faults
    assert all("raise rally point 1" in line for line in low.lines)


def test_items_after_a_return_are_a_flight_of_their_own(check):
    items = [
        *(item(WAYPOINT, A, 400), item(WAYPOINT, C, 400), item(RETURN)),
        *(item(LAND_START), item(WAYPOINT, D, 350), item(LAND, (2400, 2000), 300)),
    ]
    found = check(items, home=(*A, 300))
    assert [len(chain) for chain in points(found)] == [3, 2]
    assert "item 5 and later items, after the end of the mission, are judged as a flight" in (
        " ".join(texts(found))
    )
    # Its first item needs the whole clearance.
    low = check([*items[:4], item(WAYPOINT, D, 320), items[5]], home=(*A, 300))
    assert [fault.limit for fault in low.faults] == ["clearance"]


def test_jumps_are_unrolled_and_faults_named_once(check):
    items = [
        *(item(WAYPOINT, A, 400), item(WAYPOINT, B, 400), item(WAYPOINT, C, 400)),
        *(item(WAYPOINT, (3400, 5000), 400), item(JUMP, params=(2, 50, 0, 0))),
        item(WAYPOINT, (1000, 5000), 400),
    ]
    hill = PLAIN.copy()
    hill[130:136, 87:93] = 390
    found = check(items, hill)
    names = [name for name, *_ in points(found)[0]]
    assert names == [f"item {n}" for n in (1, 2, 3, 4, 2, 3, 4, 2, 3, 4, 6)]
    assert [fault["where"] for fault in found.report["faults"]] == ["item 4 to 2"]
    endless = check([*items[:4], item(JUMP, params=(2, -1, 0, 0)), items[5]], hill)
    assert "without end" in texts(endless)[0]
    assert check([*items[:4], item(JUMP, params=(2, 0, 0, 0)), items[5]], hill).feasible


def test_a_jump_without_a_target_is_refused(refusal):
    items = [item(WAYPOINT, A, 400), item(JUMP, params=(9, 1, 0, 0))]
    assert refusal(items) == "item 2 (DO_JUMP) leads to item 9, which is not in the mission."


def test_jumps_that_lead_to_too_many_items_are_refused(refusal):
    items = [item(WAYPOINT, A, 400 + number) for number in range(100)]
    items += [item(JUMP, params=(1, 2, 0, 0))] * 150
    assert refusal(items) == (
        "more than 20,000 items are flown, those that its jumps repeat included; split it."
    )


def test_a_mission_of_jumps_alone_is_refused(refusal):
    assert refusal([item(JUMP, params=(1, 2, 0, 0))]) == "no item of the mission is flown."


@pytest.mark.parametrize("command", [TURNS, TIME, UNLIMITED])
def test_a_circle_has_the_radius_of_its_item_or_of_the_aircraft(command, check):
    items = [item(WAYPOINT, A, 400), item(command, B, 400, params=(2, 0, -260, 0))]
    assert check(items).flight.chains[0].points[1].circle_m == 260
    items[1] = item(command, B, 400)
    assert check(items).flight.chains[0].points[1].circle_m == 150


def test_a_circle_that_is_too_tight_is_a_fault(check):
    items = [item(WAYPOINT, A, 400), item(TURNS, B, 400, params=(2, 0, 80, 0))]
    (fault,) = check(items).report["faults"]
    assert fault["sentence"].startswith(
        "item 2: turn too tight: 80 m of radius, the aircraft needs 150 m (70.0 m too short), at "
    )
    assert fault["sentence"].endswith("; a radius of 150 m would do.")


def test_a_circle_without_a_place_is_around_the_item_before_it(check):
    items = [item(WAYPOINT, A, 400), item(WAYPOINT, B, 410), item(TIME), item(WAYPOINT, C, 400)]
    assert points(check(items))[0][2] == ("item 3", 2000, 3000, 410)


def test_a_loiter_to_an_altitude_climbs_on_its_circle(check):
    items = [item(WAYPOINT, A, 340), item(TO_ALT, (1200, 3000), 700, params=(0, 200, 0, 0))]
    steep = check([items[0], item(WAYPOINT, (1200, 3000), 700)])
    assert [fault.limit for fault in steep.faults] == ["climb"]
    assert check(items).feasible
    # Its disc is judged from the height at which it begins.
    hill = PLAIN.copy()
    hill[103:106, 38:42] = 500
    assert [fault.limit for fault in check(items, hill).faults] == ["clearance"]


def test_an_endless_circle_before_more_items_is_a_warning(check):
    items = [item(WAYPOINT, A, 400), item(UNLIMITED, B, 400), item(WAYPOINT, C, 400)]
    assert check(items).reading.warnings == (
        "item 2 (NAV_LOITER_UNLIM (17)) circles without end; the items after it are judged as "
        "flown when the pilot continues the mission.",
    )


def test_a_higher_speed_widens_turns(check):
    corner = [item(WAYPOINT, (2000, 2700), 400), item(WAYPOINT, (2400, 2700), 400)]
    items = [item(WAYPOINT, A, 400), item(WAYPOINT, (2000, 3050), 400), *corner]
    assert check(items).feasible
    slow = [items[0], item(SPEED, params=(0, 15, -1, 0)), *items[1:]]
    assert check(slow).feasible
    assert check([items[0], item(SPEED), *items[1:]]).feasible
    fast = check([items[0], item(SPEED, params=(0, 40, -1, 0)), *items[1:]])
    assert {fault.limit for fault in fast.faults} == {"turn"}
    assert "40 m/s is above the cruise speed" in texts(fast)[0]


@pytest.mark.parametrize(
    ("bad", "sentence"),
    [
        (
            item(82, B, 400),
            "item 2 is NAV_SPLINE_WAYPOINT (82), which cannot be judged; leave it out or replace "
            "it by waypoints.",
        ),
        (
            item(4321),
            "item 2 is the command 4321, which cannot be judged; leave it out or replace it by "
            "waypoints.",
        ),
        (item(WAYPOINT), "item 2 (NAV_WAYPOINT (16)) has no place" + NOWHERE),
        (item(LAND), "item 2 (NAV_LAND (21)) has no place" + NOWHERE),
        (item(WAYPOINT, B, None), "item 2 (NAV_WAYPOINT (16)) has no height."),
        (
            item(WAYPOINT, B, 50, 7),
            "item 2 has a height in the frame LOCAL_OFFSET_NED (7), which cannot be judged; give "
            "it above mean sea level (0), above home (3) or above the ground (10).",
        ),
        (
            item(WAYPOINT, B, 50, 99),
            "item 2 has a height in the frame 99, which cannot be judged; give it above mean sea "
            "level (0), above home (3) or above the ground (10).",
        ),
        (
            item(WAYPOINT, (-900, 3000), 50, GROUND),
            "item 2 has a height above the ground, which is unknown there: it lies off the map.",
        ),
        (item(TAKEOFF, None, 50), "item 2 (NAV_TAKEOFF (22)) has no place, and none follows."),
        (
            item(WAYPOINT, B, -1e308),
            "item 2 (NAV_WAYPOINT (16)) has a height of -1e+308 m; the most is 100,000 m, so mend "
            "the number.",
        ),
        (
            item(UNLIMITED, B, 400, params=(0, 0, 1e308, 0)),
            "item 2 (NAV_LOITER_UNLIM (17)) has a radius of 1e+308 m; the most is 100,000 m, so "
            "mend the number.",
        ),
        (
            item(SPEED, params=(0, 1e308, 0, 0)),
            "item 2 (DO_CHANGE_SPEED (178)) asks for 1e+308 m/s; the most is 1000 m/s, so mend the "
            "number.",
        ),
    ],
)
def test_an_item_that_cannot_be_judged_is_refused_by_number_and_name(bad, sentence, refusal):
    assert refusal([item(WAYPOINT, A, 400), bad]) == sentence


def test_home_off_the_map_needs_an_altitude(check, refusal):
    items = [item(WAYPOINT, A, 100, HOME), item(WAYPOINT, B, 100, HOME)]
    assert refusal(items, home=(-900, 3000, None)) == (
        "home has no altitude, and lies off the map or over a void."
    )
    found = check(items, home=(-900, 3000, 300))
    assert points(found)[0][0][3] == 400
    assert texts(found)[0] == (
        "home lies off the map or over a void, so its altitude of 300 m is not compared with the "
        "ground; heights above home are judged from it."
    )


def test_a_forward_jump_without_end_repeats_nothing(check):
    items = [item(WAYPOINT, A, 400), item(JUMP, params=(4, -1, 0, 0)), item(WAYPOINT, B, 0)]
    found = check([*items, item(WAYPOINT, C, 400)])
    assert [point[0] for point in points(found)[0]] == ["item 1", "item 4"]
    assert texts(found) == []


def test_a_landing_at_another_height_than_the_ground_is_said(check):
    high = check([item(WAYPOINT, A, 400), item(LAND, C, 380)])
    (remark,) = high.reading.remarks
    assert str(remark.grade) == "warning"
    assert remark.text == (
        "item 2 (NAV_LAND (21)) is at 380.0 m, and the ground there at 300.0 m; the landing is "
        "judged down to 380.0 m only."
    )
    low = check([item(WAYPOINT, A, 400), item(LAND, C, 100)])
    assert next(low.lines).endswith("; give item 2 the height of the ground there, 300.0 m.")
    assert check([item(WAYPOINT, A, 400), item(LAND, C, 300)]).feasible


@pytest.mark.parametrize(("height", "shown"), [(-1.0, "-1"), (1e308, "1e+308"), (np.nan, "nan")])
def test_a_return_at_no_height_is_refused(height, shown, refusal):
    items = [item(WAYPOINT, A, 400), item(RETURN)]
    assert refusal(items, return_m=height) == (
        f"the height of a return must be from 0 to 100,000 m above home, not {shown} "
        "(--return-height)."
    )


def test_a_mission_without_any_place_is_refused(refusal):
    assert refusal([item(RETURN)]) == "it has neither home nor an item with a place."


def test_a_mission_off_the_map_is_refused(refusal):
    items = [item(WAYPOINT, (-9000, 3000), 400), item(WAYPOINT, (-8000, 3000), 400)]
    lat, lon = degrees(-9000, 3000)
    assert refusal(items) == (
        f"the mission lies outside the map: item 1 is at {lat:.6f}, {lon:.6f}; give the terrain of "
        "its place."
    )


def test_an_aircraft_that_stalls_in_every_turn_is_refused(refusal):
    from dataclasses import replace

    from pathgene.host.problem.aircraft import load

    slow = replace(load("silver-fox"), lift_coefficient_max=0.3)
    items = [item(WAYPOINT, A, 400), item(WAYPOINT, B, 400)]
    assert refusal(items, aircraft=slow) == (
        "Silver Fox-like stalls in every turn at its cruise speed of 23 m/s; choose another UAV."
    )


def test_a_wind_beyond_the_airspeed_is_refused(refusal):
    items = [item(WAYPOINT, A, 400), item(WAYPOINT, B, 400)]
    assert refusal(items, wind=(30.0, 0.0)).startswith("A wind of 30 m/s is not below the airspeed")
