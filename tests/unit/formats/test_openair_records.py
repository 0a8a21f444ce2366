"""Every record of OpenAir in its spellings, compared with aerofiles where that reads them."""

import io
import time

import numpy as np
import pytest
from aerofiles.openair import Reader
from aerofiles.openair.reader import coordinate

from pathgene.host.formats import openair
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature, LeftOut, Limit, Reference


CORNERS = (
    "DP 60:00:00 N 010:00:00 E",
    "DP 60:00:00 N 010:06:00 E",
    "DP 60:06:00 N 010:06:00 E",
)
RING = ((10.0, 60.0), (10.1, 60.0), (10.1, 60.1))
X = "V X=60:00:00 N 010:00:00 E"


def read(*lines):
    content = Content("\n".join(lines).encode())
    assert openair.recognises(content)
    return list(openair.features(content))


def aerofiles(*lines):
    """Return the records as aerofiles has them; None for one that it drops."""
    return [record for record, _ in Reader(io.StringIO("\n".join(lines)))]


# Places in spellings that aerofiles reads, and in spellings that it refuses or misreads.
COMMON = (
    "60:01:30 N 010:03:00 E",
    "60:01:30N 010:03:00E",
    "60:01:30N010:03:00E",
    "60:01.5 N 010:03.0 E",
    "60:01:30.00 N 10:3:0 E",
)
OURS = (
    "600130 N 0100300 E",
    "600130N 0100300E",
    "600130N0100300E",
    "600130.0N 0100300.00E",
    "6001N 01003E",
    "6001.5N 01003.0E",
    "N600130 E0100300",
    "N6001.5 E01003",
    "60 01 30 N 010 03 00 E",
    "60 01.5 N 010 03.0 E",
    "N60 01 30 E010 03 00",
    "60°01'30\"N 010°03'00\"E",
    "60° 01′ 30″ N, 10° 3′ E",
    "60:01:30 n 010:03:00 e",
    "n60:01:30, e010:03:00",
    "60.025 N 10.05 E",
    "60:01.5 n 10.05 e",
)
MINUTE = 1 / 60


@pytest.mark.parametrize("place", [*COMMON, *OURS])
def test_reads_places_as_aerofiles_does_or_as_written(place):
    (found,) = read("AC R", f"V X={place}", "DC 5")
    lon, lat = found.rings[0][0]
    expected = (60.025, 10.05)
    if place in COMMON:
        assert coordinate(place) == pytest.approx(expected, abs=1e-12)
    else:
        with pytest.raises(ValueError, match="invalid coordinate format"):
            coordinate(place)
        # These have whole minutes of latitude.
        expected = (60 + MINUTE, 10.05) if place == "6001N 01003E" else expected
    assert (lat, lon) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("place", "reason"),
    [
        ("606130 N 0100300 E", "has more than 60 minutes or seconds"),
        ("600170 N 0100300 E", "has more than 60 minutes or seconds"),
        ("956001 N 0100300 E", "is no place on Earth"),
        ("600130 N 4100300 E", "is no place on Earth"),
        ("600 N 010 E", "is no place on Earth"),
        ("600130 0100300", "is no place, such as"),
        ("600130 N N 0100300 E", "is no place, such as"),
        ("N 600130 N 0100300 E", "is no place, such as"),
        ("60:01:30:10 N 010:03:00 E", "is no place, such as"),
        ("60,01,30 N 010,03,00 E", "is no place, such as"),
        ("-60:01:30 N 010:03:00 E", "is no place, such as"),
        ("", "is no place, such as"),
    ],
)
def test_names_a_bad_place(place, reason):
    bad, good = read("AC R", "AN R-7", f"V X={place}", "DC 5", "AC Q", *CORNERS)
    assert isinstance(bad, Bad)
    assert bad.label == 'airspace 1, "R-7"'
    assert reason in bad.reason
    assert good.number == 2


def test_a_place_of_many_blanks_takes_no_longer():
    began = time.process_time()
    for text in (f"60:00:00{' ' * 9000}x", f"60:00{' ,' * 9000} x", "6" * 9000, "6 " * 9000):
        bad, _ = read("AC R", f"DP {text}", "AC Q", *CORNERS)
        assert isinstance(bad, Bad)
        assert len(bad.reason) < 200
    assert time.process_time() - began < 1.0


# Limits that are read, and the ones that are named because they could mean several heights.
LIMITS = {
    "2500' AGL": Limit(762, Reference.AGL),
    "2500ft agl": Limit(762, Reference.AGL),
    "2500 FT": Limit(762, Reference.AMSL),
    "2500": Limit(762, Reference.AMSL),
    "2500 ft GND": Limit(762, Reference.AGL),
    "2500ft SFC": Limit(762, Reference.AGL),
    "2500 ft MSL": Limit(762, Reference.AMSL),
    "762m AMSL": Limit(762, Reference.AMSL),
    "FL 95": Limit(2895.6, Reference.STANDARD),
    "FL95": Limit(2895.6, Reference.STANDARD),
    "fl095": Limit(2895.6, Reference.STANDARD),
    "SFC": Limit(0, Reference.AGL),
    "gnd": Limit(0, Reference.AGL),
    "UNL": None,
    "UNLIM": None,
    "Unlimited": None,
}
UNKNOWN = (
    "FL95 AGL",
    "FL 95 GND",
    "Ask on 122.8",
    "2500/3500 ft",
    "FL",
    "2.500 ft",
    "10.000 ft",
    "95 km",
    "",
)


