"""The report on files of zones."""

import json
import math
from datetime import UTC, datetime

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats.classes import forbidding as classes_of
from pathgene.host.formats.classes import forbids
from pathgene.host.formats.features import Feature, Limit, Period, Reference
from pathgene.host.formats.features import LeftOut as Left
from pathgene.host.formats.times import applicability, between, moment
from pathgene.host.problem import zone_intake
from pathgene.host.problem.zones import ZoneOptions, read_zones
from pathgene.host.remarks import Grade, Remark
from pathgene.host.terrain import Terrain


X, Y = np.meshgrid(np.arange(41), np.arange(41))
TERRAIN = Terrain("hill", 100.0 + 5.0 * X, 100.0, 100.0, "EPSG:32632", (500_000.0, 5_000_000.0))
DEPARTURE = datetime(2026, 5, 1, 9, tzinfo=UTC)


def ring(x, y, size=500.0):
    corners = np.array([(x, y), (x + size, y), (x + size, y + size), (x, y + size)])
    lat, lon = TERRAIN.to_geographic(*corners.T)
    return (tuple(zip(lon.tolist(), lat.tolist(), strict=True)),)


def feature(number=1, name="R-7", at=(1000.0, 1000.0), **more):
    return Feature(number, name, ring(*at), **more)


def read(monkeypatch, *features, **options):
    """Return the zones and the report of a file with these features."""
    monkeypatch.setattr(zone_intake, "read_features", lambda path: ("OpenAir", list(features)))
    return read_zones("airspace.txt", TERRAIN, ZoneOptions(**options))


def said(found, grade):
    return [each.text for each in found.reading.remarks if each.grade == grade]


def metres(height, reference=Reference.AMSL):
    return Limit(height, reference)


def test_counts_and_limits_are_said(monkeypatch):
    low = Limit(300.0, Reference.AMSL, "GND")
    high = Limit(2895.6, Reference.STANDARD, "FL 95")
    found = read(
        monkeypatch,
        feature(17, lower=low, upper=high),
        feature(18, "far", at=(90_000.0, 1000.0)),
    )
    assert said(found, "note")[0] == (
        "airspace.txt: 2 zones read as OpenAir; 1 touches the map, 1 can forbid flight."
    )
    (zone,) = found.reading.facts["zones"]
    assert (zone["part"], zone["lower"], zone["upper"]) == ('feature 17, "R-7"', "GND", "FL 95")
    assert zone["lower_m"] == 300.0
    assert 2895.6 < zone["upper_m"] < 3250
    assert said(found, "warning") == []
    assert any(
        'feature 18, "far" forbids nothing: it lies off the map' in text
        for text in said(found, "note")
    )
    json.dumps(found.reading.to_dict())


@pytest.mark.parametrize(
    ("more", "options", "reason"),
    [
        ({"at": (90_000.0, 0.0)}, {}, "it lies off the map"),
        ({"upper": metres(144.0)}, {}, "its upper limit is under the ground everywhere"),
        ({"upper": metres(-3.0, Reference.AGL)}, {}, "its upper limit is under the ground"),
        ({"lower": metres(900.0)}, {"ceiling_m": 900.0}, "its lower limit is over the ceiling"),
        (
            {"lower": metres(300.0), "upper": metres(300.0)},
            {},
            "its lower limit is its upper limit",
        ),
        (
            {"periods": (Period(end=datetime(2026, 4, 1, tzinfo=UTC)),)},
            {"departure": DEPARTURE},
            "it is not active during the flight",
        ),
    ],
)
def test_a_zone_that_forbids_nothing_is_a_warning(monkeypatch, more, options, reason):
    found = read(monkeypatch, feature(3, **more), **options)
    counts, warning = said(found, "warning")
    assert counts.endswith("0 can forbid flight.")
    assert warning.startswith(f'airspace.txt: feature 3, "R-7" forbids nothing: {reason}')
    assert found.reading.facts["can_forbid"] == 0
    # The same zone, with room for a flight, gives no warning.
    assert said(read(monkeypatch, feature(3)), "warning") == []


STANDARD, AGL = Reference.STANDARD, Reference.AGL


