"""No-fly zones: exact rasters, GeoJSON, and their form in a summary."""

import json
import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rasterio.warp import transform

from pathgene.host.errors import InputError
from pathgene.host.problem.zones import Circle, Polygon, Zone, raster, read_zones, zone_from_dict
from pathgene.host.terrain import Terrain


SQUARE = ((100.0, 100.0), (300.0, 100.0), (300.0, 300.0), (100.0, 300.0))


def terrain(shape=(9, 12), dx_m=50.0, dy_m=50.0, crs=None, origin=(0.0, 0.0)):
    return Terrain(
        name="world", elevation=np.zeros(shape), dx_m=dx_m, dy_m=dy_m, crs=crs, origin=origin
    )


def nodes(zone, where=None):
    """Return the nodes in a zone as a set of (column, row)."""
    rows, columns = np.nonzero(raster([zone], terrain() if where is None else where))
    return set(zip(columns.tolist(), rows.tolist(), strict=True))


def test_makers_of_zones(tmp_path):
    assert Zone.circle(1, 2, 3) == Circle(1, 2, 3)
    hole = ((150, 150), (200, 150), (200, 200))
    made = Zone.polygon(np.array(SQUARE).tolist(), [hole])
    assert made == Polygon(SQUARE, (hole,))
    file = tmp_path / "zones.geojson"
    file.write_text(
        '{"type": "Polygon", "crs_local": true, "coordinates": '
        f"[{json.dumps(SQUARE)}, {json.dumps(hole)}]}}"
    )
    assert Zone.read(file, terrain()) == (made,)
    assert all(isinstance(zone, Zone) for zone in (made, Zone.circle(1, 2, 3)))
    # Drawn twice, its ground would be open by the even-odd rule.
    assert Zone.polygon([*SQUARE, SQUARE[0], *SQUARE, SQUARE[0]], [hole]) == made
    with pytest.raises(InputError, match=r"^No-fly polygon: a ring must have at least 3 corners"):
        Zone.polygon([(0, 0), (1, 1)])


def test_circle_holds_the_nodes_on_its_border():
    # 3-4-5: the nodes at (150, 200) from the axis are exactly on it.
    inside = nodes(Circle(200, 200, 250))
    assert {(7, 8), (8, 7), (9, 4), (1, 0)} <= inside
    assert inside == {
        (i, j)
        for i in range(12)
        for j in range(9)
        if (50 * i - 200) ** 2 + (50 * j - 200) ** 2 <= 250**2
    }
    assert (9, 4) not in nodes(Circle(200, 200, 249.999))


def test_circle_of_radius_0_is_a_node_or_nothing():
    assert nodes(Circle(100, 150, 0)) == {(2, 3)}
    assert nodes(Circle(101, 150, 0)) == set()


def test_zones_may_extend_beyond_the_map():
    assert nodes(Circle(-100, 0, 150)) == {(0, 0), (1, 0), (0, 1), (0, 2)}
    assert nodes(Circle(-5000, 0, 150)) == set()
    assert nodes(Polygon(((-500, -500), (75, -500), (75, 75), (-500, 75)))) == {
        (0, 0),
        (1, 0),
        (0, 1),
        (1, 1),
    }


def test_polygon_holds_its_edges_and_corners():
    assert nodes(Polygon(SQUARE)) == {(i, j) for i in range(2, 7) for j in range(2, 7)}
    assert nodes(Polygon(SQUARE[::-1])) == nodes(Polygon((*SQUARE, SQUARE[0])))


def test_hole_is_open_and_its_border_closed():
    hole = ((150, 150), (250, 150), (250, 250), (150, 250))
    assert nodes(Polygon(SQUARE, (hole,))) == nodes(Polygon(SQUARE)) - {(4, 4)}


def test_border_survives_rounding():
    # Corners typed as decimals, nodes as products: 9 * 74.35 is not the double nearest to 669.15.
    grid = terrain((40, 40), 74.35, 30.87)
    for k in range(1, 30):
        east, north = float(f"{k * 74.35:.2f}"), float(f"{k * 30.87:.2f}")
        ring = ((0.0, 0.0), (east, 0.0), (east, north), (0.0, north))
        assert nodes(Polygon(ring), grid) == {(i, j) for i in range(k + 1) for j in range(k + 1)}


def exactly_inside(ring, x, y):
    """Return whether a point is inside by the even-odd rule in rationals; edges are inside."""
    inside = False
    for (xa, ya), (xb, yb) in pairwise((*ring, ring[0])):
        if (
            (xb - xa) * (y - ya) == (yb - ya) * (x - xa)
            and min(xa, xb) <= x <= max(xa, xb)
            and min(ya, yb) <= y <= max(ya, yb)
        ):
            return True
        if (ya <= y) != (yb <= y) and x < xa + Fraction(y - ya) * (xb - xa) / (yb - ya):
            inside = not inside
    return inside


