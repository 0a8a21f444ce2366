"""Scenario files and ``--popup``: their meaning, and refused values."""

import json
import re

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import wholes
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.replanning.airspace import Airspace
from pathgene.host.replanning.scenario import (
    Event,
    NewZone,
    Placed,
    Scenario,
    parse_popup,
    read_scenario,
)
from pathgene.host.terrain import Terrain


FILE = """
autopilot = "finishes-leg"

[[event]]
at_s = 60
gone = ["storm"]
wind = [3, -4]

[[event]]
at_s = 40
appear = [
  {name = "storm", on = "path", ahead_m = 800, radius_m = 150, velocity = [5, 0]},
  {polygon = [[0, 0], [100, 0], [0, 100]], upper = 900},
]
goal = [6000, 4000, 300]

[[event]]
at_s = 90
board = "lost"
"""


def test_a_file_says_what_happens(tmp_path):
    file = tmp_path / "storm.toml"
    file.write_text(FILE)
    scenario = read_scenario(file)
    assert scenario.autopilot == "finishes-leg"
    first, second, third = scenario.events
    storm, polygon = first.appear
    assert storm == NewZone(Placed("path", 150.0, 800.0), "storm", (5.0, 0.0))
    assert polygon.shape == Polygon([(0, 0), (100, 0), (0, 100)], upper_m=900.0)
    assert (first.at_s, first.goal) == (40.0, (6000.0, 4000.0, 300.0))
    assert second == Event(60.0, gone=("storm",), wind=(3.0, -4.0))
    assert third == Event(90.0, board_lost=True)
    both = scenario + Scenario((Event(50.0, wind=(0.0, 0.0)),))
    assert [event.at_s for event in both.events] == [40, 50, 60, 90]
    assert both.autopilot == "finishes-leg"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("event = 3", "a scenario needs a table"),
        ("wind = [1, 2]\n[[event]]\nat_s = 1\nboard = 'lost'", "a scenario has no key 'wind'"),
        ("[[event]]\nboard = 'lost'", "an event needs at_s"),
        ("[[event]]\nat_s = -1\nboard = 'lost'", "an event needs at_s"),
        ("[[event]]\nat_s = 1", "says nothing"),
        ("[[event]]\nat_s = 1\nboard = 'found'", 'board can only be "lost"'),
        ("[[event]]\nat_s = 1\nwind = [1]", "wind must be 2 numbers"),
        ("[[event]]\nat_s = 1\ngoal = 'home'", "goal must be 3 numbers"),
        ("[[event]]\nat_s = 1\ngone = 'storm'", "gone must be a list"),
        ("[[event]]\nat_s = 1\nappear = [3]", "must be a table"),
        ("[[event]]\nat_s = 1\nappear = [{on = 'moon', radius_m = 3}]", "placed on path, goal"),
        ("[[event]]\nat_s = 1\nappear = [{on = 'goal'}]", "radius of a placed zone"),
        ("[[event]]\nat_s = 1\nappear = [{on = 'goal', radius_m = 0}]", "radius of a placed zone"),
        ("[[event]]\nat_s = 1\nappear = [{x = 1, y = 2}]", "A no-fly zone must be"),
        ("autopilot = 'none'\n[[event]]\nat_s = 1\nboard = 'lost'", "The autopilot must be"),
        ("[[event]", "not valid TOML"),
    ],
)
def test_a_bad_file_is_refused_with_its_name(tmp_path, text, sentence):
    file = tmp_path / "bad.toml"
    file.write_text(text)
    with pytest.raises(InputError, match=re.escape(sentence)) as error:
        read_scenario(file)
    assert str(error.value).startswith(str(file))


def test_a_file_that_is_not_there_or_no_text(tmp_path):
    with pytest.raises(InputError, match="Cannot read the scenario"):
        read_scenario(tmp_path / "none.toml")
    (tmp_path / "picture.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not UTF-8"):
        read_scenario(tmp_path / "picture.toml")


def test_popups(hills, tmp_path):
    assert parse_popup("3000,2500,200@40", hills) == Event(
        40.0, (NewZone(Circle(3000.0, 2500.0, 200.0)),)
    )
    assert parse_popup("ahead:900,150@4.5", hills).appear[0].shape == Placed("path", 150.0, 900.0)
    assert parse_popup("goal:100@0", hills).appear[0].shape == Placed("goal", 100.0)
    assert parse_popup("aircraft:100@9", hills).appear[0].shape == Placed("aircraft", 100.0)
    file = tmp_path / "zones.geojson"
    file.write_text(
        '{"type": "FeatureCollection", "crs_local": true, "features": [{"type": "Feature", '
        '"properties": {"radius_m": 90}, "geometry": {"type": "Point", "coordinates": [5, 6]}}]}'
    )
    assert parse_popup(f"{file}@7", hills).appear[0].shape == Circle(5.0, 6.0, 90.0)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "3,4,5",
        "3,4,5@",
        "3,4,5@x",
        "3,4,5@-1",
        "3,4,5@inf",
        "3,4@5",
        "moon:3@4",
        "@5",
        "ahead:nan,5@3",
        "goal:inf@3",
    ],
)
def test_bad_popups_are_refused_in_one_sentence(hills, text):
    with pytest.raises(InputError, match="--popup must be"):
        parse_popup(text, hills)


