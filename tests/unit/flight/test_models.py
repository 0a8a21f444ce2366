"""The flight models and their planning figures."""

import re
from xml.etree import ElementTree

import pytest

from pathgene.host.errors import InputError
from pathgene.host.flight.models import MODELS, model_for, model_named
from pathgene.host.problem import aircraft


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
