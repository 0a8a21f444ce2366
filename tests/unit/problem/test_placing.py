"""Features of files over a terrain, compared with PROJ and Shapely."""

import random

import numpy as np
import pytest
import shapely
from pyproj import Geod, Transformer
from shapely.geometry import Polygon as Shape

from pathgene.host.formats.features import Edges, Feature
from pathgene.host.problem.placing import goes_short_way, place
from pathgene.host.terrain import Terrain


GEOD = Geod(ellps="WGS84")
FILES, MANY = 30, 400


def terrain_at(lon, lat, crs=None, cells=41):
    """Return a terrain of 4 km with its south-west node at a place."""
    zone = int((lon + 180) % 360 // 6) + 1
    crs = crs or f"EPSG:{(32600 if lat >= 0 else 32700) + zone}"
    to_map = Transformer.from_crs(4326, crs, always_xy=True)
    origin = to_map.transform(lon, lat)
    heights = np.zeros((cells, cells))
    return Terrain("plain", heights, 100.0, 100.0, crs, origin), to_map


def grid(terrain, rng, count=400):
    """Return points of a map with their longitudes and latitudes, by PROJ."""
    x = np.array([rng.uniform(0, terrain.width_m) for _ in range(count)])
    y = np.array([rng.uniform(0, terrain.height_m) for _ in range(count)])
    back = Transformer.from_crs(terrain.crs, 4326, always_xy=True)
    lon, lat = back.transform(x + terrain.origin[0], y + terrain.origin[1])
    return x, y, lon, lat


def covered(parts, x, y):
    """Return which points are in a part, and their distance from the borders, by Shapely."""
    points = shapely.points(x, y)
    inside, away = np.zeros(len(x), bool), np.full(len(x), np.inf)
    for part in parts:
        outer, *holes = part.rings
        # Parts that are cut may touch themselves along the border of the box around the map.
        area = shapely.make_valid(Shape(outer))
        for hole in holes:
            area = area.difference(shapely.make_valid(Shape(hole)))
        inside |= shapely.contains(area, points)
        away = np.minimum(away, shapely.distance(shapely.boundary(area), points))
    return inside, away


def star(rng, lon, lat, size, corners):
    """Return a star-shaped ring around a place; its edges do not cross."""
    angles = [2 * np.pi * (corner + rng.uniform(0, 0.9)) / corners for corner in range(corners)]
    reach = [size * rng.uniform(0.3, 1.0) for _ in angles]
    return tuple(
        (lon + r * np.cos(a), min(max(lat + r * np.sin(a), -89.0), 89.0))
        for r, a in zip(reach, angles, strict=True)
    )


def place_of(rng):
    return rng.uniform(-179.5, 179.5), rng.choice([-1, 1]) * rng.uniform(0.5, 79.5)


def check_edges(seed):
    """The map lies on the middle of an edge of a ring of metres up to half the Earth."""
    rng = random.Random(seed)
    lon, lat = place_of(rng)
    ring = star(rng, lon, lat, min(10 ** rng.uniform(-2.5, 1.8), 50.0), rng.randint(5, 12))
    hole = tuple((lon + (e - lon) / 4, lat + (n - lat) / 4) for e, n in ring)
    edge = rng.randrange(len(ring))
    (ea, na), (eb, nb) = ring[edge - 1], ring[edge]
    share = rng.uniform(0.3, 0.7)
    at = ea + share * (eb - ea), min(max(na + share * (nb - na), -79.5), 79.5)
    terrain, to_map = terrain_at(at[0] - 0.02, at[1] - 0.01)
    turn = 360.0 * rng.choice([-1, 0, 0, 1])
    rings = tuple(tuple((e + turn, n) for e, n in each) for each in (ring, hole))
    (parts,) = place([Feature(1, "", rings)], terrain)

    x, y, east, north = grid(terrain, rng)
    # By definition: edges are straight in longitude and latitude.
    around = at[0] + (east - at[0] + 180.0) % 360.0 - 180.0
    wanted = shapely.contains(Shape(ring, [hole]), shapely.points(around, north))
    inside, away = covered(parts, x, y)
    assert np.array_equal(inside[away > 0.5], wanted[away > 0.5]), seed

    shares = np.linspace(0, 1, 2001)
    lines = [
        np.column_stack([a[k] + shares * (b[k] - a[k]) for k in (0, 1)])
        for each in (ring, hole)
        for a, b in zip(each, (*each[1:], each[0]), strict=True)
    ]
    points = np.concatenate(lines)
    points = points[(abs(points - at) < 0.2).all(axis=1)]
    x, y = to_map.transform(*points.T)
    x, y = np.array(x) - terrain.origin[0], np.array(y) - terrain.origin[1]
    on_map = (x > 0) & (x < terrain.width_m) & (y > 0) & (y < terrain.height_m)
    _, away = covered(parts, x[on_map], y[on_map])
    assert away.max(initial=0.0) < 0.5, seed
    return int(on_map.sum())


@pytest.mark.parametrize("seed", range(FILES))
def test_areas_are_where_their_degrees_say(seed):
    check_edges(seed)


def test_a_long_edge_is_divided():
    """The parallel at 60 N bends by 6 km in a chord of 800 km."""
    terrain, to_map = terrain_at(9.0, 60.0)
    ring = ((2.0, 60.01), (16.0, 60.01), (16.0, 62.0), (2.0, 62.0))
    (parts,) = place([Feature(1, "", (ring,))], terrain)
    x, y = to_map.transform(np.linspace(9.01, 9.06, 50), np.full(50, 60.01))
    _, away = covered(parts, x - terrain.origin[0], y - terrain.origin[1])
    assert away.max() < 0.5


@pytest.mark.long
def test_many_areas_are_where_their_degrees_say():
    assert sum(check_edges(seed) for seed in range(FILES, MANY)) > 20 * MANY


@pytest.mark.parametrize("edges", [Edges.GEODESIC, Edges.RHUMB])
@pytest.mark.parametrize("seed", range(6))
def test_edges_follow_geodesics_and_rhumb_lines(edges, seed):
    rng = random.Random(seed)
    lon, lat = rng.uniform(-150, 150), rng.choice([-1, 1]) * rng.uniform(20, 65)
    # The edge from corner 0 to corner 1 passes the map and is hundreds of kilometres long.
    first, second = (lon - 4.0, lat - 1.0), (lon + 4.0, lat + 1.5)
    if edges is Edges.GEODESIC:
        line = np.array(GEOD.npts(*first, *second, 4000))
    else:
        mercator = Transformer.from_crs(4326, 3395, always_xy=True)
        ends = np.array(mercator.transform(*np.array([first, second]).T))
        shares = np.linspace(0, 1, 4001)
        along = ends[:, :1] + shares * (ends[:, 1:] - ends[:, :1])
        line = np.column_stack(mercator.transform(*along, direction="INVERSE"))
    at = line[len(line) // 2]
    terrain, to_map = terrain_at(at[0] - 0.02, at[1] - 0.02)
    ring = (first, second, (lon + 4.0, lat + 8.0), (lon - 4.0, lat + 8.0))
    (parts,) = place([Feature(1, "", (ring,), edges=edges)], terrain)
    x, y = to_map.transform(*line.T)
    x, y = x - terrain.origin[0], y - terrain.origin[1]
    on_map = (x > 0) & (x < terrain.width_m) & (y > 0) & (y < terrain.height_m)
    assert on_map.sum() > 10
    _, away = covered(parts, x[on_map], y[on_map])
    assert away.max() < 0.5


def test_a_zone_may_be_written_in_three_ways_across_the_antimeridian():
    terrain, _ = terrain_at(179.98, -16.51)
    boxes = []
    for east in (180.01, -179.99):
        for west in (179.99, -180.01):
            ring = ((west, -16.5), (east, -16.5), (east, -16.49), (west, -16.49))
            ((part,),) = place([Feature(1, "", (ring,))], terrain)
            boxes.append(np.array(part.rings[0]))
    for other in boxes[1:]:
        np.testing.assert_allclose(other, boxes[0], atol=1e-6)


WORLD = ((-180.0, -90.0), (180.0, -90.0), (180.0, 90.0), (-180.0, 90.0))
NEARLY = ((-179.0, -80.0), (179.0, -80.0), (179.0, 80.0), (-179.0, 80.0))


@pytest.mark.parametrize("ring", [NEARLY, (NEARLY[0], (0.0, -80.0), *NEARLY[1:])])
@pytest.mark.parametrize("lon", [-178.9, 9.0, 178.9])
def test_a_map_of_the_world_stays_as_drawn(ring, lon):
    terrain, _ = terrain_at(lon, 40.0)
    (parts,) = place([Feature(1, "", (ring,))], terrain)
    x, y, _, _ = grid(terrain, random.Random(1))
    inside, away = covered(parts, x, y)
    assert inside[away > 0.5].all()


def test_only_a_ring_that_is_moved_goes_the_short_way():
    south, north = 60.0, 61.0

    def box(west, east):
        return Feature(1, "", (((west, south), (east, south), (east, north), (west, north)),))

    assert goes_short_way(box(-179.0, 179.0))
    assert goes_short_way(box(-170.0, 170.0))
    around = tuple((longitude, north) for longitude in range(-170, 190, 10))
    whole = Feature(1, "", (NEARLY,))
    for feature in (box(179.0, 181.0), box(-90.0, 90.0), box(-180.0, 180.0), whole):
        assert not goes_short_way(feature)
    assert not goes_short_way(Feature(1, "", (around,)))


@pytest.mark.parametrize("lon", [-180.02, -179.99, -75.0, 0.0, 100.0, 179.98])
def test_a_zone_around_the_world_covers_the_map(lon):
    terrain, _ = terrain_at(lon, 40.0)
    (parts,) = place([Feature(1, "", (WORLD,))], terrain)
    x, y, _, _ = grid(terrain, random.Random(1))
    inside, away = covered(parts, x, y)
    assert inside[away > 0.5].all()


@pytest.mark.parametrize(("latitude", "is_inside"), [(85.0, True), (89.99, False)])
def test_a_ring_around_the_pole_has_the_pole(latitude, is_inside):
    """The map contains the pole; the ring is far outside it, or a hole within the map."""
    crs = "EPSG:32661"
    terrain, _ = terrain_at(0.0, 89.9, crs, cells=401)
    ring = tuple((longitude, latitude) for longitude in range(-170, 190, 10))
    (parts,) = place([Feature(1, "", (ring,))], terrain)
    x, y, _, north = grid(terrain, random.Random(2))
    inside, away = covered(parts, x, y)
    sure = (away > 20.0) & (abs(north - latitude) > 0.002)
    assert np.array_equal(inside[sure], (north > latitude)[sure])
    assert is_inside == bool(inside[sure].all())


@pytest.mark.parametrize("radius_m", [500.0, 250_000.0])
def test_circles_are_cut_and_not_refused(radius_m):
    """Centres lie on the map and 200 km, 300 km and 9,000 km away."""
    terrain, _ = terrain_at(10.0, 60.0)
    x, y, lon, lat = grid(terrain, random.Random(3))
    for centre in ((10.03, 60.02), (10.0, 61.8), (4.6, 60.0), (10.0, -20.0)):
        (parts,) = place([Feature(1, "", ((centre,),), radius_m)], terrain)
        _, _, away = GEOD.inv(*np.broadcast_arrays(lon, lat, *centre))
        inside = np.zeros(len(x), bool)
        for part in parts:
            if part.radius_m is None:
                inside |= covered([part], x, y)[0]
            else:
                ((cx, cy),) = part.rings[0]
                inside |= np.hypot(x - cx, y - cy) <= part.radius_m
        # The frame's metres are longer or shorter than true ones by 0.1 % at most.
        sure = abs(away - radius_m) > 1e-3 * radius_m + 1
        assert np.array_equal(inside[sure], (away < radius_m)[sure]), centre


def test_short_edges_keep_their_corners_bit_for_bit():
    terrain, _ = terrain_at(11.0, 47.0)
    ring = ((11.01, 47.01), (11.02, 47.01), (11.02, 47.02))
    ((part,),) = place([Feature(1, "", (ring,))], terrain)
    x, y = terrain.to_local([lat for _, lat in ring], [lon for lon, _ in ring])
    assert part.rings == (tuple(zip(x.tolist(), y.tolist(), strict=True)),)


@pytest.mark.parametrize("is_local", [False, True])
def test_an_outline_that_goes_round_twice_is_forbidden_inside(is_local):
    terrain, _ = terrain_at(10.0, 60.0)
    x, y = np.array([1000.0, 2000.0, 2000.0, 1000.0]), np.array([1000.0, 1000.0, 2000.0, 2000.0])
    lat, lon = (y, x) if is_local else terrain.to_geographic(x, y)
    ring = tuple(zip(lon.tolist(), lat.tolist(), strict=True))
    inner = tuple(((x + 3 * ring[0][0]) / 4, (y + 3 * ring[0][1]) / 4) for x, y in ring)
    for rings in ((ring * 2,), (ring, ring), ((*ring, ring[0], *inner),)):
        (parts,) = place([Feature(1, "", rings, is_local=is_local)], terrain)
        inside, _ = covered(parts, np.array([1500.0, 1100.0, 900.0]), np.array([1500.0, 1100, 900]))
        assert inside.tolist() == [True, True, False]
        assert all(part.is_tangled for part in parts)
    # A fence to stay in is open inside.
    (parts,) = place([Feature(1, "", (ring * 2,), keeps_in=True, is_local=is_local)], terrain)
    inside, _ = covered(parts, np.array([1500.0, 900.0]), np.array([1500.0, 900.0]))
    assert inside.tolist() == [False, True]
