"""Members of ED-318: each wrong value is refused, and each departure named, as the schema says.

A fault that leaves area, heights, times and class clear, such as a missing authority, is named, and
the zone is read. The transcription of the schema was compared with the public one (UASGeoZones/
ED-318, commit e98b292, 2026-11-28).
"""

import json
import random

import pytest

from pathgene.host.formats import ed318
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature, LeftOut
from pathgene.host.remarks import Grade
from tests.support.host import ed318_files
from tests.support.host.ed318_files import LAYER, PERIOD, POLYGON, RING, SQUARE, changed, told, zone
from tests.support.host.ed318_schema import document_faults, faults


def read(*zones):
    document = {"type": "FeatureCollection", "features": list(zones)}
    content = Content(json.dumps(document).encode())
    assert ed318.recognises(content)
    return list(ed318.features(content))


DAILY = {"day": ["MON"], "startTime": "08:00:00Z"}
TEXTS = [{"text": "a", "lang": "en"}]
AUTHORITY = {"purpose": "INFORMATION"}
# Wrong values of each member, each with the reason.
WRONG = {
    "identifier": (5, "its identifier must be a text, not 5."),
    "country": (["NOR"], "its country must be a text, not ['NOR']."),
    "name": ("Fort", "its name must be a list, not 'Fort'."),
    "name of another kind": (["Fort"], "its name must be an object, not 'Fort'."),
    "name with a number": ([{"text": 5, "lang": "en"}], "its text must be a text, not 5."),
    "restrictionConditions": (5, "its restrictionConditions must be a text, not 5."),
    "region": (1.5, "its region must be a whole number, not 1.5."),
    "region in words": ("north", "its region must be a whole number, not 'north'."),
    "reason": (["NOISY"], "its reason must be one of AIR_TRAFFIC, SENSITIVE"),
    "reason alone": ("NOISE", "its reason must be a list, not 'NOISE'."),
    "otherReasonInfo": ({}, "its otherReasonInfo must be a list, not {}."),
    "regulationExemption": (True, "its regulationExemption must be one of YES, NO, not True."),
    "message": ([5], "its message must be an object, not 5."),
    "zoneAuthority": (AUTHORITY, "its zoneAuthority must be a list"),
    "purpose": ([{"purpose": "INFO"}], "its purpose must be one of AUTHORIZATION"),
    "siteURL": ([AUTHORITY | {"siteURL": 5}], "its siteURL must be a text, not 5."),
    "email": ([AUTHORITY | {"email": []}], "its email must be a text, not []."),
    "phone": ([AUTHORITY | {"phone": 47}], "its phone must be a text, not 47."),
    "service": ([AUTHORITY | {"service": "x"}], "its service must be a list, not 'x'."),
    "contactName": ([AUTHORITY | {"contactName": [1]}], "its contactName must be an object"),
    "intervalBefore": ([AUTHORITY | {"intervalBefore": 3}], "its intervalBefore must be a text"),
    "limitedApplicability": (PERIOD, "its limitedApplicability must be a list"),
    "schedule": ([{"schedule": DAILY}], "its schedule must be a list"),
    "day": ([{"schedule": [{"day": "MON"}]}], "its day must be a list, not 'MON'."),
    "dataSource": ("x", "its dataSource must be an object, not 'x'."),
    "creationDate": ({"creationDate": 2026}, "its creationDate must be a text, not 2026."),
    "originator": ({"originator": "x"}, "its originator must be an object, not 'x'."),
    "extendedProperties": ([], "its extendedProperties must be an object, not []."),
}
HOMES = {
    **dict.fromkeys(
        ("purpose", "siteURL", "email", "phone", "service", "contactName", "intervalBefore"),
        "zoneAuthority",
    ),
    **dict.fromkeys(("schedule", "day"), "limitedApplicability"),
    **dict.fromkeys(("creationDate", "originator"), "dataSource"),
}


