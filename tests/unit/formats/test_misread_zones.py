"""Zone files that are plausible and were once read in another sense without a word."""

import json

import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats import geojson, kml, plan
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, LeftOut, Limit, Reference
from pathgene.host.formats.registry import read_features


RING = [[9.0, 45.0], [9.01, 45.0], [9.01, 45.01], [9.0, 45.0]]


def document(properties, geometry=None):
    geometry = geometry or {"type": "Polygon", "coordinates": [RING]}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def reads(value, reader=geojson):
    text = value if isinstance(value, str) else json.dumps(value)
    return list(reader.features(Content(text.encode())))


def placemark(properties):
    data = "".join(
        f'<Data name="{name}"><value>{value}</value></Data>' for name, value in properties.items()
    )
    corners = " ".join(f"{lon},{lat}" for lon, lat in RING)
    return (
        f"<kml><Placemark><ExtendedData>{data}</ExtendedData><Polygon><outerBoundaryIs><LinearRing>"
        f"<coordinates>{corners}</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>"
        "</kml>"
    )


def both(properties):
    """Return the features of the same properties in GeoJSON and in KML."""
    return [*reads(document(properties)), *reads(placemark(properties), kml)]


def amsl(metres):
    return Limit(metres, Reference.AMSL)


def agl(metres):
    return Limit(metres, Reference.AGL)


@pytest.mark.parametrize(
    ("properties", "lower", "upper", "notes"),
    [
        (
            {"lower": 400, "upper": 3000, "unit": "ft"},
            amsl(121.92),
            amsl(914.4),
            ["limits without a reference are above sea level"],
        ),
        (
            {"lower": 0, "upper": 120.125, "reference": "AGL", "unit": "m"},
            agl(0),
            agl(120.125),
            [],
        ),
        ({"upper": 400, "upper_uom": "FT", "Upper_Ref": "SFC"}, None, agl(121.92), []),
        ({"upper": 400, "datum": "agl"}, None, agl(400), ["limits without a unit are metres"]),
        ({"upper": 95, "unit": "FL"}, None, Limit(2895.6, Reference.STANDARD), []),
        ({"upper": 95, "reference": "FL"}, None, Limit(2895.6, Reference.STANDARD), []),
        ({"upper": 50, "reference": "HAE", "uom": "m"}, None, Limit(50, Reference.WGS84), []),
        (
            {"lower": 1, "upper": 2, "unit": "m", "lowerReference": "AGL", "refUpper": "MSL"},
            agl(1),
            amsl(2),
            [],
        ),
        (
            {"lower": "GND", "upper": "400 ft", "unit": "ft", "ref": "AGL"},
            agl(0),
            agl(121.92),
            ["lower 'GND' is read as the ground below the zone"],
        ),
        (
            {"lower": "0", "upper": " 600 "},
            amsl(0),
            amsl(600),
            ["limits without a unit or reference are metres above sea level"],
        ),
        ({"upper": "120 m AGL"}, None, agl(120), []),
        ({"upper": "", "unit": "ft"}, None, None, []),
    ],
)
def test_unit_and_reference_beside_a_limit_are_read(properties, lower, upper, notes):
    for feature in both(properties):
        for found, wanted in ((feature.lower, lower), (feature.upper, upper)):
            if wanted is None:
                assert found is None
            else:
                assert found.reference is wanted.reference
                assert found.height_m == pytest.approx(wanted.height_m)
        assert [remark.text for remark in feature.remarks] == notes
        assert feature.unread == ()


