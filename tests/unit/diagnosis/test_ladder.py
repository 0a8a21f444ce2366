"""Each rung of the ladder by hand: code, sentence, place and figure."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.diagnosis import diagnose
from pathgene.host.diagnosis.reach import Reach, has_room
from pathgene.host.problem.aircraft import load
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain


FOX = load("silver-fox")
START, GOAL = (500.0, 500.0, 250.0), (5000.0, 5000.0, 250.0)
WALL = ((-100.0, 2960.0), (6000.0, 2960.0), (6000.0, 3040.0), (-100.0, 3040.0))


def flat(**changes):
    heights = np.full((60, 60), 100.0)
    return Terrain("flat", heights, 100.0, 100.0, **changes)


def problem(*zones, elevation=None, start=START, goal=GOAL, aircraft=FOX, **options):
    ground = flat() if elevation is None else Terrain("made", elevation, 100.0, 100.0)
    return Problem(ground, start, goal, aircraft, zones, **options)


def heights(value=100.0):
    return np.full((60, 60), value)


def test_finds_nothing_wrong():
    reason = diagnose(problem())
    assert (reason.code, reason.proven, reason.place) == ("not-found", False, None)
    assert reason.sentence.startswith("No path was found at this cell size (100 m), and no limit")


def test_end_in_the_margin_of_a_zone():
    zone = Circle(500, 700, 190, name="K", lower_m=240, upper_m=300)
    reason = diagnose(problem(zone))
    assert reason.sentence == (
        "The start is 10.0 m from zone K, within the zone margin of 25 m; move the start or give a "
        "smaller --zone-margin."
    )
    assert (reason.code, reason.proven, reason.end, reason.zones) == (
        "start",
        True,
        "start",
        ("zone K",),
    )
    assert reason.figure.to_dict() == {
        "limit": "zone-margin",
        "allowed": 25.0,
        "would_do": pytest.approx(10.0),
        "unit": "m",
    }
    assert diagnose(problem(replace(zone, lower_m=280))).code == "not-found"
    assert diagnose(problem(replace(zone, t0_s=10))).code == "not-found"
    assert diagnose(problem(zone, rules=Rules(zone_margin_m=9.0))).code == "not-found"
    # At the goal, a zone that ends at some time may or may not end too late.
    goal = Circle(5000, 5200, 190)
    assert diagnose(problem(goal)).code == "goal"
    assert diagnose(problem(replace(goal, t1_s=60))).code == "not-found"


@pytest.mark.parametrize(
    ("options", "limit", "sentence"),
    [
        (
            {"rules": Rules(ceiling_m=240)},
            "ceiling",
            "The start at 250.0 m is 10.0 m above the ceiling, 240.0 m.",
        ),
        (
            {"aircraft": replace(FOX, service_ceiling_m=200)},
            "service-ceiling",
            "The start at 250.0 m is 50.0 m above the service ceiling of Silver Fox-like, 200.0 m.",
        ),
        (
            {"rules": Rules(ceiling_agl_m=120)},
            "ceiling-agl",
            "The start is 150.0 m above the ground, 30.0 m more than the ceiling above ground, "
            "120.0 m.",
        ),
    ],
)
def test_end_above_a_ceiling(options, limit, sentence):
    reason = diagnose(problem(**options))
    assert (reason.code, reason.figure.limit, reason.sentence) == ("start", limit, sentence)


def test_ground_and_voids_beside_an_end():
    pit = heights(920)
    pit[50, 50] = 100
    reason = diagnose(problem(elevation=pit, start=(500, 500, 1070)))
    assert (reason.code, reason.figure.to_dict()) == (
        "goal",
        {"limit": "goal-altitude", "allowed": 250.0, "would_do": 280.0, "unit": "m"},
    )
    assert reason.sentence == (
        "The ground within the corridor of 25 m is 30.0 m too high beside the goal, whatever the "
        "heading; raise the goal by 30.0 m, move it or give a smaller --corridor."
    )
    void = heights()
    void[50] = void[:, 50] = np.nan
    goal = (5060, 5060, 250)
    reason = diagnose(problem(elevation=void, goal=goal))
    assert (reason.code, reason.figure.limit) == ("goal", "void")


def test_ends_near_the_edge_of_the_map():
    reason = diagnose(problem(start=(3.0, 4.0, 250.0)))
    assert (reason.code, reason.proven, reason.place) == ("start", True, (3.0, 4.0))
    assert reason.sentence == (
        "The start is 3.0 m from the edge of the map, and the corridor of 25 m leaves the map "
        "there, whatever the heading; move the start 30.5 m into the map or give --corridor 3."
    )
    assert reason.figure.to_dict() == {
        "limit": "corridor",
        "allowed": 25.0,
        "would_do": 3.0,
        "unit": "m",
    }
    # Some headings keep the corridor on the map, so that a search decides.
    reason = diagnose(problem(goal=(5000.0, 5880.0, 250.0)))
    assert (reason.code, reason.proven) == ("goal", False)
    assert reason.sentence == (
        "The goal is 20.0 m from the edge of the map, and the corridor of 25 m leaves the map "
        "there; move the goal 5.0 m into the map or give --corridor 20."
    )
    assert diagnose(problem(goal=(5000.0, 5875.0, 250.0))).code == "not-found"
    assert diagnose(problem(goal=(5000.0, 5880.0, 250.0), rules=Rules(corridor_m=20))).code == (
        "not-found"
    )
    corner = {"start": (3.0, 4.0, 250.0)}
    assert diagnose(problem(**corner, as_paper=True)).code == "not-found"
    assert diagnose(problem(**corner, rules=Rules(corridor_m=0))).code == "not-found"
    assert not diagnose(problem(**corner, start_heading_deg=45.0)).proven
    assert diagnose(problem(start=(18.0, 18.0, 250.0))).proven is False


@pytest.mark.parametrize(("gap_m", "closed"), [(20.0, True), (24.9, True), (25.1, False)])
def test_a_gap_along_the_edge_narrower_than_the_corridor_is_closed(gap_m, closed):
    """Zone and margin leave a gap along the east edge; in the west they reach the edge."""
    east = 5900.0 - gap_m - 25.0
    zone = Polygon(((-100.0, 2960.0), (east, 2960.0), (east, 3040.0), (-100.0, 3040.0)), name="a")
    reason = diagnose(problem(zone))
    assert ((reason.code, reason.proven) == ("closed", True)) == closed
    if closed:
        assert reason.zones == ("zone a",)
        assert "the edge of the map and zone a enclose" in reason.sentence
    # A path may pass if it begins in the gap.
    start = (5900.0 - 1.0, 2900.0, 250.0)
    assert not diagnose(problem(zone, start=start)).proven


def test_zones_enclose_an_end():
    reason = diagnose(problem(Circle(3000, 800, 50), Polygon(WALL, name="border")))
    assert (reason.code, reason.proven) == ("closed", True)
    assert reason.zones == ("zone border",)
    assert reason.sentence == (
        "No way leads from the start to the goal at any altitude: the edge of the map and zone "
        f"border enclose the {reason.end}, and must open near (2960, 2960) m."
    )
    (line,) = reason.ring
    assert line[0, 0] <= 0 or line[0, 0] >= 5900
    assert reason.region.shape == (60, 60)
    assert reason.region.any()
    json.dumps(reason.to_dict(), allow_nan=False)


def test_voids_enclose_an_end():
    void = heights()
    void[:, 30] = np.nan
    reason = diagnose(problem(elevation=void))
    assert (reason.code, reason.zones) == ("closed", ())
    assert "voids of the terrain" in reason.sentence
    void[20, 30] = 100
    assert not diagnose(problem(elevation=void)).proven


def test_a_zone_that_ends_or_can_be_flown_over_closes_nothing():
    for limits in ({"t1_s": 100.0}, {"t0_s": 5.0}, {"upper_m": 400.0}, {"lower_m": 300.0}):
        reason = diagnose(problem(Polygon(WALL, **limits)))
        assert not reason.proven, limits


def test_a_zone_that_ground_and_ceiling_close():
    hidden = Polygon(WALL, name="low", lower_m=140.0)
    assert diagnose(problem(hidden)).zones == ("zone low",)
    high = Polygon(WALL, name="low", upper_m=600.0)
    reason = diagnose(problem(high, rules=Rules(ceiling_m=610.0)))
    assert (reason.code, reason.zones) == ("ceiling", ("zone low",))
    assert reason.figure.to_dict() == {
        "limit": "ceiling",
        "allowed": 610.0,
        "would_do": 625.0,
        "unit": "m",
    }
    assert not diagnose(problem(high, rules=Rules(ceiling_m=625.0))).proven
    reason = diagnose(problem(high, rules=Rules(ceiling_agl_m=500.0)))
    assert (reason.code, reason.figure.limit) == ("ceiling", "ceiling-agl")


def test_ceiling_below_a_ridge():
    ridge = heights()
    ridge[:, 28:33] = 600
    reason = diagnose(problem(elevation=ridge, rules=Rules(ceiling_m=500.0)))
    assert reason.sentence == (
        "No way leads from the start to the goal below the ceiling of 500 m: near (2800, 2800) m, "
        "the ground leaves no room; a --ceiling of 630 m would do for ground and zones."
    )
    assert not diagnose(problem(elevation=ridge, rules=Rules(ceiling_m=630.0))).proven


def test_pits():
    wide = heights(700)
    wide[47:54, 47:54] = 100
    reason = diagnose(problem(elevation=wide, start=(500, 500, 1070)))
    assert (reason.code, reason.proven, reason.end) == ("descent", False, "goal")
    assert reason.figure.allowed == 30
    assert 40 < reason.figure.would_do < 80
    assert reason.region[50, 50]
    assert not reason.region[5, 5]
    # The walls of a pit are out of reach, but not for an aircraft that circles.
    deep = heights(1600)
    deep[47:54, 47:54] = 100
    reason = diagnose(problem(elevation=deep, start=(500, 500, 1970)))
    assert (reason.code, reason.proven) == ("descent", False)
    assert reason.sentence.endswith("there may be room to circle, which no planner does.")
    narrow = heights(900)
    narrow[49:51, 49:52] = 100
    reason = diagnose(problem(elevation=narrow, start=GOAL, goal=(500, 500, 1050)))
    assert (reason.code, reason.proven, reason.end) == ("climb", True, "start")
    assert reason.sentence.endswith("and the limit is 10; there is no room to circle.")


def test_power():
    weak = replace(FOX, engine_power_W=10)
    reason = diagnose(problem(aircraft=weak))
    assert (reason.code, reason.proven) == ("power", True)
    assert reason.figure.would_do == 258
    climber = replace(FOX, engine_power_W=400)
    reason = diagnose(problem(aircraft=climber, goal=(5000, 5000, 1200)))
    assert (reason.code, reason.proven) == ("power", False)
    assert 600 < reason.figure.would_do < 800


def test_fuel():
    reason = diagnose(problem(aircraft=replace(FOX, fuel_weight_N=0.05)))
    assert (reason.code, reason.proven) == ("fuel", True)
    assert reason.figure.would_do > 0.05
    enough = replace(FOX, fuel_weight_N=reason.figure.would_do)
    assert not diagnose(problem(aircraft=enough)).proven


def test_stall_in_every_turn():
    stalling = replace(FOX, lift_coefficient_max=0.3)
    wall = Polygon(((2900, 2900), (3100, 2900), (3100, 3100), (2900, 3100)), name="town")
    reason = diagnose(problem(wall, aircraft=stalling))
    assert (reason.code, reason.figure.limit) == ("turn", "stall")
    assert not diagnose(problem(aircraft=stalling)).proven


def test_the_first_reason_on_the_page_is_told_where_several_hold():
    at_start = Circle(500, 700, 190)
    town = Polygon(((2900, 2900), (3100, 2900), (3100, 3100), (2900, 3100)))
    ridge = heights()
    ridge[:, 28:33] = 600
    stalling = replace(FOX, lift_coefficient_max=0.3)
    thirsty = replace(stalling, fuel_weight_N=0.05)
    weak = replace(thirsty, engine_power_W=10)
    for code, zones, ground, aircraft in (
        ("start", (at_start, Polygon(WALL), town), ridge, weak),
        ("closed", (Polygon(WALL), town), ridge, weak),
        ("ceiling", (town,), ridge, weak),
        ("power", (town,), None, weak),
        ("fuel", (town,), None, thirsty),
        ("turn", (town,), None, stalling),
        ("not-found", (), None, FOX),
    ):
        given = problem(*zones, elevation=ground, aircraft=aircraft, rules=Rules(ceiling_m=500.0))
        assert diagnose(given).code == code


def test_gaps_narrower_than_a_cell():
    gap = (Circle(3000, 1400, 1500, name="a"), Circle(3000, 4600, 1625, name="b"))
    reason = diagnose(problem(*gap))
    assert (reason.code, reason.proven, reason.zones) == ("not-found", False, ("zone a", "zone b"))
    assert "every gap is narrower than a cell" in reason.sentence


def test_as_paper():
    wall = tuple((x, y + 100 * (y > 3000)) for x, y in WALL)
    reason = diagnose(problem(Polygon(wall, name="border"), as_paper=True))
    assert (reason.code, reason.zones) == ("closed", ("zone border",))
    # The samples of a path miss a wall between two rows of nodes.
    slit = ((-100.0, 2960.0), (6000.0, 2960.0), (6000.0, 2980.0), (-100.0, 2980.0))
    assert diagnose(problem(Polygon(slit), as_paper=True)).code == "not-found"


def test_headings_leave_nothing_proven():
    assert not diagnose(problem(Polygon(WALL), start_heading_deg=90.0)).proven


def test_place_on_earth():
    ground = flat(crs="EPSG:32616", origin=(600000.0, 4000000.0))
    reason = diagnose(Problem(ground, START, GOAL, FOX, [Polygon(WALL)]))
    assert reason.place_geo == pytest.approx(ground.to_geographic(*reason.place))


SIDES = (50.0, 100.0)


def test_distances_on_level_ground():
    reach = Reach.of(np.zeros((4, 5)), SIDES, (1, 1), 10.0, 0.1)
    assert reach.flown_m[1, 4] == 150
    assert reach.flown_m[3, 1] == 200
    assert reach.flown_m[3, 3] == pytest.approx(2 * math.hypot(50, 100))
    assert reach.way((1, 3)).tolist() == [[1, 1], [1, 2], [1, 3]]


def test_climbs_along_its_way_alone():
    heights = np.zeros((1, 40))
    heights[0, 20:22] = 100.0
    # 20 nodes from the first are 1000 m.
    assert Reach.of(heights, SIDES, (0, 0), 50.0, 0.0500001).nodes.all()
    stopped = Reach.of(heights, SIDES, (0, 0), 50.0, 0.0499999)
    assert stopped.nodes.tolist() == [[True] * 20 + [False] * 20]


@pytest.mark.parametrize(("cells", "fits"), [(4, False), (5, False), (7, True), (9, True)])
def test_room_for_a_circle(cells, fits):
    nodes = np.zeros((20, 20), dtype=bool)
    nodes[5 : 5 + cells, 3:17] = True
    assert has_room(nodes, (50.0, 50.0), 150.0) == fits


def test_room_around_a_peak():
    nodes = np.zeros((20, 20), dtype=bool)
    nodes[5:14, 5:14] = True
    nodes[6:13, 6:13] = False
    assert has_room(nodes, (50.0, 50.0), 150.0)
    assert not has_room(nodes, (50.0, 50.0), math.inf)