@pytest.mark.parametrize(
    ("lower", "upper", "said"),
    [
        (
            metres(500.0),
            metres(40.0, AGL),
            "500 m AMSL, lies above its upper, 40 m AGL on this map",
        ),
        (metres(2895.6, STANDARD), metres(304.8, AGL), "2895.6 m STD, lies above its upper, 304"),
        (metres(2895.6, STANDARD), metres(0.0, AGL), "2895.6 m STD, lies above its upper, 0 m AGL"),
        (metres(120.0, AGL), metres(0.0, AGL), "120 m AGL, lies above its upper, 0 m AGL."),
        (metres(900.0), metres(300.0), "900 m AMSL, lies above its upper, 300 m AMSL."),
    ],
)
def test_a_zone_upside_down_is_bad(monkeypatch, lower, upper, said):
    wrong = feature(3, lower=lower, upper=upper)
    with pytest.raises(InputError, match=r'feature 3, "R-7": its lower limit, ') as refusal:
        read(monkeypatch, wrong)
    assert said in str(refusal.value)
    # It is read where it informs only, and where it lies elsewhere if the ground decides.
    informs = feature(3, lower=lower, upper=upper, category="E", forbids=False)
    assert read(monkeypatch, informs).reading.facts["read"] == 1
    if lower.reference is not upper.reference:
        off = feature(3, at=(90_000.0, 0.0), lower=lower, upper=upper)
        assert "off the map" in read(monkeypatch, off).reading.warnings[1]


def test_a_file_without_a_zone_that_forbids_is_a_warning(monkeypatch):
    line = Left("feature 1", "a LineString is not an area")
    assert said(read(monkeypatch, line), "warning") == [
        "airspace.txt: 0 zones read as OpenAir; 0 touch the map, 0 can forbid flight."
    ]
    informs = feature(category="E", forbids=False)
    assert said(read(monkeypatch, informs), "warning") == [
        "airspace.txt: 1 zone read as OpenAir; 1 touches the map, 0 can forbid flight."
    ]


def test_a_zone_that_is_active_only_after_the_flight_is_a_warning(monkeypatch):
    (_, warning) = said(read(monkeypatch, feature(t0_s=4000.0), longest_s=3600.0), "warning")
    assert warning == (
        'airspace.txt: feature 1, "R-7" forbids nothing: it is not active during the flight.'
    )
    assert said(read(monkeypatch, feature(t0_s=3000.0), longest_s=3600.0), "warning") == []


def test_a_zone_without_size_is_a_warning(monkeypatch):
    point = Feature(1, "mast", ((ring(1000.0, 1000.0)[0][0],),), 0.0)
    assert any("it has no size" in text for text in said(read(monkeypatch, point), "warning"))


@pytest.mark.parametrize(
    ("forbid", "forbidding"),
    [(None, {"D"}), ("default,E", {"D", "E"}), ("P", set()), ("FIS", "DE")],
)
def test_a_type_and_a_class_are_both_named_and_counted(monkeypatch, forbid, forbidding):
    zones = [
        feature(
            number,
            letter,
            category="FIS",
            airspace_class=letter,
            forbids=forbids("FIS", airspace_class=letter),
        )
        for number, letter in enumerate("DE", start=1)
    ]
    chosen = None if forbid is None else classes_of(forbid)
    found = read(monkeypatch, *zones, forbid=chosen)
    assert found.reading.facts["categories"] == {"FIS": {"read": 2, "forbid": len(forbidding)}}
    assert [zone["class"] for zone in found.reading.facts["zones"]] == ["D", "E"]
    assert len(found.zones) == found.reading.facts["can_forbid"] == len(forbidding)
    notes = " ".join(said(found, "note"))
    for number, letter in enumerate("DE", start=1):
        assert (f"FIS of class {letter}" in notes) == (letter not in forbidding)
        note = (
            f'feature {number}, "{letter}": its type FIS does not forbid flight, but its class '
            f"{letter} does."
        )
        assert (note in notes) == (letter in forbidding and forbid != "FIS")


def test_parts_left_out_are_grouped_by_reason(monkeypatch):
    points = [Left(f"placemark {number}", "a Point is not an area") for number in range(1, 13)]
    link = Left("a NetworkLink", "linked zones are not read", True)
    found = read(monkeypatch, feature(), *points, link)
    assert len(found.left_out) == 13
    assert said(found, "warning") == [
        "airspace.txt: a NetworkLink left out: linked zones are not read."
    ]
    assert said(found, "note")[1] == (
        "airspace.txt: placemark 1, placemark 2, placemark 3, placemark 4, placemark 5 and 7 more "
        "left out: a Point is not an area."
    )