@pytest.mark.parametrize(
    ("properties", "reason"),
    [
        (
            {"upper": 400, "unit": "yards"},
            " with unit 'yards' is no height; give m, ft or FL, and AMSL, AGL or WGS84.",
        ),
        (
            {"upper": 120, "reference": "QFE"},
            " with reference 'QFE' is no height; give m, ft or FL, and AMSL, AGL or WGS84.",
        ),
        (
            {"upper": "400 ft AMSL", "reference": "AGL"},
            "its upper '400 ft AMSL' with reference 'AGL' is no height; give m, ft or FL, and "
            "AMSL, AGL or WGS84.",
        ),
        ({"upper": 120, "unit": "m", "uom": "ft"}, "unit and uom contradict each other."),
        (
            {"upper": "2000 ft"},
            "upper '2000 ft' has no reference; add AMSL or AGL: '2000 ft AMSL'.",
        ),
    ],
)
def test_unknown_unit_or_reference_makes_a_zone_bad(properties, reason):
    for part in both(properties):
        assert isinstance(part, Bad)
        assert part.reason.endswith(reason)


def test_table_columns_of_text_are_numbers():
    point = {"type": "Point", "coordinates": [9.0, 45.0]}
    (circle,) = reads(document({"radius_m": "250", "t0": "5"}, point))
    assert (circle.radius_m, circle.t0_s) == (250.0, 5.0)


@pytest.mark.parametrize("data", [b"", b" \n\t\r\n", b"\xef\xbb\xbf", b"\xff\xfe", b"\x1e\n"])
@pytest.mark.parametrize("name", ["zones.geojson", "zones.kml", "zones.txt", "zones"])
def test_refuses_an_empty_file(tmp_path, data, name):
    file = tmp_path / name
    file.write_bytes(data)
    with pytest.raises(InputError, match=r"^No-fly file .* is empty; give GeoJSON, "):
        read_features(file)


def fences(inclusion):
    fence = {"version": 1, "polygon": [[45.0, 9.0], [45.0, 9.1], [45.1, 9.1]]} | inclusion
    geofence = {"version": 2, "circles": [], "polygons": [fence]}
    return reads({"fileType": "Plan", "geoFence": geofence}, plan)


@pytest.mark.parametrize(
    ("value", "keeps_in"), [(True, True), (1, True), (False, False), (0, False)]
)
def test_inclusion_of_a_fence_is_true_or_false(value, keeps_in):
    (fence,) = fences({"inclusion": value})
    assert fence.keeps_in is keeps_in


@pytest.mark.parametrize(
    ("inclusion", "why"),
    [
        ({"inclusion": "false"}, "\"inclusion\" of a fence must be true or false, not 'false'"),
        ({"inclusion": 2}, '"inclusion" of a fence must be true or false, not 2'),
        ({"inclusion": None}, '"inclusion" of a fence must be true or false, not None'),
        ({}, 'a fence has no member "inclusion"; give true (stay in) or false'),
    ],
)
def test_other_inclusions_make_a_fence_bad(inclusion, why):
    assert fences(inclusion) == [Bad("fence polygon 1", f"the polygon is bad ({why}).")]


CLASS = "its class 'D' is not read, and it forbids flight"
DESCRIPTION = "its description names limits of height and is not read"


def described(text, properties=()):
    """Return the remarks on a zone with a description, in GeoJSON and in KML."""
    found = reads(document({"name": "R-7", "description": text, **dict(properties)}))
    shown = f"<Placemark><description><![CDATA[{text}]]></description>"
    found += reads(placemark(dict(properties)).replace("<Placemark>", shown), kml)
    return [[remark.text for remark in each.remarks] for each in found]


@pytest.mark.parametrize(
    "text",
    [
        "<td>Upper limit</td><td>400 ft</td>",
        "Lower Altitude: 120",
        "from ground to FL 95",
        "SFC - FL095, class D",
        "up to 4500 ft AMSL",
        "1500ft MSL",
        "120 AGL",
        "Ceiling: 400",
    ],
)
def test_limits_in_a_description_are_a_note(text):
    assert described(text) == [[DESCRIPTION]] * 2


@pytest.mark.parametrize(
    "text", ["", "a park", "upper lake", "Gainesville, FL 32601", "MSL", "no upper limit", "12 m"]
)
def test_other_descriptions_are_no_note(text):
    assert described(text) == [[]] * 2


