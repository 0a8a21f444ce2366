"""openAIP: limits, types, classes and times of airspaces in GeoJSON and JSON."""

import json
from datetime import UTC, datetime, time

import pytest

from pathgene.host.formats import classes, openaip
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, LeftOut, Limit, Period, Reference, SunEvent
from pathgene.host.remarks import Grade, Remark


RING = [[10.0, 60.0], [10.1, 60.0], [10.1, 60.1], [10.0, 60.0]]
POLYGON = {"type": "Polygon", "coordinates": [RING]}
FACTS = {
    "_id": "5f6",
    "name": "TMA",
    "type": 7,
    "icaoClass": 2,
    "lowerLimit": {"value": 4500, "unit": 1, "referenceDatum": 1},
    "upperLimit": {"value": 95, "unit": 6, "referenceDatum": 2},
}
MONDAY = {"dayOfWeek": 0, "startTime": "08:00", "endTime": "16:00", "sunrise": False}


def read(*airspaces, geometry=POLYGON):
    features = [{"type": "Feature", "properties": each, "geometry": geometry} for each in airspaces]
    content = Content(json.dumps({"type": "FeatureCollection", "features": features}).encode())
    assert openaip.recognises(content)
    return list(openaip.features(content))


def hours(*operating, **more):
    return {"hoursOfOperation": {"operatingHours": list(operating), **more}}


def periods(**facts):
    (found,) = read(FACTS | facts)
    return found.periods


@pytest.mark.parametrize("wrapped", [True, False])
def test_reads_the_json_of_the_service(wrapped):
    airspace = FACTS | {"geometry": POLYGON}
    document = {"items": [airspace], "page": 1} if wrapped else [airspace]
    content = Content(json.dumps(document).encode())
    assert openaip.recognises(content)
    (found,) = openaip.features(content)
    assert found.lower == Limit(4500 * 0.3048, Reference.AMSL)
    assert found.upper == Limit(95 * 30.48, Reference.STANDARD)
    assert (found.name, found.category, found.forbids) == ("TMA", "TMA", True)


def test_reads_limits_of_any_spelling():
    lower = {"value": 300, "unit": "M", "referenceDatum": "GND"}
    (found,) = read(FACTS | {"lowerLimit": lower, "upperLimit": "FL 95"})
    assert (found.lower, found.upper) == (
        Limit(300, Reference.AGL),
        Limit(95 * 30.48, Reference.STANDARD),
    )
    (found,) = read(FACTS | {"upperLimit": {"unlimited": True}})
    assert (found.upper, found.unread) == (None, ())
    (found,) = read(FACTS | {"upperLimit": "by NOTAM"})
    assert (found.upper, found.unread) == (None, ("upperLimit",))


def test_a_second_limit_makes_the_airspace_reach_as_far_as_either():
    higher = {"value": 1000, "unit": 1, "referenceDatum": 0}
    first, second = read(FACTS | {"upperLimitMax": higher})
    assert first.lower == second.lower == Limit(4500 * 0.3048, Reference.AMSL)
    assert [first.upper, second.upper] == [
        Limit(95 * 30.48, Reference.STANDARD),
        Limit(1000 * 0.3048, Reference.AGL),
    ]
    found = read(FACTS | {"upperLimitMax": higher, "lowerLimitMin": higher | {"value": 500}})
    assert len({(each.lower, each.upper) for each in found}) == len(found) == 4
    assert len(read(FACTS | {"upperLimitMax": FACTS["upperLimit"], "lowerLimitMin": None})) == 1


def test_reads_what_the_parser_of_openaip_writes_from_openair():
    facts = {
        "name": "CTR",
        "class": "D",
        "type": "CTR",
        "lowerCeiling": {"value": 0, "unit": "FT", "referenceDatum": "GND"},
        "upperCeiling": {"value": 2500, "unit": "FT", "referenceDatum": "MSL"},
    }
    (found,) = read(facts)
    assert (found.category, found.upper) == ("CTR", Limit(2500 * 0.3048, Reference.AMSL))
    facts["type"] = "UNCLASSIFIED"
    assert read(facts)[0].category == "D"
    del facts["type"]
    assert read(facts | {"class": "R"})[0].category == "RESTRICTED"
    (found,) = read(facts | {"class": "G", "type": 3})
    assert (found.category, found.forbids) == ("PROHIBITED", True)


