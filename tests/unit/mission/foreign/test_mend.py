"""Missions with a planted fault are mended by few and small changes, written, and flown."""

import json

import numpy as np
import pytest

from pathgene.host.errors import InputError, JobError
from pathgene.host.formats.registry import mission_in, read_mission
from pathgene.host.mission.foreign.check import check_mission
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.mission.foreign.mend import mend
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.sim.autopilot.pilot import Kind
from tests.support.host.foreign import NOWHERE, PLAIN, item, items_of, land, plan_of
from tests.support.host.mended_missions import outcome, problem_of
from tests.support.host.planted_missions import KINDS, plant


LONG_SEEDS = range(100, 200)
HILL = PLAIN.copy()
HILL[95:106, 95:106] = 400.0


def mended(tmp_path, text, heights=PLAIN, name="m.plan", **options):
    """Return the mended mission of a text."""
    file = tmp_path / name
    file.write_text(text)
    problem = FlightProblem(land(heights), NOWHERE, NOWHERE, **options)
    return mend(read_mission(file), problem)


def place_of(lat, lon):
    """Return a place in metres of the land."""
    x, y = land(PLAIN).to_local(np.array([lat]), np.array([lon]))
    return float(x[0]), float(y[0])


def written(found, text, name="m.plan", out=None):
    return found.written(text.encode(), name, out or name)


@pytest.mark.parametrize("kind", KINDS)
def test_a_planted_fault_is_mended(kind, tmp_path):
    mission, problem = problem_of(plant(kind, 4, faulty=True), tmp_path / "m.plan")
    found = mend(mission, problem)
    assert found.feasible
    assert found.refusal is None
    assert check_mission(found.mission, problem).feasible
    assert 1 <= len(found.changes) <= 2
    kinds = {change.kind for change in found.changes}
    assert kinds == {"fence": {"insert"}, "turn": {"move"}}.get(kind, {"raise"})


@pytest.mark.parametrize("kind", ["ridge", "survey"])
def test_a_mission_without_faults_stays_as_it_is(kind, tmp_path):
    mission, problem = problem_of(plant(kind, 4, faulty=False), tmp_path / "m.plan")
    found = mend(mission, problem)
    assert found.feasible
    assert found.changes == ()
    assert found.mission == mission


def test_a_change_keeps_the_limit_without_the_tolerance_of_a_check(tmp_path):
    found = mend(*problem_of(plant("home", 1, faulty=True), tmp_path / "m.plan"))
    assert len(found.changes) == 1
    assert found.after.report["minimum_clearance_m"] >= 29.99


@pytest.mark.ci
@pytest.mark.parametrize("kind", KINDS)
def test_a_mended_mission_is_flown_with_half_of_its_clearance(kind, tmp_path):
    assert outcome(kind, 1, tmp_path / "m.plan").is_kept


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_a_thousand_missions_are_mended_and_flown(kind, tmp_path):
    found = [outcome(kind, seed, tmp_path / "m.plan") for seed in LONG_SEEDS]
    flown = [each for each in found if each.flight is not None]
    assert len(flown) >= 0.95 * len(found)
    assert all(each.is_kept for each in flown)


@pytest.mark.ci
@pytest.mark.parametrize("kind", ["return", "survey"])
def test_px4_flies_a_mended_mission(kind, tmp_path):
    assert outcome(kind, 1, tmp_path / "m.plan", Kind.PX4).is_kept


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_px4_flies_mended_missions_of_every_kind(kind, tmp_path):
    for seed in LONG_SEEDS[:3]:
        assert outcome(kind, seed, tmp_path / "m.plan", Kind.PX4).is_kept


def survey_of(text):
    return json.loads(text)["mission"]["items"][1]


def test_lines_of_a_survey_stay_in_place_and_its_definition_is_kept(tmp_path):
    document = json.loads(plant("survey", 4, faulty=True).plan)
    survey = document["mission"]["items"][1]
    survey |= {"angle": 90, "polygon": [[1, 2], [3, 4], [5, 6]]}
    survey["TransectStyleComplexItem"]["CameraCalc"] = {"DistanceToSurface": 120}
    document["station"] = {"own": [1, None, "x"]}
    text = json.dumps(document)
    heights = plant("survey", 4, faulty=True).heights
    found = mended(tmp_path, text, heights)
    after = json.loads(written(found, text))
    before, now = items_of(document), items_of(after)
    assert [each["params"][:6] for each in before.values()] == [
        each["params"][:6] for each in now.values()
    ]
    assert before != now
    for each in (*before.values(), *now.values()):
        each["params"][6] = 0
    for plan in (document, after):
        plan["mission"]["items"][1]["TransectStyleComplexItem"].pop("Items")
    assert document["mission"]["items"][1] == after["mission"]["items"][1]
    assert document["station"] == after["station"]
    assert "survey 2 keeps its old height" in found.remarks[0]