def test_a_feature_of_several_parts_is_named_once(monkeypatch):
    high = metres(30.0, Reference.AGL)
    found = read(monkeypatch, feature(1, "A", upper=high), feature(1, "A", lower=high))
    assert any(text.endswith('on the safe side: feature 1, "A".') for text in said(found, "note"))


def test_properties_that_are_not_read_are_named(monkeypatch):
    found = read(monkeypatch, feature(unread=("floor", "ceiling")))
    (warning,) = said(found, "warning")
    assert 'floor, ceiling of feature 1, "R-7" are not read' in warning


def test_zones_without_height_do_not_refuse_the_others(monkeypatch):
    flat = {"lower": metres(300.0), "upper": metres(300.0)}
    found = read(monkeypatch, feature(1, "A", **flat), feature(2, "B", **flat), feature(3, "C"))
    assert [zone.name for zone in found.zones] == ["C"]
    assert said(found, "warning") == [
        'airspace.txt: feature 1, "A", feature 2, "B" forbid nothing: their lower limits are their '
        "upper limits."
    ]
    turned = {"lower": metres(301.0), "upper": metres(300.0)}
    with pytest.raises(InputError, match=r'feature 1, "A": .*lower'):
        read(monkeypatch, feature(1, "A", **turned), feature(3, "C"))


def test_remarks_of_the_format_are_said_once_with_their_zones(monkeypatch):
    doubt = Remark(Grade.WARNING, "its heights contradict each other")
    paper = Remark(Grade.NOTE, "it names no authority")
    found = read(
        monkeypatch,
        feature(1, "A", remarks=(doubt, paper)),
        feature(1, "A", remarks=(doubt,)),
        feature(2, "B", remarks=(doubt,)),
        feature(3, "far", at=(90_000.0, 1000.0), remarks=(doubt,)),
    )
    assert said(found, "warning") == [
        'airspace.txt: feature 1, "A", feature 2, "B": its heights contradict each other.'
    ]
    assert 'airspace.txt: feature 1, "A": it names no authority.' in said(found, "note")


def test_categories_forbid_as_the_user_says(monkeypatch):
    parts = [
        feature(1, "A", category="CTR"),
        feature(2, "B", category="E", forbids=False),
        feature(3, "C"),
    ]
    found = read(monkeypatch, *parts)
    assert [zone.name for zone in found.zones] == ["A", "C"]
    assert found.reading.facts["categories"]["E"] == {"read": 1, "forbid": 0}
    assert any('feature 2, "B"; --forbid changes this.' in text for text in said(found, "note"))
    found = read(monkeypatch, *parts, forbid=frozenset({"E"}))
    # A zone without a category always forbids.
    assert [zone.name for zone in found.zones] == ["B", "C"]


def test_times_need_a_departure(monkeypatch):
    times = (Period(start=datetime(2026, 5, 1, 10, tzinfo=UTC)),)
    always = read(monkeypatch, feature(periods=times))
    assert [(zone.t0_s, zone.t1_s) for zone in always.zones] == [(None, None)]
    assert any("always active without --departure" in text for text in said(always, "note"))
    timed = read(monkeypatch, feature(periods=times), departure=DEPARTURE)
    assert [(zone.t0_s, zone.t1_s) for zone in timed.zones] == [(3600.0, None)]
    assert len(said(timed, "note")) == 1


@pytest.mark.parametrize(
    ("first", "last", "words"),
    [
        (None, None, ""),
        (60.0, None, "from 60 s of the flight"),
        (0.0, 90.5, "from 0 s, until 90.5 s of the flight"),
    ],
)
def test_seconds_of_the_flight_are_said(monkeypatch, first, last, words):
    found = read(monkeypatch, feature(t0_s=first, t1_s=last))
    assert found.reading.facts["zones"][0]["times"] == words


