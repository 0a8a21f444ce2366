"""Limits that legs, turns and circles break, and their remedies."""

from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.mission.foreign.check import check_path
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.problem.aircraft import load
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain
from tests.support.host.foreign import PLAIN, item


WAYPOINT, TURNS = 16, 18
A, B, C = (600, 3000), (2000, 3000), (3400, 3000)


def line(*places, height=400):
    return [item(WAYPOINT, place, height) for place in places]


def circled(radius=150):
    return [*line(A), item(TURNS, B, 400, params=(1, 0, radius, 0)), *line(C)]


def limits(check):
    return [(fault.limit, round(fault.metres)) for fault in check.faults]


def endings(check):
    return [text.rpartition("; ")[2] for text in check.lines]


def test_a_clean_mission_has_its_length_and_least_clearance(check):
    found = check(line(A, B, C))
    assert dict(found.pairs) == {
        "feasible": "yes",
        "faults": "0",
        "items": "3, 2 legs flown",
        "length": "2800.0 m",
        "minimum clearance": "100.0 m, item 1 to 2",
    }


def test_a_mission_of_one_item_has_no_leg(check):
    found = check(line(A))
    assert found.feasible
    assert found.report["minimum_clearance_m"] is None
    assert dict(found.pairs)["minimum clearance"] == "none: no leg is judged in the air"
    assert dict(found.pairs)["items"] == "1, 0 legs flown"
    assert dict(check(line(A, B)).pairs)["items"] == "2, 1 leg flown"
    low = check([item(TURNS, A, 340, params=(1, 0, 0, 0))], PLAIN + 20)
    assert (limits(low), endings(low)) == ([("clearance", 10)], ["raise item 1 by 10 m."])


def test_a_place_without_a_leg_is_judged(check):
    low = check([item(WAYPOINT, A, 250)])
    assert (limits(low), endings(low)) == ([("clearance", 80)], ["raise item 1 by 80 m."])
    high = check([item(WAYPOINT, A, 400)], rules=Rules(ceiling_m=350.0))
    assert limits(high) == [("ceiling", 50)]


def test_a_leg_off_the_map_is_a_fault_with_its_metres(check):
    found = check(line(A, (600, 6100)))
    assert limits(found) == [("map", 100)]
    assert endings(found) == ["move item 2 by 100 m to the south (180 degrees)."]
    # The turn begins before a point, and stays on the map.
    assert check(line(A, (600, 6100), (2000, 5000))).feasible


def test_a_circle_off_the_map_is_moved_inwards(check):
    items = circled()
    items[1] = item(TURNS, (2000, 100), 400, params=(1, 0, 150, 0))
    found = check(items)
    assert limits(found) == [("map", 75)]
    assert endings(found) == ["move item 2 by 75 m to the north (0 degrees)."]


def test_ground_that_is_unknown_is_a_fault_without_metres(check):
    heights = PLAIN.copy()
    heights[98:103, 42:46] = np.nan
    found = check(line(A, B, C), heights)
    assert limits(found) == [("void", 0)]
    assert endings(found) == ["fly around it, or fill the voids (--fill-voids)."]
    assert found.report["minimum_clearance_m"] is None
    assert dict(found.pairs)["minimum clearance"] == "unknown over a void, item 1 to 2"
    heights = PLAIN.copy()
    heights[103:106, 66:68] = np.nan
    assert limits(check(circled(), heights)) == [("void", 0)]


@pytest.mark.parametrize(
    ("options", "limit"),
    [
        ({"rules": Rules(ceiling_m=380.0)}, "ceiling"),
        ({"rules": Rules(ceiling_agl_m=80.0)}, "ceiling-agl"),
        ({"aircraft": replace(load("silver-fox"), service_ceiling_m=380.0)}, "service-ceiling"),
    ],
)
def test_ceilings_are_kept(options, limit, check):
    found = check([*line(A), item(WAYPOINT, B, 380), item(WAYPOINT, C, 379)], **options)
    assert limits(found) == [(limit, 20)]
    assert endings(found) == ["lower item 1 by 20 m."]
    assert f": {limit} 20.0 m too high (400.0 m, allowed 380 m), at " in next(found.lines) or (
        limit == "ceiling-agl"
    )


