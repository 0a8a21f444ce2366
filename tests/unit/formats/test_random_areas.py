"""Random files of GeoJSON and KML as other programs write them, compared with other readers."""

import io
import json
import random

import geopandas
import numpy as np
import pytest
import shapely
from fastkml import KML
from fastkml.utils import find_all
from pyproj import Transformer
from shapely.geometry import MultiPolygon, Polygon, mapping, shape

from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature, LeftOut, Reference
from pathgene.host.formats.registry import FORMATS


FILES, MANY = 30, 250
NAMES = ("R-7", "Gefängnis", "prison & court", "", "zone <1>")


def read(data):
    content = Content(data)
    row = next(row for row in FORMATS if row.zones and row.module.recognises(content))
    return row.name, list(row.module.features(content))


def polygon(rng, scale=1.0):
    """Return a polygon, perhaps with a hole, both rings in either direction."""
    lon, lat = rng.uniform(-179, 179), rng.uniform(-75, 75)
    corners = rng.randint(5, 9)
    size = scale * 10 ** rng.uniform(-3, -0.5)
    angles = [2 * np.pi * (k + rng.uniform(0, 0.9)) / corners for k in range(corners)]
    ring = [(lon + size * np.cos(a), lat + size * np.sin(a)) for a in angles]
    holes = []
    if rng.random() < 0.4:
        holes = [[(lon + (e - lon) / 3, lat + (n - lat) / 3) for e, n in ring]]
    rings = [each[:: rng.choice((1, -1))] for each in (ring, *holes)]
    return Polygon(rings[0], rings[1:])


def assert_same(feature, wanted, atol=1e-9, share=1e-6):
    assert isinstance(feature, Feature), feature
    own = Polygon(feature.rings[0], feature.rings[1:])
    assert len(feature.rings) == 1 + len(wanted.interiors)
    assert shapely.hausdorff_distance(own, wanted) <= atol
    assert own.symmetric_difference(wanted).area <= share * wanted.area + 1e-15


SYSTEMS = (None, "EPSG:4258", "EPSG:4269", "EPSG:3857", "EPSG:32633", "EPSG:25832", "EPSG:2154")


def geojson(rng):
    """Return a file: polygons, multi-polygons, collections, marks and lines, in some system."""
    system = rng.choice(SYSTEMS)
    features = []
    for number in range(rng.randint(1, 6)):
        shapes = [polygon(rng) for _ in range(rng.choice((1, 1, 2)))]
        if system not in (None, "EPSG:4258", "EPSG:4269"):
            # Near Europe, where these systems are valid.
            shapes = [
                shapely.transform(
                    each,
                    lambda xy, at=(8.0 + number, 47.0 + part): at + (xy - xy.mean(axis=0)) * 0.2,
                )
                for part, each in enumerate(shapes)
            ]
            to = Transformer.from_crs(4326, system, always_xy=True)
            shapes = [
                shapely.transform(each, lambda xy, to=to: np.column_stack(to.transform(*xy.T)))
                for each in shapes
            ]
        geometry = mapping(shapes[0] if len(shapes) == 1 else MultiPolygon(shapes))
        kind = rng.randrange(5)
        if kind == 0:
            geometry = {"type": "GeometryCollection", "geometries": [geometry]}
        elif kind == 1:
            geometry = rng.choice(
                (None, {"type": "Point", "coordinates": [1, 2]},
                 {"type": "LineString", "coordinates": [[1, 2], [3, 4]]})
            )  # fmt: skip
        features.append(
            {"type": "Feature", "geometry": geometry, "properties": {"name": f"{number}"}}
        )
    document = {"type": "FeatureCollection", "features": features}
    if system is not None:
        form = rng.choice(("urn:ogc:def:crs:EPSG::{}", "EPSG:{}"))
        name = form.format(system[5:])
        document["crs"] = {"type": "name", "properties": {"name": name}}
    text = json.dumps(document, ensure_ascii=rng.random() < 0.5)
    return text.encode("utf-8-sig" if rng.random() < 0.3 else "utf-8"), document


def check_geojson(seed):
    data, document = geojson(random.Random(seed))
    name, parts = read(data)
    assert name == "geojson"
    left_out = [part for part in parts if isinstance(part, LeftOut)]
    found = [part for part in parts if not isinstance(part, LeftOut)]
    frame = geopandas.read_file(io.BytesIO(data))
    if frame.crs is not None and frame.crs.to_epsg() not in (4326, 4258, 4269):
        # Edges are straight in the system of the file.
        frame = frame.set_geometry(frame.geometry.segmentize(50.0)).to_crs(4326)
    wanted, others = [], 0
    for feature, geometry in zip(document["features"], frame.geometry, strict=True):
        geometries = [] if geometry is None else list(shapely.get_parts(geometry))
        areas = [
            part
            for each in geometries
            for part in shapely.get_parts(each)
            if part.geom_type == "Polygon"
        ]
        wanted += [(feature["properties"]["name"], each) for each in areas]
        others += not areas
    assert [part.name for part in found] == [name for name, _ in wanted], seed
    assert len(left_out) == others
    for part, (_, area) in zip(found, wanted, strict=True):
        assert_same(part, area, *(() if "crs" not in document else (3e-6, 3e-4)))


