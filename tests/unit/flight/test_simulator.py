"""JSBSim in the local frame, and the flight models with their planning figures."""

import math
import re
import sys
from xml.etree import ElementTree

import pytest

from pathgene.host.errors import InputError
from pathgene.host.flight.models import MODELS, model_for, model_named
from pathgene.host.flight.simulator import STEP_S, Simulator
from pathgene.host.problem import aircraft


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


def test_every_model_has_planning_figures():
    for name, model in MODELS.items():
        assert model_for(aircraft.load(name)) is model is model_named(name)


def test_own_model_has_the_figures_of_the_plan():
    fox = aircraft.load("silver-fox")
    folder = MODELS["silver-fox"].folder / "silver-fox"
    root = ElementTree.parse(folder / "silver-fox.xml").getroot()

    def value(tag):
        return float(root.find(f".//{tag}").text)

    assert value("wingspan") == fox.wing_span_m
    assert value("wingarea") == fox.wing_area_m2
    assert value("emptywt") * 9.80665 == pytest.approx(fox.weight_N, rel=1e-4)
    numbers = [float(number) for number in re.findall(r"<value> ([-\d.]+) </value>", text(root))]
    assert fox.zero_lift_drag_coefficient in numbers
    assert any(n == pytest.approx(fox.induced_drag_factor, rel=1e-3) for n in numbers)
    table = root.find(".//function[@name='aero/coefficient/CL']//tableData").text.split()
    assert max(map(float, table[1::2])) == fox.lift_coefficient_max
    motor = ElementTree.parse(folder / "Engines" / "silver-fox-motor.xml").getroot()
    assert float(motor.find("power").text) == fox.engine_power_W


def text(root):
    return ElementTree.tostring(root, encoding="unicode")


def test_refuses_unknown_models():
    with pytest.raises(InputError, match=r"^There is no flight model 'x'; choose from silver-fox"):
        model_named("x")
    with pytest.raises(InputError, match=r"^There is no flight model of Heron; choose one of .*"):
        model_for(aircraft.load("heron"))
