"""Flights of exported missions: their verdict, and full circles in it."""

import math

import numpy as np
import pytest

from bench import autopilot, exports
from bench.exports import Outcome, fly_export
from bench.report import Options
from pathgene.host.errors import InputError
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