PREFIXES = (
    '<kml xmlns="http://www.opengis.net/kml/2.2">',
    '<kml xmlns="http://earth.google.com/kml/2.1">',
    '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">',
    '<kml xmlns="http://www.opengis.net/kml/2.2" '
    'xsi:schemaLocation="http://www.opengis.net/kml/2.2 ogckml22.xsd">',
    "<kml>",
)


def kml(rng):
    """Return a file, its polygons with names and heights, and whether it is strict XML."""
    separator, blank = rng.choice((" ", "\n", " \n\t")), rng.choice((",", ",", ", ", " , "))
    placemarks, wanted = [], []
    for _ in range(rng.randint(1, 5)):
        area, name = polygon(rng), rng.choice(NAMES)
        mode = rng.choice(("", "clampToGround", "absolute", "relativeToGround"))
        extrude, height = rng.random() < 0.5, rng.choice((0.0, 120.0, 1500.5))
        style = rng.choice(("Polygon", "LineString", "LinearRing", "MultiGeometry"))
        if style in ("LineString", "LinearRing"):
            area = Polygon(area.exterior)
        rings = [
            separator.join(blank.join((repr(x), repr(y), repr(height))) for x, y in ring.coords)
            for ring in (area.exterior, *area.interiors)
        ]
        head = f"<extrude>{int(extrude)}</extrude>" + (
            f"<altitudeMode>{mode}</altitudeMode>" if mode else ""
        )
        if style in ("LineString", "LinearRing"):
            inner = f"<{style}>{head}<coordinates>{rings[0]}</coordinates></{style}>"
        else:
            sides = ["outerBoundaryIs"] + ["innerBoundaryIs"] * (len(rings) - 1)
            inner = f"<Polygon>{head}" + "".join(
                f"<{side}><LinearRing><coordinates>\n{ring}\n</coordinates></LinearRing></{side}>"
                for side, ring in zip(sides, rings, strict=True)
            ) + "</Polygon>"  # fmt: skip
        if style == "MultiGeometry":
            inner = f"<MultiGeometry>{inner}</MultiGeometry>"
        escaped = name.replace("&", "&amp;").replace("<", "&lt;")
        placemarks.append(f"<Placemark><name>{escaped}</name>{inner}</Placemark>")
        references = {"absolute": Reference.AMSL, "relativeToGround": Reference.AGL}
        upper = (height, references[mode]) if extrude and height and mode in references else None
        wanted.append((name, area, upper))
    head, encoding = rng.choice(PREFIXES), rng.choice(("utf-8", "utf-16", "iso-8859-1", "cp1252"))
    declared = {"cp1252": "windows-1252"}.get(encoding, encoding)
    text = (
        f'<?xml version="1.0" encoding="{declared}"?>\n{head}<Document><Folder>'
        f"{''.join(placemarks)}</Folder></Document></kml>"
    )
    is_strict = "opengis" in head and "xsi:" not in head and blank == ","
    return text.encode(encoding), wanted, is_strict


def check_kml(seed):
    data, wanted, is_strict = kml(random.Random(seed))
    name, parts = read(data)
    assert name == "kml"
    assert [part.name for part in parts] == [name for name, _, _ in wanted], seed
    for part, (_, area, upper) in zip(parts, wanted, strict=True):
        assert_same(part, area)
        own = None if part.upper is None else (part.upper.height_m, part.upper.reference)
        assert (part.lower, own) == (None, upper), seed
    if is_strict:
        document = KML.parse(io.BytesIO(data))
        geometries = [shape(each.geometry) for each in find_all(document, of_type=_placemark())]
        areas = [
            each if each.geom_type == "Polygon" else Polygon(each.coords)
            for geometry in geometries
            for each in ([geometry] if not hasattr(geometry, "geoms") else geometry.geoms)
        ]
        for part, area in zip(parts, areas, strict=True):
            assert_same(part, shapely.force_2d(area))


def _placemark():
    from fastkml import Placemark

    return Placemark


@pytest.mark.parametrize("seed", range(FILES))
@pytest.mark.parametrize("check", [check_geojson, check_kml])
def test_reads_random_files_as_other_readers_do(check, seed):
    check(seed)


