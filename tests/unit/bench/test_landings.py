"""Landings in wind: their touch-down, and a glide that leaves no reserve."""

import pytest

from bench import landings
from bench.landings import Landing, exported, fly_landing
from pathgene.host.mission.autopilot import landing
from pathgene.sim.autopilot.pilot import Kind


def test_the_landings_are_of_all_aircraft_winds_and_autopilots():
    every = landings.landings()
    assert len({(each.name, each.autopilot) for each in every}) == len(every) == 3 * 4 * 2


def touch_down(wind):
    """Return a landing of the Silver Fox by ArduPlane."""
    return fly_landing(*exported(Landing("silver-fox", wind, "ARDUPLANE")), Kind.ARDUPLANE, 1)


@pytest.mark.ci
def test_a_glide_steeper_than_without_thrust_lands_late(monkeypatch):
    """Against the wind the touch-down is within 60 m, four seconds of flare at 15 m/s."""
    flown = touch_down("head")
    assert abs(flown.along_m) < 60.0
    assert abs(flown.across_m) < 6.0
    assert flown.share > 0.5
    monkeypatch.setattr(landing, "_SHARE_OF_IDLE", 1.4)
    monkeypatch.setattr(landing, "_GLIDE_DEG", 6.0)
    assert touch_down("calm").along_m > 60.0
