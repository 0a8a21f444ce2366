"""Limits of height: texts, numbers with units and references, and properties of features."""

import json

import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats import geojson
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Limit, Reference
from pathgene.host.formats.limits import limit, limit_text, own_limits, stated_limits
from pathgene.host.remarks import Grade
from tests.support.host.zone_files import LIMIT_TEXTS


@pytest.mark.parametrize(("text", "expected"), LIMIT_TEXTS.items())
@pytest.mark.parametrize("change", [str, str.lower, "  {} ".format])
def test_reads_texts(text, expected, change):
    found = limit_text(change(text))
    if expected is None:
        assert found is None
        return
    assert found.height_m == pytest.approx(expected[0])
    assert str(found.reference) == expected[1]


@pytest.mark.parametrize(
    ("text", "height_m", "reference"),
    [
        ("1500", 457.2, "AMSL"),
        ("1500 ft", 457.2, "AMSL"),
        ("1500 AGL", 457.2, "AGL"),
        ("500m", 500, "AMSL"),
        ("GND+500", 152.4, "AGL"),
        ("500ft ALT", 152.4, "AMSL"),
        ("3500 FT STD", 1066.8, "STD"),
        ("100 m WGS84", 100, "WGS84"),
        ("100 m WGS-84", 100, "WGS84"),
        ("2500' AGL", 762, "AGL"),
        ("2500'", 762, "AMSL"),
        ("2500 ’ msl", 762, "AMSL"),
        ("2500ft agl", 762, "AGL"),
        ("2500 Ft. Agl", 762, "AGL"),
        ("fl 95", 2895.6, "STD"),
        ("FL95 MSL", 2895.6, "STD"),
    ],
)
def test_takes_the_unit_and_reference_of_a_format_where_a_text_has_none(text, height_m, reference):
    found = limit_text(text, "FT", "AMSL")
    assert found.height_m == pytest.approx(height_m)
    assert str(found.reference) == reference


@pytest.mark.parametrize(
    "text",
    [
        "",
        "Ask on 122.8",
        "see AIP",
        "1000 ft AGL / FL 65",
        "FL 65 or 1000 ft",
        "1000 ft AGL AMSL",
        "1000 m ft AMSL",
        # One thousand feet, or one and a half?
        "1.500 ft AMSL",
        "1,5 km AMSL",
        "1,50 m AMSL",
        "FL",
        "ft AMSL",
        "FL 95 AGL AMSL",
        # A flight level is a pressure, not a height above the ground.
        "FL95 AGL",
        "FL 95 WGS84",
        "FL 95'",
        # Feet and inches.
        "6'3\"",
        "6' 3",
        "95 km AMSL",
        # From the ground to 500 feet.
        "GND-500 ft",
        "FL-95",
        # A flight level, not feet.
        "F095",
    ],
)
def test_reads_no_text_that_could_mean_something_else(text):
    with pytest.raises(ValueError, match=r"^"):
        limit_text(text, "FT", "AMSL")


def test_assumes_neither_unit_nor_reference():
    for text in ("1500", "1500 ft", "1500 AMSL"):
        with pytest.raises(ValueError, match=text):
            limit_text(text)


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        (("high", "m", "AGL"), "a limit of height must be a number, not 'high'."),
        ((True, "m", "AGL"), "a limit of height must be a number, not True."),
        ((float("nan"), "m", "AGL"), "a limit of height must be a number, not nan."),
        ((5, "yd", "AGL"), "the unit of a limit of height must be m, ft or FL, not 'yd'."),
        ((95, "FL", "AGL"), "a flight level, 95, has no height AGL."),
        (
            (5, "m", "QFE"),
            "the reference of a limit of height must be AGL, AMSL, WGS84 or STD, not 'QFE'.",
        ),
    ],
)
def test_refuses_bad_numbers_units_and_references(values, reason):
    with pytest.raises(InputError) as caught:
        limit(*values)
    assert str(caught.value) == reason


def test_limits_tell_how_they_are_stated():
    texts = ("GND", "4500 ft amsl", "FL065", "300m AGL")
    described = ["GND", "4500 ft AMSL", "FL 65", "300 m AGL"]
    assert [limit_text(text).described for text in texts] == described
    assert limit(4500, "FT", "MSL").described == "4500 ft AMSL"
    assert limit(4500, "FT", "MSL") == Limit(4500 * 0.3048, Reference.AMSL)


def test_a_flight_level_is_standard_whatever_its_reference():
    assert limit(95, "FL", "MSL") == Limit(95 * 30.48, Reference.STANDARD)


FT_1000, FL_95 = Limit(304.8, Reference.AGL), Limit(95 * 30.48, Reference.STANDARD)


@pytest.mark.parametrize(
    "names", [("lowerLimit", "upperLimit"), ("floor", "ceiling"), ("base", "top")]
)
def test_reads_properties_that_state_unit_and_reference(names):
    low, high = names
    properties = {"name": "TMA", low: "1000 ft AGL", high: "FL 95", "colour": "red"}
    assert stated_limits(properties) == (FT_1000, FL_95, names, ())
    value = {"value": 1000, "unit": "ft", "reference": "AGL"}
    assert stated_limits({low: value}) == (FT_1000, None, (low,), ())


@pytest.mark.parametrize(
    ("read", "names"), [(own_limits, ("lower", "upper")), (stated_limits, ("floor", "ceiling"))]
)
def test_words_for_limits_are_repeated_with_their_meaning(read, names):
    low, high = names
    found = read({low: "Ground", high: " unlimited "})
    assert found[:2] == (Limit(0, Reference.AGL), None)
    assert [(each.grade, each.text) for each in found.remarks] == [
        (Grade.NOTE, f"{low} 'Ground' is read as the ground below the zone"),
        (Grade.NOTE, f"{high} 'unlimited' is read as no limit"),
    ]
    assert read({high: "120 m AGL"}).remarks == ()


def test_reads_no_property_that_leaves_open_its_unit_or_reference():
    for value in (1000, "1000", "1000 ft", {"value": 5, "unit": 1, "referenceDatum": 0}, [5]):
        assert stated_limits({"lowerLimit": value, "upperLimit": "FL 95"}) == (
            None,
            FL_95,
            ("upperLimit",),
            (),
        )


def feature(**properties):
    geometry = {"type": "Polygon", "coordinates": [[[10, 60], [11, 60], [11, 61], [10, 60]]]}
    document = {"type": "Feature", "properties": properties, "geometry": geometry}
    (found,) = geojson.features(Content(json.dumps(document).encode()))
    return found


def test_geojson_of_other_programs_has_their_limits_and_names_those_that_are_not_read():
    found = feature(lowerLimit="4500 ft AMSL", upperLimit="FL 95", maxHeight=120)
    assert found.lower == Limit(4500 * 0.3048, Reference.AMSL)
    assert (found.upper, found.unread) == (FL_95, ("maxHeight",))
    found = feature(lowerLimit=4500, upperLimit="by NOTAM")
    assert (found.lower, found.upper, found.unread) == (None, None, ("lowerLimit", "upperLimit"))


def test_our_own_properties_count_before_others():
    found = feature(lower=100, floor="FL 95", ceiling="FL 195")
    assert (found.lower, found.upper) == (Limit(100, Reference.AMSL), None)
    assert found.unread == ("floor", "ceiling")
    assert feature(upper="FL 95").upper == FL_95
