"""The strict rule on zones: a dense-sampling oracle, and cases that a raster misses."""

import math
import timeit
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.zones import pack_zones, zone_intrusions, zone_metres
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zone_raster import blocked_cells
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain
from tests.support.host.random_flights import (
    CRUISE_M_S,
    near_a_limit,
    piece_rows,
    piece_times,
    random_path,
    random_zones,
    star,
    track_of,
)
from tests.support.host.zone_oracle import distances, enters


UNLIMITED = dict.fromkeys(("lower_m", "upper_m", "t0_s", "t1_s"))
SQUARE = ((100.0, 100.0), (300.0, 100.0), (300.0, 300.0), (100.0, 300.0))


def metres(path, zones, margin_m=0.0, radius_m=30.0):
    path = np.array(path, dtype=float)
    pieces, rows = piece_rows(path, radius_m)
    return zone_metres(pieces, rows, piece_times(pieces, rows), pack_zones(zones, margin_m))


def random_case(seed):
    """Return zones, margin, path and radius; most paths pass within a metre of a limit."""
    rng = np.random.default_rng(seed)
    nodes, cell_m = rng.integers(8, 33), rng.choice([5.0, 10.0, 30.0])
    side_m = float((nodes - 1) * cell_m)
    zones = random_zones(rng, side_m, side_m)
    margin_m = float(rng.choice([0.0, 1.0, 25.0, rng.uniform(0, 50)]))
    radius_m = 10 ** rng.uniform(0, 2)
    path = random_path(rng, side_m, side_m, zones)
    if rng.random() < 0.7:
        path = near_a_limit(rng, path, zones[rng.integers(len(zones))], margin_m, radius_m)
    return zones, margin_m, path, radius_m


def compare_with_oracle(seeds):
    """Assert that no path rejected by the oracle is free; return the counts of both verdicts."""
    rejected, near, spared, too_strict = 0, 0, 0, 0
    for seed in seeds:
        zones, margin_m, path, radius_m = random_case(seed)
        track = track_of(path, radius_m)
        entered = metres(path, zones, margin_m, radius_m)
        if enters(track, zones, margin_m, speed_m_s=CRUISE_M_S):
            assert entered > 0, seed
            rejected += 1
        elif enters(track, zones, margin_m, speed_m_s=CRUISE_M_S, spare_m=1.0):
            near += 1
        else:
            spared += 1
            too_strict += entered > 0
    return rejected, near, spared, too_strict


def test_agrees_with_dense_samples():
    rejected, near, spared, too_strict = compare_with_oracle(range(300))
    assert min(rejected, near, spared) > 30
    assert too_strict == 0


@pytest.mark.parametrize(
    "flights",
    [pytest.param(1000, marks=pytest.mark.ci), pytest.param(20_000, marks=pytest.mark.long)],
)
def test_agrees_with_dense_samples_of_many_flights(flights):
    rejected, near, spared, too_strict = compare_with_oracle(range(1000, 1000 + flights))
    assert min(rejected, spared) > 0.2 * flights
    assert near > 0.125 * flights  # As many of the rejected paths also pass within a metre.
    assert too_strict <= 0.01 * spared


def sampled(path, zone, margin_m, radius_m):
    """Return metres inside a zone and the minimum distance to it where it applies, from samples."""
    low = -np.inf if zone.lower_m is None else zone.lower_m - margin_m
    high = np.inf if zone.upper_m is None else zone.upper_m + margin_m
    t0 = -np.inf if zone.t0_s is None else zone.t0_s
    t1 = np.inf if zone.t1_s is None else zone.t1_s
    inside_m, distance_m, flown = 0.0, np.inf, 0.0
    for piece in track_of(path, radius_m):
        fractions = (np.arange(4000) + 0.5) / 4000
        x, y, z = piece.points(fractions).T
        times = (flown + fractions * piece.length_m) / CRUISE_M_S
        flown += piece.length_m
        applies = (low < z) & (z < high) & (t0 <= times) & (times <= t1)
        gaps = distances(zone, x[applies], y[applies])
        inside_m += np.count_nonzero(gaps <= margin_m) * piece.length_m / 4000
        distance_m = min(distance_m, gaps.min(initial=np.inf))
    return inside_m, distance_m


