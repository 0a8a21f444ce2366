"""Every construct of KML that carries an area or hides one, compared with fastkml and shapely."""

import math
import time

import pytest
import shapely
from fastkml import KML, Placemark
from fastkml.utils import find_all
from shapely.geometry import Polygon, shape

from pathgene.host.errors import InputError
from pathgene.host.formats import kml
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature, LeftOut, Limit, Reference


CORNERS = ((10.0, 60.0), (10.1, 60.0), (10.1, 60.1), (10.0, 60.05))
HOLE = ((10.04, 60.03), (10.06, 60.03), (10.05, 60.05))
CIRCLE = tuple(
    (10.0 + 0.02 * math.cos(math.radians(angle)), 60.0 + 0.01 * math.sin(math.radians(angle)))
    for angle in range(0, 360, 5)
)
AMSL, AGL = Reference.AMSL, Reference.AGL
HEAD = (
    '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">'
    "<Document>{}</Document></kml>"
)


def places(ring, height=None, shift=0.0, is_closed=True):
    tail = "" if height is None else f",{height}"
    corners = (*ring, ring[0]) if is_closed else ring
    return " ".join(f"{lon + shift!r},{lat!r}{tail}" for lon, lat in corners)


def side(kind, text):
    return f"<{kind}><LinearRing><coordinates>{text}</coordinates></LinearRing></{kind}>"


def polygon(inside="", height=None, holes=(), shift=0.0, ring=CORNERS):
    inner = "".join(side("innerBoundaryIs", places(hole, height, shift)) for hole in holes)
    outer = side("outerBoundaryIs", places(ring, height, shift))
    return f"<Polygon>{inside}{outer}{inner}</Polygon>"


def line(inside="", height=None, kind="LineString", is_closed=True):
    coordinates = places(CORNERS, height, is_closed=is_closed)
    return f"<{kind}>{inside}<coordinates>{coordinates}</coordinates></{kind}>"


def placemark(geometry, more=""):
    return f"<Placemark><name>R-7</name>{more}{geometry}</Placemark>"


def mode(name, extrude=1, tag="altitudeMode"):
    return f"<extrude>{extrude}</extrude><{tag}>{name}</{tag}>"


def data(**values):
    inner = "".join(
        f'<Data name="{key}"><value>{value}</value></Data>' for key, value in values.items()
    )
    return f"<ExtendedData>{inner}</ExtendedData>"


def typed(**values):
    inner = "".join(
        f'<SimpleData name="{key}">{value}</SimpleData>' for key, value in values.items()
    )
    return f'<ExtendedData><SchemaData schemaUrl="#s">{inner}</SchemaData></ExtendedData>'


SCHEMA = (
    '<Schema id="s" name="s"><SimpleField type="string" name="lowerLimit"/>'
    '<SimpleField type="string" name="upperLimit"/></Schema>'
)


def multi(*parts):
    return f"<MultiGeometry>{''.join(parts)}</MultiGeometry>"


def read(text):
    return list(kml.features(Content(text.encode() if isinstance(text, str) else text)))


def areas_of(text):
    """Return the areas of a document as fastkml and shapely have them."""
    found = []
    for each in find_all(KML.from_string(text, strict=False), of_type=Placemark):
        waiting = [shape(each.geometry)] if each.geometry is not None else []
        while waiting:
            one = waiting.pop(0)
            if hasattr(one, "geoms"):
                waiting = [*one.geoms, *waiting]
            elif one.geom_type == "Polygon":
                found.append(shapely.force_2d(one))
            elif one.geom_type in ("LineString", "LinearRing") and one.is_closed:
                found.append(Polygon(shapely.force_2d(one).coords))
    return found