@pytest.mark.parametrize(
    ("start", "end", "grade", "text"),
    [
        (None, 4, "warning", "valid until 2026-04-04T00:00:00+00:00, before the departure"),
        (6, None, "warning", "valid from 2026-06-06T00:00:00+00:00, after the departure"),
        (4, 6, "note", ""),
    ],
)
def test_the_validity_of_a_file_is_compared_with_the_departure(
    monkeypatch, start, end, grade, text
):
    first, last = (month and datetime(2026, month, month, tzinfo=UTC) for month in (start, end))
    parts = [feature(number, valid=Period(first, last)) for number in (1, 2)]
    found = read(monkeypatch, *parts, departure=DEPARTURE)
    remarks = [each for each in said(found, grade) if "states that it is valid" in each]
    assert len(remarks) == bool(text)
    assert all(each.startswith(f"airspace.txt: states that it is {text}") for each in remarks)
    assert len(found.zones) == 2
    unknown = said(read(monkeypatch, *parts), "note")
    assert sum("which is not compared without --departure" in each for each in unknown) == 1


def test_bad_features_are_named_and_skipped_on_demand(monkeypatch):
    bad = Feature(17, "R-7", (((9.0, 45.0), (9.1, 45.0)),))
    with pytest.raises(InputError) as refusal:
        read(monkeypatch, feature(16), bad, feature(18))
    assert str(refusal.value) == (
        "No-fly file 'airspace.txt': feature 17, \"R-7\": a ring must have at least 3 corners, "
        "not 2; --skip-bad-zones reads the other 2."
    )
    found = read(monkeypatch, feature(16), bad, feature(18), skip_bad=True)
    assert len(found.zones) == 2
    (warning,) = said(found, "warning")
    assert 'feature 17, "R-7" left out: a ring must have at least 3 corners' in warning


def test_swapped_coordinates_are_refused_by_place(monkeypatch):
    right = feature()
    swapped = Feature(2, "prison", (tuple((lat, lon) for lon, lat in right.rings[0]),))
    with pytest.raises(
        InputError, match=r'feature 2, "prison": it lies off the map, at'
    ) as refusal:
        read(monkeypatch, right, swapped)
    remedy = "swap them in the file, or in --origin LAT,LON if you gave it, or leave it out by "
    assert str(refusal.value).endswith(f"{remedy}--skip-bad-zones.")
    # A zone elsewhere that is not on the map in either order is not a fault.
    assert (
        read(monkeypatch, right, feature(2, at=(400_000.0, 0.0))).zones
        == read(monkeypatch, right).zones
    )


@pytest.mark.parametrize("turned", [0, 1, 2])
def test_only_a_ring_that_meets_the_map_is_swapped(monkeypatch, turned):
    """The box of the triangle holds the map at (45.15, 9.0), but the triangle does not."""
    far = ((39.0, 9.06), (45.2, 3.0), (39.0, 3.0))
    far = far[turned:] + far[:turned]
    found = read(monkeypatch, feature(), Feature(2, "far", (far,)))
    assert len(found.zones) == 1
    assert not said(found, "warning")
    near = ((45.4, 8.5), (45.4, 9.5), (44.9, 9.0))
    near = near[turned:] + near[:turned]
    with pytest.raises(InputError, match="it lies off the map, at latitude"):
        read(monkeypatch, feature(), Feature(2, "near", (near,)))


def test_a_far_country_is_not_swapped(monkeypatch):
    """A zone that covers the map if swapped, and is many times as large, is elsewhere."""
    country = ((40.0, 4.0), (50.0, 4.0), (50.0, 14.0), (40.0, 14.0))
    found = read(monkeypatch, feature(), Feature(2, "FIR", (country,)))
    assert len(found.zones) == 1
    assert said(found, "warning") == [
        'feature 2, "FIR" lies off the map, at latitude 4 and longitude 40, and would cover all of '
        "it with the two swapped; swap them in the file if it belongs here."
    ]
    # A fence to stay in may be as large, and a zone may cover a map of its own size.
    with pytest.raises(InputError, match="it lies off the map, at latitude"):
        read(monkeypatch, Feature(2, "", (country,), keeps_in=True))
    around = ((45.1, 8.9), (45.3, 8.9), (45.3, 9.1), (45.1, 9.1))
    with pytest.raises(InputError, match="it lies off the map, at latitude"):
        read(monkeypatch, feature(), Feature(2, "", (around,)))