@pytest.mark.parametrize("name", WRONG)
def test_refuses_a_wrong_value_of_each_member(name):
    value, reason = WRONG[name]
    feature = zone(**{HOMES.get(name, name.split()[0]): value})
    assert faults(feature), "the schema allows this"
    bad, good = read(feature, zone())
    assert isinstance(bad, Bad)
    assert reason in bad.reason
    assert isinstance(good, Feature)


# Departures that leave area, heights and times clear, each with a part of the note.
DEPARTURES = {
    "no authority": (changed("properties", "zoneAuthority", value=None), "have no zoneAuthority"),
    "empty authority": (zone(zoneAuthority=[]), "its zoneAuthority has 0 members"),
    "no purpose": (zone(zoneAuthority=[{}]), "its zoneAuthority has no purpose"),
    "no country": (changed("properties", "country", value=None), "its properties have no country"),
    "short country": (zone(country="NO"), "its country has 2 characters, not at least 3"),
    "no identifier": (changed("properties", "identifier", value=None), "have no identifier"),
    "long identifier": (zone(identifier="TST000123"), "has 9 characters, not at most 7"),
    "no variant": (changed("properties", "variant", value=None), "have no variant"),
    "no language": (zone(message=[{"text": "x"}]), "its message has no lang"),
    "long text": (zone(message=[{"text": "x" * 201, "lang": "en"}]), "its text has 201 characters"),
    "many reasons": (zone(reason=["NOISE"] * 10), "its reason has 10 members"),
    "unknown member": (zone(colour="red"), "its properties have an unknown member colour"),
    "unknown member of a period": (
        zone(
            limitedApplicability=[
                {"startdatetime": "2026-05-01T06:00:00Z", "endDateTime": "2026-05-02T06:00:00Z"}
            ]
        ),
        "its limitedApplicability has an unknown member startdatetime",
    ),
    "no day": (zone(limitedApplicability=[{"schedule": [{}]}]), "its schedule has no day"),
    "null": (zone(message=[], region=None), "its region is null"),
    "spelling of ED-269": (zone(type="REQ_AUTHORISATION"), "'REQ_AUTHORISATION', has another"),
    "lower case": (zone(type="prohibited"), "its type, 'prohibited', has another spelling"),
    "unit in capitals": (
        zone({**POLYGON, "layer": {**LAYER, "uom": "FT"}}),
        "its uom, 'FT', has another spelling",
    ),
    "reference in lower case": (
        zone({**POLYGON, "layer": {**LAYER, "upperReference": "amsl"}}),
        "its upperReference, 'amsl', has another spelling",
    ),
    "null layer": (zone({**POLYGON, "layer": None}), "its layer is null"),
    "time without seconds": (
        zone(limitedApplicability=[{"schedule": [{"day": ["MON"], "startTime": "08:00Z"}]}]),
        "its startTime, '08:00Z', is no full time of day with a time zone",
    ),
    "moment without a zone": (
        zone(limitedApplicability=[{"endDateTime": "2026-05-01T06:00:00"}]),
        "is no full date and time with a time zone",
    ),
}


@pytest.mark.parametrize(("feature", "text"), DEPARTURES.values(), ids=DEPARTURES)
def test_names_departures_and_reads_the_zone(feature, text):
    assert faults(feature), "the schema allows this"
    (found,) = read(feature)
    (remark,) = found.remarks
    assert remark.grade is Grade.NOTE
    assert remark.text.startswith("it departs from ED-318, and is read: ")
    assert text in remark.text
    assert (found.rings, found.category in ed318.CLASSES) == ((SQUARE,), True)


