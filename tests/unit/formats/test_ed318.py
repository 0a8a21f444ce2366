"""Every construct of ED-318: valid zones are read, and each fault is refused with its reason.

A fault that leaves area, heights, times and class clear, such as a missing authority, is named, and
the zone is read. The transcription of the schema was compared with the public one (UASGeoZones/
ED-318, commit e98b292, 2026-11-28).
"""

import json
from datetime import UTC, datetime, time

import pytest

from pathgene.host.formats import ed318
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature, LeftOut, Limit, Period, Reference, SunEvent
from pathgene.host.remarks import Grade
from tests.support.host.ed318_files import (
    CIRCLE,
    EXTENT,
    LAYER,
    PERIOD,
    POLYGON,
    RING,
    SQUARE,
    changed,
    told,
    zone,
)
from tests.support.host.ed318_schema import faults


def read(*zones):
    document = {"type": "FeatureCollection", "features": list(zones)}
    content = Content(json.dumps(document).encode())
    assert ed318.recognises(content)
    return list(ed318.features(content))


def periods(*limited):
    feature = zone(limitedApplicability=list(limited))
    assert not faults(feature)
    (found,) = read(feature)
    return found.periods


@pytest.mark.parametrize(
    ("geometry", "areas"),
    [
        (POLYGON, [((SQUARE,), None)]),
        (CIRCLE, [((((10.0, 60.0),),), 500.0)]),
        (
            {"type": "MultiPolygon", "coordinates": [[RING], [RING, RING]], "layer": LAYER},
            [((SQUARE,), None), ((SQUARE, SQUARE), None)],
        ),
        (
            {"type": "GeometryCollection", "geometries": [CIRCLE, POLYGON]},
            [((((10.0, 60.0),),), 500.0), ((SQUARE,), None)],
        ),
        ({"type": "Polygon", "coordinates": [[[*at, 3.0] for at in RING]]}, [((SQUARE,), None)]),
    ],
    ids=["polygon", "circle", "multi-polygon", "collection", "third-coordinate"],
)
def test_reads_each_kind_of_area(geometry, areas):
    feature = zone(geometry)
    assert not faults(feature)
    found = read(feature)
    assert [(each.rings, each.radius_m) for each in found] == areas
    assert {each.name for each in found} == {"Fort"}
    assert {each.number for each in found} == {1}


@pytest.mark.parametrize("kind", ["LineString", "MultiPoint", "Point"])
def test_leaves_out_geometries_that_are_no_areas(kind):
    coordinates = RING[0] if kind == "Point" else RING[:2]
    feature = zone({"type": kind, "coordinates": coordinates, "layer": LAYER})
    assert not faults(feature)
    reason = f"a {kind} without an extent is not an area"
    assert read(feature) == [LeftOut('feature 1, "Fort"', reason, True)]
    feature["properties"]["type"] = "NO_RESTRICTION"
    assert read(feature) == [LeftOut('feature 1, "Fort"', reason, False)]


@pytest.mark.parametrize(
    "geometry",
    [
        {"type": "Polygon", "coordinates": []},
        {"type": "MultiPolygon", "coordinates": []},
        {"type": "MultiPolygon", "coordinates": [[], []]},
        {"type": "GeometryCollection", "geometries": []},
    ],
)
def test_names_empty_geometries(geometry):
    feature = zone(geometry)
    assert not faults(feature)
    assert read(zone(), feature)[1] == LeftOut('feature 2, "Fort"', "its geometry is empty")


def test_a_limit_without_a_reference_is_named_and_none():
    feature = zone({**POLYGON, "layer": {"upper": 120, "lower": 0, "lowerReference": "AGL"}})
    assert not faults(feature)
    (found,) = read(feature)
    assert (found.lower, found.upper) == (Limit(0, Reference.AGL), None)
    assert found.unread == ("upper without upperReference",)


