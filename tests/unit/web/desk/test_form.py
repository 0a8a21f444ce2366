"""The fields of the form are the keys of a problem file."""

import pytest

from pathgene.host.errors import InputError
from pathgene.host.options.table import NAMED, OPTIONS, OWN
from pathgene.host.planners import PLANNERS
from pathgene.host.problem import aircraft
from pathgene.host.web.desk.form import GROUPS, ZONE_FIELDS, fields_of, planner_fields


def every_field():
    fields = [field for table in GROUPS for field in fields_of(table)]
    fields += [field for planner in PLANNERS for field in planner_fields(planner)]
    return {field.option.name: field for field in fields}


def test_every_key_has_a_field_or_a_place_on_the_page():
    on_map = {"terrain", "start", "start_geo", "goal", "goal_geo", "via", "via_geo"}
    on_map |= {"nofly", "nofly_circle", "uav"}
    output = {option.name for option in OPTIONS if option.table == "output"}
    names = {option.name for option in NAMED.values() if option.table}
    assert set(every_field()) == names - on_map - output
    assert {field.option.key for field in ZONE_FIELDS} == {"name", "lower", "upper", "t0", "t1"}


def test_a_planner_has_its_own_options_with_their_meaning():
    for name, entry in PLANNERS.items():
        fields = planner_fields(name)
        assert {field.option.name for field in fields} == set(entry.options)
        for field in fields:
            assert field.meaning == OWN[field.option.name].meaning
            assert field.choices == OWN[field.option.name].choices


def test_the_aircraft_are_the_shipped_ones():
    (field,) = fields_of("aircraft")
    assert list(field.choices) == aircraft.names()


@pytest.mark.parametrize(
    ("dest", "entered", "value"),
    [
        ("clearance", "42", 42.0),
        ("clearance", 42, 42.0),
        ("clearance", "", None),
        ("clearance", None, None),
        ("generations", "300", 300),
        ("wind", "3, -2.5", (3.0, -2.5)),
        ("cell", "30", (30.0, 30.0)),
        ("cell", "30, 20", (30.0, 20.0)),
        ("origin", "36.2; -84.4", (36.2, -84.4)),
        ("water_level", "-30", -30.0),
        ("water_level", "none", "none"),
        ("void", "-9999", (-9999.0,)),
        ("void", "-9999, 0", (-9999.0, 0.0)),
        ("void", "none", "none"),
        ("planner", "astar", "astar"),
        ("agl", True, True),
        ("board", "model:", "model:"),
    ],
)
def test_a_value_is_read_and_shown_again(dest, entered, value):
    field = every_field()[dest]
    assert field.value_of(entered) == value
    if not isinstance(value, bool):
        assert field.value_of(field.text_of(value)) == value


@pytest.mark.parametrize(
    ("dest", "entered", "sentence"),
    [
        ("clearance", "low", "The clearance must be a number, not 'low'."),
        ("generations", "2.5", "The generations must be a whole number, not '2.5'."),
        ("wind", "3", "The wind must be a list of 2 numbers, not '3'."),
        ("water_level", "high", "The water level must be a number or none, not 'high'."),
        ("void", "sea", "The void must be a number, a list of numbers or none, not 'sea'."),
        ("planner", "best", f"The planner must be one of {', '.join(PLANNERS)}, not 'best'."),
    ],
)
def test_what_is_no_such_value_is_one_sentence(dest, entered, sentence):
    with pytest.raises(InputError) as caught:
        every_field()[dest].value_of(entered)
    assert str(caught.value) == sentence