@pytest.mark.parametrize("key", ["class", "Class", "airspace_class", "icaoClass"])
def test_a_class_of_plain_files_is_a_note(key):
    note = CLASS.replace("class", key, 1)
    assert described("", {key: "D"}) == [[note]] * 2
    assert described("to FL 95", {key: "D"}) == [[note, DESCRIPTION]] * 2
    assert described("", {"classification": "D", f"{key}_of": "D"}) == [[]] * 2


PLACES = [[9.0, 45.0], [9.1, 45.1]]


def test_each_point_of_a_multi_point_with_a_radius_is_a_circle():
    circles = reads(document({"radius_m": 250}, {"type": "MultiPoint", "coordinates": PLACES}))
    assert [circle.rings for circle in circles] == [(((9.0, 45.0),),), (((9.1, 45.1),),)]
    assert [circle.radius_m for circle in circles] == [250.0, 250.0]


SIDES = [[RING[0], RING[1]], [RING[1], RING[2]], [RING[0], RING[2]]]


@pytest.mark.parametrize(
    ("geometry", "properties", "reason"),
    [
        ({"type": "Point", "coordinates": PLACES[0]}, {"radius": 500}, "the radius of a circle is"),
        ({"type": "MultiPoint", "coordinates": PLACES}, {"Radius_km": 1}, "the radius of a circle"),
        ({"type": "LineString", "coordinates": RING}, {}, "a closed LineString is not an area; "),
        ({"type": "MultiLineString", "coordinates": [RING]}, {}, "a closed MultiLineString is not"),
        ({"type": "MultiLineString", "coordinates": SIDES}, {}, "a closed MultiLineString is not"),
    ],
)
def test_a_part_that_may_forbid_flight_is_bad(geometry, properties, reason):
    (part,) = reads(document(properties, geometry))
    assert isinstance(part, Bad)
    assert part.reason.startswith(reason)


@pytest.mark.parametrize("key", ["buffer", "buffer_m", "radius", "Width_NM", "corridorWidth"])
def test_a_corridor_is_a_warning(key):
    line = {"type": "LineString", "coordinates": RING[:3]}
    (part,) = reads(document({"stroke-width": 2, key: 300}, line))
    reason = f"a LineString is not an area, also with {key!r}; draw its corridor as a polygon"
    assert part == LeftOut("feature 1", reason, True)
    (part,) = reads(document({"stroke-width": 2, "widthUnits": 1}, line))
    assert not part.is_suspicious


def test_open_lines_and_plain_points_are_left_out():
    for kind, places in (
        ("MultiLineString", SIDES[:2]),
        ("LineString", RING[:3]),
        ("Point", PLACES[0]),
    ):
        (part,) = reads(document({}, {"type": kind, "coordinates": places}))
        assert isinstance(part, LeftOut)


@pytest.mark.parametrize(
    "properties",
    [
        {"inclusion": "true"},
        {"type": "inclusion"},
        {"fence": "keep-in"},
        {"kind": "Inclusive zone"},
    ],
)
def test_an_area_to_stay_in_is_no_zone(properties):
    for value, reader in ((document(properties), geojson), (placemark(properties), kml)):
        (part,) = reads(value, reader)
        assert isinstance(part, Bad)
        key, stated = next(iter(properties.items()))
        assert part.reason.startswith(f"its {key} {stated!r} asks to stay inside, but a zone")
    for silent in ({"inclusion": "false"}, {"name": "inclusion"}, {"type": "exclusion"}):
        for value, reader in ((document(silent), geojson), (placemark(silent), kml)):
            (part,) = reads(value, reader)
            assert not isinstance(part, Bad)


def test_a_radius_of_a_polygon_is_not_read():
    (found,) = reads(document({"radius_m": 500}))
    assert (found.unread, found.radius_m) == (("radius_m",), None)
