"""Flights of exported missions: their verdict, and full circles in it."""

import math

import numpy as np
import pytest

from bench import autopilot, exports
from bench.export_missions import AIRCRAFT, GENERATED, Mission, missions
from bench.exports import Outcome, fly_export
from bench.flight_rows import WEATHERS
from bench.report import Options
from pathgene.host.errors import InputError
from pathgene.host.mission.autopilot import climbs, flight_plan
from pathgene.host.planners import PLANNERS
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.origin import at_origin
from tests.support.host.missions import make_mission


@pytest.fixture(scope="module")
def flown():
    """Return a flight of a random mission."""
    return fly_export(*make_mission(1))


def test_an_exported_mission_is_accepted_and_flown_to_its_end(flown):
    assert (flown.refusal, flown.arrived) == ("", True)
    assert math.isfinite(flown.share)
    assert flown.beside_m > 0


def test_a_refused_mission_is_no_flight(monkeypatch):
    problem, path = make_mission(1)
    made = exports.flight_plan

    def far(*arguments, **options):
        plan = made(*arguments, **options)
        object.__setattr__(plan.items[0], "lat", 95.0)
        return plan

    monkeypatch.setattr(exports, "flight_plan", far)
    outcome = fly_export(problem, path)
    assert "(invalid param5 x)" in outcome.refusal
    assert not outcome.kept


def up_a_slope():
    """Return a problem in a tail wind, and a path up 9 km at the Cessna's limit."""
    slope, foot, top = 0.0587, 4500.0, 13_500.0
    heights = slope * np.clip(np.arange(161) * 100.0 - foot, 0.0, top - foot)
    terrain = at_origin(Terrain("slope", np.tile(heights, (61, 1)), 100.0, 100.0), 46.0, 8.0)
    high = float(heights[-1])
    start, goal = (500.0, 3000.0, 40.0), (14_500.0, 3000.0, high + 60.0)
    problem = Problem(terrain, start, goal, aircraft.load("c172p"), wind=(8.0, 0.0))
    corners = (foot - 200.0, 3000.0, 40.0), (top, 3000.0, high + 45.0)
    return problem, np.array([start, *corners, goal])


def test_the_judge_finds_a_climb_without_a_reserve(monkeypatch):
    assert fly_export(*up_a_slope()).kept
    monkeypatch.setattr(climbs, "SUSTAINED", 1.0)
    monkeypatch.setattr(flight_plan, "check_climbs", lambda problem, points: None)
    late = fly_export(*up_a_slope())
    assert late.arrived
    assert late.share < 0.3


def test_the_missions_are_of_all_planners_aircraft_and_weathers():
    every = missions()
    assert len(set(every)) == len(every) > 200
    for terrain in ("canyon", "river"):
        pairs = {(m.planner, m.aircraft) for m in every if m.terrain == terrain}
        assert pairs == {(planner, plane) for planner in PLANNERS for plane in AIRCRAFT}
    weathers = {(m.aircraft, m.weather) for m in every if m.terrain in GENERATED}
    assert weathers == {(plane, weather) for plane in AIRCRAFT for weather in WEATHERS}
    assert len({m.seed for m in every}) > 150


def test_generated_ground_is_the_same_each_time_and_has_a_place():
    first, second, other = (
        Mission(name, "j3cub", "along", "astar").problem()
        for name in (GENERATED[0], GENERATED[0], GENERATED[1])
    )
    assert first.start == second.start != other.start
    assert first.terrain.to_geographic(np.zeros(1), np.zeros(1)) is not None
    assert np.hypot(*first.wind) == pytest.approx(8.0)
    assert first.start[2] - first.terrain.ground(*first.start[:2]) == pytest.approx(60.0)
    assert 300 <= np.ptp(first.terrain.elevation) <= 1800


def test_the_sentences_of_a_refused_export_are_followed():
    # Its circle is too near to the rim of the canyon.
    outcome = exports._measure(Mission("canyon", "j3cub", "calm", "astar"))
    assert outcome["found"]
    assert any(text.startswith("goal") for text in outcome["followed"])
    assert outcome["kept"]


def test_the_report_names_every_mission_that_is_not_kept():
    names = missions()[:4]
    figures = {"arrived": True, "share": 0.9, "end_share": 0.8, "beside_m": 9.0}
    kept, low, refused = (
        {"found": True, "followed": told, **exports._figures(outcome)}
        for told, outcome in (
            (["start 4 m higher"], Outcome(**figures)),
            ([], Outcome(**figures | {"share": 0.3, "circles": 1})),
            (["goal higher"], Outcome(refusal="No room; go away.")),
        )
    )
    results = [*zip(names, (kept, low, refused, {"found": False}), strict=True)]
    report = exports._report([*results, (names[0], {})])
    assert report.notes[0].startswith("1 of 3 missions kept; 1 further ones have no path.")
    assert report.notes[-1] == "Missions not measured yet: 1."
    lost = report.further[-1].rows
    assert [reason for _, reason in lost] == [
        "keeps 0.30 on the way, 1 full circles",
        "refused: No room",
    ]
    total = [sum(row[1:7][k] for row in report.rows) for k in range(6)]
    assert total == [3, 1, 1, 0, 0, 1]


@pytest.mark.parametrize(
    ("change", "kept"),
    [
        ({}, True),
        ({"share": 0.4}, False),
        ({"end_share": 0.4}, False),
        ({"beside_m": 26.0}, False),
        ({"circles": 1}, False),
        ({"zones": 1}, False),
        ({"arrived": False}, False),
    ],
)
def test_a_flight_is_kept_if_all_of_it_is(change, kept):
    figures = {"arrived": True, "share": 0.9, "end_share": 0.9, "beside_m": 10.0}
    assert Outcome(**figures | change).kept == kept


def test_full_circles_are_counted():
    straight = np.zeros(600)
    circle = np.linspace(0, 2 * math.pi, 150)
    slow = np.linspace(0, 2 * math.pi, 1500)
    twice = np.concatenate((straight, circle, np.full(600, 2 * math.pi), 2 * math.pi - circle))
    assert exports._circles(np.concatenate((straight, slow))) == 0
    assert exports._circles(np.concatenate((straight, circle, np.full(300, 6.28)))) == 1
    assert exports._circles(twice) == 2


def test_real_flights_must_be_named(tmp_path):
    with pytest.raises(InputError, match=r"^Name the folder of real flights \(--flights FOLDER\)"):
        autopilot.run(Options())
    folder = tmp_path / "flight"
    folder.mkdir()
    (folder / "track.csv").write_text(
        "t_s,lat,lon,alt_amsl_m,roll_deg,tecs_height_m\n0,46,8,600,0,100\n1,46,8,600,0,100\n"
    )
    (folder / "events.txt").write_text("0.00 Mission: 1 WP\n")
    (folder / "conditions.txt").write_text("calm\n")
    (folder / "mission.waypoints").write_text(
        "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t46\t8\t500\t1\n"
    )
    with pytest.raises(InputError, match=r"conditions\.txt states no AIRSPEED\.$"):
        autopilot.read_flight(folder)
