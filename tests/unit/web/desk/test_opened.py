"""Missions of other ground stations on the desk: opened, judged, mended and compared."""

import asyncio
import json

import pytest
from nicegui import ElementFilter, ui

from pathgene.host.errors import InputError
from pathgene.host.formats.registry import mission_in
from pathgene.host.mission.foreign.check import check_mission
from pathgene.host.web.desk.desk import Desk
from pathgene.host.web.desk.files import open_upload
from pathgene.host.web.desk.sheet import Sheet
from pathgene.host.web.desk.terrains import Terrains
from tests.support.host.foreign import item, plan_of, write_planted
from tests.support.host.planted_missions import degrees
from tests.unit.web.desk.test_page import opened


def of_kml(*shapes):
    """Return a KML with lines and polygons in metres of the land: a tag and points each."""
    marks = []
    for tag, points in shapes:
        places = " ".join("{1:.8f},{0:.8f},420".format(*degrees(*point)) for point in points)
        inner = f"<coordinates>{places}</coordinates>"
        if tag == "Polygon":
            inner = f"<outerBoundaryIs><LinearRing>{inner}</LinearRing></outerBoundaryIs>"
        mode = "<altitudeMode>absolute</altitudeMode>"
        marks.append(f"<Placemark><name>{tag}</name><{tag}>{mode}{inner}</{tag}></Placemark>")
    return f"<kml><Document>{''.join(marks)}</Document></kml>".encode()


LINE = ("LineString", [(900, 1500), (4500, 1500)])
CLOSED = ("LineString", [(900, 900), (1900, 900), (1900, 1900), (900, 900)])
AREA = ("Polygon", [(2500, 2500), (3500, 2500), (3000, 3500), (2500, 2500)])


@pytest.fixture(scope="module")
def planted(tmp_path_factory):
    """Folder of a mission with one fault in its fence, and of its land."""
    folder = tmp_path_factory.mktemp("planted")
    write_planted(folder, "fence", faulty=True)
    return folder


@pytest.fixture
def sheet(tmp_path, planted):
    sheet = Sheet(Terrains(tmp_path))
    open_upload(sheet, sheet._terrains, "land.npz", (planted / "land.npz").read_bytes())
    return sheet


def give(sheet, name, content, earlier=None):
    return open_upload(sheet, sheet._terrains, name, content, earlier)


@pytest.mark.parametrize(
    ("shapes", "zones", "points", "sentence"),
    [
        ([LINE], 0, 2, "a.kml: a line of KML, 2 points."),
        ([AREA, LINE], 1, 2, "a.kml: a line of KML, 2 points, and 1 zone."),
        ([AREA], 1, None, "a.kml: 1 zone, no mission: there is no LineString in it."),
        ([CLOSED], 1, None, "a.kml: 1 zone, no mission: its line ends where it begins, around"),
    ],
)
def test_a_kml_is_what_is_drawn_in_it_and_the_report_says_it(
    sheet, shapes, zones, points, sentence
):
    said, mission = give(sheet, "a.kml", of_kml(*shapes))
    assert said[0].startswith(sentence)
    assert len(sheet.zones) == zones
    assert points == (None if mission is None else len(mission.content.items))


def test_the_fences_of_a_mission_come_once_and_go_with_the_next(sheet, planted):
    source = (planted / "m.plan").read_bytes()
    sheet.zones.append({"circle": (5000.0, 5000.0, 50.0)})
    own = sheet.copy().zones
    said, first = give(sheet, "m.plan", source)
    assert said[0] == "m.plan: a .plan of QGroundControl, 6 items, and 2 zones."
    assert sheet.zones == [*own, *first.fences]
    _, again = give(sheet, "m.plan", source, first)
    assert sheet.zones == [*own, *first.fences]
    points = plan_of([item(16, place, 420) for place in LINE[1]]).encode()
    _, other = give(sheet, "other.plan", points, again)
    assert len(other.content.items) == 2
    assert sheet.zones == own