@pytest.mark.parametrize("text", ["ahead:9,-5@3", "goal:0@3", "1,2,-5@3"])
def test_bad_numbers_of_popups_are_named(hills, text):
    with pytest.raises(InputError, match=rf"^--popup '{re.escape(text)}': .*, not "):
        parse_popup(text, hills)


def test_zones_come_move_drift_and_go(mission):
    air = Airspace(mission)
    place = {"goal": (6500.0, 4500.0), "aircraft": (2000.0, 4500.0)}

    def happen(event):
        air.happen(event, lambda on, ahead: place[on])

    storm = NewZone(Placed("aircraft", 100.0), "storm", (10.0, 0.0))
    happen(Event(10.0, (storm, NewZone(Placed("goal", 50.0)))))
    assert air.zones_at(10.0) == (
        Circle(2000.0, 4500.0, 100.0, name="storm"),
        Circle(6500.0, 4500.0, 50.0, name="pop-up 1"),
    )
    assert air.drift(14.0)
    assert air.zones_at(14.0)[0] == Circle(2040.0, 4500.0, 100.0, name="storm")
    # A zone with the same name has moved, and no longer drifts.
    happen(Event(20.0, (NewZone(Circle(3000.0, 4000.0, 80.0), "storm"),)))
    assert [zone.name for zone in air.zones_at(20.0)] == ["pop-up 1", "storm"]
    assert not air.drift(30.0)
    happen(Event(40.0, gone=("storm", "pop-up 1"), wind=(1.0, 2.0)))
    assert (air.zones_at(40.0), air.wind, air.goal) == ((), (1.0, 2.0), mission.goal)
    assert [since for since, _ in air.past] == [0, 10, 14, 20, 40]
    with pytest.raises(InputError, match="No zone of the name 'storm' is there at 50 s"):
        happen(Event(50.0, gone=("storm",)))


def test_zones_that_appear_together_may_share_a_name(mission):
    air = Airspace(mission)
    parts = [Circle(x, 4500.0, 80.0, name="R-7") for x in (3000.0, 5000.0)]
    air.happen(Event(10.0, tuple(map(NewZone, parts))), lambda on, ahead: (0.0, 0.0))
    assert air.zones_at(10.0) == tuple(parts)


def test_a_zone_above_the_ground_appears_with_all_of_its_tiles(mission):
    steep = Terrain("steep", np.tile(10.0 * np.arange(81), (61, 1)), 100.0, 100.0)
    mission = Problem(steep, (1000, 4500, 500), (7000, 4500, 900))
    air = Airspace(mission)
    zone = Circle(4000.0, 2000.0, 900.0, name="R-7", upper_agl_m=100.0)
    air.happen(Event(10.0, (NewZone(zone, "", (10.0, 0.0)),)), lambda on, ahead: (0.0, 0.0))
    tiles = air.zones_at(10.0)
    assert wholes(tiles) == (zone,)
    assert len(tiles) > 20
    # The limit follows the ground to where the zone drifts.
    assert max(tile.upper_m for tile in tiles) == pytest.approx(600, abs=1)
    air.drift(60.0)
    assert max(tile.upper_m for tile in air.zones_at(60.0)) == pytest.approx(650, abs=1)
    air.happen(Event(70.0, gone=("R-7",)), lambda on, ahead: (0.0, 0.0))
    assert air.zones_at(70.0) == ()


def test_times_of_zones_count_from_the_moment(mission):
    air = Airspace(mission)
    zone = Circle(3000.0, 4500.0, 80.0, name="a", t0_s=50.0, t1_s=80.0)
    air.happen(Event(10.0, (NewZone(zone),)), lambda on, ahead: (0.0, 0.0))
    (before,) = air.zones_at(10.0)
    assert (before.t0_s, before.t1_s) == (40.0, 70.0)
    (during,) = air.zones_at(60.0)
    assert (during.t0_s, during.t1_s) == (None, 20.0)
    assert air.zones_at(80.0) == ()


def test_a_polygon_moves_with_its_holes():
    zone = Polygon([(0, 0), (90, 0), (90, 90), (0, 90)], ([(30, 30), (60, 30), (60, 60)],))
    east = zone.moved(10.0, -5.0)
    assert east.ring[0] == (10.0, -5.0)
    assert east.holes[0][0] == (40.0, 25.0)


def test_a_file_without_a_zone_is_refused_with_the_reason(tmp_path, hills):
    file = tmp_path / "wire.geojson"
    line = {"type": "LineString", "coordinates": [[5, 6], [90, 80]]}
    file.write_text(
        json.dumps({"type": "FeatureCollection", "crs_local": True, "features": [line]})
    )
    with pytest.raises(InputError, match=r"^No zone of --popup .*a LineString is not an area"):
        parse_popup(f"{file}@7", hills)
