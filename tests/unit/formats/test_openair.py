"""OpenAir: records, places, outlines, activations, and each fault with its reason."""

from datetime import UTC, datetime

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats import openair
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Edges, LeftOut, Limit, Period, Reference
from pathgene.host.formats.registry import read_features
from pathgene.host.problem.zones import read_zones
from pathgene.host.terrain import Terrain


HEAD = ("AC R", "AN R-7", "AL GND", "AH FL 65")
CORNERS = ("DP 60:00:00 N 010:00:00 E", "DP 60:00:00 N 010:06:00 E", "DP 60:06:00 N 010:06:00 E")
RING = ((10.0, 60.0), (10.1, 60.0), (10.1, 60.1))


def content(*lines):
    return Content("\n".join(lines).encode())


def read(*lines):
    file = content(*lines)
    assert openair.recognises(file)
    return list(openair.features(file))


def test_reads_an_airspace():
    (found,) = read("* a comment", *HEAD, *CORNERS, CORNERS[0])
    assert np.allclose(found.rings, (RING,))
    assert (found.label, found.category, found.forbids) == ('airspace 1, "R-7"', "RESTRICTED", True)
    assert (found.lower, found.upper) == (
        Limit(0, Reference.AGL),
        Limit(65 * 30.48, Reference.STANDARD),
    )


@pytest.mark.parametrize(
    "place",
    [
        "60:01:30 N 010:03:00 E",
        "60:01:30N 010:03:00E",
        "60:01:30N010:03:00E",
        "60:01.5 N 010:03.0 E",
        "60.025 N 10.05 E",
        "N60:01:30 E010:03:00",
        "60:01:30 n, 10:3:0 e",
        "60:01:30.00 N   010:03:00.00 E  * here",
        "60:01:30.0N\t010:02:60 E",
    ],
)
def test_reads_places_in_any_spelling(place):
    (found,) = read(*HEAD, f"V X={place}", "DC 1.5")
    assert np.allclose(found.rings[0][0], (10.05, 60.025), rtol=0, atol=1e-12)
    assert found.radius_m == 1.5 * 1852


def test_reads_the_southern_and_western_hemispheres():
    (found,) = read(*HEAD, "V X=33:30:00 S 070:15:00 W", "DC 5 nm")
    assert found.rings[0][0] == (-70.25, -33.5)


def test_reads_records_in_lower_case_and_of_all_line_endings():
    for ending in ("\r\n", "\r", "\n"):
        text = ending.join(line.lower() for line in (*HEAD, *CORNERS))
        (found,) = openair.features(Content(text.encode()))
        assert np.allclose(found.rings, (RING,))


@pytest.mark.parametrize("ending", ["\r\n", "\r", "\n"])
@pytest.mark.parametrize("head", ["", "* made by hand"])
def test_recognises_all_line_endings(tmp_path, ending, head):
    file = tmp_path / "zones.txt"
    file.write_bytes(ending.join((head, *HEAD, *CORNERS)).encode())
    name, items = read_features(file)
    assert name == "OpenAir"
    assert [each.name for each in items] == ["R-7"]


def test_recognises_places_that_begin_with_the_hemisphere():
    content = Content(b"AC R\nDP N600000 E0100000\nDP N600000 E0100600\nDP N600600 E0100600\n")
    assert openair.recognises(content)


@pytest.mark.parametrize("empty", ["AC", "AC ", "AC * no class"])
def test_an_empty_class_is_bad(empty):
    bad, good = read(empty, "AN x", *CORNERS, *HEAD, *CORNERS)
    assert bad == Bad('airspace 1, "x"', "line 1: it has no AC with a class, such as AC D.")
    assert good.category == "RESTRICTED"
    (alone,) = read(empty, *CORNERS)
    assert isinstance(alone, Bad)


def test_an_outline_before_the_first_class_is_bad():
    reason = "the outline has no AC with a class, such as AC D, before its DP."
    assert Bad("line 3", reason) in read("AN x", "AL GND", *CORNERS)
    assert Bad("line 2", reason) in read("AN x", *CORNERS, *HEAD, *CORNERS)


def test_refuses_airspace_without_a_class_or_an_outline(tmp_path):
    file = tmp_path / "zones.txt"
    file.write_text("\n".join(("AN x", *CORNERS)))
    terrain = Terrain("flat", np.zeros((9, 9)), 100.0, 100.0, "EPSG:32632", (5e5, 5e6))
    with pytest.raises(InputError, match="line 2: the outline has no AC with a class"):
        read_zones(file, terrain)
    file.write_text("AC D\rAN x")
    with pytest.raises(InputError, match="looks like OpenAir without an outline"):
        read_zones(file, terrain)