def test_a_survey_in_a_zone_without_limits_is_not_mended(tmp_path):
    planted = plant("survey", 4, faulty=False)
    first = items_of(json.loads(planted.plan))[4]["params"]
    lat, lon = first[4:6]
    x, y = place_of(lat, lon)
    found = mended(tmp_path, planted.plan, planted.heights, zones=[Circle(x, y, 100.0)])
    assert not found.feasible
    assert "cannot be mended" in found.refusal
    with pytest.raises(JobError, match="cannot be mended"):
        written(found, planted.plan)


def test_heights_come_first_and_their_frames_stay(tmp_path):
    for frame, low in ((0, 340.0), (3, 40.0), (10, 40.0)):
        text = plan_of(
            [item(16, place, low, frame) for place in ((1500, 3000), (4500, 3000))],
            home=(1500, 2000, 300.0),
        )
        found = mended(tmp_path, text, HILL)
        after = json.loads(written(found, text))["mission"]["items"]
        assert [each["frame"] for each in after] == [frame] * 2
        assert {change.kind for change in found.changes} == {"raise"}
        raised = [each["params"][6] - low for each in after]
        assert 90 <= max(raised) <= 100


def test_shown_altitudes_follow_the_height(tmp_path):
    listed = [item(16, place, 340.0) for place in ((1500, 3000), (4500, 3000))]
    for each in listed:
        each |= {"AltitudeMode": 3, "Altitude": 40.0, "AMSLAltAboveTerrain": 340.0}
    text = plan_of(listed)
    after = json.loads(written(mended(tmp_path, text, HILL), text))["mission"]["items"]
    for each in after:
        assert each["AMSLAltAboveTerrain"] == each["params"][6]
        assert each["Altitude"] == pytest.approx(each["params"][6] - 300)
        assert each["AltitudeMode"] == 3


def test_jumps_follow_inserted_waypoints(tmp_path):
    places = [(900, 1500), (900, 3000), (4500, 3000), (4500, 1200), (2700, 1200)]
    listed = [item(16, place, 420.0) for place in places]
    text = plan_of([*listed, item(177, params=(3, 1, 0, 0)), item(16, (900, 1200), 420.0)])
    found = mended(tmp_path, text, zones=[Circle(2700.0, 3000.0, 200.0)])
    after = json.loads(written(found, text))["mission"]["items"]
    new = len(after) - 7
    assert new >= 1
    assert {change.kind for change in found.changes} <= {"insert", "detour"}
    jump = next(each for each in after if each["command"] == 177)
    before = json.loads(text)["mission"]["items"][2]["params"]
    assert jump["params"][0] == 3 + new
    assert after[3 + new - 1]["params"] == before


def test_a_jump_ahead_gets_its_own_waypoints(tmp_path):
    corners = [(600, 1500), (1500, 3000), (1500, 5000), (3000, 5400), (4500, 3000), (5400, 1500)]
    first, *rest = (item(16, place, 420.0) for place in corners)
    text = plan_of([first, rest[0], item(177, params=(6, 1, 0, 0)), *rest[1:]])
    found = mended(tmp_path, text, zones=[Circle(3000.0, 3000.0, 200.0)])
    assert {change.item for change in found.changes} == {"item 2"}
    after = json.loads(written(found, text))["mission"]["items"]
    at = [each["command"] for each in after].index(177)
    assert at == 3
    assert after[at]["params"][0] == 7
    assert after[6]["params"] == json.loads(text)["mission"]["items"][5]["params"]


@pytest.mark.ci
def test_a_turn_back_is_led_around(tmp_path):
    places = ((600, 3000), (3000, 3000), (700, 3100), (700, 5000))
    text = plan_of([item(16, place, 420.0) for place in places])
    found = mended(tmp_path, text)
    assert found.feasible
    assert {change.kind for change in found.changes} == {"detour"}


def test_a_circle_is_widened(tmp_path):
    text = plan_of([item(18, (3000, 3000), 320.0, params=(2, 0, -80, 0))])
    found = mended(tmp_path, text, HILL)
    assert [change.kind for change in found.changes] == ["raise", "widen"]
    assert found.changes[1].sentence == "widened the circle of item 1 by 70 m, to 150 m."
    (after,) = json.loads(written(found, text))["mission"]["items"]
    assert after["params"][:4] == [2, 0, -150, 0]
    assert after["params"][6] == 430.0


def test_a_rally_point_is_raised(tmp_path):
    text = plan_of(
        [item(16, (600, 600), 420.0), item(16, (4500, 600), 420.0), item(20)],
        home=(900, 3000, 300.0),
        rally=[(3000, 3000, 50.0)],
    )
    found = mended(tmp_path, text, HILL)
    assert [(change.kind, change.item) for change in found.changes] == [("raise", "rally point 1")]
    point = json.loads(written(found, text))["rallyPoints"]["points"][0]
    assert point[2] == found.mission.rally[0][2] == 131.0


def test_a_landing_below_the_ground_is_raised_to_it(tmp_path):
    text = plan_of([item(16, (600, 3000), 380.0), item(21, (4200, 3000), 260.0)])
    found = mended(tmp_path, text)
    assert found.feasible
    assert found.mission.items[1].alt_m == 300.0


