"""Single changes of the mending: which are offered, which are needed, and which are written."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.errors import JobError
from pathgene.host.formats.registry import mission_in, read_mission
from pathgene.host.mission.foreign.changes import changes
from pathgene.host.mission.foreign.check import check_mission
from pathgene.host.mission.foreign.draft import Draft
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.mission.foreign.mend import _Search
from pathgene.host.mission.foreign.repairs import Means, Repairs
from pathgene.host.problem.zones import Circle, Polygon
from tests.support.host.foreign import NOWHERE, PLAIN, item, items_of, land, plan_of
from tests.support.host.planted_missions import plant
from tests.unit.mission.foreign.test_mend import HILL, mended, place_of, written


@pytest.mark.parametrize("name", ["m.plan", "m.waypoints"])
def test_a_mission_that_does_not_pass_as_it_is_read_back_is_not_written(name, tmp_path):
    planted = plant("ridge", 4, faulty=True)
    text = planted.plan if name == "m.plan" else planted.waypoints
    found = mended(tmp_path, text, planted.heights, name)
    unmended = replace(found, entries=Draft.of(found.before.mission).written)
    with pytest.raises(JobError) as error:
        unmended.written(text.encode(), name, name)
    assert str(error.value).startswith(f"The mended mission does not pass as {name} states it")


def test_a_home_in_the_file_is_kept(tmp_path):
    text = plan_of(
        [item(16, place, 340.0) for place in ((1500, 3000), (4500, 3000))], home=(900, 900, 300.0)
    )
    after = mission_in(written(mended(tmp_path, text, HILL), text), "m.plan")
    assert after.home[2] == 300.0


def test_every_change_has_its_line(tmp_path):
    text = plan_of([item(18, (3000, 3000), 320.0, params=(2, 0, -80, 0))])
    found = mended(tmp_path, text, HILL)
    assert list(found.lines) == [
        each.sentence[:1].upper() + each.sentence[1:] for each in found.changes
    ]
    assert len(list(found.lines)) == 2


def test_a_waypoint_that_makes_a_turn_too_tight_is_left_out(tmp_path):
    """No move of it makes the turn fit, as the waypoints around it are fixed by zones."""
    places = [(600, 3000), (3000, 3000), (3005, 3020), (3000, 3040), (5400, 3000)]
    found = mended(tmp_path, plan_of([item(16, place, 420.0) for place in places]))
    assert found.feasible
    assert {change.kind for change in found.changes} & {"remove", "move", "detour"}


def test_a_rally_point_in_a_zone_is_moved(tmp_path):
    text = plan_of(
        [item(16, (600, 600), 420.0), item(16, (4500, 600), 420.0), item(20)],
        home=(900, 5000, 300.0),
        rally=[(3000, 3000, 130.0)],
    )
    found = mended(tmp_path, text, zones=[Circle(3000.0, 3000.0, 60.0)])
    assert found.feasible
    assert [(change.kind, change.item) for change in found.changes] == [("move", "rally point 1")]
    lat, lon, _ = json.loads(written(found, text))["rallyPoints"]["points"][0]
    assert math.dist(place_of(lat, lon), (3000, 3000)) >= 60.0 + 25.0


def test_an_item_above_the_ground_keeps_its_height_where_it_is_moved(tmp_path):
    places = ((600, 3000), (3000, 3000), (5400, 3000))
    text = plan_of([item(16, place, 60.0, 10) for place in places], home=(600, 2000, 300.0))
    slope = PLAIN + 0.1 * np.arange(PLAIN.shape[1])
    found = mended(tmp_path, text, slope, zones=[Circle(3000.0, 3000.0, 150.0)])
    assert found.feasible
    assert all(each.frame == 10 for each in found.mission.items)


def test_lines_of_a_survey_get_no_waypoints_beside_them(tmp_path):
    planted = plant("survey", 4, faulty=False)
    numbers = sorted(items_of(json.loads(planted.plan)))
    ends = [items_of(json.loads(planted.plan))[each]["params"][4:6] for each in numbers[3:5]]
    (ax, ay), (bx, by) = (place_of(*end) for end in ends)
    middle = Circle((ax + bx) / 2, (ay + by) / 2, 5.0)
    found = mended(tmp_path, planted.plan, planted.heights, zones=[middle])
    assert not found.feasible
    assert found.changes == ()


def test_the_way_to_a_return_gets_waypoints_before_it(tmp_path):
    text = plan_of(
        [item(16, (600, 3000), 420.0), item(16, (5000, 3000), 420.0), item(20)],
        home=(600, 3000, 300.0),
    )
    zone = Circle(3000.0, 3000.0, 200.0)
    found = mended(tmp_path, text, zones=[zone])
    assert found.feasible
    commands = [each.command for each in found.mission.items]
    assert commands[-1] == 20
    assert commands[-2] == 16
    assert len(commands) > 3


def drafted(tmp_path, text, heights=PLAIN, **options):
    """Return a mission as a draft, and its check."""
    file = tmp_path / "m.plan"
    file.write_text(text)
    mission = read_mission(file)
    problem = FlightProblem(land(heights), NOWHERE, NOWHERE, **options)
    return Draft.of(mission), check_mission(mission, problem)


def test_the_item_of_a_tight_turn_may_be_left_out(tmp_path):
    places = [(600, 3000), (3000, 3000), (2950, 3000), (5400, 3000)]
    draft, check = drafted(tmp_path, plan_of([item(16, place, 420.0) for place in places]))
    assert check.faults[0].limit == "turn"
    (repair,) = Repairs(draft, check).by(Means.REMOVALS)
    assert [each.kind for each in changes(repair.draft)] == ["remove"]
    assert len(repair.draft.entries) == len(places) - 1
    # The item of a survey is not.
    within = [replace(each, item=replace(each.item, within="survey 2")) for each in draft.entries]
    assert not list(Repairs(replace(draft, entries=tuple(within)), check).by(Means.REMOVALS))


def test_changes_that_are_not_needed_are_taken_back(tmp_path):
    text = plan_of(
        [item(16, (600, 600), 420.0), item(16, (4500, 600), 420.0), item(20)],
        home=(900, 3000, 300.0),
        rally=[(3000, 4500, 60.0), (3000, 3000, 110.0)],
    )
    draft, check = drafted(tmp_path, text, HILL)
    search = _Search(check.judge, None)
    # Only the second rally point needs its new height.
    raised = draft.raised([0], [0, 1], 40.0)
    lean, after = search.lean(raised, search.check(raised))
    assert after.feasible
    assert [each.item for each in changes(lean)] == ["rally point 2"]


def test_a_planner_that_finds_no_way_offers_no_detour(tmp_path):
    ring = [(x, y) for x, y in ((2000, 0), (2600, 0), (2600, 6000), (2000, 6000))]
    draft, check = drafted(
        tmp_path,
        plan_of([item(16, place, 420.0) for place in ((600, 3000), (5400, 3000))]),
        zones=[Polygon(ring)],
    )
    assert not list(Repairs(draft, check).by(Means.DETOURS))