@pytest.mark.parametrize(
    ("name", "change", "sentence"),
    [
        ("m.plan", {"origin": "far"}, "the mission lies outside the map: item 1 is at "),
        ("m.plan", {"command": 82}, "item 2"),
        ("m.gpx", {"kml": b"{}"}, "this is not the content of a .gpx file"),
        ("m.kml", {"kml": of_kml()}, "there is no LineString in it."),
    ],
)
def test_a_refused_mission_is_one_sentence_and_changes_nothing(
    sheet, planted, name, change, sentence
):
    document = json.loads((planted / "m.plan").read_text())
    items = document["mission"]["items"]
    if "origin" in change:
        for each in items:
            each["params"][5] += 3.0
    if "command" in change:
        items[1]["command"] = change["command"]
    before = sheet.text()
    with pytest.raises(InputError) as caught:
        give(sheet, name, change.get("kml") or json.dumps(document).encode())
    assert str(caught.value).startswith(f"{name} cannot be opened as a mission: {sentence}")
    assert sheet.text() == before


def test_a_mission_is_judged_by_the_problem_of_the_page(sheet, planted):
    _, mission = give(sheet, "m.plan", (planted / "m.plan").read_bytes())
    zone = [each for each in mission.fences if "circle" in each]
    (fault,) = mission.judged(sheet.flight_problem()).scene["faults"]
    assert "zone 1 entered" in fault["sentence"]
    sheet.remove_zone(sheet.zones.index(zone[0]))
    assert mission.judged(sheet.flight_problem()).check.feasible
    sheet.set("clearance", 300.0)
    assert not mission.judged(sheet.flight_problem()).check.feasible
    sheet.set("clearance", None)
    sheet.set("as_paper", True)
    with pytest.raises(InputError, match=r"^A mission is judged by the rules; switch off as paper"):
        sheet.flight_problem()


@pytest.fixture(scope="module")
def desk(tmp_path_factory, planted):
    desk = Desk(tmp_path_factory.mktemp("desk"))
    sheet = desk._first
    open_upload(sheet, desk.terrains, "land.npz", (planted / "land.npz").read_bytes())
    yield desk
    desk.close()


def texts(kind=ui.label):
    return [each.text for each in ElementFilter(kind=kind)]


async def until(condition):
    for _ in range(1500):
        if condition():
            return
        await asyncio.sleep(0.02)
    raise AssertionError("it took too long")


@pytest.mark.ci
def test_a_mission_is_mended_compared_and_judged_again_after_a_change(desk, planted):
    source = (planted / "m.plan").read_bytes()

    async def use():
        async with opened(desk) as (_, page):
            card = page._mission
            _, mission = open_upload(page._sheet, desk.terrains, "m.plan", source)
            card.open(mission)
            await page._settle()
            await until(lambda: "✗ 1 fault · m.plan" in texts())
            assert "Mend" in texts(ui.button)
            # A mending that is stopped leaves the mission as it is.
            await card.mend()
            await until(lambda: "Stop mending" in texts(ui.button))
            card.stop()
            await until(lambda: "Mending was stopped; the mission is as before." in texts())
            await card.mend()
            assert desk.jobs.active == []
            await until(lambda: "✓ no fault · m-mended.plan" in texts())
            await until(lambda: "Download m-mended.plan" in texts(ui.button))
            assert "Mend" not in texts(ui.button)
            assert any(text.startswith("Inserted 1 waypoint after item 3") for text in texts())
            (mended,) = card._missions[1:]
            again = mission_in(mended.source, mended.name)
            assert check_mission(again, page._sheet.flight_problem()).feasible
            card._turn()
            await until(lambda: "✗ 1 fault · m.plan" in texts())
            # A zone on the mended way: its file is not offered any more.
            page._sheet.zones.append({"circle": (900.0, 3000.0, 3000.0)})
            page._changed()
            await until(lambda: "Mend" in texts(ui.button))
            assert "Download m-mended.plan" not in texts(ui.button)
            # A value that is not one: no verdict, and the reason above.
            page._sheet.set("as_paper", True)
            page._changed()
            await until(lambda: "switch off as paper" in page._trouble.text)
            await until(lambda: "m.plan is not judged; see above." in texts())
            await card._close()
            assert not card.is_open

    asyncio.run(use())
