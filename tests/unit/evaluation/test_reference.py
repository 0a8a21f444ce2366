"""The reference and the compiled evaluator on cases computed by hand."""

import dataclasses
import math
from collections import Counter

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator, reference
from pathgene.host.problem.aircraft import load
from pathgene.host.problem.zones import Circle
from tests.support.host.flight_cases import random_case


FOX = load("silver-fox")


@pytest.fixture(params=["reference", "compiled"])
def evaluate(request):
    """Function that returns the terms of a path, by each implementation."""

    def run(problem, points, **options):
        path = np.array([problem.start, *points, problem.goal])
        if request.param == "reference":
            return reference.evaluate(problem, path, **options)
        return Evaluator(problem, threads=1, **options).evaluate(path)

    return run


def columns(**heights):
    """Return flat ground at 100 m, 51 x 51, with other heights in the columns ``c5=...``."""
    elevation = np.full((51, 51), 100.0)
    for name, height in heights.items():
        elevation[:, int(name[1:])] = height
    return elevation


def test_straight_line_is_utopia(evaluate, make_problem):
    terms = evaluate(make_problem((100, 100, 200), (3100, 4100, 300)), [])
    assert terms.length_m == math.hypot(5000, 100)
    assert terms.mean_altitude_m == 250
    assert (terms.penalty, terms.cost, terms.fitness) == (0, 1, 1.5)


def test_every_term_of_a_quarter_turn(evaluate, make_problem):
    problem = make_problem((0, 0, 200), (1000, 1000, 200))
    terms = evaluate(problem, [(1000, 0, 200)])
    length = 850 + 75 * math.pi + 850
    drag = 248.8416 * 0.0251 + 113**2 / (math.pi * 0.8 * 7.5 * 248.8416)
    utopia = math.hypot(1000, 1000)
    assert terms.length_m == pytest.approx(length)
    assert terms.mean_altitude_m == pytest.approx(200)
    # Weight and drag fall by a thousandth here.
    assert terms.fuel_N == pytest.approx(drag * length * 1.1569e-6 / 0.8, rel=3e-4)
    assert terms.cost == pytest.approx(length / utopia, rel=1e-4)
    assert terms.fitness == pytest.approx(1 + 1 / (1 + terms.cost))
    assert terms.penalty == 0


def test_mean_altitude_weighs_by_length(evaluate, make_problem):
    # An impossible corner in a short leg: pieces of 100 m and 1000 m.
    terms = evaluate(make_problem((0, 0, 200), (100, 1000, 300)), [(100, 0, 200)])
    second = math.hypot(1000, 100)
    assert terms.mean_altitude_m == pytest.approx((100 * 200 + second * 250) / (100 + second))
    assert terms.impossible_arcs == 1


@pytest.mark.parametrize(("height", "expected"), [(200.0, 0.0), (200.000001, 100.0)])
def test_under_the_terrain_is_strict(evaluate, make_problem, height, expected):
    # Mid-points 75, 125, ... 975; nearest to column 5 from 450 up to, not including, 550.
    problem = make_problem((50, 500, 200), (950, 500, 200), columns(c5=height))
    assert evaluate(problem, []).distance_under_terrain_m == expected


@pytest.mark.parametrize(
    ("y", "expected"), [(449.999, 0.0), (450.0, 700.0), (549.999, 700.0), (550.0, 0.0)]
)
def test_nearest_node_rounds_half_up(evaluate, make_problem, y, expected):
    elevation = np.full((51, 51), 100.0)
    elevation[5, 2:9] = 500.0
    problem = make_problem((0, y, 200), (1000, y, 200), elevation)
    assert evaluate(problem, []).distance_under_terrain_m == expected


