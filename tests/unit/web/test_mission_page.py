"""The page of a checked mission: the marks of its faults, and parts that are flown on their own."""

import base64

import numpy as np
import pytest

from pathgene.host.problem.zones import Circle
from pathgene.host.web.mission_page import check_scene, page_of_check
from tests.support.host.foreign import PLAIN, checked, item, land, plan_of


ZONE = (4500.0, 3000.0)
ITEMS = [item(16, (900, 1500), 420), item(16, (4500, 1500), 420), item(16, (4500, 4500), 420)]


def column(track, name):
    return np.frombuffer(base64.b64decode(track[name]), "<f4")


@pytest.fixture
def check(tmp_path):
    def run(items, **options):
        return checked(land(PLAIN), tmp_path / "m.plan", plan_of(items), **options)

    return run


def test_faults_have_their_places_metres_flown_and_sentences(check):
    found = check(ITEMS, zones=(Circle(*ZONE, 200.0, name="mast"),))
    scene = check_scene(found, "m.plan")
    (fault,) = scene["faults"]
    (line,) = found.lines
    assert line == f"1. {fault['sentence']}"
    assert (fault["x"], fault["y"], fault["z"]) == pytest.approx((*ZONE, 420), abs=210)
    (path,) = scene["paths"]
    track = path["track"]
    # The track is there, at the metres flown.
    for axis in "xyz":
        there = np.interp(fault["at_m"], column(track, "s"), column(track, axis))
        assert there == pytest.approx(fault[axis], abs=3)
    (broken,) = track["broken"]
    assert broken["limit"] == "zone mast"
    assert broken["from_m"] < fault["at_m"] < broken["to_m"]
    assert broken["to_m"] - broken["from_m"] == pytest.approx(2 * 215, abs=12)
    assert scene["verdict"]["feasible"] is False
    assert fault["sentence"] in page_of_check(found, "m.plan")


def test_the_distance_stays_ascending_between_parts_flown_on_their_own(check):
    items = [*ITEMS[:2], item(21, (3000, 3000), 300), item(16, (900, 3000), 420), ITEMS[2]]
    track = check_scene(check(items), "m.plan")["paths"][0]["track"]
    assert (np.diff(column(track, "s")) >= 0).all()
    assert np.isnan(column(track, "x")).sum() == 1
    assert track["length_m"] == pytest.approx(column(track, "s")[-1])
    assert track["samples"] == len(column(track, "s"))


def test_each_fault_is_at_its_own_place_in_the_order_of_the_list(check):
    zones = (Circle(*ZONE, 200.0, name="mast"), Circle(2400.0, 1500.0, 200.0, name="tower"))
    found = check(ITEMS, zones=zones)
    shown = check_scene(found, "m.plan")["faults"]
    numbered = [f"{number}. {each['sentence']}" for number, each in enumerate(shown, 1)]
    assert numbered == list(found.lines)
    tower, mast = shown
    assert "zone tower" in tower["sentence"]
    assert "zone mast" in mast["sentence"]
    assert (tower["x"], tower["y"]) == pytest.approx((2400, 1500), abs=210)
    assert (mast["x"], mast["y"]) == pytest.approx(ZONE, abs=210)
    assert tower["at_m"] == pytest.approx(1500, abs=210)
    assert mast["at_m"] == pytest.approx(5100, abs=210)