def test_circles_keep_ceilings(check):
    found = check(circled(), rules=Rules(ceiling_m=395.0))
    assert ("ceiling", 5) in limits(found)
    assert [fault.is_leg for fault in found.faults] == [True, False, True]


@pytest.mark.parametrize(
    ("zone", "remedy"),
    [
        (Circle(1300, 3000, 100, name="town", upper_m=410.0), "raise items 1 and 2 by 35 m."),
        (Circle(1300, 3000, 100, name="town", lower_m=390.0), "lower items 1 and 2 by 35 m."),
        (
            Circle(1300, 3090, 100, name="town"),
            "move items 1 and 2 by 35 m to the south (180 degrees).",
        ),
    ],
)
def test_zones_are_passed_above_below_or_beside(zone, remedy, check):
    found = check(line(A, B, C), zones=[zone])
    (limit,) = limits(found)
    assert limit[0] == "zone town"
    assert endings(found) == [remedy]


def test_a_zone_above_or_below_is_none(check):
    zones = [Circle(1300, 3000, 100, upper_m=374.0), Circle(2000, 3000, 100, lower_m=426.0)]
    assert check(circled(), zones=zones).feasible


@pytest.mark.parametrize(
    ("zone", "remedy"),
    [
        (Circle(2000, 3200, 50), "move item 2 by 25 m to the south (180 degrees)."),
        (Circle(2000, 3200, 50, upper_m=390.0), "raise item 2 by 15 m."),
        (Circle(2000, 3200, 50, lower_m=410.0), "lower item 2 by 15 m."),
    ],
)
def test_a_circle_leaves_a_zone(zone, remedy, check):
    found = check(circled(), zones=[zone])
    assert limits(found) == [("zone 1", 25)]
    assert not found.faults[0].is_leg
    assert endings(found) == [remedy]


def test_a_climb_that_autopilots_are_late_in_is_none(check):
    """A climb at the limit may be asked for by three seconds on a short first leg, by one later."""
    climb = np.tan(np.radians(10))
    second = (680, 3000), 400 + 80 * climb + 10
    late = [*line(A), item(WAYPOINT, *second)]
    assert check(late).feasible
    # The aircraft climbs as it can.
    found = check([*late, item(WAYPOINT, C, second[1])])
    track = found.judge.track(found.flight.chains[0].points)
    assert track.arrived_m[1] == pytest.approx(400 + 80 * climb, abs=0.1)
    assert track.arrived_m[2] == pytest.approx(second[1])
    for height, feasible in ((4.0, True), (5.0, False)):
        higher = 400 + 1400 * climb + height
        assert check([*line(A, B), item(WAYPOINT, C, higher)]).feasible is feasible
        assert check([*line(A), item(WAYPOINT, B, higher)]).feasible is feasible


def test_a_descent_is_too_steep_and_mended_at_the_lower_end(check):
    found = check([item(WAYPOINT, A, 1300), item(WAYPOINT, B, 400), *line(C)])
    assert limits(found) == [("descent", 92)]
    assert endings(found) == ["raise item 2 by 92 m."]


def test_a_change_of_height_in_place_is_a_climb(check):
    found = check([*line(A, B), item(WAYPOINT, B, 460), item(WAYPOINT, C, 460)])
    assert limits(found) == [("climb", 60)]