# A placemark, the lower and upper limit, and the names of the parts that are not read.
READ = {
    "polygon": (placemark(polygon()), None, None, ()),
    "inner boundary": (placemark(polygon(holes=[HOLE])), None, None, ()),
    "two inner boundaries": (
        placemark(polygon(holes=[HOLE, [(lon + 0.03, lat) for lon, lat in HOLE]])),
        None,
        None,
        (),
    ),
    "circle": (
        placemark(polygon(ring=CIRCLE)),
        None,
        None,
        (),
    ),
    "ring": (placemark(line(kind="LinearRing")), None, None, ()),
    "closed path": (placemark(line()), None, None, ()),
    "closed path, extruded": (
        placemark(line(mode("absolute"), 300)),
        None,
        Limit(300, AMSL),
        (),
    ),
    "multi-geometry": (
        placemark(multi(polygon(), multi(polygon(shift=1.0), line(kind="LinearRing")))),
        None,
        None,
        (),
    ),
    "tessellate": (placemark(polygon("<tessellate>1</tessellate>")), None, None, ()),
    "heights without extrude": (placemark(polygon(mode("absolute", 0), 300)), None, None, ()),
    "absolute": (placemark(polygon(mode("absolute"), 300)), None, Limit(300, AMSL), ()),
    "relativeToGround": (
        placemark(polygon(mode("relativeToGround"), 120)),
        None,
        Limit(120, AGL),
        (),
    ),
    "clampToGround": (placemark(polygon(mode("clampToGround"), 120)), None, None, ()),
    "no mode": (placemark(polygon("<extrude>1</extrude>", 120)), None, None, ()),
    "clampToSeaFloor": (
        placemark(polygon(mode("clampToSeaFloor", 1, "gx:altitudeMode"), 120)),
        None,
        None,
        (),
    ),
    "relativeToSeaFloor": (
        placemark(polygon(mode("relativeToSeaFloor", 1, "gx:altitudeMode"), 120)),
        None,
        None,
        ("altitudeMode relativeToSeaFloor",),
    ),
    "two heights": (
        placemark(multi(polygon(mode("absolute", 0), 300), polygon(mode("absolute", 0), 900))),
        Limit(300, AMSL),
        Limit(900, AMSL),
        (),
    ),
    "two heights in two modes": (
        placemark(
            multi(polygon(mode("absolute", 0), 300), polygon(mode("relativeToGround", 0), 900))
        ),
        None,
        None,
        ("altitudeMode absolute", "altitudeMode relativeToGround"),
    ),
    "our data": (placemark(polygon(), data(lower=100, upper="none")), Limit(100, AMSL), None, ()),
    "data": (
        placemark(polygon(), data(lowerLimit="GND", upperLimit="FL 95")),
        Limit(0, AGL),
        Limit(95 * 30.48, Reference.STANDARD),
        (),
    ),
    "data of a schema": (
        SCHEMA + placemark(polygon(mode("absolute"), 300), typed(floor="500 ft AGL")),
        Limit(500 * 0.3048, AGL),
        None,
        (),
    ),
    "data that state no unit": (
        placemark(polygon(), data(upperLimit="120", purpose="x")),
        None,
        None,
        ("upperLimit",),
    ),
    "hidden": (placemark(polygon(), "<visibility>0</visibility>"), None, None, ()),
    "folders": (
        f"<Folder><visibility>0</visibility><Folder>{placemark(polygon())}</Folder></Folder>",
        None,
        None,
        (),
    ),
    "documents": (f"<Document>{placemark(polygon())}</Document>", None, None, ()),
    "time span": (
        placemark(polygon(), "<TimeSpan><begin>2026-05-01</begin></TimeSpan>"),
        None,
        None,
        ("TimeSpan",),
    ),
    "time stamp": (
        placemark(polygon(), "<TimeStamp><when>2026-05-01</when></TimeStamp>"),
        None,
        None,
        ("TimeStamp",),
    ),
    "region": (
        placemark(polygon(), "<Region><LatLonAltBox><north>61</north></LatLonAltBox></Region>"),
        None,
        None,
        ("Region",),
    ),
    "time span of a folder": (
        "<Folder><TimeSpan><begin>2026-05-01</begin></TimeSpan>"
        f"{placemark(polygon())}</Folder>",
        None,
        None,
        ("TimeSpan",),
    ),
    "styles": (
        '<Style id="s"><PolyStyle><fill>0</fill></PolyStyle></Style><StyleMap id="m"><Pair><key>'
        "normal</key><styleUrl>#s</styleUrl></Pair></StyleMap>"
        + placemark(polygon(), "<styleUrl>#m</styleUrl><description>red</description>"),
        None,
        None,
        (),
    ),
}  # fmt: skip