@pytest.mark.ci
def test_metres_and_distances_agree_with_samples():
    inside, apart = 0, 0
    for seed in range(80):
        zones, margin_m, path, radius_m = random_case(seed)
        pieces, rows = piece_rows(path, radius_m)
        times = piece_times(pieces, rows)
        found = zone_intrusions(pieces, rows, times, pack_zones(zones, margin_m))
        steps_m = 0.02 * len(path) + 0.01 * sum(len(getattr(zone, "ring", ())) for zone in zones)
        for zone, intrusion in zip(zones, found, strict=True):
            metres_inside, distance_m = sampled(path, zone, margin_m, radius_m)
            # A sample stands for at most 0.3 m, and each crossing may be wrong by half of that.
            assert intrusion.metres == pytest.approx(metres_inside, abs=5 * steps_m + 1)
            assert intrusion.distance_m <= distance_m + 1e-9
            if math.isfinite(distance_m):
                assert intrusion.distance_m == pytest.approx(distance_m, abs=0.3)
                assert (intrusion.distance_m <= margin_m + 1e-6) == (intrusion.metres > 0)
            assert (intrusion.entry is None) == (intrusion.metres == 0)
            inside += metres_inside > 0
            apart += math.isfinite(distance_m) and metres_inside == 0
        total = zone_metres(pieces, rows, times, pack_zones(zones, margin_m))
        assert total == pytest.approx(sum(intrusion.metres for intrusion in found))
    assert min(inside, apart) > 20


def spots(path, zone, margin_m=0.0, radius_m=30.0):
    pieces, rows = piece_rows(np.array(path, dtype=float), radius_m)
    times = piece_times(pieces, rows)
    (found,) = zone_intrusions(pieces, rows, times, pack_zones([zone], margin_m))
    return found


def test_cells_that_are_not_blocked_hold_nothing_that_is_rejected():
    """The search's raster is as strict as the rule, even at the very corners of its free cells."""
    rng = np.random.default_rng(3)
    where = Terrain(
        name="map", elevation=np.zeros((24, 32)), dx_m=30.0, dy_m=20.0, crs=None, origin=(0.0, 0.0)
    )
    tried = 0
    for _ in range(60):
        zones = [replace(zone, **UNLIMITED) for zone in random_zones(rng, 930.0, 460.0)]
        margin_m = float(rng.choice([0.0, 25.0]))
        free = ~blocked_cells(zones, where, margin_m)
        packed = pack_zones(zones, margin_m)
        rows, columns = np.nonzero(free)
        for row, column in zip(rows[::7].tolist(), columns[::7].tolist(), strict=True):
            corners = np.array((column, row)) + rng.choice([-0.5, 0.5, 0.0], (4, 2))
            path = np.column_stack((corners * (30.0, 20.0), np.arange(4)))
            pieces, count = piece_rows(path, 3.0)
            assert zone_metres(pieces, count, piece_times(pieces, count), packed) == 0
            tried += 1
    assert tried > 2000


def test_a_long_path_among_many_zones_takes_microseconds():
    """40 km, 31 waypoints, 20 polygons of 8 corners: 4 to 11 us measured, 0.1 ms with distances."""
    rng = np.random.default_rng(1)
    path = np.linspace((0.0, 20e3, 50.0), (40e3, 20e3, 900.0), 31)
    path[1:-1, 1] += rng.normal(0, 500, 29)
    zones = [Polygon(star(rng, x, rng.uniform(18e3, 22e3), 1500, 8)) for x in range(0, 40000, 2000)]
    pieces, rows = piece_rows(path, 150.0)
    times, packed = piece_times(pieces, rows), pack_zones(zones, 25)
    for measure in (zone_metres, zone_intrusions):
        measure(pieces, rows, times, packed)
        assert (
            min(timeit.repeat(partial(measure, pieces, rows, times, packed), number=1, repeat=20))
            < 0.5e-3
        )


# --- Zones that a raster of nodes misses ---------------------------------------------------------


def test_circle_between_the_nodes_is_seen():
    # 70 m around the middle of a cell of 100 m: its corners are 71 m away.
    across = [(0, 150, 50), (1000, 150, 50)]
    assert metres(across, [Circle(350, 150, 70)]) == pytest.approx(140, abs=1e-4)
    assert metres(across, [Circle(350, 150, 70)], 25) == pytest.approx(190, abs=1e-4)
    assert metres(across, [Circle(350, 250, 70)], 25) == 0


