"""The plan of QGroundControl: its content, and how MAVSDK and pathgene read it."""

import copy
import itertools
import json
import math
from dataclasses import replace
from importlib import metadata

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats.flight_plan import CHANGE_SPEED, LOITER, RTL, WAYPOINT
from pathgene.host.formats.plan import plan_document, read_plan
from pathgene.host.problem.zones import Circle
from tests.support.host.earth import agree, single
from tests.support.host.missions import SEEDS, flight
from tests.unit.mission.autopilot.mavsdk_autopilot import importer


VERSION = metadata.version("pathgene")


@pytest.fixture(scope="module")
def plans():
    verdicts = itertools.cycle((None, True, False))
    return [
        replace(flight(seed), feasible=feasible)
        for seed, feasible in zip(SEEDS, verdicts, strict=False)
    ]


@pytest.fixture(scope="module")
def documents(plans):
    """Return the content of the files, as a reader gets it."""
    return [json.loads(json.dumps(plan_document(plan))) for plan in plans]


def test_every_number_is_where_the_format_has_it(missions, plans, documents):
    for (problem, _), plan, document in zip(missions, plans, documents, strict=True):
        assert (document["fileType"], document["version"]) == ("Plan", 1)
        mission, fence, rally = (document[key] for key in ("mission", "geoFence", "rallyPoints"))
        assert (mission["version"], fence["version"], rally["version"]) == (2, 2, 2)
        items = mission["items"]
        assert [item["doJumpId"] for item in items] == list(range(1, len(items) + 1))
        assert {item["type"] for item in items} == {"SimpleItem"}
        assert {item["frame"] for item in items} == {0}
        # QGroundControl's editor takes this for AMSL, in items and in items added to them.
        flown = [item for item in items if item["command"] not in (CHANGE_SPEED, RTL)]
        assert {item["AltitudeMode"] for item in flown} == {2}
        assert mission["globalPlanAltitudeMode"] == 2
        *waypoints, last = (item for item in items if item["command"] != CHANGE_SPEED)
        assert {item["command"] for item in waypoints} == {WAYPOINT}
        assert last["command"] == {"loiter": LOITER, "rtl": RTL}[plan.end.kind]
        assert {item["Altitude"] == item["params"][6] for item in flown} == {True}
        assert not any("Altitude" in item for item in items if item not in flown)
        for piece in fence["circles"] + fence["polygons"]:
            assert (piece["version"], piece["inclusion"]) == (1, False)
        ground = problem.terrain.ground(*problem.start[:2])
        *home, home_alt = mission["plannedHomePosition"]
        assert home == items[0]["params"][4:6]
        assert home_alt == ground
        assert rally["points"] == [list(point) for point in plan.rally]

        assert [item["params"] for item in items] == [
            [*item.params, item.lat, item.lon, item.alt_m] for item in plan.items
        ]
        # Start and goal are waypoints, with their exact altitudes.
        lat, lon, alt = np.array([item["params"][4:] for item in waypoints]).T
        for end in (problem.start, problem.goal):
            assert any(
                height == end[2] and agree(problem.terrain, np.array([end]), *np.array([place]).T)
                for *place, height in zip(lat, lon, alt, strict=True)
            )
        # ArduPilot refuses a loiter or a return with null, which MAVLink carries as NaN.
        assert None not in items[-1]["params"]