@pytest.mark.parametrize("row", READ.values(), ids=READ)
def test_reads_each_construct_as_fastkml_does(row):
    text, lower, upper, unread = row
    document = HEAD.format(text)
    found, areas = read(document), areas_of(document)
    assert all(isinstance(part, Feature) for part in found), found
    assert {(part.lower, part.upper, part.unread) for part in found} == {(lower, upper, unread)}
    assert {part.name for part in found} == {"R-7"}
    # Polygons of one footprint are one area.
    unique = [each for n, each in enumerate(areas) if not any(map(each.equals, areas[:n]))]
    own = [Polygon(part.rings[0], part.rings[1:]) for part in found]
    assert len(own) == len(unique)
    assert all(any(one.equals_exact(each, 1e-12) for each in unique) for one in own)


ICON = "<Icon><href>a.png</href></Icon>"
# A part that is no area, beside one: the label, a part of the reason, and the weight.
LEFT_OUT = {
    "point": (placemark("<Point><coordinates>10,60</coordinates></Point>"), "R-7", "Point", False),
    "open path": (placemark(line(is_closed=False)), "R-7", "an open path is not an area", False),
    "two open paths": (
        placemark(multi(line(is_closed=False), line(is_closed=False))),
        "R-7",
        "an open path is not an area",
        False,
    ),
    "track": (
        placemark("<gx:Track><when>2026-05-01T00:00:00Z</when><gx:coord>10 60 0</gx:coord>"
                  "</gx:Track>"),
        "R-7", "a Track is not an area", False,
    ),
    "tracks": (
        placemark("<gx:MultiTrack><gx:Track><gx:coord>1 2 3</gx:coord></gx:Track></gx:MultiTrack>"),
        "R-7", "a MultiTrack is not an area", False,
    ),
    "model": (
        placemark("<Model><Location><longitude>10</longitude><latitude>60</latitude></Location>"
                  "</Model>"),
        "R-7", "a Model is not an area", False,
    ),
    "nothing": (placemark(""), "R-7", "it has no geometry", False),
    "empty multi-geometry": (placemark(multi()), "R-7", "it has no geometry", False),
    "link": (
        "<NetworkLink><name>all</name><Link><href>all.kml</href></Link></NetworkLink>",
        "all", "linked zones are not read", True,
    ),
    "ground overlay": (
        f"<GroundOverlay><name>range</name>{ICON}<LatLonBox><north>61</north></LatLonBox>"
        "</GroundOverlay>",
        "range", "a picture on the ground is not an area", True,
    ),
    "photo overlay": (
        f"<PhotoOverlay><name>view</name>{ICON}</PhotoOverlay>", "view", "a picture", True,
    ),
    "screen overlay": (
        f"<ScreenOverlay><name>logo</name>{ICON}</ScreenOverlay>",
        "logo", "a picture on the screen is not an area", False,
    ),
    "tour": (
        "<gx:Tour><name>flight</name><gx:Playlist><gx:AnimatedUpdate><Update><targetHref/><Change>"
        '<Placemark targetId="x"><name>moved</name></Placemark></Change></Update>'
        "</gx:AnimatedUpdate></gx:Playlist></gx:Tour>",
        "flight", "a Tour is not an area", False,
    ),
}  # fmt: skip


@pytest.mark.parametrize("row", LEFT_OUT.values(), ids=LEFT_OUT)
def test_names_each_construct_that_is_no_area_once(row):
    text, name, reason, is_suspicious = row
    zone = placemark(polygon()).replace("R-7", "zone")
    parts = read(HEAD.format(text + zone))
    (left_out,) = (part for part in parts if isinstance(part, LeftOut))
    assert f'"{name}"' in left_out.label
    assert reason in left_out.reason
    assert left_out.is_suspicious is is_suspicious
    assert [part.name for part in parts if isinstance(part, Feature)] == ["zone"]
    with pytest.raises(InputError, match="there is no polygon or circle in it; "):
        read(HEAD.format(text))


def test_a_point_with_a_radius_of_another_name_is_bad():
    point = placemark("<Point><coordinates>10,60</coordinates></Point>", data(Radius=5))
    (part,) = read(HEAD.format(point))
    assert isinstance(part, Bad)
    assert part.reason.endswith("extended data \"radius_m\", not 'Radius'.")


def test_an_update_of_another_document_is_named():
    update = f"<NetworkLinkControl><Update><Create>{placemark(polygon())}</Create></Update>{{}}"
    text = HEAD.format(placemark(polygon())).replace(
        "<Document>", update.format("</NetworkLinkControl><Document>")
    )
    left_out, *zones = read(text)
    assert left_out == LeftOut("an Update", "changes of other files are not applied", True)
    assert len(zones) == 2


