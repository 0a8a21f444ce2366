"""Files that a user gives to the page, and a problem as drawn."""

import io

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.mission.build import mission_of
from pathgene.host.problem.aircraft import load
from pathgene.host.web.desk.drawn import drawn_problem
from pathgene.host.web.desk.files import open_upload
from pathgene.host.web.desk.sheet import Sheet
from pathgene.host.web.desk.terrains import Terrains


ZONES = b"""{"type": "FeatureCollection", "crs_local": true, "features": [{"type": "Feature",
"properties": {"name": "lake", "lower": 10, "upper": 90},
"geometry": {"type": "Polygon", "coordinates": [[[1000, 1000], [1500, 1000], [1200, 1400]]]}}]}"""


@pytest.fixture
def sheet(tmp_path):
    sheet = Sheet(Terrains(tmp_path))
    sheet.take_terrain("canyon")
    return sheet


def give(sheet, name, content):
    said, _ = open_upload(sheet, sheet._terrains, name, content)
    return said


def test_zones_come_besides_those_that_are_there(sheet):
    give(sheet, "one.geojson", ZONES)
    give(sheet, "TWO.JSON", ZONES)
    corners = [[1000.0, 1000.0], [1500.0, 1000.0], [1200.0, 1400.0]]
    assert sheet.zones == 2 * [{"polygon": corners, "name": "lake", "lower": 10.0, "upper": 90.0}]


def test_the_report_on_zones_stays_with_the_problem(sheet):
    give(sheet, "lake.geojson", ZONES.replace(b'"lower": 10, "upper": 90', b'"ceiling": 90'))
    sentence = (
        'lake.geojson: ceiling of feature 1, "lake" is not read, so nothing is limited by it.'
    )
    assert sentence in sheet.mission().problem.zones_reading.warnings
    run = mission_of(sheet.task()).problem.zones_reading
    assert sentence in run.warnings
    (file,) = run.facts["files"]
    assert (file["file"], file["read"]) == ("lake.geojson", 1)
    sheet.remove_zone(0)
    assert sheet.mission().problem.zones_reading.facts["files"] == []


def test_a_zone_above_the_ground_is_one_zone(sheet):
    give(sheet, "town.geojson", ZONES.replace(b'"upper": 90', b'"upper": "120 m AGL"'))
    (zone,) = sheet.zones
    assert zone["upper"] == "120 m AGL"
    (drawn,) = drawn_problem(sheet, sheet.terrain())["zones"]
    assert drawn["text"] == "lake\n10 m to 120 m AGL"
    assert len(drawn["rings"][0]) == 3
    assert len(sheet.mission().problem.zones) > 1
    # The limit follows the ground at the zone's new place.
    upper_m = drawn["upper_m"]
    sheet.reshape(0, {"polygon": [[4000.0, 2500.0], [4600.0, 2500.0], [4600.0, 2900.0]]})
    (moved,) = drawn_problem(sheet, sheet.terrain())["zones"]
    assert moved["upper_m"] != upper_m
    other = Sheet(sheet._terrains)
    other.open_text(sheet.text())
    assert other.zones == sheet.zones


def test_a_problem_replaces_all_and_an_aircraft_the_aircraft(sheet):
    other = Sheet(sheet._terrains)
    other.set("clearance", 60.0)
    give(sheet, "other.toml", other.text().encode())
    assert sheet.text() == other.text()
    table = load("heron").to_dict() | {"name": "mine"}
    text = "\n".join(f"{key} = {value!r}".replace("'", '"') for key, value in table.items())
    give(sheet, "mine.toml", text.encode())
    assert sheet.values["uav"] == table
    assert sheet.values["clearance"] == 60.0
    assert sheet.mission().problem.aircraft.name == "mine"


def test_a_problem_is_reported_like_its_files(sheet):
    content = io.BytesIO()
    place = {"crs": "EPSG:32632", "origin": np.array([500_000.0, 5_000_000.0])}
    heights = np.tile(np.linspace(-60.0, 240.0, 60), (60, 1))
    np.savez(content, elevation=heights, dx_m=50.0, dy_m=50.0, **place)
    on_terrain = give(sheet, "coast.npz", content.getvalue())
    on_zones = give(sheet, "lake.geojson", ZONES.replace(b'"upper": 90', b'"ceiling": 90'))
    assert any("lie below 0 m" in sentence for sentence in on_terrain)
    assert any("not read" in sentence for sentence in on_zones)
    outside = '[[zones]]\nname = "far"\ncircle = [90000.0, 0.0, 50.0]\n'
    said = give(sheet, "problem.toml", f"{sheet.text()}\n{outside}".encode())
    assert said[: len(on_terrain)] == on_terrain
    assert [each for each in said if "far" in each and "forbids nothing" in each] == said[-1:]
    said = give(sheet, "aircraft.toml", "".join(_aircraft_lines()).encode())
    assert said == []


def _aircraft_lines():
    for key, value in (load("heron").to_dict() | {"name": "mine"}).items():
        yield f"{key} = {value!r}\n".replace("'", '"')


def test_a_terrain_keeps_planner_and_rules(sheet):
    sheet.set("clearance", 60.0)
    sheet.add_via(1000, 1000)
    content = io.BytesIO()
    np.savez(content, elevation=np.zeros((30, 40)), dx_m=50.0, dy_m=50.0)
    give(sheet, "land.npz", content.getvalue())
    assert sheet.values["clearance"] == 60.0
    assert sheet.via == []
    assert sheet.terrain().shape == (30, 40)
    sheet.mission()


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("a.toml", b"\xff", "a.toml: not valid TOML: "),
        ("a.toml", b"x =", "a.toml: not valid TOML: "),
        ("a.toml", b"x = 1", "a.toml: unknown UAV parameter 'x'; "),
        ("a.toml", b"#" * 16_000_001, "a.toml: has more than 16 MB, too much for a problem."),
        ("a.geojson", b"{}", "No-fly file 'a.geojson': "),
        ("a.kml", b"<kml", "a.kml cannot be opened as a mission: this is not the content of a "),
        ("a.png", b"PNG", "a.png: "),
    ],
)
def test_what_is_bad_changes_nothing(sheet, name, content, sentence):
    before = sheet.text()
    with pytest.raises(InputError) as caught:
        give(sheet, name, content)
    assert sentence in str(caught.value)
    assert "/" not in str(caught.value).partition(";")[0].replace("text/", "")
    assert sheet.text() == before


def test_points_are_drawn_at_their_altitudes(sheet):
    terrain = sheet.terrain()
    sheet.add_via(1000, 2000)
    sheet.set("return_to_start", True)
    points = drawn_problem(sheet, terrain)["points"]
    assert [point["kind"] for point in points] == ["start", "via", "goal", "return"]
    via = points[1]
    assert via["ground_m"] == terrain.ground(1000, 2000)
    assert via["z"] == via["ground_m"] + 100
    sheet.set("agl", False)
    assert drawn_problem(sheet, terrain)["points"][1]["z"] == 100


def test_what_is_not_allowed_yet_is_drawn_all_the_same(sheet):
    sheet.zones.append({"circle": (500.0, 500.0, 900.0), "lower": 900.0, "upper": 100.0})
    sheet.place("start", -500.0, 400.0)
    del sheet.values["goal"]
    drawn = drawn_problem(sheet, sheet.terrain())
    assert [point["kind"] for point in drawn["points"]] == ["start"]
    (zone,) = drawn["zones"]
    assert zone["circle"]["radius_m"] == 900.0
    assert zone["lower_m"] is None
    with pytest.raises(InputError):
        sheet.mission()