@pytest.mark.parametrize("row", range(1, 12))
def test_border_between_cells_of_odd_size(evaluate, make_problem, row):
    # A product like 6.5 * 30.87 is rounded; y / dy decides on which side of it a path lies.
    y = (row - 0.5) * 30.87
    elevation = np.full((40, 40), 100.0)
    elevation[row, 2:31] = 500.0
    problem = make_problem((0, y, 200), (1203.93, y, 200), elevation, dx_m=30.87, dy_m=30.87)
    on_row = math.floor(y / 30.87 + 0.5) == row
    expected = 29 * 30.87 if on_row else 0
    assert evaluate(problem, []).distance_under_terrain_m == pytest.approx(expected, abs=16)


def test_distance_under_terrain_is_in_parts_of_each_piece(evaluate, make_problem):
    # 905 m in ceil(905 / 50) = 19 equal parts; three mid-points lie over column 5.
    problem = make_problem((50, 500, 200), (955, 500, 200), columns(c5=300.0))
    middles = 50 + 905 / 19 * (np.arange(19) + 0.5)
    count = np.count_nonzero((middles >= 450) & (middles < 550))
    assert evaluate(problem, []).distance_under_terrain_m == pytest.approx(count * 905 / 19)
    assert count in (2, 3)


def test_default_step_is_half_the_smaller_side_of_a_cell(make_problem):
    assert make_problem((0, 0, 200), (900, 0, 200), dx_m=80.0, dy_m=30.0).ds_m == 15.0


def test_void_is_impassable(evaluate, make_problem):
    problem = make_problem((50, 500, 5000), (950, 500, 5000), columns(c5=np.nan))
    terms = evaluate(problem, [])
    assert (terms.distance_under_terrain_m, terms.void_crossed_m) == (100, 100)
    assert terms.penalty == 100


def test_outside_the_map_is_under_the_terrain(evaluate, make_problem):
    problem = make_problem((100, 1000, 900), (100, 3000, 900))
    terms = evaluate(problem, [(-900, 1000, 900), (-900, 3000, 900)])
    # Both arcs fit. From x = 0 to the west: two legs of 900 less 150, two arcs, one straight.
    expected = 2 * 750 + 150 * math.pi + 1700
    assert terms.distance_under_terrain_m == pytest.approx(expected, abs=100)
    assert terms.void_crossed_m == 0


def test_the_edge_of_the_map_is_on_it(evaluate, make_problem):
    problem = make_problem((0, 0, 200), (5000, 5000, 200))
    assert evaluate(problem, [(5000, 0, 200)]).penalty == 0


def test_no_fly_zone_counts_apart_from_the_terrain(evaluate, make_problem):
    problem = make_problem(
        (50, 500, 200), (950, 500, 200), columns(c5=300.0), zones=(Circle(500, 500, 100),)
    )
    terms = evaluate(problem, [])
    assert terms.distance_under_terrain_m == 100  # Column 5.
    assert terms.distance_in_nofly_m == 300  # Columns 4 to 6.
    assert terms.penalty == 400
    assert terms.fitness == 1 / 401


@pytest.mark.parametrize(
    ("slope_deg", "steep"), [(10, False), (10.00001, True), (-30, False), (-30.00001, True)]
)
def test_slope_limits_are_inclusive(evaluate, make_problem, slope_deg, steep):
    rise = 3000 * math.tan(math.radians(slope_deg))
    up = rise if rise > 0 else 0
    problem = make_problem((1000, 1000, 2000), (4000, 4000, 2000 + up))
    # Over (1000, 4000), so that the first leg is `rise` on 3000 m and the corner cannot be rounded.
    problem = dataclasses.replace(problem, aircraft=dataclasses.replace(FOX, turn_radius_m=5000.0))
    terms = evaluate(problem, [(1000, 4000, 2000 + rise)])
    first = math.hypot(3000, rise)
    back = math.atan2(up - rise, 3000) > math.radians(10)
    expected = (first if steep else 0) + (math.hypot(3000, up - rise) if back else 0)
    assert terms.distance_too_steep_m == pytest.approx(expected)