def test_a_tail_wind_flattens_climbs_and_widens_turns(check):
    corner = line(A, (1400, 3000), (1400, 3400), (2400, 3400))
    climb = [item(WAYPOINT, A, 400), item(WAYPOINT, B, 400 + 0.9 * 1400 * np.tan(np.radians(10)))]
    assert check(corner).feasible
    assert check(climb).feasible
    assert {fault.limit for fault in check(corner, wind=(8.0, 0.0)).faults} == {"turn"}
    assert [fault.limit for fault in check(climb, wind=(8.0, 0.0)).faults] == ["climb"]
    assert check(climb, wind=(-8.0, 0.0)).feasible


def test_a_reversal_turns_back(check):
    found = check(line(A, B, (1000, 3000)))
    assert limits(found) == [("turn", 300)]
    (text,) = found.lines
    assert "item 2: turn back on itself, which takes a radius of 150 m, at " in text
    assert text.endswith("; leave item 2 out.")
    assert found.report["faults"][0]["change"] == {"of": ["item 2"], "leave_out": True}


def test_a_turn_that_does_not_fit_is_mended_by_a_move_or_by_leaving_it_out(check):
    found = check(line(A, B, (2000, 3200), (3000, 3200)))
    assert limits(found) == [("turn", 100)]
    assert endings(found)[0].startswith("move item ")


def test_points_on_a_circle_that_can_be_flown_turn_enough(check):
    angles = np.linspace(-1.5, 1.5, 40)
    for radius, feasible in ((152, True), (120, False)):
        places = [(3000 + radius * np.sin(a), 3000 - radius * np.cos(a)) for a in angles]
        assert check(line(*places)).feasible is feasible


def test_a_remedy_that_breaks_another_limit_says_so(check):
    heights = PLAIN.copy()
    heights[98:103, 60:62] = 700
    found = check(line(A, B, (2300, 3000), C), heights)
    assert any(" would do, but breaks item " in text for text in found.lines)
    changes = [fault["change"] for fault in found.report["faults"]]
    assert any("climb" in text for change in changes for text in change.get("breaks", ()))


def test_home_off_the_map_needs_another_terrain(check):
    """No item states the place of home."""
    items = [item(22, A, 150, 3), *line(B), item(20)]
    found = check(items, home=(-600, 3000, 300))
    assert {fault.limit for fault in found.faults} == {"map"}
    assert endings(found)[-1] == "give a terrain that reaches farther."


def test_a_path_over_a_terrain_without_a_place_has_metres():
    terrain = Terrain("plain", PLAIN, 30.0, 30.0)
    path = np.array([(600.0, 3000.0, 400.0), (2000.0, 3000.0, 400.0)])
    problem = FlightProblem(
        terrain, tuple(path[0]), tuple(path[1]), zones=[Circle(1300, 3090, 100)]
    )
    found = check_path(problem, path)
    (text,) = found.lines
    assert ", at (1300.0, 3000.0) m, " in text
    (fault,) = found.tables
    assert (fault["x_m"], fault["y_m"]) == pytest.approx((1300, 3000))
    assert fault["change"]["places"] == [
        pytest.approx((600, 2965)),
        pytest.approx((2000, 2965)),
    ]


def test_a_fault_without_a_remedy_says_so(check):
    items = [*line(A, (2000, 4000), C), item(20)]
    zone = Circle(2000, 3000, 100)
    found = check(items, home=(*A, 300), zones=[zone])
    assert limits(found) == [("zone 1", 125)]
    assert endings(found) == ["no move of these items would do, so lead the mission another way."]


def test_the_height_of_a_return_rises_no_more_than_it_must(check):
    # The return begins at 400 m and sinks to 400 m above a ridge of 410 m halfway.
    ridge = PLAIN.copy()
    ridge[:, 80:86] = 410.0
    items = [item(WAYPOINT, (4800, 3000), 400), item(20)]
    found = check(items, ridge, home=(*A, 300), return_m=100.0)
    raised = next(each for each in found.remedies if each.handles == (("return", 0),))
    assert 40 <= raised.up_m <= 42
    after = check(items, ridge, home=(*A, 300), return_m=100.0 + raised.up_m)
    assert after.feasible