@pytest.mark.parametrize("thick_m", [80, 1, 1e-3])
def test_wall_thinner_than_a_cell_is_seen(thick_m):
    west, east = 350 - thick_m / 2, 350 + thick_m / 2
    wall = Polygon(((west, -1), (east, -1), (east, 2001), (west, 2001)))
    assert metres([(0, 1000, 50), (1000, 1000, 50)], [wall]) == pytest.approx(thick_m, abs=1e-4)
    slanting = metres([(0, 500, 50), (700, 1200, 50)], [wall])
    assert slanting == pytest.approx(thick_m * math.sqrt(2), abs=1e-4)


def test_path_inside_an_edge_is_seen():
    zone = Polygon(((0, 0), (2000, 0), (2000, 2000), (0, 2000)))
    along = [(-500, 45, 50), (2500, 45, 50)]
    assert metres(along, [zone]) == pytest.approx(2000, abs=1e-4)
    assert spots(along, zone).distance_m == 0
    assert metres([(-500, -45, 50), (2500, -45, 50)], [zone], 44.9) == 0
    assert metres([(-500, -45, 50), (2500, -45, 50)], [zone], 45.1) == pytest.approx(2000, abs=20)


def test_heights_are_honoured():
    zone = Polygon(SQUARE, lower_m=100, upper_m=200)

    def level(z):
        return metres([(0, 200, z), (400, 200, z)], [zone], 10)

    assert level(89) == level(211) == 0
    # A distance of exactly the margin is enough.
    assert level(90) == level(210) == 0
    assert level(91) == level(209) == pytest.approx(220, abs=1e-4)
    # 90 to 210 m is the third part of the climb from 0 to 360 m: 133 m of 400, within 90 and 310.
    climb = spots([(0, 200, 0), (400, 200, 360)], zone, 10)
    length = math.hypot(400, 360)
    assert climb.metres == pytest.approx(length / 3, abs=1e-4)
    assert climb.entry.at_m == pytest.approx(length / 4, abs=1e-4)
    for limits, free in ({"lower_m": 100}, 80), ({"upper_m": 100}, 120):
        assert metres([(0, 200, free), (400, 200, free)], [Circle(200, 200, 50, **limits)]) == 0
        assert metres([(0, 200, 100), (400, 200, 100 + 1e-9)], [Circle(200, 200, 50)]) > 99


def test_times_are_honoured():
    # At 20 m/s the circle is flown through from 5 to 15 s after the start.
    path = [(0, 0, 50), (100, 0, 50), (400, 0, 50)]
    for t0, t1, expected in (
        (None, 4.9, 0),
        (None, 10, 100),
        (12, None, 60),
        (15.1, None, 0),
        (0, 99, 200),
        (7, 8, 20),
    ):
        zone = Circle(200, 0, 100, t0_s=t0, t1_s=t1)
        assert metres(path, [zone]) == pytest.approx(expected, abs=1e-4)
    assert spots(path, Circle(200, 0, 100, t1_s=4)).distance_m == pytest.approx(20)
    assert spots(path, Circle(200, 0, 100, t0_s=50)).distance_m == math.inf
    assert spots(path, Circle(200, 0, 100, t0_s=50)).nearest is None


def test_a_zone_counts_for_the_parts_of_an_arc_in_wind_that_it_is_active_in():
    """The true times are integrated in steps of 5 cm."""
    rng = np.random.default_rng(5)
    flat = Terrain("flat", np.zeros((41, 41)), 100.0, 100.0)
    for _ in range(40):
        wind = tuple(rng.uniform(-8, 8, 2))
        problem = Problem(flat, (500.0, 500.0, 100.0), (500.0, 1700.0, 100.0), wind=wind)
        evaluator = Evaluator(problem, threads=1)
        path = np.array(
            [problem.start, (3000.0, 500.0, 100.0), (3000.0, 1700.0, 100.0), problem.goal]
        )
        track = evaluator.track(path).sample(0.05)
        east, north = np.diff(track.x), np.diff(track.y)
        moved = np.hypot(east, north)
        east, north, moved = (each[moved > 1e-9] for each in (east, north, moved))
        east, north = east / moved, north / moved
        speed = problem.aircraft.cruise_speed_m_s
        along, cross = wind[0] * east + wind[1] * north, wind[0] * north - wind[1] * east
        seconds = np.cumsum(moved / (along + np.sqrt(speed**2 - cross**2)))
        t0 = float(rng.uniform(0, seconds[-1]))
        t1 = t0 + float(rng.uniform(0.5, 20))
        timed = replace(
            problem,
            zones=[Circle(1700, 1100, 5000, t0_s=t0, t1_s=t1)],
            rules=Rules(zone_margin_m=0),
        )
        found = Evaluator(timed, threads=1).evaluate(path).distance_in_nofly_m
        inside = (seconds >= t0) & (seconds <= t1)
        exact_m = float(moved[inside].sum())
        # At both ends a part of an arc, of some 60 m, may count whole.
        assert exact_m - 0.5 <= found <= exact_m + 2 * 65