def test_two_legs_at_the_limit_meet_in_an_arc_beyond_it(evaluate, make_problem):
    climb = math.tan(math.radians(10))
    problem = make_problem((0, 0, 200), (1000, 1000, 200 + 2000 * climb))
    terms = evaluate(problem, [(1000, 0, 200 + 1000 * climb)])
    arc = math.hypot(75 * math.pi, 300 * climb)
    assert terms.distance_too_steep_m == pytest.approx(arc)
    assert terms.penalty == pytest.approx(arc)


def test_impossible_arcs_cost_their_share_of_the_length(evaluate, make_problem):
    # Two corners 100 m apart do not fit, the third does.
    problem = make_problem((0, 0, 200), (3000, 1000, 200))
    terms = evaluate(problem, [(1000, 0, 200), (1000, 100, 200), (3000, 100, 200)])
    assert terms.impossible_arcs == 2
    assert terms.length_m == pytest.approx(1000 + 100 + 1850 + 75 * math.pi + 750)
    assert terms.penalty == pytest.approx(2 / 3 * terms.length_m)
    assert terms.fitness == pytest.approx(1 / (1 + terms.penalty))


def test_zero_wind_changes_no_bit(evaluate, make_problem):
    points = [(700, 300, 250), (1500, 1900, 180)]
    ends = (10, 20, 200), (3000, 4000, 300)
    calm = evaluate(make_problem(*ends), points)
    assert evaluate(make_problem(*ends, wind=(0.0, -0.0)), points) == calm


def test_wind_scales_fuel_and_utopia(evaluate, make_problem):
    ends = (0, 0, 200), (3000, 0, 200)
    calm, tail, head = (
        evaluate(make_problem(*ends, wind=wind), []) for wind in ((0, 0), (10, 0), (-10, 0))
    )
    assert tail.fuel_N == pytest.approx(calm.fuel_N * 23 / 33, rel=1e-3)
    assert head.fuel_N == pytest.approx(calm.fuel_N * 23 / 13, rel=1e-3)
    assert (tail.cost, head.cost) == (1, 1)


def test_wind_on_an_arc_is_the_sum_of_eight_parts(evaluate, make_problem):
    ends, corner, wind = ((0, 0, 200), (1000, 1000, 200)), [(1000, 0, 200)], (9.0, -4.0)
    air = 850 * 23 / (9 + math.sqrt(23**2 - 4**2)) + 850 * 23 / (-4 + math.sqrt(23**2 - 9**2))
    for part in range(8):
        angle = math.pi / 2 * (part + 0.5) / 8
        along = 9 * math.cos(angle) - 4 * math.sin(angle)
        across = 9 * math.sin(angle) + 4 * math.cos(angle)
        air += 150 * math.pi / 16 * 23 / (along + math.sqrt(23**2 - across**2))
    calm = evaluate(make_problem(*ends), corner)
    windy = evaluate(make_problem(*ends, wind=wind), corner)
    assert windy.fuel_N / calm.fuel_N == pytest.approx(air / calm.length_m, rel=1e-5)


def test_piece_that_the_wind_forbids_is_too_steep(evaluate, make_problem):
    # 45 degrees leave 16.3 of 23 m/s; a crosswind of 17 m/s exceeds that. The climb limit is not
    # reached.
    aircraft = dataclasses.replace(
        FOX, max_climb_deg=80.0, max_descent_deg=80.0, turn_radius_m=5000.0
    )
    problem = make_problem((0, 1000, 200), (3000, 1000, 200), aircraft=aircraft, wind=(0, 17))
    terms = evaluate(problem, [(1000, 1000, 1200)])
    assert terms.distance_too_steep_m == pytest.approx(math.hypot(1000, 1000))
    assert math.isfinite(terms.fuel_N)