def test_a_zone_without_properties_forbids():
    feature = {**zone(), "properties": None}
    assert not faults(feature)
    (found,) = read(feature)
    assert (found.category, found.forbids, found.label) == ("", True, "feature 1")
    assert found.upper == Limit(400 * 0.3048, Reference.AMSL)
    assert "it has no properties" in told(found)


def test_another_geoid_is_a_warning():
    document = {"type": "FeatureCollection", "features": [zone()]}
    document["metadata"] = {"otherGeoid": "urn:x"}
    (found,) = ed318.features(Content(json.dumps(document).encode()))
    (remark,) = found.remarks
    assert remark.grade is Grade.WARNING
    assert "above the geoid urn:x count" in remark.text


def test_leaves_out_a_zone_without_geometry():
    feature = zone(None)
    assert not faults(feature)
    assert read(feature, zone())[0] == LeftOut('feature 1, "Fort"', "it has no geometry")


@pytest.mark.parametrize(
    ("layer", "lower", "upper"),
    [
        (LAYER, Limit(10 * 0.3048, Reference.AGL), Limit(400 * 0.3048, Reference.AMSL)),
        ({**LAYER, "uom": "m"}, Limit(10, Reference.AGL), Limit(400, Reference.AMSL)),
        ({"lower": -5.5, "lowerReference": "WGS84"}, Limit(-5.5, Reference.WGS84), None),
        ({"upper": 120, "upperReference": "AGL"}, None, Limit(120, Reference.AGL)),
        ({}, None, None),
    ],
    ids=["feet", "metres", "lower-only", "upper-only", "none"],
)
def test_reads_layers(layer, lower, upper):
    feature = zone({**POLYGON, "layer": layer})
    assert not faults(feature)
    (found,) = read(feature)
    assert (found.lower, found.upper) == (lower, upper)


def test_a_layer_of_a_collection_holds_for_parts_without_their_own():
    own = {**CIRCLE, "layer": {"upper": 50, "upperReference": "AGL"}}
    bare = {key: value for key, value in POLYGON.items() if key != "layer"}
    feature = zone({"type": "GeometryCollection", "geometries": [own, bare], "layer": LAYER})
    assert not faults(feature)
    first, second = read(feature)
    assert first.upper == Limit(50, Reference.AGL)
    assert second.lower == Limit(10 * 0.3048, Reference.AGL)


@pytest.mark.parametrize(
    ("kind", "category", "forbids"),
    [
        ("USPACE", "USPACE", True),
        ("PROHIBITED", "PROHIBITED", True),
        ("REQ_AUTHORIZATION", "REQ_AUTHORISATION", True),
        ("CONDITIONAL", "CONDITIONAL", True),
        ("NO_RESTRICTION", "NO_RESTRICTION", False),
    ],
)
def test_reads_types(kind, category, forbids):
    feature = zone(type=kind, variant="CUSTOMIZED")
    assert not faults(feature)
    (found,) = read(feature)
    assert (found.category, found.forbids) == (category, forbids)


def test_reads_periods():
    start, end = datetime(2026, 5, 1, 6, tzinfo=UTC), datetime(2026, 6, 1, 4, tzinfo=UTC)
    assert periods(PERIOD) == (Period(start, end),)
    assert periods({"endDateTime": "2026-06-01T04:00:00Z"}) == (Period(None, end),)
    assert periods() == ()
    assert periods(PERIOD, {}) == ()