def test_times_that_are_not_known_count_as_active():
    pieces, rows = piece_rows(np.array([(0.0, 0, 50), (400, 0, 50)]), 30.0)
    packed = pack_zones([Circle(200, 0, 100, t0_s=99)], 0)
    # The straight is the second of three rows.
    for start, end in ((0.0, math.inf), (math.nan, math.nan), (math.inf, math.inf)):
        times = np.array([0.0, start, end, end])
        assert zone_metres(pieces, rows, times, packed) == pytest.approx(200)
    assert zone_metres(pieces, rows, np.array([0.0, 0.0, 20.0, 20.0]), packed) == 0


# --- Touching ------------------------------------------------------------------------------------


DIAMOND = ((80.0, 0.0), (0.0, 80.0), (-80.0, 0.0), (0.0, -80.0))


@pytest.mark.parametrize("margin_m", [0.0, 25.0, 1 / 3])
@pytest.mark.parametrize("far_m", [0.0, 1e5, 7e6])
@pytest.mark.parametrize(
    ("zone", "reach"),
    [
        (Circle(0, 0, 50), 50),
        (Polygon(((-100, -100), (100, -100), (100, 100), (-100, 100))), 100),
        (Polygon(DIAMOND), 80),
    ],
    ids=["circle", "edge", "corner"],
)
def test_limit_is_exact_to_a_tenth_of_a_millimetre(zone, reach, far_m, margin_m):
    """Lines and arcs pass a zone's northernmost place, even far from the origin."""
    if isinstance(zone, Circle):
        zone = Circle(far_m, -far_m, zone.radius_m)
    else:
        zone = Polygon([(far_m + x, y - far_m) for x, y in zone.ring])
    for aside_m, expected in ((-1e-4, True), (1e-4, False)):
        y = reach + margin_m + aside_m
        # An arc of 100 m rounds a right angle at 41 m from the corner.
        corner = y - 100 * (math.sqrt(2) - 1)
        top = y + 100 * (math.sqrt(2) - 1)
        paths = [
            [(-300, y), (300, y)],
            [(-400, corner + 400), (0, corner), (400, corner + 400)],
            [(-400, top - 400), (0, top), (400, top - 400)],
        ]
        # The last arc, which bends around the place, cuts a flat top.
        for path in paths[: 2 if reach == 100 else 3]:
            placed = [(far_m + px, py - far_m, 50) for px, py in path]
            assert (metres(placed, [zone], margin_m, 100.0) > 0) == expected, path


def test_path_on_an_edge_or_through_a_corner_is_inside():
    zone = Polygon(SQUARE)
    assert metres([(0, 100, 50), (400, 100, 50)], [zone]) == pytest.approx(200, abs=1e-4)
    assert metres([(100, 100, 50), (300, 100, 50)], [zone]) == pytest.approx(200)
    assert metres([(0, 0, 50), (400, 400, 50)], [zone]) == pytest.approx(200 * math.sqrt(2))
    # It touches one corner from outside.
    assert metres([(0, 200, 50), (200, 0, 50)], [zone]) > 0
    assert metres([(0, 199.99, 50), (199.99, 0, 50)], [zone]) == 0
    # Corners that repeat, and a hole that fills the ring, leave the edges.
    repeated = Polygon((SQUARE[0], SQUARE[0], *SQUARE[1:]))
    assert spots([(0, 50, 50), (90, 50, 50)], repeated).distance_m == pytest.approx(math.sqrt(2600))
    assert metres([(0, 0, 50), (400, 400, 50)], [repeated]) == pytest.approx(200 * math.sqrt(2))
    hollow = Polygon(SQUARE, (SQUARE,))
    assert 0 < metres([(0, 200, 50), (400, 200, 50)], [hollow]) < 1e-4
    assert metres([(0, 200, 50), (400, 200, 50)], [hollow], 10) == pytest.approx(40, abs=1e-4)