def test_reads_the_names_of_old_and_new_encodings():
    for encoding in ("utf-8", "utf-8-sig", "cp1252"):
        text = "\n".join((*HEAD, *CORNERS)).replace("R-7", "Zürich – Süd…")
        (found,) = openair.features(Content(text.encode(encoding)))
        assert found.name == "Zürich – Süd…"


def test_the_type_of_version_2_decides():
    lines = ("AC E", "AY RMZ", "AN x", "AI 5-6", "AF 123.500", "AG Radio", "AX 7000", "TP 7000")
    (found,) = read(*lines, *CORNERS)
    assert (found.category, found.forbids) == ("RMZ", True)
    (found,) = read("AC D", "AY NONE", *CORNERS)
    assert (found.category, found.forbids) == ("D", True)
    (found,) = read("AC UNC", "AY GSEC", *CORNERS)
    assert (found.category, found.forbids) == ("GLIDING", False)


@pytest.mark.parametrize(
    ("lines", "category", "airspace_class", "forbids"),
    [
        (("AC D", "AY FIS"), "FIS", "D", True),
        (("AC C", "AY VFRSEC"), "VFR", "C", True),
        (("AC C", "AY ACCSEC"), "ACC", "C", True),
        (("AC R", "AY GSEC"), "GLIDING", "RESTRICTED", True),
        (("AC XYZ", "AY FIS"), "FIS", "XYZ", True),
        (("AC E", "AY FIS"), "FIS", "E", False),
        (("AC E", "AY TMZ"), "TMZ", "E", True),
        (("AC CTR", "AY CTR"), "CTR", "", True),
    ],
)
def test_a_type_that_informs_does_not_open_a_class_that_forbids(
    lines, category, airspace_class, forbids
):
    (found,) = read(*lines, *CORNERS)
    assert (found.category, found.airspace_class) == (category, airspace_class)
    assert found.forbids is forbids


def test_a_second_type_does_not_open_the_first():
    (bad,) = read("AC E", "AY RMZ", "AY FIS", *CORNERS)
    assert bad == Bad("airspace 1", "line 3: a second AY contradicts 'RMZ'.")
    (found,) = read("AC E", "AY RMZ", "AY rmz", *CORNERS)
    assert found.forbids


def test_a_class_that_nobody_knows_forbids_and_is_named_with_its_first_line():
    area = ("AN one", *CORNERS)
    found = read("AC XYZ", *area, "AC D", "AY ODD", *area, "AC XYZ", *area, "AC E", *area)
    assert [each.category for each in found] == ["XYZ", "ODD", "XYZ", "E"]
    assert [each.forbids for each in found] == [True, True, True, False]
    about = "is no type or class that is known, so it forbids flight; correct the file if the area"
    texts = [[remark.text for remark in each.remarks] for each in found]
    assert texts == [
        [f"XYZ (line 1) {about} is open to flight"],
        [f"ODD (line {len(area) + 3}) {about} is open to flight"],
        [f"XYZ (line 1) {about} is open to flight"],
        [],
    ]


def test_limits_that_say_no_height_are_named_and_none():
    (found,) = read("AC R", "AL see AIP", "AH 1000ft AGL / FL65", *CORNERS)
    assert (found.lower, found.upper) == (None, None)
    assert found.unread == ("AL see AIP", "AH 1000ft AGL / FL65")
    (found,) = read("AC R", *CORNERS)
    assert (found.lower, found.upper, found.unread) == (None, None, ())


def test_reads_activations():
    moments = ("2026-05-01T06:00Z", "2026-05-02T24:00Z")
    (found,) = read(*HEAD, f"AA {'/'.join(moments)}", f"AA {moments[0]}/NONE ; later", *CORNERS)
    start, end = datetime(2026, 5, 1, 6, tzinfo=UTC), datetime(2026, 5, 3, tzinfo=UTC)
    assert found.periods == (Period(start, end), Period(start))


def test_an_airspace_that_a_notam_activates_is_always_active_and_says_so():
    (found,) = read(*HEAD, "AA 2026-05-01T06:00Z/NONE", "AA NONE", *CORNERS)
    assert (found.periods, found.unread) == ((), ("AA NONE",))


def test_an_airway_is_its_segments_and_their_ends():
    places = (line.replace("DP", "DY") for line in CORNERS)
    found = read(*HEAD, "V W=2", *places)
    assert [each.radius_m for each in found] == [1852, 1852, None, 1852, None]
    assert {each.edges for each in found if each.radius_m is None} == {Edges.GEODESIC}
    assert {each.number for each in found} == {1}