def test_a_fence_to_stay_in_with_swapped_coordinates_is_refused(monkeypatch):
    (corners,) = ring(1000.0, 1000.0)
    swapped = (tuple((lat, lon) for lon, lat in corners),)
    with pytest.raises(InputError, match="it lies off the map, at latitude"):
        read(monkeypatch, Feature(1, "", swapped, keeps_in=True))
    (zone,) = read(monkeypatch, Feature(1, "", (corners,), keeps_in=True)).zones
    assert len(zone.holes) == 1


@pytest.mark.parametrize(
    ("period", "is_plain"),
    [
        ({"startDateTime": "2026-05-01T06:00:00Z", "endDateTime": "2027-05-01T06:00:00Z"}, False),
        ({"startDateTime": "2026-05-01T06:00:00", "endDateTime": "2027-05-01T06:00:00Z"}, True),
        ({"schedule": [{"day": ["ANY"], "startTime": "06:00:00", "endTime": "20:00:00Z"}]}, True),
        ({"schedule": [{"day": ["ANY"], "startTime": "06:00Z", "endTime": "20:00+02:00"}]}, False),
        ({"schedule": [{"day": ["ANY"], "startEvent": "SR", "endEvent": "SS"}]}, False),
    ],
)
def test_times_without_a_time_zone_are_a_warning(monkeypatch, period, is_plain):
    zone = feature(3, periods=applicability(period))
    wanted = ['airspace.txt: times without a time zone count as UTC: feature 3, "R-7".']
    for options in ({}, {"departure": DEPARTURE}):
        assert said(read(monkeypatch, zone, **options), "warning")[-1:] == wanted * is_plain


def test_intervals_of_openair_without_a_time_zone_are_plain():
    assert between(moment("2026-05-01T06:00"), None).has_plain_times
    assert not between(moment("2026-05-01T06:00Z"), moment("9999-12-31T23:59Z")).has_plain_times


@pytest.mark.parametrize(
    ("west", "east", "is_doubtful"),
    [(-100.0, 100.0, True), (-170.0, 170.0, True), (-180.0, 180.0, False), (-90.0, 89.0, False)],
)
def test_an_edge_that_went_the_short_way_is_a_warning(monkeypatch, west, east, is_doubtful):
    _, latitude = feature().rings[0][0]
    ring = tuple((x, latitude + y) for x, y in ((west, -1), (east, -1), (east, 1), (west, 1)))
    found = said(read(monkeypatch, feature(), Feature(2, "wide", (ring,))), "warning")
    start = "airspace.txt: an edge of more than 180 degrees of longitude went the short way round "
    end = 'divide the edge if the long way is meant: feature 2, "wide".'
    assert [text.startswith(start) and text.endswith(end) for text in found] == [True] * is_doubtful


SQUARE = [(1000.0, 1000.0), (2000.0, 1000.0), (2000.0, 2000.0), (1000.0, 2000.0)]
STAR = [
    (1500.0 + 500.0 * math.sin(0.8 * math.pi * i), 1500.0 + 500.0 * math.cos(0.8 * math.pi * i))
    for i in range(5)
]


@pytest.mark.parametrize(
    ("corners", "is_named"),
    [
        (SQUARE, False),
        (SQUARE[::-1], False),
        ([*SQUARE, SQUARE[0]], False),
        # A concave corner, and a spike.
        ([*SQUARE, (1400.0, 1500.0)], False),
        ([*SQUARE[:2], (2500.0, 1000.0), *SQUARE[1:]], False),
        (SQUARE * 2, True),
        ([*SQUARE, *SQUARE, SQUARE[0]], True),
        (STAR, True),
        ([SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]], True),
    ],
    ids=[
        "square",
        "clockwise",
        "closed",
        "concave",
        "spike",
        "twice",
        "twice-closed",
        "star",
        "bow",
    ],
)
def test_an_outline_that_crosses_itself_is_a_warning(monkeypatch, corners, is_named):
    lat, lon = TERRAIN.to_geographic(*np.array(corners).T)
    rings = (tuple(zip(lon.tolist(), lat.tolist(), strict=True)),)
    found = read(monkeypatch, Feature(1, "R-7", rings))
    sentence = (
        "airspace.txt: the outline crosses itself or is drawn twice, and ground that it encloses "
        "twice counts as inside and forbidden; draw it once around its area: "
        'feature 1, "R-7".'
    )
    assert (sentence in said(found, Grade.WARNING)) == is_named
