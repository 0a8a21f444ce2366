"""Plans over files that were misread, if they are at hand."""

import json

import pytest

from pathgene.host.cli import main
from tests.support.host.cases import case


#: Commands of MAVLink below this number have a place; changes of speed have 0 there.
FIRST_OF_CONDITIONS = 112


def run(*arguments):
    return main(list(map(str, arguments)))


def test_a_mission_over_sea_floor_stays_above_the_water(tmp_path):
    terrain = case("01-sea-floor-as-ground/topobathy.tif")
    ends = ("--agl", "--start", "900,1500,80", "--goal", "11000,1500,80")
    out = ("--planner", "astar", "--write", "plan", "--out", tmp_path)
    assert run("plan", "--terrain", terrain, *ends, *out) == 0
    items = json.loads((tmp_path / "path.plan").read_text())["mission"]["items"]
    flown = [item["params"][6] for item in items if item["command"] < FIRST_OF_CONDITIONS]
    altitudes = [altitude for altitude in flown if altitude is not None]
    assert min(altitudes) > 29
    # The clearance is kept above the water, so the long leg over it is not much higher either.
    assert sorted(altitudes)[1] < 60


def test_a_plan_over_web_mercator_holds_on_the_geographic_tile(tmp_path, capsys):
    folder = "02-web-mercator/"
    zones = ("--nofly", case(f"{folder}tower.geojson"))
    ends = ("--agl", "--start-geo", "59.985,10.015,80", "--goal-geo", "60.015,10.095,80")
    out = ("--planner", "astar", "--out", tmp_path)
    assert run("plan", "--terrain", case(f"{folder}merc60.tif"), *ends, *zones, *out) == 0
    planned = json.loads((tmp_path / "summary.json").read_text())
    capsys.readouterr()
    path = ("--path", tmp_path / "path.geojson", "--json")
    assert run("check", "--terrain", case(f"{folder}geo60.tif"), *zones, *path) == 0
    checked = json.loads(capsys.readouterr().out)
    assert checked["feasible"]
    assert checked["length_m"] == pytest.approx(planned["length_m"], rel=1e-3)