@pytest.mark.parametrize(
    ("number", "icao_class", "category", "forbids"),
    [
        (1, 8, "RESTRICTED", True),
        (2, 8, "DANGER", True),
        (3, 8, "PROHIBITED", True),
        (4, 3, "CTR", True),
        (10, 6, "FIR", False),
        (21, 4, "GLIDING", False),
        (21, 3, "GLIDING", True),
        (32, 3, "VFR", True),
        (33, 2, "FIS", True),
        (33, 4, "FIS", False),
        (33, 8, "FIS", False),
        (0, 3, "D", True),
        (0, 4, "E", False),
        (0, 8, "OTHER", True),
    ],
)
def test_an_airspace_forbids_if_its_type_or_its_class_does(number, icao_class, category, forbids):
    (found,) = read(FACTS | {"type": number, "icaoClass": icao_class})
    assert (found.category, found.forbids) == (category, forbids)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"type": 37}, "TYPE 37"),
        ({"type": -1}, "TYPE -1"),
        ({"type": 33.5, "icaoClass": 6}, "TYPE 33.5"),
        ({"type": True, "icaoClass": 6}, "TYPE True"),
        ({"type": "TOWER", "icaoClass": 6}, "TOWER"),
        ({"type": 33, "icaoClass": 9}, "CLASS 9"),
    ],
)
def test_an_unknown_type_or_class_forbids_and_is_named(change, named):
    found, other = read(FACTS | change, FACTS)
    assert found.forbids
    text = (
        f"{named} is no type or class that is known, so it forbids flight; correct the file if the "
        "area is open to flight"
    )
    assert found.remarks == (Remark(Grade.WARNING, text),)
    assert not other.remarks
    names = (found.category, found.airspace_class)
    # The user's choice of classes does not open it.
    assert any(name and classes.forbids(name, frozenset()) for name in names)


def test_reads_hours_of_operation():
    assert periods() == ()
    assert periods(**hours(MONDAY, {**MONDAY, "dayOfWeek": 2})) == (
        Period(days=frozenset({0, 2}), first=time(8), last=time(16)),
    )
    by_sun = {**MONDAY, "sunrise": True, "sunset": True}
    assert periods(**hours(by_sun)) == (
        Period(days=frozenset({0}), first=SunEvent.SUNRISE, last=SunEvent.SUNSET),
    )
    every_day = [{**MONDAY, "dayOfWeek": day} for day in range(7)]
    assert periods(**hours(*every_day)) == (Period(first=time(8), last=time(16)),)
    whole = [{**each, "startTime": "00:00", "endTime": "00:00"} for each in every_day]
    assert periods(**hours(*whole)) == ()
    start = datetime(2026, 5, 1, tzinfo=UTC)
    assert periods(activeFrom="2026-05-01T00:00:00Z") == (Period(start),)
    assert periods(activeFrom="2026-05-01T00:00:00Z", **hours(*whole)) == (Period(start),)


@pytest.mark.parametrize("name", ["byNotam", "onDemand", "onRequest"])
def test_an_airspace_that_somebody_may_activate_counts_as_always_active(name):
    assert periods(**{name: True}, **hours(MONDAY)) == ()
    assert periods(**hours(MONDAY, {**MONDAY, "byNotam": True})) == ()


def test_an_activation_without_a_time_is_said():
    (found,) = read(FACTS | {"byNotam": True, "onRequest": True, "onDemand": False})
    text = "it is activated by NOTAM or on request and counts as always active"
    assert found.remarks == (Remark(Grade.NOTE, text),)
    assert read(FACTS | {"byNotam": None})[0].remarks == ()


def test_hours_of_operation_are_said_to_be_utc():
    utc = Remark(Grade.NOTE, "its hours of operation count as UTC, as openAIP defines them")
    assert read(FACTS | hours(MONDAY))[0].remarks == (utc,)
    day = {"dayOfWeek": 0, "sunrise": True, "sunset": True}
    assert read(FACTS | hours(day))[0].remarks == ()
    assert read(FACTS | {"activeFrom": "2026-05-01T00:00:00Z"})[0].remarks == ()
    # Local times are not read, which is a warning.
    assert read(FACTS | hours(MONDAY, remarks="Times are LOCAL"))[0].remarks == ()


def test_an_activity_in_a_class_that_does_not_forbid_is_a_warning():
    open_ = {"type": 0, "icaoClass": 6}
    (found,) = read(FACTS | open_ | {"activity": 1})
    assert not found.forbids
    (remark,) = found.remarks
    assert remark.grade is Grade.WARNING
    assert remark.text.startswith("its activity is parachuting, and its class")
    assert read(FACTS | open_ | {"activity": 0})[0].remarks == ()
    assert read(FACTS | {"activity": 5})[0].remarks == ()