@pytest.mark.parametrize(
    ("daily", "days", "first", "last"),
    [
        ({"startTime": "08:00:00Z", "endTime": "16:30:00Z"}, {0, 5}, time(8), time(16, 30)),
        ({"startTime": "22:00:00Z", "endTime": "04:00:00Z"}, {0, 5}, time(22), time(4)),
        # Half past midnight in Oslo is the day before in UTC.
        (
            {"startTime": "00:30:00+02:00", "endTime": "06:00:00+02:00"},
            {6, 4},
            time(22, 30),
            time(4),
        ),
        ({"startTime": "20:00:00-06:00", "endTime": "21:00:00-06:00"}, {1, 6}, time(2), time(3)),
        ({"startEvent": "SR", "endEvent": "SS"}, {0, 5}, SunEvent.SUNRISE, SunEvent.SUNSET),
        (
            {"startEvent": "BMCT", "endTime": "12:00:00Z"},
            {0, 5},
            SunEvent.MORNING_TWILIGHT,
            time(12),
        ),
        (
            {"startTime": "12:00:00Z", "endEvent": "EECT"},
            {0, 5},
            time(12),
            SunEvent.EVENING_TWILIGHT,
        ),
        ({"startTime": "12:00:00Z"}, {0, 5}, time(12), time(0)),
        ({"endTime": "12:00:00Z"}, {0, 5}, time(0), time(12)),
        ({"startTime": "06:00:00Z", "endTime": "24:00:00Z"}, {0, 5}, time(6), time(0)),
        ({"startTime": "00:00:00Z", "endTime": "24:00:00Z"}, {0, 5}, None, None),
        ({"startTime": "09:00:00Z", "endTime": "09:00:00Z"}, {0, 1, 5, 6}, None, None),
        ({}, {0, 5}, None, None),
    ],
)
def test_reads_schedules(daily, days, first, last):
    (found,) = periods({"schedule": [{"day": ["MON", "SAT"], **daily}]})
    assert (found.days, found.first, found.last) == (days, first, last)


def test_each_schedule_is_a_period_and_any_is_every_day():
    clock = {"startTime": "08:00:00Z", "endTime": "09:00:00Z"}
    found = periods(
        {**PERIOD, "schedule": [{"day": ["ANY"], **clock}, {"day": ["TUE", "ANY"], **clock}]}
    )
    assert [each.days for each in found] == [frozenset(), frozenset()]
    assert found[0].start == datetime(2026, 5, 1, 6, tzinfo=UTC)


LIMITED = ("properties", "limitedApplicability")
DAILY = {"day": ["MON"], "startTime": "08:00:00Z"}


@pytest.mark.parametrize(
    ("feature", "reason"),
    [
        (changed("properties", "type", value="FORBIDDEN"), "its type must be one of"),
        (changed("properties", "type", value=None), "its type must be one of"),
        (changed("properties", "variant", value="OTHER"), "its variant must be COMMON"),
        (changed("properties", value=[1]), "its properties must be an object."),
        (changed("geometry", value="here"), "its geometry is not a GeoJSON object."),
        (changed("geometry", "type", value="Circle"), "a geometry must be a Polygon"),
        (changed("geometry", "coordinates", value=[RING[:2]]), "three corners or more."),
        (changed("geometry", "coordinates", value=[[["a", 1]] * 4]), "two finite numbers."),
        (changed("geometry", "coordinates", value={}), "at least one ring."),
        (changed("geometry", "layer", value=[1]), "its layer must be an object"),
        (changed("geometry", "layer", "upper", value="400"), "must be a number, not '400'."),
        (changed("geometry", "layer", "lower", value=[0]), "must be a number, not [0]."),
        (changed("geometry", "layer", "uom", value="km"), "must be m or ft, not 'km'."),
        (changed("geometry", "layer", "upperReference", value="STD"), "must be AGL, AMSL or WGS84"),
        (changed("geometry", "layer", "lowerReference", value="QFE"), "must be AGL, AMSL or WGS84"),
        (changed("geometry", "extent", value=500), "an extent must be an object of a Point."),
        (changed("geometry", "extent", "subType", value="Ellipse"), "must be Circle"),
        (changed("geometry", "extent", "radius", value=None), "a number above 0, not None."),
        (changed("geometry", "extent", "radius", value=-5), "a number above 0, not -5."),
        (changed("geometry", "extent", "radius", value="500"), "a number above 0, not '500'."),
        (zone({**POLYGON, "extent": EXTENT}), "an extent must be an object of a Point."),
        (zone({"type": "GeometryCollection", "geometries": CIRCLE}), 'a list of "geometries".'),
        (changed(*LIMITED, value=["always"]), "must be an object, not 'always'."),
        (changed(*LIMITED, value=[{"startDateTime": "soon"}]), "'soon' is no date and time"),
        (changed(*LIMITED, value=[{"endDateTime": 5}]), "5 is no date and time"),
        (changed(*LIMITED, value=[{"endDateTime": "2026-05-01"}]), "is no date and time"),
        (changed(*LIMITED, value=[{"schedule": ["MON"]}]), "a daily period must be an object"),
        (changed(*LIMITED, value=[{"schedule": [{"day": ["Monday"]}]}]), "'MONDAY' is no day"),
        (
            changed(*LIMITED, value=[{"schedule": [{**DAILY, "startTime": "8 o'clock"}]}]),
            "is no time of day",
        ),
        (
            changed(*LIMITED, value=[{"schedule": [{"day": ["MON"], "endEvent": "NOON"}]}]),
            "'NOON' is no event of the sun",
        ),
    ],
)
def test_refuses_each_fault_of_the_schema(feature, reason):
    assert faults(feature), "the schema allows this"
    bad, good = read(feature, zone())
    assert isinstance(bad, Bad)
    assert reason in bad.reason
    assert bad.label in ("feature 1", 'feature 1, "Fort"')
    assert isinstance(good, Feature)


