"""Zones from KML and from the fences of a plan."""

import json

import numpy as np
import pytest
from shapely.geometry import Point
from shapely.geometry import Polygon as Shape

from pathgene.host.errors import InputError
from pathgene.host.formats import kml
from pathgene.host.formats.plan import plan_document
from pathgene.host.problem.tiles import over_ground, wholes
from pathgene.host.problem.zones import Circle, Polygon, read_zones
from pathgene.host.report.track import track_of
from pathgene.host.terrain import Terrain
from tests.support.host.missions import SEEDS, flight, make_mission


HEIGHTS = np.zeros((41, 41))
HEIGHTS[:, 20:] = 80.0
TERRAIN = Terrain("step", HEIGHTS, 100.0, 100.0, "EPSG:32632", (500_000.0, 5_000_000.0))
SQUARE = ((1000.0, 1000.0), (2000.0, 1000.0), (2000.0, 2000.0), (1000.0, 2000.0))


def read(tmp_path, text, terrain=TERRAIN, name="zones.kml"):
    file = tmp_path / name
    file.write_text(text if isinstance(text, str) else json.dumps(text))
    return read_zones(file, terrain).zones


def assert_same(found, wanted):
    """Assert that two zones are equal within a centimetre."""
    assert type(found) is type(wanted)
    if isinstance(wanted, Circle):
        assert np.allclose((found.x_m, found.y_m), (wanted.x_m, wanted.y_m), atol=0.01)
        assert found.radius_m == wanted.radius_m
    else:
        assert np.allclose(found.ring, wanted.ring, atol=0.01)
        assert len(found.holes) == len(wanted.holes)
        for hole, other in zip(found.holes, wanted.holes, strict=True):
            assert np.allclose(hole, other, atol=0.01)


def test_reads_the_zones_of_our_kml(tmp_path):
    count = 0
    for seed in range(40):
        problem, path = make_mission(seed)
        if not problem.zones:
            continue
        found = read(tmp_path, kml.write(track_of(problem, path)).decode(), problem.terrain)
        for zone, wanted in zip(found, problem.zones, strict=True):
            assert_same(zone, wanted)
            assert zone.limits == wanted.limits
            count += 1
    assert count > 40


def test_reads_the_fences_of_our_plan(tmp_path):
    """The file has circles first, no names, and holes joined to their ring."""
    for seed in SEEDS:
        problem, _ = make_mission(seed)
        plan = flight(seed)
        if not plan.fence:
            continue
        found = read(tmp_path, plan_document(plan), problem.terrain, "path.plan")
        fenced = [
            zone
            for number, zone in enumerate(problem.zones, start=1)
            if not any(f"{zone.name or f'zone {number}'}:" in note for note in plan.notes)
        ]
        fenced.sort(key=lambda zone: not isinstance(zone, Circle))
        for zone, wanted in zip(found, fenced, strict=True):
            if isinstance(wanted, Circle) or not wanted.holes:
                assert_same(zone, wanted)
            else:
                area = Shape(wanted.ring, wanted.holes).area
                assert Shape(zone.ring).buffer(0).area == pytest.approx(area, rel=1e-5)


def positions(ring, *height):
    lat, lon = TERRAIN.to_geographic(*np.array((*ring, ring[0])).T)
    tail = "".join(f",{value}" for value in height)
    return " ".join(
        f"{float(east)!r},{float(north)!r}{tail}" for north, east in zip(lat, lon, strict=True)
    )


def polygon(inside, ring=SQUARE, height=(), name="R-1", data=""):
    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        '<kml xmlns="http://earth.google.com/kml/2.1"><Document><Folder><Placemark>'
        f"<name>{name}</name>{data}<Polygon>{inside}<outerBoundaryIs><LinearRing><coordinates>"
        f"{positions(ring, *height)}</coordinates></LinearRing></outerBoundaryIs></Polygon>"
        "</Placemark></Folder></Document></kml>"
    )


EXTRUDED = "<extrude>1</extrude><altitudeMode>{}</altitudeMode>"