def test_the_direction_of_arcs_begins_anew_with_each_airspace_and_the_centre_stays():
    arc = ("DA 5,10,100", "DP 60:00:00 N 010:00:00 E")
    first, second = read(
        *HEAD, "V X=60:00:00 N 010:00:00 E", "V D=-", *arc, *HEAD, "DA 5,10,100", arc[1]
    )
    # Counter-clockwise from 10 to 100 degrees is the long way.
    assert len(first.rings[0]) > 2 * len(second.rings[0])


def test_a_label_of_terrain_before_the_outline_leaves_the_airspace_whole():
    (found,) = read(*HEAD, "TO name", "TC name", "V Z=100", *CORNERS)
    assert np.allclose(found.rings, (RING,))


def test_ends_of_arcs_are_no_corners_of_their_own():
    north, east = "60:05:00 N 010:00:00 E", "60:00:00 N 010:10:00 E"
    centre = "60:00:00 N 010:00:00 E"
    (found,) = read(
        *HEAD, f"DP {north}", f"V X={centre}", f"DB {north}, {east}", f"DP {east}", f"DP {north}"
    )
    ring = np.array((*found.rings[0], found.rings[0][0]))
    assert np.hypot(*np.diff(ring, axis=0).T).min() > 1e-6


def test_reads_across_the_antimeridian():
    (found,) = read(*HEAD, "V X=10:00:00 N 179:59:00 E", "DA 10,0,359", "DP 10:00:00 N 179:59:00 W")
    longitudes = np.array(found.rings[0])[:, 0]
    assert longitudes.max() - longitudes.min() < 1


def test_leaves_out_terrain_and_names_unknown_records():
    found = read(
        "AN 1", "TO Lake", CORNERS[0], *HEAD, "ZZ 5", "ZZ 6", *CORNERS, "TC Town", *CORNERS
    )
    areas = [part for part in found if not isinstance(part, LeftOut)]
    assert len(areas) == 1
    assert [part for part in found if isinstance(part, LeftOut)] == [
        LeftOut("line 2", "the terrain 'Lake' is no airspace"),
        LeftOut("line 13", "the terrain 'Town' is no airspace"),
        LeftOut("line 1", "the record AN before the first AC is not known"),
        LeftOut("line 8", "the record ZZ is not known"),
    ]


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ((), "it has no outline (line 1)."),
        (CORNERS[:2], "its outline has fewer than three corners."),
        (("DP here",), "line 5: 'here' is no place, such as 60:01:30 N 010:03:00 E."),
        (("DP 60:01:30 N 010:03:00",), "line 5: '60:01:30 N 010:03:00' is no place"),
        (("DP 60:75:00 N 010:03:00 E",), "has more than 60 minutes or seconds."),
        (("DP 95:00:00 N 010:03:00 E",), "is no place on Earth."),
        (("DC 5",), "line 5: DC has no centre before it (V X=)."),
        (("V X=60:00:00 N 010:00:00 E", "DC wide"), "line 6: 'wide' is no number."),
        (("V X=60:00:00 N 010:00:00 E", "DC 0"), "line 6: '0' is no radius in nautical miles."),
        (("V X=60:00:00 N 010:00:00 E", "DA 5,10"), "DA '5,10' is no radius, start and end."),
        (
            ("V X=60:00:00 N 010:00:00 E", "DB 60:00:00 N 010:00:00 E, 60:01:00 N 010:00:00 E"),
            "an end of the arc lies at its centre.",
        ),
        (("V Q=5",), "line 5: 'V Q=5' is no variable of OpenAir."),
        (("V D=left",), "line 5: 'V D=left' is no variable of OpenAir."),
        (("DQ 5",), "line 5: the outline has an unknown record DQ."),
        ((*CORNERS, "AL FL 5"), "line 8: a second AL contradicts 'GND'."),
        (("DY 60:00:00 N 010:00:00 E",), "its airway has no width before it (V W=)."),
        ((*CORNERS, "AA today"), "AA 'today' is no interval START/END."),
        ((*CORNERS, "AA today/NONE"), "'today' is no date and time, such as 2026-05-01T06:00:00Z."),
        (
            (*CORNERS, "AA 2026-05-02T06:00Z/2026-05-01T06:00Z"),
            "AA '2026-05-02T06:00Z/2026-05-01T06:00Z' ends before its start.",
        ),
    ],
)
def test_names_a_bad_airspace_and_reads_the_others(lines, reason):
    first, second = read(*HEAD, *lines, "AC Q", "AN Q-1", *CORNERS)
    assert isinstance(first, Bad)
    assert first.label == 'airspace 1, "R-7"'
    assert reason in first.reason
    assert first.reason.endswith((".", "E."))
    assert (second.number, second.name) == (2, "Q-1")


def test_takes_no_other_text():
    for text in ("AC R", "hello", '{"AC R": 1}', "<kml>\nAC R\nDP 60:00 N 10:00 E</kml>"):
        assert not openair.recognises(Content(text.encode()))
