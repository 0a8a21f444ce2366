"""A zone with limits above the ground is one zone to a user, and tiles to search and judgement."""

import json
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from pathgene.host.mission.build import mission_of
from pathgene.host.mission.problem_file import read_problem
from pathgene.host.problem.tiles import wholes
from pathgene.host.report.read import read_run
from pathgene.host.terrain.surface import surface_below
from pathgene.host.web.scene import problem_scene
from tests.cli.conftest import ENDS, assert_check_agrees, plan, run_here


KML = {"kml": "http://www.opengis.net/kml/2.2"}


def zone_file(folder, corners, **properties):
    """Write a polygon as GeoJSON in local metres."""
    feature = {
        "type": "Feature",
        "properties": {"name": "R-7", **properties},
        "geometry": {"type": "Polygon", "coordinates": [[*corners, corners[0]]]},
    }
    file = folder / "zones.geojson"
    document = {"type": "FeatureCollection", "crs_local": True, "features": [feature]}
    file.write_text(json.dumps(document))
    return file


BESIDE = [[600, 2600], [2400, 2600], [2400, 3900], [600, 3900]]
ACROSS = [[3600, 900], [4600, 900], [4600, 3900], [3600, 3900]]


@pytest.fixture(scope="module")
def planned(hills, tmp_path_factory):
    """The folder of a plan past a zone with limits above the ground."""
    folder = tmp_path_factory.mktemp("beside")
    zones = zone_file(folder, BESIDE, lower="30 m AGL", upper="400 ft AGL")
    options = ("--nofly", zones, "--origin", "47,8", "--planner", "astar", "--no-picture")
    files = ("--write", "plan,kml", "--save-problem", folder / "saved.toml")
    assert plan(hills, folder, *options, *files) == 0
    return folder


def test_a_summary_has_one_zone_with_its_limits_as_read(planned, capsys):
    summary = json.loads((planned / "summary.json").read_text())
    zone, _ = summary["nofly"]
    assert zone == {
        "polygon": [[float(x), float(y)] for x, y in BESIDE],
        "name": "R-7",
        "lower": "30 m AGL",
        "upper": "121.92 m AGL",
    }
    limits = [limit["limit"] for limit in summary["limits"]]
    assert limits.count("zone R-7") == 1
    assert len(read_run(planned / "summary.json").problem.zones) > 20
    assert_check_agrees(planned, summary, capsys)


def test_exports_have_one_zone(planned):
    fence = json.loads((planned / "path.plan").read_text())["geoFence"]
    assert (len(fence["polygons"]), len(fence["circles"])) == (1, 1)
    assert len(fence["polygons"][0]["polygon"]) == len(BESIDE)
    features = json.loads((planned / "path.geojson").read_text())["features"]
    zone, _ = (each for each in features if each["properties"]["kind"] == "zone")
    assert zone["properties"]["upper"] == "121.92 m AGL"
    root = ET.parse(planned / "path.kml").getroot()
    (placemark,) = (
        each
        for each in root.iterfind(".//kml:Placemark", KML)
        if each.findtext("kml:name", namespaces=KML) == "R-7"
    )
    modes = {each.text for each in placemark.iterfind(".//kml:altitudeMode", KML)}
    assert modes == {"relativeToGround"}
    heights = {
        place.rpartition(",")[2]
        for each in placemark.iterfind(".//kml:coordinates", KML)
        for place in each.text.split()
    }
    assert heights == {"30", "121.92"}


@pytest.mark.parametrize("name", ["path.kml", "path.geojson"])
def test_exports_are_read_back_as_the_same_zone(planned, hills, name):
    summary = json.loads((planned / "summary.json").read_text())
    zones = ("--origin", "47,8", "--nofly", planned / name)
    path = ("check", "--path", planned / "path.geojson", "--terrain", hills, *zones, "--json")
    report = json.loads(run_here(*path).stdout)
    assert report["feasible"]
    (found,) = (each for each in report["limits"] if each["limit"] == "zone R-7")
    (known,) = (each for each in summary["limits"] if each["limit"] == "zone R-7")
    # Positions of files are rounded to a tenth of a millimetre.
    assert found["worst"] == pytest.approx(known["worst"], abs=0.01)


def test_a_saved_problem_has_the_same_tiles(planned):
    run = read_run(planned / "summary.json")
    saved = mission_of(read_problem(planned / "saved.toml")).problem
    assert saved.zones == run.problem.zones
    report = json.loads(run_here("problem", "check", planned / "saved.toml", "--json").stdout)
    assert report["zones"] == 2


def test_a_table_states_a_limit_above_the_ground(hills, tmp_path):
    zone = f'[[zones]]\npolygon = {BESIDE}\nname = "R-7"\nupper = "120 m AGL"\n'
    file = tmp_path / "problem.toml"
    ends = "start = [500.0, 500.0, 100.0]\ngoal = [5500.0, 3500.0, 100.0]\nagl = true\n"
    terrain = f"[terrain]\nsource = {json.dumps(str(hills))}\n"
    file.write_text(f"{terrain}[mission]\n{ends}{zone}")
    problem = mission_of(read_problem(file)).problem
    (whole,) = wholes(problem.zones)
    assert (whole.upper_m, whole.upper_agl_m) == (None, 120.0)
    x, y = (each.ravel() for each in np.meshgrid(range(650, 2400, 90), range(2650, 3900, 90)))
    surface = surface_below(problem.terrain, x.astype(float), y.astype(float))
    highest = np.full(len(x), -np.inf)
    for tile in problem.zones:
        inside = tile.footprint.contains(x, y)
        highest[inside] = np.maximum(highest[inside], tile.upper_m)
    assert (highest >= surface + 120).all()
    file.write_text(file.read_text().replace("120 m AGL", "FL 95"))
    said = run_here("problem", "check", file)
    assert said.returncode == 2
    assert "upper in [zones] must be a number of metres, or a height above" in said.stderr


def test_a_path_over_a_zone_has_no_fence_and_one_sentence(hills, tmp_path):
    zones = zone_file(tmp_path, ACROSS, upper="60 m AGL")
    options = ("--nofly", zones, "--origin", "47,8", "--planner", "astar", "--write", "plan")
    command = ("plan", "--terrain", hills, *ENDS, *options, "--no-picture", "--out", tmp_path)
    said = run_here(*command)
    assert said.returncode == 0
    assert said.stderr.count("No fence for R-7") == 1
    fence = json.loads((tmp_path / "path.plan").read_text())["geoFence"]
    assert fence["polygons"] == []


def test_the_page_draws_the_outline_once_and_the_profile_by_tiles(planned):
    scene = problem_scene(read_run(planned / "summary.json").problem)
    assert scene["zones_left_out"] == 0
    zone, circle = scene["zones"]
    assert zone["text"] == "R-7\n30 to 121.92 m AGL"
    assert zone["rings"] == [[[float(x), float(y)] for x, y in BESIDE]]
    assert zone["upper_m"] == max(tile["upper_m"] for tile in zone["tiles"])
    assert len(zone["tiles"]) > 20
    assert circle["tiles"] is None
