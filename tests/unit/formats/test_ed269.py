"""ED-269: zones with volumes, in the variants that states publish, and the faults."""

import copy
import json
from datetime import UTC, datetime, time

import pytest

from pathgene.host.formats import ed269
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, LeftOut, Limit, Period, Reference


RING = [[10.0, 60.0], [10.1, 60.0], [10.1, 60.1], [10.0, 60.0]]
VOLUME = {
    "uomDimensions": "FT",
    "lowerLimit": 0,
    "lowerVerticalReference": "AGL",
    "upperLimit": 400,
    "upperVerticalReference": "AMSL",
    "horizontalProjection": {"type": "Polygon", "coordinates": [RING]},
}
CIRCLE = {"type": "Circle", "center": [10.0, 60.0], "radius": 500}
ZONE = {
    "identifier": "NOR01",
    "country": "NOR",
    "name": "Fort",
    "type": "COMMON",
    "restriction": "PROHIBITED",
    "uSpaceClass": "",
    "applicability": [{"permanent": "YES"}],
    "geometry": [VOLUME],
}


def read(*zones):
    content = Content(json.dumps({"title": "Zones", "features": zones}).encode())
    assert ed269.recognises(content)
    return list(ed269.features(content))


def changed(**properties):
    return copy.deepcopy(ZONE) | properties


def volume(**values):
    return changed(geometry=[VOLUME | values])


def test_reads_a_polygon_between_limits():
    (found,) = read(ZONE)
    assert found.rings == (((10.0, 60.0), (10.1, 60.0), (10.1, 60.1)),)
    assert found.lower == Limit(0, Reference.AGL)
    assert found.upper == Limit(400 * 0.3048, Reference.AMSL)
    assert (found.category, found.forbids, found.periods) == ("PROHIBITED", True, ())
    assert found.label == 'feature 1, "Fort"'


def test_the_radius_of_a_circle_is_in_metres_whatever_the_unit_of_heights():
    (found,) = read(volume(horizontalProjection=CIRCLE))
    assert (found.rings, found.radius_m) == ((((10.0, 60.0),),), 500.0)


def test_reads_several_polygons_of_a_volume():
    hole = [[10.05, 60.02], [10.06, 60.02], [10.06, 60.03], [10.05, 60.02]]
    projection = {"type": "MultiPolygon", "coordinates": [[RING], [RING, hole]]}
    first, second = read(volume(horizontalProjection=projection))
    assert [len(first.rings), len(second.rings)] == [1, 2]
    projection["coordinates"] = {}
    assert read(volume(horizontalProjection=projection)) == [
        Bad('feature 1, "Fort"', "a Polygon must have at least one ring.")
    ]


def test_reads_the_variants_of_publications():
    one = changed(
        name=[{"lang": "de-CH", "text": "Festung"}, {"lang": "en-GB", "text": "Fort"}],
        geometry=VOLUME | {"uomDimensions": "m", "lowerLimit": None},
        restriction="REQ_AUTHORIZATION",
        applicability={"permanent": "YES"},
    )
    other = changed()
    del other["applicability"], other["name"], other["geometry"][0]["upperLimit"]
    first, second = read(one, other)
    assert (first.name, first.lower, first.upper) == ("Fort", None, Limit(400, Reference.AMSL))
    assert first.category == "REQ_AUTHORISATION"
    assert (second.name, second.upper, second.periods) == ("NOR01", None, ())


@pytest.mark.parametrize("as_list", [True, False])
def test_reads_schedules(as_list):
    daily = {"day": ["MON", "FRI"], "startTime": "08:00:00.00Z", "endTime": "17:30Z"}
    period = {
        "permanent": "NO",
        "startDateTime": "2026-06-15T09:00:00.00Z",
        "endDateTime": "2026-06-16T00:00:00Z",
        "schedule": [daily] if as_list else daily,
    }
    (found,) = read(changed(applicability=[period] if as_list else period))
    start, end = datetime(2026, 6, 15, 9, tzinfo=UTC), datetime(2026, 6, 16, tzinfo=UTC)
    assert found.periods == (Period(start, end, frozenset({0, 4}), time(8), time(17, 30)),)