@pytest.mark.parametrize(
    ("altitudes", "wind", "message"),
    [
        (
            (100, -101),
            (0, 0),
            r"has a mean altitude of -0\.5 m, and costs are relative to it; "
            r"shift the datum so that it is positive\.",
        ),
        (
            (1000, 500),
            (0, 0),
            "is so steep a glide that it burns no fuel, and costs are relative to it; "
            r"raise the goal or lower the start\.",
        ),
        (
            (100, 1100),
            (0, 17),
            "cannot be flown in this wind, and costs are relative to it; "
            r"reduce the wind or move start or goal\.",
        ),
    ],
    ids=["below the datum", "glide", "wind"],
)
def test_no_utopia(altitudes, wind, message):
    start, goal = (0, 0, altitudes[0]), (1000, 0, altitudes[1])
    with pytest.raises(InputError, match=f"^The straight line from start to goal {message}$"):
        reference.utopia(start, goal, FOX, wind)


def random_problem(seed):
    """Return a problem without timed zones, which the definition of the search leaves out."""
    problem, path = random_case(np.random.default_rng(seed))
    zones = tuple(zone for zone in problem.zones if zone.t0_s is None and zone.t1_s is None)
    return dataclasses.replace(problem, zones=zones), path


@pytest.mark.ci
def test_search_agrees_with_the_definition():
    counts = Counter()
    for case in range(250):
        problem, path = random_problem((5, case))
        try:
            evaluator = Evaluator(problem, threads=1)
        except InputError:
            continue
        terms = reference.evaluate(problem, path)
        penalty, cost = (
            values[0] for values in evaluator.penalty_cost(path[None], np.array([len(path)]))
        )
        fitness = evaluator.fitness(path[None], np.array([len(path)]))[0]
        assert cost == pytest.approx(terms.cost, rel=1e-9), case
        # Samples at the border of two cells may fall to either side: one part for each piece.
        parts = 2 * len(path) * evaluator.ds_m
        sampled = terms.distance_under_terrain_m + terms.distance_in_nofly_m
        closed = terms.penalty - sampled
        assert penalty >= closed * (1 - 1e-9)
        assert penalty == pytest.approx(terms.penalty, rel=1e-9, abs=parts), case
        counts["exact"] += penalty == pytest.approx(terms.penalty, rel=1e-9)
        counts["feasible"] += fitness > 1
        counts["paths"] += 1
        for name in ("wind", "start_heading_deg", "goal_heading_deg", "zones"):
            counts[name] += getattr(problem, name) not in (None, (), (0.0, 0.0))
        counts["roof"] += problem.roof is not None
        blind = evaluator.fitness_counted(path[None], np.array([len(path)]), np.array([sampled]))[0]
        if terms.penalty > 0:
            assert blind == pytest.approx(terms.fitness, rel=1e-8), case
    assert counts["exact"] >= 0.97 * counts["paths"]
    assert min(counts[name] for name in ("wind", "start_heading_deg", "zones", "roof")) >= 20
    assert counts["feasible"] >= 20


@pytest.mark.ci
def test_limits_of_reference_and_kernels_agree():
    beyond = 0
    for case in range(150):
        problem, path = random_problem((6, case))
        plane = dataclasses.replace(
            problem.aircraft, engine_power_W=150.0, fuel_weight_N=0.01, service_ceiling_m=60.0
        )
        problem = dataclasses.replace(problem, aircraft=plane)
        try:
            evaluator = Evaluator(problem, threads=1)
        except InputError:
            continue
        terms = reference.evaluate(problem, path)
        sampled = terms.distance_under_terrain_m + terms.distance_in_nofly_m
        fitness = evaluator.fitness_counted(path[None], np.array([len(path)]), np.array([sampled]))[
            0
        ]
        assert fitness == pytest.approx(terms.fitness, rel=1e-8), case
        evaluation = evaluator.evaluate(path)
        beyond += evaluation.distance_beyond_limits_m > 0
        assert evaluation.fuel_N == pytest.approx(terms.fuel_N, rel=1e-9)
        assert evaluation.distance_too_steep_m == pytest.approx(terms.distance_too_steep_m)
    assert beyond > 100