# Bad constructs, each with a part of the reason.
RING = places(CORNERS)
BAD = {
    "no boundary": ("<Polygon/>", "a polygon must have an outer boundary."),
    "only a hole": (f"<Polygon>{side('innerBoundaryIs', RING)}</Polygon>", "an outer boundary."),
    "two outer boundaries": (
        f"<Polygon>{side('outerBoundaryIs', RING) * 2}</Polygon>",
        "a polygon must have one outer boundary, not 2.",
    ),
    "no coordinates": (f"<Polygon>{side('outerBoundaryIs', '')}</Polygon>", "'' are no positions"),
    "words": (f"<Polygon>{side('outerBoundaryIs', 'here')}</Polygon>", "'here' are no positions"),
    "one number": (f"<Polygon>{side('outerBoundaryIs', '10 60')}</Polygon>", "are no positions"),
    "four numbers": (f"<Polygon>{side('outerBoundaryIs', '1,2,3,4')}</Polygon>", "no positions"),
    "not a number": (f"<Polygon>{side('outerBoundaryIs', 'nan,2 3,4')}</Polygon>", "no positions"),
    "no place": (
        f"<Polygon>{side('outerBoundaryIs', '10,95 11,95 11,96 10,95')}</Polygon>",
        "(10, 95) is no WGS84 longitude and latitude; latitude comes second; give degrees.",
    ),
    "a line there and back": (
        f"<Polygon>{side('outerBoundaryIs', '10,60 11,60 10,60')}</Polygon>",
        "its walls do not close around an area; draw a polygon.",
    ),
    "a bad hole": (
        f"<Polygon>{side('outerBoundaryIs', RING)}{side('innerBoundaryIs', 'x')}</Polygon>",
        "'x' are no positions",
    ),
}  # fmt: skip


@pytest.mark.parametrize("row", BAD.values(), ids=BAD)
def test_names_each_bad_construct_with_the_reason(row):
    geometry, reason = row
    zone = placemark(polygon()).replace("R-7", "zone")
    bad, good = read(HEAD.format(placemark(geometry) + zone))
    assert isinstance(bad, Bad)
    assert bad.label == 'placemark 1, "R-7"'
    assert reason in bad.reason
    assert good.name == "zone"


def test_coordinates_of_many_blanks_take_no_longer():
    began = time.process_time()
    text = RING.replace(" ", " " * 40_000)
    (found,) = read(HEAD.format(placemark(f"<Polygon>{side('outerBoundaryIs', text)}</Polygon>")))
    assert Polygon(found.rings[0]).equals(Polygon(CORNERS))
    assert time.process_time() - began < 1.0


NAMESPACES = {
    "2.0": '<kml xmlns="http://earth.google.com/kml/2.0">',
    "2.1": '<kml xmlns="http://earth.google.com/kml/2.1">',
    "2.2": '<kml xmlns="http://www.opengis.net/kml/2.2">',
    "2.3": '<kml xmlns="http://www.opengis.net/kml/2.3">',
    "Google's 2.2": '<kml xmlns="http://earth.google.com/kml/2.2">',
    "none": "<kml>",
    "prefix": '<k:kml xmlns:k="http://www.opengis.net/kml/2.2">',
    "undeclared": '<kml xmlns="http://www.opengis.net/kml/2.2" xsi:schemaLocation="a b">',
}


@pytest.mark.parametrize("head", NAMESPACES.values(), ids=NAMESPACES)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "iso-8859-1", "cp1252"])
def test_reads_each_namespace_and_encoding(head, encoding):
    height = (
        mode("absolute", 1, "gx:altitudeMode") if head == NAMESPACES["none"] else mode("absolute")
    )
    body = placemark(polygon(height, 300)).replace("R-7", "Gefängnis")
    if head == NAMESPACES["prefix"]:
        body = body.replace("</", "<\0").replace("<", "<k:").replace("<k:\0", "</k:")
    declared = {"cp1252": "windows-1252", "utf-8-sig": "utf-8"}.get(encoding, encoding)
    end = "</k:kml>" if head == NAMESPACES["prefix"] else "</kml>"
    text = f'<?xml version="1.0" encoding="{declared}"?>{head}{body}{end}'
    (found,) = read(text.encode(encoding))
    assert (found.name, found.upper) == ("Gefängnis", Limit(300, AMSL))
    assert Polygon(found.rings[0]).equals(Polygon(CORNERS))