@pytest.mark.parametrize(
    ("more", "is_said"),
    [
        ({}, False),
        ({"startDateTime": None, "schedule": []}, False),
        ({"schedule": [{"day": ["ANY"], "startTime": "08:00Z", "endTime": "17:00Z"}]}, True),
        ({"endDateTime": "2026-06-16T00:00:00Z"}, True),
    ],
)
def test_times_of_a_permanent_zone_are_named(more, is_said):
    (found,) = read(changed(applicability=[{"permanent": "YES", **more}]))
    text = "it is permanent, so its dates and schedule are not read, and it is always active"
    assert found.periods == ()
    assert [remark.text for remark in found.remarks] == [text] * is_said


@pytest.mark.parametrize(
    "stated",
    [
        {"permanent": "NO"},
        {"permanent": False, "startDateTime": None, "schedule": []},
        {"permanent": "no", "endDateTime": ""},
        {},
    ],
)
def test_a_period_without_dates_counts_as_always_active_and_says_so(stated):
    dated = {"startDateTime": "2026-06-15T09:00:00Z"}
    for periods in ([stated], stated, [dated, stated]):
        (found,) = read(changed(applicability=periods))
        assert found.periods == ()
        assert [remark.text for remark in found.remarks] == [
            "a period of its applicability has neither dates nor a schedule, so it counts as "
            "always active"
        ]
    for silent in ([dated], [], None):
        (found,) = read(changed(applicability=silent))
        assert found.remarks == ()


def test_refuses_a_period_that_may_be_permanent():
    dated = {"permanent": "perhaps", "startDateTime": "2026-06-15T09:00:00Z"}
    (bad,) = read(changed(applicability=[dated]))
    assert bad == Bad('feature 1, "Fort"', "permanent must be YES or NO, not 'perhaps'.")


def test_leaves_out_a_zone_without_geometry():
    assert read(ZONE, changed(geometry=[]))[1] == LeftOut('feature 2, "Fort"', "it has no geometry")


@pytest.mark.parametrize(
    ("zone", "reason"),
    [
        (
            changed(restriction="NOT_ALLOWED"),
            "its restriction must be one of PROHIBITED, REQ_AUTHORISATION, CONDITIONAL, "
            "NO_RESTRICTION, not 'NOT_ALLOWED'.",
        ),
        (changed(geometry=[VOLUME, 5]), "a volume must be an object, not 5."),
        (volume(upperLimit="400"), "a limit of height must be a number, not '400'."),
        (
            volume(uomDimensions="KM"),
            "the unit of a limit of height must be m, ft or FL, not 'KM'.",
        ),
        (
            volume(upperVerticalReference=None),
            "the reference of a limit of height must be AGL, AMSL, WGS84 or STD, not None.",
        ),
        (
            volume(lowerVerticalReference="AMSL", lowerLimit=500),
            "its lower limit, 152.4 m, lies above its upper, 121.92 m.",
        ),
        (volume(horizontalProjection=[]), 'a volume must have a "horizontalProjection".'),
        (
            volume(horizontalProjection={"type": "Ellipse"}),
            "a horizontalProjection must be a Circle or a Polygon, not 'Ellipse'.",
        ),
        (
            volume(horizontalProjection=CIRCLE | {"radius": 0}),
            "the radius of a circle must be a number above 0, not 0.",
        ),
        (
            volume(horizontalProjection=CIRCLE | {"center": None}),
            "a position must be a list of two finite numbers.",
        ),
        (
            volume(horizontalProjection={"type": "Polygon", "coordinates": []}),
            "a Polygon must have at least one ring.",
        ),
        (
            volume(horizontalProjection={"type": "Polygon", "coordinates": [RING[:2]]}),
            "a ring must have three corners or more.",
        ),
        (
            changed(applicability=["YES"]),
            "a period of its applicability must be an object, not 'YES'.",
        ),
        (
            changed(applicability=[{"startDateTime": "tomorrow"}]),
            "'tomorrow' is no date and time, such as 2026-05-01T06:00:00Z.",
        ),
        (
            changed(applicability=[{"schedule": [{"day": ["MO"]}]}]),
            "'MO' is no day of the week; it must be MON to SUN or ANY.",
        ),
    ],
)
def test_names_a_bad_zone_and_reads_the_others(zone, reason):
    first, second = read(zone, ZONE)
    assert first == Bad('feature 1, "Fort"', reason)
    assert second.number == 2