def test_names_departures_of_the_collection():
    document = {"features": [zone()], "type": "FeatureCollection", "name": "x" * 201}
    for change, text in (
        ({}, "its name has 201 characters, not at most 200"),
        ({"name": "x", "type": "Collection"}, "the document is no FeatureCollection"),
        ({"name": "x", "metadata": {"provider": [{}]}}, "its provider has no lang"),
        ({"name": None}, "its name is null"),
    ):
        assert document_faults(document | change)
        (found,) = ed318.features(Content(json.dumps(document | change).encode()))
        assert text in told(found)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"metadata": {"validFrom": {}}}, "its validFrom must be a date and time, not {}."),
        ({"metadata": {"issued": "soon"}}, "'soon' is no date and time, such as"),
        ({"metadata": {"provider": "x"}}, "its provider must be a list, not 'x'."),
        ({"metadata": []}, "its metadata must be an object, not []."),
        ({"name": 5}, "its name must be a text, not 5."),
        ({"bbox": [1, 2, 3]}, "its bbox must be a list of four numbers or more, not [1, 2, 3]."),
    ],
)
def test_refuses_faults_of_the_collection(change, reason):
    document = {"type": "FeatureCollection", "features": [zone()], **change}
    assert document_faults(document)
    bad, good = ed318.features(Content(json.dumps(document).encode()))
    assert bad.label == "the collection"
    assert reason in bad.reason
    assert isinstance(good, Feature)


@pytest.mark.parametrize(
    ("feature", "reason"),
    [
        ({**zone(), "id": []}, "its id must be a number or a text, not []."),
        ({**zone(), "bbox": 5}, "its bbox must be a list of four numbers or more, not 5."),
        (zone({**POLYGON, "bbox": ["a"] * 4}), "its bbox must be a list of four numbers"),
        (zone({**POLYGON, "coordinates": [[*RING[:3], [1, 2, "a"]]]}), "two finite numbers."),
        (
            zone({**POLYGON, "coordinates": [RING[:3]]}),
            "a ring must have 4 positions or more, not 3",
        ),
        (zone({"type": "LineString", "coordinates": RING[:1]}), "a line must have 2 positions"),
        (zone({"type": "LineString", "coordinates": {}}), "coordinates of a LineString must be"),
        (zone({"type": "Point", "coordinates": [5]}), "two finite numbers."),
        (zone({"type": "MultiPoint", "coordinates": [5]}), "must be a list, not 5."),
        (
            zone({"type": "GeometryCollection", "geometries": [None]}),
            "its geometry is not a GeoJSON object.",
        ),
        (
            zone(
                {
                    "type": "GeometryCollection",
                    "geometries": [{"type": "GeometryCollection", "geometries": []}],
                }
            ),
            "a GeometryCollection must not contain another one.",
        ),
    ],
)
def test_refuses_faults_of_features_and_positions(feature, reason):
    assert faults(feature), "the schema allows this"
    bad, _ = read(feature, zone())
    assert isinstance(bad, Bad)
    assert reason in bad.reason


# Reasons beyond the schema: contradictions and impossible places.
BEYOND = (
    "lies above its upper",
    "three corners or more",
    "before its start",
    "give one.",
    "is no WGS84",
)


def check_random(seed):
    rng = random.Random(f"ed318 {seed}")
    document = ed318_files.document(rng)
    assert not document_faults(document)
    if seed % 4:
        document = ed318_files.mutated(document, rng)
    content = Content(json.dumps(document).encode())
    if not ed318.recognises(content):
        return
    parts = list(ed318.features(content))
    bad = [part.reason for part in parts if isinstance(part, Bad)]
    named = [part for part in parts if isinstance(part, LeftOut) or getattr(part, "remarks", ())]
    if document_faults(document):
        assert bad or named, document
    else:
        assert all(any(text in reason for text in BEYOND) for reason in bad), (bad, document)


def test_random_documents_are_judged_as_the_schema_judges_them():
    for seed in range(400):
        check_random(seed)


@pytest.mark.long
def test_many_random_documents_are_judged_as_the_schema_judges_them():
    for seed in range(400, 10_000):
        check_random(seed)
