"""Zones as flat fences."""

import itertools
import math

import numpy as np
import pytest
from pyproj import Geod
from shapely.geometry import LineString
from shapely.geometry import Polygon as Shape
from shapely.ops import unary_union

from pathgene.host.evaluation import Evaluator
from pathgene.host.formats.flight_plan import FenceCircle, FencePolygon
from pathgene.host.mission.autopilot.fence_room import room_of
from pathgene.host.mission.autopilot.fences import fences, without_holes
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain


GROUND = Terrain("plain", np.zeros((41, 41)), 100.0, 100.0, "EPSG:32632", (500_000.0, 5_000_000.0))
SQUARE = ((1500.0, 1500.0), (2500.0, 1500.0), (2500.0, 2500.0), (1500.0, 2500.0))


ROOM = room_of()


def fences_of(*zones, room=ROOM, as_paper=True):
    problem = Problem(GROUND, (100, 2000, 100), (3900, 2000, 100), zones=zones, as_paper=as_paper)
    track = Evaluator(problem, threads=1).track(np.array([problem.start, problem.goal]))
    return fences(problem, track, room)


def even_odd(ring, x, y):
    """Return which points are inside by the rule of autopilots."""
    inside = np.zeros(len(x), bool)
    for (xa, ya), (xb, yb) in itertools.pairwise((*ring, ring[0])):
        crosses = (ya > y) != (yb > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= crosses & (x < (xb - xa) * (y - ya) / (yb - ya) + xa)
    return inside


def test_a_polygon_without_holes_covers_the_same_points():
    rng = np.random.default_rng(3)
    x, y = rng.uniform(0, 100, (2, 20_000))
    for _ in range(20):
        holes = []
        for corner in ((25, 25), (70, 30), (45, 75)):
            turns = np.sort(rng.uniform(0, 2 * np.pi, 6))
            hole = np.column_stack((np.cos(turns), np.sin(turns))) * 9 + corner
            holes.append(tuple(map(tuple, hole)))
        ring = ((0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0))
        joined = without_holes(ring, tuple(holes))
        expected = even_odd(ring, x, y)
        for hole in holes:
            expected &= ~even_odd(hole, x, y)
        assert np.array_equal(even_odd(joined, x, y), expected)
        assert len(joined) == 4 + 3 * 6 + 3 * 2


def test_circles_keep_their_radius():
    (made,), left_out = fences_of(Circle(2000, 3000, 250))
    assert isinstance(made, FenceCircle)
    assert (made.radius_m, made.inclusion, left_out) == (250, False, ())


def test_a_polygon_keeps_its_corners():
    ((made,), _) = fences_of(Polygon(SQUARE))
    assert isinstance(made, FencePolygon)
    lat, lon = np.array(made.corners).T
    x, y = GROUND.to_local(lat, lon)
    assert np.allclose(np.column_stack((x, y)), SQUARE, atol=1e-3)
    area, _ = Geod(ellps="WGS84").polygon_area_perimeter(lon, lat)
    assert area == pytest.approx(1e6, rel=1e-3)


@pytest.mark.parametrize("limit", ["lower_m", "upper_m", "t0_s", "t1_s"])
@pytest.mark.parametrize(
    "make", [lambda **limits: Polygon(SQUARE, **limits), lambda **k: Circle(2000, 2100, 300, **k)]
)
def test_a_crossed_zone_with_limits_has_no_fence(make, limit):
    made, left_out = fences_of(make(name="R-12", **{limit: 300.0}), make(**{limit: 9.0}))
    assert made == ()
    assert left_out == (
        "No fence for R-12: the path crosses it above, below, before or after its limits, which a "
        "fence cannot express.",
        "No fence for zone 2: the path crosses it above, below, before or after its limits, which "
        "a fence cannot express.",
    )


def test_a_zone_with_limits_beside_the_path_has_a_fence():
    made, left_out = fences_of(Circle(2000, 3000, 250, upper_m=300), Polygon(SQUARE))
    assert len(made) == 2  # The unlimited one, too, though the path enters it.
    assert left_out == ()


def test_a_path_through_a_hole_does_not_cross_the_zone():
    hole = ((50.0, 1900.0), (3950.0, 1900.0), (3950.0, 2100.0), (50.0, 2100.0))
    ring = ((10.0, 10.0), (3990.0, 10.0), (3990.0, 3990.0), (10.0, 3990.0))
    made, left_out = fences_of(Polygon(ring, (hole,), upper_m=500.0))
    assert len(made) == 1
    assert left_out == ()
    lat, lon = np.array(made[0].corners).T
    x, y = GROUND.to_local(lat, lon)
    shape = unary_union(Shape(np.column_stack((x, y))).buffer(0))
    assert math.isclose(shape.area, 3980**2 - 3900 * 200, rel_tol=1e-6)


def star(rng, corners, radius_m, jagged_m, at=(0.0, 0.0)):
    """Return a ring with bays and teeth."""
    angles = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    bays = sum(
        rng.uniform(-0.1, 0.1) * np.sin(k * angles + rng.uniform(0, 7)) for k in (2, 3, 5, 9)
    )
    radii = radius_m * (1 + bays) + rng.uniform(-jagged_m, jagged_m, corners)
    places = np.column_stack((radii * np.cos(angles), radii * np.sin(angles))) + at
    return tuple(map(tuple, places.tolist()))


def random_zone(rng, number):
    """Return a zone of many corners beside the track of :func:`fences_of`, and its shape."""
    jagged_m, radius = rng.choice([0.0, 0.5, 3.0]), rng.uniform(150, 500)
    ring = star(rng, int(rng.integers(60, 400)), radius, jagged_m)
    shape = Shape(ring)
    holes = [star(rng, 40, 0.25 * radius, 0.5)] if rng.random() < 0.4 else []
    if holes and not shape.buffer(-1.0).contains(Shape(holes[0])):
        holes = []
    # It touches the track's margin, from either side.
    low, high = shape.bounds[1], shape.bounds[3]
    north = 2000 + 25.01 - low if rng.random() < 0.5 else 2000 - 25.01 - high
    east = rng.uniform(700, 3300)
    ring, *holes = (tuple((x + east, y + north) for x, y in each) for each in (ring, *holes))
    return Polygon(ring, tuple(holes), name=f"R-{number}"), Shape(ring, holes)


def shapes_of(fence):
    """Return polygons of fences by the even-odd rule, which cuts of zero width do not change."""
    x, y = GROUND.to_local(*np.array(fence.corners).T)
    return Shape(np.column_stack((x, y))).buffer(0)


def len_of(zone):
    """Return the corners of a zone's fence, cuts to its holes included."""
    return sum(map(len, zone.footprint.rings)) + 2 * len(zone.footprint.rings[1:])


TRACK = LineString([(100, 2000), (3900, 2000)])


@pytest.mark.parametrize(
    "seeds", [range(12), pytest.param(range(12, 400), marks=pytest.mark.long)], ids=["few", "many"]
)
def test_a_simplified_fence_contains_its_zone_and_leaves_the_corridor_free(seeds):
    """Shapely judges."""
    fitting = 0
    for seed in seeds:
        rng = np.random.default_rng(seed)
        zones, shapes = zip(*(random_zone(rng, n) for n in range(rng.integers(1, 3))), strict=True)
        room = room_of(*rng.choice([(3, None), (12, None), (0, 40)]))
        made, notes = fences_of(*zones, room=room, as_paper=False)
        assert len(made) == len(zones)
        corners = sum(len(fence.corners) for fence in made)
        if not notes:  # They have room as they are, or never will.
            assert corners == sum(map(len_of, zones))
            continue
        assert room.has(corners, len(made), 0)
        fitting += 1
        reach_m = float(notes[0].split("at most ")[1].split()[0]) + 0.06
        assert reach_m < 0.95 * 25 + 0.1
        for fence, shape in zip(made, shapes, strict=True):
            drawn = shapes_of(fence)
            assert drawn.buffer(0.02).contains(shape), seed
            closed = Shape(shape.exterior) if "closed" in notes[0] else shape
            assert closed.buffer(reach_m + 0.02).contains(drawn), seed
            added = drawn.difference(shape.buffer(0.02))
            assert added.is_empty or added.distance(TRACK) > 0.75 * 25 - 0.02, seed
    assert fitting > 0.6 * len(seeds)


def test_a_fence_of_2000_corners_has_room_with_either_autopilot():
    ring = star(np.random.default_rng(1), 2000, 900.0, 0.0, (2000.0, 3050.0))
    for autopilot, most in ((3, 83), (12, 64), (None, 64)):
        (made,), (note,) = fences_of(Polygon(ring), room=room_of(autopilot), as_paper=False)
        assert len(made.corners) == most
        assert note.startswith(
            f"The fences have {most} corners instead of 2000, because there is room for "
            f"{room_of(autopilot).items} corners and circles (--fence-corners); they contain the "
            "zones and reach at most "
        )
        assert shapes_of(made).buffer(0.02).contains(Shape(ring))


def test_without_a_margin_no_fence_is_simplified():
    ring = star(np.random.default_rng(1), 200, 900.0, 0.0, (2000.0, 3050.0))
    (made,), notes = fences_of(Polygon(ring), as_paper=True)
    assert (len(made.corners), notes) == (200, ())


def test_corners_on_a_line_cost_nothing():
    side = np.linspace(1500.0, 2500.0, 40, endpoint=False).tolist()
    ring = (
        *((x, 2500.0) for x in side),
        *((2500.0, 5000.0 - y) for y in side[:20]),
        *((4000.0 - x, 2000.5) for x in side),
        (1500.0, 2250.0),
    )
    (made,), (note,) = fences_of(Polygon(ring), room=room_of(None, 10), as_paper=True)
    assert len(made.corners) <= 10
    assert "at most 0.0 m beyond" in note
    assert shapes_of(made).symmetric_difference(Shape(ring)).area < 1.0


def test_circles_stay_circles():
    ring = star(np.random.default_rng(1), 300, 400.0, 0.0, (2000.0, 3050.0))
    made, _ = fences_of(Circle(3000, 3000, 250), Polygon(ring), as_paper=False)
    assert isinstance(made[0], FenceCircle)
    assert made[0].radius_m == 250
    assert len(made[1].corners) == 63


def test_a_hole_that_the_path_does_not_enter_is_closed_before_a_zone_is_left_out():
    outer = star(np.random.default_rng(2), 80, 900.0, 0.0, (2000.0, 3100.0))
    holes = [
        star(np.random.default_rng(3), 12, 60.0, 0.0, (2000.0 + x, 3100.0 + y))
        for x in (-300, 0, 300)
        for y in (-300, 0, 300)
    ]
    (made,), (note,) = fences_of(Polygon(outer, tuple(holes)), as_paper=False)
    assert note.endswith(" 9 holes that the path does not enter are closed.")
    assert shapes_of(made).buffer(0.02).contains(Shape(outer))


def test_zones_beyond_reach_are_left_out_last_and_named():
    """The mission is 4 km long; zones more than 8 turn radii beside it cannot be reached."""
    near = Polygon(star(np.random.default_rng(1), 40, 300.0, 3.0, (2000.0, 3050.0)), name="near")
    far = [
        Circle(2000.0 + 3000.0 * n, 9000.0 + 3000.0 * n, 100.0, name=f"far {n}") for n in range(60)
    ]
    made, notes = fences_of(near, *far, as_paper=False)
    circles = [fence for fence in made if isinstance(fence, FenceCircle)]
    corners = sum(len(fence.corners) for fence in made if isinstance(fence, FencePolygon))
    assert ROOM.has(corners, 1, len(circles))
    assert corners < 40  # It is simplified first.
    assert len(circles) + len(notes) - 1 == 60
    assert notes[0] == (
        "No fence for far 59, 253.9 km from the path: there is room for 64 corners and circles "
        "(--fence-corners)."
    )


def test_zones_within_reach_are_never_left_out():
    zones = [Circle(200.0 + 50.0 * n, 3000.0, 10.0) for n in range(70)]
    made, notes = fences_of(*zones, as_paper=False)
    assert (len(made), notes) == (70, ())
