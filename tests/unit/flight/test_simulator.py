"""JSBSim in the local frame."""

import math
import sys

import pytest

from pathgene.host.errors import InputError
from pathgene.host.flight.models import MODELS
from pathgene.host.flight.simulator import STEP_S, Simulator


def simulator(name="silver-fox", heading_deg=90.0, **options):
    return Simulator(
        MODELS[name],
        middle=(10_000.0, 10_000.0),
        place=(12_000.0, 9_000.0, 500.0),
        heading_rad=math.radians(heading_deg),
        airspeed_m_s=23.0,
        **options,
    )


def test_begins_where_it_is_put(capfd):
    state = simulator(heading_deg=30.0).state()
    assert (state.x, state.y, state.z) == pytest.approx((12_000, 9_000, 500), abs=0.01)
    assert state.airspeed_m_s == pytest.approx(23)
    assert (state.east_m_s, state.north_m_s) == pytest.approx((11.5, 19.92), abs=0.01)
    # Standard output is for results.
    assert capfd.readouterr().out == ""


def test_position_is_the_integral_of_the_velocity():
    # The frame and the model have the same north and the same metre.
    flight = simulator(heading_deg=45.0)
    x, y, z = (before := flight.state()).x, before.y, before.z
    for _ in range(600):
        flight.step()
        state = flight.state()
        x += state.east_m_s * STEP_S
        y += state.north_m_s * STEP_S
        z += state.climb_m_s * STEP_S
    assert (state.x, state.y, state.z) == pytest.approx((x, y, z), abs=0.1)


def test_head_wind_adds_to_the_airspeed():
    flight = simulator()
    flight.blow(-5.0, 0.0)
    flight.step()
    state = flight.state()
    assert state.airspeed_m_s == pytest.approx(28, abs=0.1)
    assert state.east_m_s == pytest.approx(23, abs=0.1)


def test_leans_the_mixture_with_the_height():
    flight = simulator("c172p")
    flight.sense_ground(0.0)
    assert flight._executive["fcs/mixture-cmd-norm"] == pytest.approx(0.96)


def test_ground_stays_below_the_wheels():
    flight = simulator()
    for ground in (490.0, 600.0, math.nan):
        flight.sense_ground(ground)
        flight.step()
        assert flight._executive["position/h-agl-ft"] * 0.3048 == pytest.approx(60, abs=0.5)


def test_refuses_bad_weather():
    with pytest.raises(InputError, match=r"^Gusts must be one of none, light, .*, not 'mild'\.$"):
        simulator(gusts="mild")
    with pytest.raises(InputError, match=r"^The seed of a flight must be 0 to 2147483646, not -1"):
        simulator(seed=-1)


def test_missing_package_is_one_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "jsbsim", None)
    with pytest.raises(InputError, match=r"^Flying needs the extra pathgene\[fly\]: pip install"):
        simulator()