def test_mavsdk_imports_the_same_mission_and_fence(documents):
    """MAVLink has degrees times 10 million and altitudes in single precision."""
    with importer() as read:
        for document in documents:
            imported = read(json.dumps(document))
            items = document["mission"]["items"]
            assert len(imported.mission_items) == len(items)
            for wanted, item in zip(items, imported.mission_items, strict=True):
                *params, lat, lon, alt = wanted["params"]
                assert (item.command, item.frame) == (wanted["command"], 0)
                assert item.x == pytest.approx(lat * 1e7, abs=0.51)
                assert item.y == pytest.approx(lon * 1e7, abs=0.51)
                assert item.z == single(alt)
                assert [item.param1, item.param2, item.param3] == [single(p) for p in params[:3]]
                assert math.isnan(item.param4) if item.command == WAYPOINT else item.param4 == 0
            corners = [
                (corner, len(piece["polygon"]))
                for piece in document["geoFence"]["polygons"]
                for corner in piece["polygon"]
            ]
            circles = [piece["circle"] for piece in document["geoFence"]["circles"]]
            fence = imported.geofence_items
            assert [(f.command, f.param1) for f in fence] == [
                *((5002, count) for _, count in corners),
                *((5004, single(circle["radius"])) for circle in circles),
            ]
            places = [corner for corner, _ in corners] + [circle["center"] for circle in circles]
            for (lat, lon), item in zip(places, fence, strict=True):
                assert item.x == pytest.approx(lat * 1e7, abs=0.51)
                assert item.y == pytest.approx(lon * 1e7, abs=0.51)
            heights = [point[2] for point in document["rallyPoints"]["points"]]
            assert [item.z for item in imported.rally_items] == heights


def test_circles_have_their_centres(missions, documents):
    for (problem, _), document in zip(missions, documents, strict=True):
        circles = [circle["circle"] for circle in document["geoFence"]["circles"]]
        zones = [zone for zone in problem.zones if isinstance(zone, Circle)]
        for circle in circles:
            (zone,) = (zone for zone in zones if zone.radius_m == circle["radius"])
            lat, lon = np.array(circle["center"])[:, None]
            assert agree(problem.terrain, [(zone.x_m, zone.y_m)], lat, lon)


def test_reads_its_own_files(plans, documents, tmp_path):
    file = tmp_path / "path.plan"
    for plan, document in zip(plans, documents, strict=True):
        file.write_text(json.dumps(document))
        read = read_plan(file)
        assert (read.home, read.items, read.rally) == (plan.home, plan.items, plan.rally)
        assert set(read.fence) == set(plan.fence)
        assert read.feasible is plan.feasible


def test_states_the_verdict_on_the_path(plans, documents):
    for plan, document in zip(plans, documents, strict=True):
        stated = None if plan.feasible is None else {"version": VERSION, "feasible": plan.feasible}
        assert document.get("pathgene") == stated


def altered(document, *where, to):
    """Return a copy with a different value at ``where``."""
    changed = copy.deepcopy(document)
    table = changed
    for key in where[:-1]:
        table = table[key]
    table[where[-1]] = to
    return changed


@pytest.mark.parametrize(
    ("where", "to", "sentence"),
    [
        (("version",), 2, "not a .plan file of QGroundControl, version 1."),
        (("mission", "items", 0, "params"), [0, 1], "the params of item 1 are not seven finite"),
        (("mission", "items", 1, "params", 4), None, "the params of item 2 are not seven finite"),
        (("mission", "items", 0, "params", 6), math.nan, "the params of item 1 are not seven"),
        (
            ("mission", "items", 2, "frame"),
            3,
            "item 3 has an altitude of frame 3; give altitudes above mean sea level (frame 0).",
        ),
        (
            ("mission", "items", 1),
            {"type": "ComplexItem", "complexItemType": "survey"},
            "item 2 is a survey, but only waypoints and other simple items can be read; replace "
            "it by waypoints.",
        ),
        (
            ("geoFence", "version"),
            1,
            "its fences are of another version than 2; save it with a newer program.",
        ),
        (
            ("pathgene", "feasible"),
            "no",
            "feasible of pathgene must be true or false, not 'no'.",
        ),
        (("pathgene",), 1, "not a .plan file of QGroundControl, version 1."),
    ],
)
def test_refuses_other_plans(documents, tmp_path, where, to, sentence):
    file = tmp_path / "other.plan"
    file.write_text(json.dumps(altered(documents[1], *where, to=to)))
    with pytest.raises(InputError) as refusal:
        read_plan(file)
    assert str(refusal.value).startswith(f"{file}: {sentence}")


def test_refuses_what_is_no_json(tmp_path):
    file = tmp_path / "none.plan"
    with pytest.raises(InputError, match=r"^Cannot read the plan .*none.plan' \(No such file"):
        read_plan(file)
    file.write_text("QGC WPL 110\n")
    with pytest.raises(InputError, match=r": not JSON; give a .plan file or a summary.json.$"):
        read_plan(file)
