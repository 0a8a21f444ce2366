"""Flights of planned paths, from problem to verdict."""

import json

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.flight.fly import fly, save
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


Y, X = np.mgrid[:61, :81]
HILLS = Terrain("hills", 150 + 80 * np.sin(X / 9) * np.cos(Y / 7), 100, 100)
PATH = np.array(
    [(1000, 1000, 330), (3000, 2500, 400), (5200, 2800, 330), (7000, 4500, 350)], dtype=float
)


def problem(aircraft="silver-fox", zones=(), path=PATH, **options):
    return Problem(HILLS, path[0], path[-1], aircraft, zones, **options)


@pytest.fixture(scope="module")
def kept():
    return fly(problem(wind=(3.0, 2.0)), PATH, gusts="light", seed=2)


def test_path_with_room_is_kept(kept):
    assert kept.verdict.kept
    assert kept.verdict.breaks == []
    assert (kept.model.name, kept.wind) == ("silver-fox", (3.0, 2.0))
    assert kept.verdict.clearance_flown_m > 30
    assert kept.verdict.excess <= 0.05 + 1e-9


def test_path_through_the_ground_breaks():
    low = PATH.copy()
    low[1, 2] = 120
    report = fly(problem(path=low), low)
    assert not report.verdict.kept
    assert "under the ground" in report.verdict.breaks[0]


def test_path_through_a_zone_breaks():
    report = fly(problem(zones=[Circle(4100, 2650, 40, name="tower")]), PATH)
    assert report.verdict.breaks == ["The flight enters the no-fly zone 'tower'."]


def test_another_aircraft_flies_with_its_own_figures():
    report = fly(problem(), PATH, "j3cub")
    assert report.aircraft.cruise_speed_m_s == 30
    assert report.verdict.flight_time_s == pytest.approx(report.verdict.length_m / 30, rel=0.05)


def test_writes_file_and_picture(kept, tmp_path):
    written = save(kept, tmp_path)
    assert [file.name for file in written] == ["flight.json", "flight.png"]
    content = json.loads(written[0].read_text())
    assert content["kept"] is True
    assert content["clearance_flown_m"] == kept.verdict.clearance_flown_m
    track = content["track"]
    assert {len(values) for values in track.values()} == {len(track["t_s"])}
    assert track["t_s"][1] == 1.0
    assert written[1].read_bytes()[:4] == b"\x89PNG"


def test_refuses_wind_beyond_the_airspeed():
    with pytest.raises(InputError, match=r"^A wind of 25 m/s is not below the airspeed of Silver"):
        fly(problem(), PATH, wind=(25.0, 0.0))


def test_refuses_aircraft_without_a_model():
    with pytest.raises(InputError, match=r"^There is no flight model of Heron; choose one of"):
        fly(problem("heron"), PATH)