@pytest.mark.parametrize(
    ("inside", "height", "upper"),
    [
        ("", (), None),
        ("", (300,), None),
        ("<altitudeMode>absolute</altitudeMode>", (300,), None),
        (EXTRUDED.format("absolute"), (300,), 300.0),
        (EXTRUDED.format("absolute"), (0,), None),
        (EXTRUDED.format("clampToGround"), (120,), None),
    ],
)
def test_heights_of_other_programs(tmp_path, inside, height, upper):
    (zone,) = read(tmp_path, polygon(inside, height=height))
    assert np.allclose(zone.ring, SQUARE, atol=1e-3)
    assert (zone.name, zone.lower_m, zone.upper_m) == ("R-1", None, upper)


def test_a_height_above_the_ground_follows_the_ground(tmp_path):
    """The ground is 0 m west of a step at x = 2000 m, 80 m east of it."""
    ring = ((1000.0, 1000.0), (3000.0, 1000.0), (3000.0, 2000.0), (1000.0, 2000.0))
    text = polygon(EXTRUDED.format("relativeToGround"), ring=ring, height=(120,))
    (zone,) = read(tmp_path, text)
    assert (zone.name, zone.upper_m, zone.upper_agl_m) == ("R-1", None, 120.0)
    tiles = over_ground([zone], TERRAIN)
    assert wholes(tiles) == (zone,)
    shapes = [(Shape(tile.ring), tile.upper_m) for tile in tiles]
    assert sum(shape.area for shape, _ in shapes) == pytest.approx(2e6, rel=1e-5)
    for x, least, most in ((1500, 120, 120), (1850, 120, 200), (1950, 200, 200), (2500, 200, 200)):
        (upper,) = {upper for shape, upper in shapes if shape.covers(Point(x, 1444.0))}
        assert least <= upper <= most, x


def test_extended_data_prevail(tmp_path):
    data = (
        '<ExtendedData><Data name="lower"><value>100</value></Data><SchemaData>'
        '<SimpleData name="upper">250.5</SimpleData></SchemaData></ExtendedData>'
    )
    (zone,) = read(tmp_path, polygon(EXTRUDED.format("absolute"), height=(300,), data=data))
    assert (zone.lower_m, zone.upper_m) == (100.0, 250.5)


def test_a_point_with_a_radius_is_a_circle(tmp_path):
    lat, lon = TERRAIN.to_geographic(1500.0, 1200.0)
    text = (
        "<kml><Placemark><name>mast</name><ExtendedData><Data name='radius_m'><value> 75 </value>"
        f"</Data></ExtendedData><Point><coordinates>{lon!r},{lat!r},0</coordinates></Point>"
        "</Placemark><Placemark><Point><coordinates>9,45</coordinates></Point></Placemark></kml>"
    )
    (zone,) = read(tmp_path, text)
    assert_same(zone, Circle(1500, 1200, 75))
    assert zone.name == "mast"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("<kml", "not KML: unclosed token: line 1, column 0."),
        ("<gpx/>", "not KML: its root is no kml element; it looks like GPX."),
        ("<kml/>", "there is no polygon or circle in it."),
        (
            polygon("").replace("<coordinates>9.0", "<coordinates>x"),
            'placemark 1, "R-1": \'x',
        ),
        (
            polygon(
                "",
                data="<ExtendedData><Data name='upper'><value>high</value></Data></ExtendedData>",
            ),
            "placemark 1, \"R-1\": upper must be a finite number, not 'high'.",
        ),
        (
            "<kml><Placemark><Polygon/></Placemark></kml>",
            "placemark 1: a polygon must have an outer boundary.",
        ),
    ],
)
def test_refuses_other_kml(tmp_path, text, sentence):
    with pytest.raises(InputError) as refusal:
        read(tmp_path, text)
    said = str(refusal.value)
    assert said.startswith(f"No-fly file {str(tmp_path / 'zones.kml')!r}: {sentence}")


def fence(**parts):
    """Return a plan with a fence."""
    return {"fileType": "Plan", "geoFence": {"version": 2, "circles": [], "polygons": [], **parts}}