@pytest.mark.parametrize(
    ("feature", "reason"),
    [
        (
            changed("geometry", "layer", value={**LAYER, "lowerReference": "AMSL", "lower": 500}),
            "its lower limit, 152.4 m, lies above its upper, 121.92 m.",
        ),
        (
            changed("geometry", "coordinates", value=[[[60.0, 10.0, 0], [200, 95], *RING]]),
            "is no WGS84",
        ),
        (
            changed(*LIMITED, value=[{**PERIOD, "endDateTime": "2026-04-01T00:00:00Z"}]),
            "its period ends on 2026-04-01T00:00:00+00:00, before its start.",
        ),
        (
            changed(*LIMITED, value=[{"schedule": [{**DAILY, "startEvent": "SR"}]}]),
            "a daily period has both startTime and startEvent; give one.",
        ),
    ],
)
def test_refuses_faults_that_no_schema_states(feature, reason):
    (bad,) = read(feature)
    assert isinstance(bad, Bad)
    assert reason in bad.reason


def test_reads_the_validity_of_the_collection():
    times = {"validFrom": "2026-01-01T00:00:00Z", "validTo": "2026-02-01T00:00:00+01:00"}
    document = {"type": "FeatureCollection", "metadata": times, "features": [zone(), zone(CIRCLE)]}
    found = list(ed318.features(Content(json.dumps(document).encode())))
    start, end = (datetime.fromisoformat(each) for each in times.values())
    assert [each.valid for each in found] == 2 * [Period(start, end)]
    assert [each.periods for each in found] == [(), ()]
    (plain,) = read(zone())
    assert plain.valid is None


def test_takes_no_other_geojson():
    plain = {"type": "Feature", "properties": {"type": "PROHIBITED"}, "geometry": None}
    plain["geometry"] = {"type": "Polygon", "coordinates": [RING]}
    for document in (plain, {"type": "FeatureCollection", "features": [plain, 5]}, [], 5):
        assert not ed318.recognises(Content(json.dumps(document).encode()))


def test_a_period_without_dates_counts_as_always_active_and_says_so():
    dated = {"endDateTime": "2026-05-01T06:00:00Z"}
    found, other = read(zone(limitedApplicability=[dated, {}]), zone(limitedApplicability=[dated]))
    assert (found.periods, len(other.periods)) == ((), 1)
    assert [remark.text for remark in found.remarks] == [
        "a period of its applicability has neither dates nor a schedule, so it counts as always "
        "active"
    ]
    assert other.remarks == ()