def test_holes_are_free_less_the_margin():
    hole = ((150, 150), (250, 150), (250, 250), (150, 250))
    zone = Polygon(SQUARE, (hole,))
    assert metres([(170, 200, 50), (230, 200, 50)], [zone], 19.9) == 0
    assert metres([(170, 200, 50), (230, 200, 50)], [zone], 20.1) > 0
    assert spots([(170, 200, 50), (230, 200, 50)], zone, 1).distance_m == pytest.approx(20)
    assert metres([(0, 200, 50), (400, 200, 50)], [zone]) == pytest.approx(100, abs=1e-4)


def test_vertical_pieces_and_points_of_radius_0():
    assert metres([(200, 200, 0), (200, 200, 90)], [Polygon(SQUARE)]) == pytest.approx(90)
    assert metres([(99, 200, 0), (99, 200, 90)], [Polygon(SQUARE)]) == 0
    assert metres([(99, 200, 0), (99, 200, 90)], [Polygon(SQUARE, upper_m=30)], 2) == pytest.approx(
        32, abs=1e-4
    )
    mast = Circle(200, 200, 0, upper_m=40)
    assert metres([(0, 200, 20), (400, 200, 20)], [mast], 15) == pytest.approx(30, abs=1e-4)
    assert 0 < metres([(0, 200, 20), (400, 200, 20)], [mast]) < 1e-4


def test_places_are_those_of_first_entry_and_least_distance():
    zone = Polygon(SQUARE)
    found = spots([(0, 200, 50), (400, 200, 50), (400, 0, 50)], zone, 10)
    assert found.entry.at_m == pytest.approx(90, abs=1e-4)
    assert (found.entry.row, found.distance_m) == (1, 0)
    free = spots([(0, 400, 50), (320, 400, 50), (320, 0, 50)], zone, 10)
    assert free.entry is None
    assert free.metres == 0
    assert free.distance_m == pytest.approx(20)
    assert free.nearest.row == 3
    circle = spots([(0, 0, 0), (400, 0, 0)], Circle(300, 70, 50))
    assert circle.distance_m == pytest.approx(20)
    assert circle.nearest == (1, pytest.approx(0.75), pytest.approx(300))


def test_least_distance_inside_and_beside_arcs():
    zone = Polygon(SQUARE)
    inside = spots([(150, 200, 50), (250, 200, 50)], zone)
    assert (inside.distance_m, inside.metres) == (0, pytest.approx(100))
    # Arcs of 100 m, left and right, whose middle is the place nearest to an edge.
    middle = 100 * (math.sqrt(2) - 1)
    for turn in (1, -1):
        for east, north in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            # The corner points at the square's side, 30 m from it after rounding.
            tip = 130 - middle
            ends = [(tip + 400, turn * 400), (tip, 0), (tip + 400, -turn * 400)]
            path = [(200 + a * east - b * north, 200 + a * north + b * east, 50) for a, b in ends]
            found = spots(path, zone, 0, 100.0)
            assert found.distance_m == pytest.approx(30)
            assert found.nearest.t == pytest.approx(0.5)
            # Half of the way: one of the straights minus the tangent, and half of the arc.
            assert found.nearest.at_m == pytest.approx(400 * math.sqrt(2) - 100 + 25 * math.pi)


def test_no_zones():
    assert metres([(0, 0, 0), (9, 0, 0)], []) == 0


def test_polygon_of_many_corners():
    angles = np.linspace(0, 2 * np.pi, 3001)[:-1]
    ring = np.column_stack((500 + 300 * np.cos(angles), 500 + 300 * np.sin(angles)))
    zone = Polygon([tuple(corner) for corner in ring.tolist()])
    around = [(150, 500, 50), (500, 150, 50), (850, 500, 50), (500, 850, 50), (150, 500, 50)]
    for path in ([(0, 500, 50), (1000, 500, 50)], around):
        for margin_m in (0.0, 40.0):
            expected = metres(path, [Circle(500, 500, 300)], margin_m, 100.0)
            assert metres(path, [zone], margin_m, 100.0) == pytest.approx(expected, abs=0.5)