@pytest.mark.long
@pytest.mark.parametrize("check", [check_geojson, check_kml])
def test_reads_many_random_files_as_other_readers_do(check):
    for seed in range(FILES, MANY):
        check(seed)


BOMB = (
    '<?xml version="1.0"?><!DOCTYPE kml [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    "<kml><Placemark><name>&b;</name></Placemark></kml>"
)
FOREIGN = (
    '<?xml version="1.0"?><!DOCTYPE kml [<!ENTITY a SYSTEM "file:///etc/hostname">]>'
    "<kml><Placemark><name>&a;</name></Placemark></kml>"
)


@pytest.mark.parametrize("text", [BOMB, FOREIGN])
def test_entities_are_refused(text):
    content = Content(text.encode())
    assert content.xml is None
    assert content.xml_error.startswith("it declares entities")


WALL = (
    "<Polygon><altitudeMode>{}</altitudeMode><outerBoundaryIs><LinearRing><coordinates>{}"
    "</coordinates></LinearRing></outerBoundaryIs></Polygon>"
)


@pytest.mark.parametrize("mode", ["absolute", "relativeToGround"])
@pytest.mark.parametrize("drawn", ["lid", "bottom", "lid bottom walls", "walls", "lid bottom"])
def test_a_prism_is_one_area_between_two_heights(mode, drawn):
    corners = [(10.0, 60.0), (10.1, 60.0), (10.15, 60.05), (10.0, 60.1)]
    flat = {
        "lid": [[(x, y, 2900) for x, y in (*corners, corners[0])]],
        "bottom": [[(x, y, 1400) for x, y in (*corners[::-1], corners[-1])]],
        "walls": [
            [(*a, 1400), (*b, 1400), (*b, 2900), (*a, 2900), (*a, 1400)]
            for a, b in zip(corners, (*corners[1:], corners[0]), strict=True)
        ],
    }
    inner = "".join(
        WALL.format(mode, " ".join(",".join(map(repr, point)) for point in ring))
        for part in drawn.split()
        for ring in flat[part]
    )
    text = f"<kml><Placemark><MultiGeometry>{inner}</MultiGeometry></Placemark></kml>"
    (part,) = read(text.encode())[1]
    assert_same(part, Polygon(corners))
    reference = {"absolute": Reference.AMSL, "relativeToGround": Reference.AGL}[mode]
    limits = [limit and (limit.height_m, limit.reference) for limit in (part.lower, part.upper)]
    # A single sheet gives no information about the space above or below it.
    is_sheet = drawn in ("lid", "bottom")
    assert limits == ([None, None] if is_sheet else [(1400, reference), (2900, reference)])


def prism(west, places, low, high):
    """Return the walls of a square prism, and the square."""
    corners = [(west, 60.0), (west + 0.1, 60.0), (west + 0.1, 60.1), (west, 60.1)]
    walls = [
        [(*a, low), (*b, low), (*b, high), (*a, high), (*a, low)]
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True)
    ]
    return [walls[place] for place in places], Polygon(corners)


def drawn_in_one_placemark(rings):
    inner = "".join(
        WALL.format("absolute", " ".join(",".join(map(repr, point)) for point in ring))
        for ring in rings
    )
    text = (
        f"<kml><Placemark><name>R-7</name><MultiGeometry>{inner}</MultiGeometry></Placemark></kml>"
    )
    return read(text.encode())[1]


def test_walls_next_to_another_polygon_are_an_area():
    walls, square = prism(10.0, range(4), 1400, 2900)
    flat = [(12.0, 60.0, 0), (12.1, 60.0, 0), (12.1, 60.1, 0), (12.0, 60.0, 0)]
    sheet, own = drawn_in_one_placemark([flat, *walls])
    assert_same(sheet, Polygon([place[:2] for place in flat]))
    assert_same(own, square)
    assert (own.lower.height_m, own.upper.height_m) == (1400, 2900)


def test_walls_around_no_area_are_bad_and_named():
    walls, _ = prism(10.0, (0, 1, 2), 1400, 2900)
    (part,) = drawn_in_one_placemark(walls)
    assert isinstance(part, Bad)
    assert part.label == 'placemark 1, "R-7"'
    assert "walls do not close" in part.reason


@pytest.mark.parametrize("encoding", ["utf-16", "UTF-16LE", "utf-32", "ISO-10646-UCS-2"])
def test_a_declaration_in_single_bytes_is_not_utf_16(encoding):
    for blank in ("", " ", "  ", "   "):
        text = f'<?xml version="1.0" encoding="{encoding}"?>{blank}<kml><name>Zürich</name></kml>'
        assert Content(text.encode()).xml.find("name").text == "Zürich"