whole = st.integers(-3, 14)


@given(st.lists(st.tuples(whole, whole), min_size=3, max_size=8))
def test_polygons_match_exact_arithmetic(corners):
    # On a grid of 1 m and corners on nodes, edges meet many nodes exactly; rings may cross.
    if len(corners) == 3 and corners[0] == corners[-1]:
        return
    expected = {(i, j) for i in range(12) for j in range(9) if exactly_inside(corners, i, j)}
    assert nodes(Polygon(tuple(corners)), terrain(dx_m=1.0, dy_m=1.0)) == expected


def test_raster_is_the_union():
    zones = (Circle(100, 100, 60), Polygon(SQUARE))
    np.testing.assert_array_equal(
        raster(zones, terrain()),
        raster(zones[:1], terrain()) | raster(zones[1:], terrain()),
    )
    assert not raster((), terrain()).any()
    assert raster((), terrain((3, 4))).shape == (3, 4)


@pytest.mark.parametrize(
    "zone",
    [
        Circle(1.5, -2.0, 30),
        Polygon(SQUARE),
        Polygon(SQUARE, (((150, 150), (160, 150), (150, 160)),)),
        Circle(1, 2, 3, name="Fort", lower_m=-10, upper_m=900, t0_s=0, t1_s=60.5),
        Polygon(SQUARE, name="no upper limit", lower_m=120.25),
    ],
)
def test_summary_form_round_trip(zone):
    table = json.loads(json.dumps(zone.to_dict()))
    assert zone_from_dict(table) == zone


def test_summary_form():
    assert Circle(1, 2, 3).to_dict() == {"x": 1.0, "y": 2.0, "radius_m": 3.0}
    assert Polygon(SQUARE[:3]).to_dict() == {
        "polygon": [[100.0, 100.0], [300.0, 100.0], [300.0, 300.0]]
    }
    zone = Zone.circle(1, 2, 3, name="Fort", lower_m=0, upper_m=5, t0_s=0, t1_s=9)
    assert zone.to_dict() == {
        "x": 1.0,
        "y": 2.0,
        "radius_m": 3.0,
        "name": "Fort",
        "lower": 0.0,
        "upper": 5.0,
        "t0": 0.0,
        "t1": 9.0,
    }
    assert Zone.polygon(SQUARE, upper_m=7).to_dict().keys() == {"polygon", "upper"}


def test_zone_prints_the_limits_that_are_set():
    assert repr(Circle(1, 2, 3)) == "Circle(x_m=1.0, y_m=2.0, radius_m=3.0)"
    assert repr(Circle(1, 2, 3, name="Fort", t1_s=9)) == (
        "Circle(x_m=1.0, y_m=2.0, radius_m=3.0, name='Fort', t1_s=9.0)"
    )
    assert Circle(1, 2, 3) != Circle(1, 2, 3, upper_m=9)


@pytest.mark.parametrize(
    "table",
    [None, [], {"x": 1, "y": 2}, {"polygon": [], "x": 1}, {"polygon": [[0, 0]] * 3, "holes": 3}],
)
def test_refuses_a_bad_summary_form(table):
    with pytest.raises(
        InputError,
        match=r'^A no-fly zone must be \{"x", "y", "radius_m"\} or '
        r'\{"polygon": \[\[x, y\], \.\.\.\]\}, not ',
    ):
        zone_from_dict(table)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0, 0, -1), r"^No-fly circle: radius_m must not be negative, not -1\.$"),
        ((math.nan, 0, 1), r"^No-fly circle: x_m must be a finite number, not nan\.$"),
        ((0, math.inf, 1), r"^No-fly circle: y_m must be a finite number, not inf\.$"),
        ((0, 0, "wide"), r"^No-fly circle: radius_m must be a finite number, not 'wide'\.$"),
    ],
)
def test_refuses_bad_circles(values, message):
    with pytest.raises(InputError, match=message):
        Circle(*values)


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"name": 3}, r"name must be a text, not 3\.$"),
        ({"lower_m": math.nan}, r"lower_m must be a finite number, not nan\.$"),
        ({"upper_m": "FL95"}, r"upper_m must be a finite number, not 'FL95'\.$"),
        ({"t0_s": True}, r"t0_s must be a finite number, not True\.$"),
        ({"t1_s": -1}, r"t1_s must not be negative, not -1\.$"),
        ({"lower_m": 5, "upper_m": 5}, r"lower_m must be below upper_m, not 5 and 5\.$"),
        ({"t0_s": 9, "t1_s": 8.5}, r"t0_s must be below t1_s, not 9 and 8\.5\.$"),
    ],
)
def test_refuses_bad_limits(limits, message):
    with pytest.raises(InputError, match=r"^No-fly circle: " + message):
        Zone.circle(0, 0, 1, **limits)
    with pytest.raises(InputError, match=r"^No-fly polygon: " + message):
        Zone.polygon(SQUARE, **limits)