@pytest.mark.ci
def test_a_take_off_beside_a_zone_is_moved_and_a_home_in_one_is_not(tmp_path):
    text = plan_of(
        [
            item(22, (1900, 1500), 80.0, 3),
            item(16, (1900, 3000), 40.0, 3),
            item(16, (4500, 3000), 40.0, 3),
        ],
        home=(900, 1500, 300.0),
    )
    heights = [change.kind for change in mended(tmp_path, text, HILL).changes]
    beside = mended(tmp_path, text, HILL, zones=[Circle(1400.0, 1550.0, 60.0)])
    assert [change.kind for change in beside.changes] == ["move", *heights]
    inside = mended(tmp_path, text, HILL, zones=[Circle(900.0, 1500.0, 60.0)])
    # All faults but this are mended.
    assert [fault.limit for fault in inside.after.faults] == ["zone 1"]
    assert [change.kind for change in inside.changes] == heights


def test_a_list_of_waypoints_keeps_its_other_rows(tmp_path):
    planted = plant("ridge", 4, faulty=True)
    lines = planted.waypoints.splitlines()
    lines.insert(3, "# a comment")
    fence = "7\t0\t3\t5004\t50\t0\t0\t0\t46.9\t9.2\t0\t1"
    text = "\r\n".join((*lines, fence, ""))
    found = mended(tmp_path, text, planted.heights, "m.waypoints")
    after = written(found, text, "m.waypoints").decode()
    pairs = list(zip(text.split("\r\n"), after.split("\r\n"), strict=True))
    changed = [pair for pair in pairs if pair[0] != pair[1]]
    assert len(changed) == len(found.changes)
    for before, now in changed:
        assert before.split("\t")[:10] == now.split("\t")[:10]


def test_inserted_rows_renumber_a_list_of_waypoints(tmp_path):
    rows = [
        f"{number}\t0\t0\t16\t0\t0\t0\t0\t{lat}\t{lon}\t420\t1"
        for number, (lat, lon) in enumerate(((46.97, 9.02), (46.97, 9.06)), start=1)
    ]
    jump = "3\t0\t0\t177\t2\t1\t0\t0\t0\t0\t0\t1"
    text = "\n".join(("QGC WPL 110", "0\t1\t0\t16\t0\t0\t0\t0\t0\t0\t0\t1", *rows, jump, ""))
    x, y = place_of(46.97, 9.04)
    found = mended(tmp_path, text, name="m.txt", zones=[Circle(x, y, 200.0)])
    after = mission_in(written(found, text, "m.txt"), "m.txt")
    numbers = [each.number for each in after.items]
    assert numbers == list(range(1, len(numbers) + 1))
    assert after.items[-1].params[0] == len(numbers) - 1
    assert after.items[-2].lon == 9.06


def test_a_line_becomes_a_plan(tmp_path):
    text = "lat,lon,alt\n46.97,9.02,340\n46.97,9.06,340\n"
    file = tmp_path / "m.csv"
    file.write_text(text)
    mission = read_mission(file)
    problem = FlightProblem(land(np.where(PLAIN > 0, 330.0, 0)), NOWHERE, NOWHERE)
    found = mend(mission, problem)
    after = mission_in(found.written(text.encode(), "m.csv", "n.plan"), "n.plan")
    assert [each.alt_m for each in after.items] == [each.alt_m for each in found.mission.items]
    # A ground station would show a home at 0, 0.
    assert after.home == pytest.approx((46.97, 9.02, 330.0), abs=1e-6)
    with pytest.raises(InputError) as error:
        found.written(text.encode(), "m.csv", "n.csv")
    assert str(error.value) == (
        "n.csv: a mended mission of m.csv is written as a .plan; give n.plan."
    )


def test_an_item_in_a_zone_is_moved_out_of_it(tmp_path):
    text = plan_of([item(16, place, 420.0) for place in ((600, 3000), (3000, 3000), (5400, 3000))])
    found = mended(tmp_path, text, zones=[Circle(3000.0, 3000.0, 150.0)])
    assert found.feasible
    assert "move" in {change.kind for change in found.changes}


def test_a_planner_leads_around_a_wide_zone(tmp_path):
    ring = ((2500, 1200), (3500, 1200), (3500, 4800), (2500, 4800), (2500, 4300), (3000, 3000))
    text = plan_of([item(16, place, 420.0) for place in ((600, 3000), (5400, 3000))])
    found = mended(tmp_path, text, zones=[Polygon(ring)])
    assert found.feasible
    assert {change.kind for change in found.changes} <= {"insert", "detour"}


def test_a_mission_below_a_ceiling_goes_around_a_hill(tmp_path):
    text = plan_of([item(16, place, 380.0) for place in ((600, 3000), (5400, 3000))])
    found = mended(tmp_path, text, HILL, rules=Rules(ceiling_m=400.0))
    assert found.feasible
    assert all(each.alt_m <= 400.0 for each in found.mission.items)
    assert {change.kind for change in found.changes} <= {"insert", "detour"}