@pytest.mark.parametrize(
    ("unit", "datum", "expected"),
    [
        (0, 0, Limit(300, Reference.AGL)),
        (0, 1, Limit(300, Reference.AMSL)),
        (0, 2, Limit(300, Reference.STANDARD)),
        (1, 0, Limit(91.44, Reference.AGL)),
        (1, 1, Limit(91.44, Reference.AMSL)),
        (1, 2, Limit(91.44, Reference.STANDARD)),
        (6, 1, Limit(9144, Reference.STANDARD)),
        (6, 2, Limit(9144, Reference.STANDARD)),
    ],
)
@pytest.mark.parametrize("name", ["lowerLimit", "upperLimit", "lowerLimitMin", "upperLimitMax"])
def test_reads_each_unit_and_datum_of_each_limit(name, unit, datum, expected):
    far = {"value": 400 if "lower" in name else 0, "unit": 6, "referenceDatum": 2}
    facts = {key: value for key, value in FACTS.items() if "Limit" not in key}
    facts["upperLimit" if "lower" in name else "lowerLimit"] = far
    value = {"value": 300, "unit": unit, "referenceDatum": datum}
    found = [
        limit
        for each in read(facts | {name: value})
        for limit in ((each.lower,) if "lower" in name else (each.upper,))
    ]
    assert any(
        limit is not None
        and limit.height_m == pytest.approx(expected.height_m)
        and limit.reference is expected.reference
        for limit in found
    )
    assert all(each.unread == () for each in read(facts | {name: value}))


def test_a_flight_level_above_the_ground_is_named_and_no_limit():
    for name in ("lowerLimit", "upperLimit"):
        (found,) = read(FACTS | {name: {"value": 95, "unit": 6, "referenceDatum": 0}})
        assert (found.lower if name == "lowerLimit" else found.upper) is None
        assert found.unread == (f"{name} FL 95 AGL",)


def test_members_that_limit_nothing_change_nothing():
    others = {
        "specialAgreement": True,
        "requestCompliance": True,
        "country": "NO",
        "frequencies": [{"value": "118.0", "unit": 2, "primary": True}],
        "remarks": "see AIP",
        "createdAt": "2026-05-01T00:00:00Z",
    }
    assert read(FACTS | others) == read(FACTS)


def test_hours_in_local_time_are_not_read():
    (found,) = read(FACTS | hours(MONDAY, remarks="Times are LOCAL"))
    assert (found.periods, found.unread) == ((), ("hoursOfOperation",))


def test_an_airspace_without_properties_forbids():
    first, second = read({}, FACTS)
    assert (first.label, first.category, first.forbids) == ("feature 1", "OTHER", True)
    assert (first.lower, first.upper) == (None, None)
    assert second.name == "TMA"


def test_leaves_out_points_and_lines():
    line = {"type": "LineString", "coordinates": RING[:2]}
    assert read(FACTS, geometry=line) == [
        LeftOut('feature 1, "TMA"', "a LineString is not an area", True)
    ]
    assert read(FACTS, geometry=None) == [LeftOut('feature 1, "TMA"', "it has no geometry")]
    empty = {"type": "MultiPolygon", "coordinates": []}
    assert read(FACTS, geometry=empty) == [LeftOut('feature 1, "TMA"', "its geometry is empty")]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"activity": 9}, "9 is no activity of openAIP, which has 0 to 5."),
        ({"activity": "jumps"}, "'jumps' is no activity of openAIP, which has 0 to 5."),
        ({"byNotam": "yes"}, "byNotam must be true or false, not 'yes'."),
        ({"onDemand": 1}, "onDemand must be true or false, not 1."),
        ({"onRequest": []}, "onRequest must be true or false, not []."),
        (hours({**MONDAY, "byNotam": "yes"}), "byNotam must be true or false, not 'yes'."),
        (hours({**MONDAY, "sunset": 1}), "sunset must be true or false, not 1."),
        (hours({**MONDAY, "endTime": 16}), "its endTime must be a text, not 16."),
        ({"hoursOfOperation": "H24"}, "its hoursOfOperation must be an object, not 'H24'."),
        ({"upperLimit": 95}, "upperLimit must be an object with value, unit and referenceDatum."),
        (
            {"upperLimit": {"value": "95", "unit": 6, "referenceDatum": 2}},
            "a limit of height must be a number, not '95'.",
        ),
        (
            {"upperLimit": {"value": 95, "unit": 3, "referenceDatum": 2}},
            "the unit of a limit of height must be m, ft or FL, not 3.",
        ),
        (
            {"upperLimit": {"value": 95, "unit": 6, "referenceDatum": 7}},
            "the reference of a limit of height must be AGL, AMSL, WGS84 or STD, not 7.",
        ),
        (
            {"upperLimit": {"value": 4000, "unit": 1, "referenceDatum": 1}},
            "its lower limit, 1371.6 m, lies above its upper, 1219.2 m.",
        ),
        (hours({**MONDAY, "dayOfWeek": 7}), "a dayOfWeek must be 0 to 6, not 7."),
        (hours({**MONDAY, "startTime": "8"}), "'8' is no time of day, such as 06:00:00Z."),
        (hours("MON"), "its operatingHours must be a list of objects."),
        (
            {"activeFrom": "2026-05-01T00:00:00Z", "activeUntil": "2026-04-01T00:00:00Z"},
            "its activeUntil lies before its activeFrom.",
        ),
    ],
)
def test_names_a_bad_airspace_and_reads_the_others(change, reason):
    first, second = read(FACTS | change, FACTS)
    assert first == Bad('feature 1, "TMA"', reason)
    assert second.number == 2