@pytest.mark.parametrize(
    ("ring", "message"),
    [
        (((0, 0), (1, 1)), r"^No-fly polygon: a ring must have at least 3 corners, not 2\.$"),
        (
            ((0, 0), (1, 1), (0, 0)),
            r"^No-fly polygon: a ring must have at least 3 corners, not 2\.$",
        ),
        (
            ((0, 0), (1, 1), (0, math.nan)),
            (
                r"^No-fly polygon: every corner must be two finite numbers, "
                r"x and y\.$"
            ),
        ),
        ("ring", r"^No-fly polygon: every corner must be two finite numbers, x and y\.$"),
    ],
)
def test_refuses_bad_polygons(ring, message):
    with pytest.raises(InputError, match=message):
        Polygon(ring)


def read(tmp_path, document, where=None):
    file = tmp_path / "zones.geojson"
    file.write_text(document if isinstance(document, str) else json.dumps(document), "utf-8")
    return read_zones(file, terrain() if where is None else where).zones


def feature(geometry, coordinates, **properties):
    return {
        "type": "Feature",
        "properties": properties,
        "geometry": {"type": geometry, "coordinates": coordinates},
    }


def collection(*features, **members):
    return {"type": "FeatureCollection", "features": list(features), **members}


def closed(ring):
    return [list(corner) for corner in (*ring, ring[0])]


def test_read_local_zones(tmp_path):
    hole = ((150.0, 150.0), (250.0, 150.0), (250.0, 250.0))
    other = ((0.0, 0.0), (50.0, 0.0), (0.0, 50.0))
    zones = read(
        tmp_path,
        collection(
            feature("Point", [10, 20, 99], radius_m=30),
            feature("Polygon", [closed(SQUARE), closed(hole)]),
            feature("MultiPolygon", [[closed(SQUARE)], [closed(other)]]),
            crs_local=True,
        ),
    )
    assert zones == (Circle(10, 20, 30), Polygon(SQUARE, (hole,)), Polygon(SQUARE), Polygon(other))


def test_read_one_feature_or_geometry(tmp_path):
    bare = {"type": "Polygon", "coordinates": [closed(SQUARE)], "crs_local": True}
    assert read(tmp_path, bare) == (Polygon(SQUARE),)
    single = {**feature("Point", [1, 2], radius_m=3), "crs_local": True}
    assert read(tmp_path, single) == (Circle(1, 2, 3),)


def test_read_names_heights_and_times(tmp_path):
    limits = {"name": "Fort", "lower": 100, "upper": 900.5, "t0": 0, "t1": 60}
    circle, *polygons = read(
        tmp_path,
        collection(
            feature("Point", [10, 20], radius_m=30, **limits),
            feature("MultiPolygon", [[closed(SQUARE)], [closed(SQUARE)]], **limits),
            feature("Polygon", [closed(SQUARE)], name=None, lower=None, upper=50, other="x"),
            feature("Polygon", [closed(SQUARE)], name=7),
            crs_local=True,
        ),
    )
    common = {"name": "Fort", "lower_m": 100, "upper_m": 900.5, "t0_s": 0, "t1_s": 60}
    assert circle == Circle(10, 20, 30, **common)
    assert polygons == [
        Polygon(SQUARE, **common),
        Polygon(SQUARE, **common),
        Polygon(SQUARE, upper_m=50),
        Polygon(SQUARE, name="7"),
    ]


