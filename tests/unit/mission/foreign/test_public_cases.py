"""Reported accidents of planned missions, rebuilt at other places: found, mended, and flown."""

import json

import numpy as np

from pathgene.host.formats.registry import read_mission
from pathgene.host.mission.foreign.check import check_mission
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.mission.foreign.mend import mend
from pathgene.host.problem.zones import read_zones
from tests.support.host.foreign import NOWHERE, PLAIN, item, land, plan_of
from tests.support.host.mended_flights import fly
from tests.support.host.planted_missions import degrees


def judged(tmp_path, text, heights=PLAIN):
    """Return the check of a plan, and its mended mission with the text of its file."""
    file = tmp_path / "m.plan"
    file.write_text(text)
    terrain, mission = land(heights), read_mission(file)
    own = read_zones(file, terrain).zones if mission.has_fences else ()
    problem = FlightProblem(terrain, NOWHERE, NOWHERE, zones=own)
    mended = mend(mission, problem)
    written = mended.written(text.encode(), "m.plan", "m.plan").decode()
    return check_mission(mission, problem), mended, written


def test_px4_28527_a_circle_reaches_into_a_zone_that_its_centre_is_out_of(tmp_path):
    # The mission was accepted, because the centre of its circle of 200 m lies out of the zone, and
    # the flight went 28.9 m deep into it.
    ring = [(2800, 3171.1), (3800, 3171.1), (3800, 3900), (2800, 3900)]
    places = (900, 3000), (3300, 3000), (5400, 3000)
    listed = [item(16, place, 420.0) for place in places]
    listed[1] = item(18, places[1], 420.0, params=(2, 0, 200, 0))
    document = json.loads(plan_of(listed, firmware=12))
    polygon = {"version": 1, "inclusion": False, "polygon": [[*degrees(*each)] for each in ring]}
    document["geoFence"] = {"version": 2, "circles": [], "polygons": [polygon]}
    check, mended, written = judged(tmp_path, json.dumps(document))
    (fault,) = check.report["faults"]
    assert fault["items"] == [2]
    assert fault["limit"].startswith("zone")
    assert 28.9 - 0.5 <= fault["broken_by_m"] - 25.0 <= 28.9 + 0.5
    assert mended.feasible
    assert [change.kind for change in mended.changes] == ["move"]
    assert fly(written, PLAIN).zone_m >= 0


def test_ardupilot_30151_a_survey_flies_into_a_slope_between_its_ends(tmp_path):
    # Each end of a line is clear of the ground, and a hill stands between them.
    heights = PLAIN + 160 * np.exp(-((np.arange(201) - 100.0) ** 2) / 400)[:, None]
    listed = [item(16, (1500, 600), 60.0, frame=3)]
    lines = []
    for number in range(4):
        ends = [(1500 + 450 * number, 1500), (1500 + 450 * number, 4500)]
        lines += [item(16, end, 60.0, frame=3) for end in (ends if number % 2 == 0 else ends[::-1])]
    survey = {
        "type": "ComplexItem",
        "complexItemType": "survey",
        "TransectStyleComplexItem": {"Items": lines},
    }
    text = plan_of([*listed, survey], home=(1500, 300, 300.0))
    document = json.loads(text)
    document["geoFence"] = {"version": 2, "circles": [], "polygons": []}
    check, mended, written = judged(tmp_path, json.dumps(document), heights)
    faults = check.report["faults"]
    assert [fault["items"] for fault in faults] == [[2, 3], [4, 5], [6, 7], [8, 9]]
    assert {fault["limit"] for fault in faults} == {"clearance"}
    assert mended.feasible
    assert {change.kind for change in mended.changes} <= {"raise", "insert"}
    after = json.loads(written)["mission"]["items"][1]["TransectStyleComplexItem"]["Items"]
    places = [tuple(each["params"][4:6]) for each in after]
    assert [place for place in places if list(place) in [e["params"][4:6] for e in lines]] == [
        tuple(each["params"][4:6]) for each in lines
    ]
    assert fly(written, heights).clearance_m >= 15.0