@pytest.mark.parametrize("record", ["AL", "AH"])
@pytest.mark.parametrize("text", LIMITS)
def test_reads_limits(record, text):
    (found,) = read("AC R", f"{record} {text}", *CORNERS)
    limit, expected = (found.lower if record == "AL" else found.upper), LIMITS[text]
    assert found.unread == ()
    assert (limit is None) == (expected is None)
    if expected is not None:
        assert limit.height_m == pytest.approx(expected.height_m)
        assert limit.reference is expected.reference


@pytest.mark.parametrize("record", ["AL", "AH"])
@pytest.mark.parametrize("text", UNKNOWN)
def test_names_limits_that_could_mean_several_heights(record, text):
    (found,) = read("AC R", f"{record} {text}", *CORNERS)
    assert (found.lower, found.upper) == (None, None)
    assert found.unread == (f"{record} {text}".strip(),)


# Each record that limits no zone, with a value that aerofiles accepts.
HARMLESS = {
    "AF": "123.456",
    "AG": "Radio",
    "AI": "b3836bab",
    "AT": "60:00:00 N 010:00:00 E",
    "SB": "200,200,255",
    "SP": "0,1,0,0,255",
    "V": "Z=100",
}


@pytest.mark.parametrize("name", HARMLESS)
def test_records_that_limit_nothing_change_nothing(name):
    lines = ("AC R", "AN R-7", "AH FL 65", f"{name} {HARMLESS[name]}", *CORNERS)
    (found,) = read(*lines)
    (record,) = aerofiles(*lines)
    assert [each["location"][::-1] for each in record["elements"]] == [
        pytest.approx(corner) for corner in found.rings[0]
    ]
    assert found == read("AC R", "AN R-7", "AH FL 65", *CORNERS)[0]


@pytest.mark.parametrize("line", ["AX 7000", "TP 7000", "AS station", "TO label", "TC label"])
def test_records_that_aerofiles_does_not_know_change_nothing(line):
    (found,) = read("AC R", line, *CORNERS)
    assert found == read("AC R", *CORNERS)[0]


def test_reads_class_name_type_and_activation():
    lines = ("AC D", "AY CTR", "AN Name", "AA 2026-05-01T06:00Z/2026-05-01T08:00Z", *CORNERS)
    (found,) = read(*lines)
    (record,) = aerofiles(*lines)
    assert (record["class"], record["airspace_type"]) == ("D", found.category)
    assert found.name == record["name"]
    assert [(each.start, each.end) for each in found.periods] == [
        (each["start"], each["end"]) for each in record["activation"]
    ]


# An outline, and the same outline in lower case and with other blanks.
OUTLINES = {
    "DP": CORNERS,
    "DA": (X, "DA 5,10,100", CORNERS[0]),
    "DA the other way": (X, "V D=-", "DA 5,100,10", CORNERS[0]),
    "DB": (X, "DB 60:05:00 N 010:00:00 E, 60:00:00 N 010:10:00 E", CORNERS[0]),
    "DC": (X, "DC 5"),
    "DY": ("V W=2", *(each.replace("DP", "DY") for each in CORNERS)),
}


@pytest.mark.parametrize("outline", OUTLINES.values(), ids=OUTLINES)
def test_reads_outlines_in_any_case_and_spacing(outline):
    found = read("AC R", *outline)
    assert all(isinstance(each, Feature) for each in found)
    for change in (
        str.lower,
        lambda line: f"  {line.replace(' ', '  ', 1)}  * a comment",
        lambda line: line.replace("=", " = "),
        lambda line: line.replace(" ", "\t", 1),
    ):
        others = read("ac r", *map(change, outline))
        assert len(others) == len(found)
        for one, other in zip(found, others, strict=True):
            assert one.radius_m == other.radius_m
            assert np.allclose(one.rings, other.rings, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("outline", "reason"),
    [
        (("DA 5,10,100",), "DA has no centre before it (V X=)."),
        (("DB 60:05 N 010:00 E, 60:00 N 010:10 E",), "DB has no centre before it (V X=)."),
        (("DC 5",), "DC has no centre before it (V X=)."),
        (("DY 60:00 N 010:00 E",), "its airway has no width before it (V W=)."),
        ((X, "DA 5,10"), "is no radius, start and end."),
        ((X, "DA a,10,20"), "'a' is no number."),
        ((X, "DA -5,10,20"), "'-5' is no radius in nautical miles."),
        ((X, "DB 60:05 N 010:00 E"), "is no place"),
        ((X, "DC"), "'' is no number."),
        (("V X=",), "'' is no place"),
        (("V W=wide",), "'wide' is no number."),
        (("V D=0",), "'V D=0' is no variable of OpenAir."),
        (("V T=5",), "'V T=5' is no variable of OpenAir."),
        (("DX 5",), "the outline has an unknown record DX."),
        ((*CORNERS, "AA"), "AA '' is no interval START/END."),
    ],
)
def test_names_a_bad_record_with_its_line(outline, reason):
    bad, good = read("AC R", *outline, "AC Q", *CORNERS)
    assert isinstance(bad, Bad)
    assert reason in bad.reason
    assert good.number == 2


def test_names_terrain_and_unknown_records():
    found = read(
        "AC R", *CORNERS, "TC Town", *CORNERS, "TO Lake", *CORNERS, "AC Q", "QQ 1", *CORNERS
    )
    assert [each.label for each in found if isinstance(each, LeftOut)] == [
        "line 5",
        "line 9",
        "line 14",
    ]
    assert [each.number for each in found if isinstance(each, Feature)] == [1, 2]
    assert np.allclose(found[0].rings, (RING,))