def test_read_geographic_zones(tmp_path):
    where = terrain((100, 100), 30.0, 30.0, "EPSG:32611", (388328.65545, 3790772.82763))
    ring = ((100.0, 200.0), (2000.0, 250.0), (1500.0, 1800.0))
    longitude, latitude = transform(
        "EPSG:32611",
        "EPSG:4326",
        [where.origin[0] + x for x, _ in ring],
        [where.origin[1] + y for _, y in ring],
    )
    corners = closed(tuple(zip(longitude, latitude, strict=True)))
    circle, polygon = read(
        tmp_path,
        collection(feature("Point", corners[0], radius_m=400), feature("Polygon", [corners])),
        where,
    )
    assert (circle.x_m, circle.y_m, circle.radius_m) == pytest.approx((100, 200, 400), abs=1e-3)
    np.testing.assert_allclose(polygon.ring, ring, atol=1e-3)


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ("{", r"is not JSON: .+; give GeoJSON, .+\.$"),
        ("3", r": not a GeoJSON object\.$"),
        (
            {"features": [{"attributes": {"NAME": "R-7"}, "geometry": {"rings": []}}]},
            r": it is the JSON of ArcGIS, not GeoJSON; save or request it as GeoJSON\.$",
        ),
        (
            {"type": "Topology", "objects": {}, "arcs": []},
            r": it is TopoJSON, not GeoJSON; save or request it as GeoJSON\.$",
        ),
        (collection(crs_local="yes"), r': "crs_local" must be true or false, not \'yes\'\.$'),
        (
            collection(feature("Point", [1, 2], radius_m=5)),
            (
                r": the terrain has no coordinate reference system, so GeoJSON has no place on "
                r'it; give --origin LAT,LON, .+ as GeoJSON with the member "crs_local": true\.$'
            ),
        ),
        (
            {"type": "FeatureCollection", "crs_local": True},
            r': a FeatureCollection must have a list of "features"\.$',
        ),
        (
            {"type": "Feature", "crs_local": True},
            r": feature 1: its geometry is not a GeoJSON object\.$",
        ),
        (collection(3, crs_local=True), r": feature 1: it is not a GeoJSON object\.$"),
        (
            collection(feature("Point", [1, 2], radius_m=-5), crs_local=True),
            r": feature 1: radius_m is negative, -5\.$",
        ),
        (
            collection(feature("Point", [1, 2], radius_m=5, upper="high"), crs_local=True),
            r": feature 1: upper must be a finite number, not 'high'\.$",
        ),
        (
            collection(feature("Point", [1], radius_m=5), crs_local=True),
            r": a position must be a list of two finite numbers\.$",
        ),
        (
            collection(feature("Point", None, radius_m=5), crs_local=True),
            r": a position must be a list of two finite numbers\.$",
        ),
        (
            collection(feature("Point", [math.nan, 1], radius_m=5), crs_local=True),
            r": a position must be a list of two finite numbers\.$",
        ),
        (
            collection(feature("Circle", [1, 2], name="R-7"), crs_local=True),
            (
                r': feature 1, "R-7": a geometry must be a Polygon, a MultiPolygon, a '
                r"GeometryCollection or a Point with \"radius_m\", not 'Circle'\.$"
            ),
        ),
        (
            collection(feature("Polygon", []), crs_local=True),
            r": a Polygon must have at least one ring\.$",
        ),
        (
            collection(feature("MultiPolygon", {}), crs_local=True),
            r": the coordinates of a MultiPolygon must be a list\.$",
        ),
        (
            collection(feature("Polygon", [[[0, 0], [1, 1], [0, 0]]]), crs_local=True),
            r": feature 1: a ring must have at least 3 corners, not 2\.$",
        ),
    ],
)
def test_refuses_bad_files(tmp_path, document, message):
    with pytest.raises(InputError, match=r"^No-fly file '.*zones\.geojson'" + r"\:?.*" + message):
        read(tmp_path, document)


def test_refuses_local_metres_and_other_systems_as_geographic(tmp_path):
    where = terrain(crs="EPSG:32611")
    with pytest.raises(
        InputError,
        match=r": \(500, 200\) is no WGS84 longitude and latitude; for "
        r'local metres add the member "crs_local": true\.$',
    ):
        read(tmp_path, collection(feature("Point", [500, 200], radius_m=5)), where)
    crs = {"type": "name", "properties": {"name": "my own grid"}}
    with pytest.raises(InputError, match=r'"my own grid"\}\} is unknown; convert it to WGS84'):
        read(tmp_path, collection(crs=crs), where)
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
    assert read(tmp_path, collection(crs=crs), where) == ()


def test_refuses_a_missing_file(tmp_path):
    with pytest.raises(
        InputError,
        match=r"^Cannot read no-fly file '.*none\.geojson': No such "
        r"file or directory\.$",
    ):
        read_zones(tmp_path / "none.geojson", terrain())


@pytest.mark.parametrize("far", [2e9, -2e9, 1e308, math.inf])
def test_corners_that_are_nowhere_near_are_refused(far):
    """Exact arithmetic takes a minute with coordinates of 1e308."""
    with pytest.raises(InputError, match=r"^No-fly polygon: "):
        Polygon(((0.0, 0.0), (far, 0.0), (0.0, 5.0)))