def places(ring):
    return [list(place) for place in zip(*TERRAIN.to_geographic(*np.array(ring).T), strict=True)]


def test_a_fence_to_stay_in_is_a_zone_around_it(tmp_path):
    (centre,) = places([(3000.0, 3000.0)])
    plan = fence(
        polygons=[{"version": 1, "inclusion": True, "polygon": places(SQUARE)}],
        circles=[{"version": 1, "inclusion": True, "circle": {"center": centre, "radius": 500.0}}],
    )
    around_circle, around_square = read(tmp_path, plan, name="keep-in.plan")
    assert around_square.name == "outside of fence polygon 1"
    assert isinstance(around_square, Polygon)
    x = y = np.arange(41) * 100.0
    covered = around_square.covers(x, y)
    inside = (x > 1000) & (x < 2000)
    assert np.array_equal(covered, ~(inside[:, None] & inside[None, :]))

    # The polygon on the circle keeps a path inside the circle.
    outside = np.hypot(x[None, :] - 3000, y[:, None] - 3000) >= 500
    assert (around_circle.covers(x, y) >= outside).all()
    deep = np.hypot(x[None, :] - 3000, y[:, None] - 3000) < 499.9
    assert not around_circle.covers(x, y)[deep].any()


@pytest.mark.parametrize(
    ("plan", "sentence"),
    [
        ({"fileType": "Plan"}, "it has no geoFence of QGroundControl."),
        (fence(), "there is no fence in it."),
        (
            fence(version=1),
            "its fences are of another version than 2; save it with a newer program.",
        ),
        (
            fence(polygons=[{"polygon": [[1]], "inclusion": False}]),
            "fence polygon 1: the polygon is bad.",
        ),
        (
            fence(circles=[{"circle": {"center": [45, 9], "radius": -1}, "inclusion": False}]),
            "fence circle 1: the circle is bad.",
        ),
    ],
)
def test_refuses_bad_fences(tmp_path, plan, sentence):
    with pytest.raises(InputError) as refusal:
        read(tmp_path, plan, name="bad.plan")
    assert str(refusal.value) == f"No-fly file {str(tmp_path / 'bad.plan')!r}: {sentence}"


@pytest.mark.parametrize(
    "text",
    [polygon(""), fence(polygons=[{"inclusion": True, "polygon": [[45, 9], [45, 10], [46, 9]]}])],
)
def test_needs_a_place_on_earth(tmp_path, text):
    with pytest.raises(InputError, match=r"no coordinate reference system, so .*--origin LAT,LON"):
        read(tmp_path, text, Terrain("local", HEIGHTS, 100.0, 100.0))


def test_refuses_an_archive(tmp_path):
    file = tmp_path / "zones.zip"
    file.write_bytes(b"PK\x03\x04\xff\xfe")
    with pytest.raises(InputError, match=r"looks like a ZIP or KMZ archive; give GeoJSON, KML,"):
        read_zones(file, TERRAIN)


@pytest.mark.parametrize(
    ("data", "kind"),
    [
        (b"\x89PNG\r\n\x1a\n", "a picture"),
        (b"\x00\x00\x27\x0a" + bytes(20), "a shapefile"),
        (b"PK\x03\x04 no document", "a ZIP or KMZ archive"),
        (b"SQLite format 3\x00", "a GeoPackage"),
        (b"POLYGON ((9 45, 10 45, 9 46, 9 45))", "well-known text"),
        (b"lat,lon\n45,9\n", "a table of positions"),
        (b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n", "a drawing in DXF"),
        (b"%PDF-1.7", "a PDF"),
        (bytes(range(256)), "a binary file"),
    ],
)
def test_a_file_of_another_kind_is_refused_with_the_kind(tmp_path, data, kind):
    file = tmp_path / "zones.kml"
    file.write_bytes(data)
    with pytest.raises(InputError, match=f"looks like {kind}.*; give GeoJSON, "):
        read_zones(file, TERRAIN)
