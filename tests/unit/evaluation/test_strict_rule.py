"""The strict rule compared with dense samples, and on tracks with a known excess."""

import math
import time
from collections import Counter

import numpy as np
import pytest

from pathgene.host.diagnosis.reason import broken_limit
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.pieces import fastest_over_ground
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.report.summary import terms
from pathgene.host.terrain import Terrain
from tests.support.host.flight_cases import random_case, random_edge_case
from tests.support.host.flight_oracle import examine


def strict_penalty(problem, path):
    path = np.asarray(path, dtype=np.float64)
    evaluator = Evaluator(problem, threads=1)
    return float(evaluator.penalty_cost(path[None], np.array([len(path)]), fine=True)[0][0])


def compare(count, seed, make=random_case):
    """Compare ``count`` random paths; return counts, such as of paths near a limit."""
    counts = Counter()
    case = 0
    while counts["paths"] < count:
        case += 1
        problem, path = make(np.random.default_rng((seed, case)))
        try:
            penalty = strict_penalty(problem, path)
        except InputError:
            # A straight path that costs nothing.
            continue
        found = examine(problem, path)
        counts["paths"] += 1
        counts["near"] += found.near
        counts["feasible"] += penalty == 0
        assert penalty > 0 or not found.rejected, (seed, case, found)
        if found.accepted_with_a_metre:
            counts["roomy"] += 1
            counts["refused"] += penalty > 0
    return counts


@pytest.mark.ci
def test_no_path_is_feasible_that_samples_reject():
    counts = compare(100, 1)
    assert counts["near"] >= 25
    assert counts["feasible"] >= 20
    assert counts["refused"] <= 0.01 * counts["roomy"]


@pytest.mark.long
def test_no_path_of_many_is_feasible_that_samples_reject():
    """Takes about 25 minutes on one core."""
    counts = compare(20_000, 2)
    assert counts["near"] >= 5_000
    assert counts["roomy"] >= 3_500
    assert counts["refused"] <= 0.01 * counts["roomy"]


def test_no_path_along_the_edge_is_feasible_that_samples_reject():
    counts = compare(150, 3, random_edge_case)
    assert counts["near"] >= 70
    assert counts["feasible"] >= 40
    assert counts["roomy"] >= 15
    assert counts["refused"] <= 0.01 * counts["roomy"]


@pytest.mark.long
def test_no_path_of_many_along_the_edge_is_feasible_that_samples_reject():
    """Takes about 10 minutes on one core."""
    counts = compare(5_000, 4, random_edge_case)
    assert counts["roomy"] >= 800
    assert counts["refused"] <= 0.01 * counts["roomy"]


def beyond_the_edge(problem, path):
    """Return a problem and its path over land that extends beyond the edge at its height."""
    terrain = problem.terrain
    nodes = math.ceil(problem.rules.corridor_m / min(terrain.dx_m, terrain.dy_m)) + 1
    wide = Terrain("wide", np.pad(terrain.elevation, nodes, "edge"), terrain.dx_m, terrain.dy_m)
    moved = path + np.array((nodes * terrain.dx_m, nodes * terrain.dy_m, 0.0))
    heading = problem.start_heading_deg
    options = {"rules": problem.rules, "start_heading_deg": heading}
    return Problem(wide, moved[0], moved[-1], problem.aircraft, **options), moved


def test_samples_find_paths_that_take_the_height_of_the_edge_for_the_ground_beyond():
    found = 0
    for case in range(60):
        problem, path = random_edge_case(np.random.default_rng((3, case)))
        if strict_penalty(*beyond_the_edge(problem, path)) == 0:
            found += examine(problem, path).rejected
    assert found >= 10


def land(elevation, cell_m=30.0):
    return Terrain(
        name="land", elevation=elevation, dx_m=cell_m, dy_m=cell_m, crs=None, origin=(0.0, 0.0)
    )


def straight(elevation, start, goal, **rules):
    return Problem(land(elevation), start, goal, rules=Rules(**rules)), [start, goal]


def test_clearance_is_kept_to_a_nanometre_and_a_corner_of_a_cell_counts():
    elevation = np.full((21, 21), 10.0)
    elevation[10, 10] = 60.0
    # Its square begins at 285 m, where heights between nodes are lower.
    for y, low, highest in ((260.1, 25.0, 60.0), (260.1, 24.0, None), (240.0, 25.0, None)):
        start, goal = (40.0, y, 90.0), (560.0, y, 90.0)
        problem, path = straight(elevation, start, goal, corridor_m=low)
        assert strict_penalty(problem, path) == 0
        under, path = straight(
            elevation, (40.0, y, 90.0 - 1e-6), (560.0, y, 90.0 - 1e-6), corridor_m=low
        )
        assert (strict_penalty(under, path) > 0) == (highest is not None)


def test_ceiling_above_ground_is_over_the_higher_of_both_surfaces():
    elevation = np.full((21, 21), 10.0) + 3.0 * np.arange(21)
    for above_m, allowed in ((0.0, True), (1e-6, False)):
        # On a slope of 0.1 the nearest node is up to 1.5 m lower; the height between counts then.
        start, goal = ((x, 300.0, 10.0 + 0.1 * x + 60.0 + above_m) for x in (40.0, 560.0))
        problem, path = straight(elevation, start, goal, ceiling_agl_m=60.0)
        assert (strict_penalty(problem, path) == 0) == allowed


def test_limits_touched_all_along_take_milliseconds():
    nodes = np.arange(700) * 30.0
    plane = np.add.outer(0.02 * nodes, 0.03 * nodes) + 100
    for goal in ((20_000.0, 333.0), (20_000.0, 15_000.0)):
        for above_m in (30.0, 30.0 + 1e-6, 60.0, 60.0 - 1e-6):
            ends = [(x, y, 100 + 0.03 * x + 0.02 * y + above_m) for x, y in ((100.0, 333.0), goal)]
            problem, path = straight(plane, *ends, ceiling_agl_m=60.0, corridor_m=0.0)
            strict_penalty(problem, path)
            began = time.process_time()
            strict_penalty(problem, path)
            assert time.process_time() - began < 0.5


FLAT = np.full((34, 34), 10.0)


def along_the_edge(away_m, **rules):
    """Return the evaluation of a level flight of 900 m along the south edge of flat land."""
    problem, path = straight(FLAT, (45.0, away_m, 90.0), (945.0, away_m, 90.0), **rules)
    return Evaluator(problem, threads=1).evaluate(np.array(path))


def test_the_corridor_stays_on_the_map():
    for away_m, corridor_m in ((25.0, 25.0), (24.9, 24.9), (0.0, 0.0), (5.0, 0.0)):
        kept = along_the_edge(away_m, corridor_m=corridor_m)
        assert kept.feasible
        assert "map" not in [limit["limit"] for limit in kept.limits]
        assert kept.minimum_clearance_m == pytest.approx(80)
    left = along_the_edge(20.0)
    assert not left.feasible
    assert left.distance_under_terrain_m == pytest.approx(900)
    assert left.limits[0] == {
        "limit": "map",
        "worst": pytest.approx(-5, abs=1e-5),
        "allowed": 0.0,
        "at_m": pytest.approx(7.5),
    }
    summary = terms(left)
    assert summary["minimum_clearance_m"] is None
    clearance = next(limit for limit in summary["limits"] if limit["limit"] == "clearance")
    assert clearance["worst"] == pytest.approx(80)
    assert broken_limit(summary["limits"]) == (
        "has a corridor that leaves the map by 5 m, 8 m from the start"
    )


def test_the_place_where_the_corridor_leaves_the_map():
    problem, path = straight(FLAT, (100.0, 500.0, 90.0), (900.0, 20.0, 90.0))
    evaluator = Evaluator(problem, threads=1)
    track = np.array(path)
    way = (track[1] - track[0])[:2]
    east, north = way / np.hypot(*way)
    # The south rim is at y = 25 * east.
    along = (500.0 - 25.0 * east) / -north
    (stretch,) = evaluator.broken(track)
    assert stretch.limit == "map"
    assert stretch.from_m == pytest.approx(along, abs=problem.ds_m)
    assert stretch.to_m == pytest.approx(np.hypot(*way))
    # At the edge itself, the corridor of a path straight inwards is on the map.
    inwards, path = straight(FLAT, (500.0, 0.0, 90.0), (500.0, 500.0, 90.0))
    assert strict_penalty(inwards, path) == 0


def test_end_beside_a_void_excuses_nothing():
    elevation = np.full((21, 21), 10.0)
    elevation[2, 2] = np.nan
    elevation[10, 10] = 200.0
    # The nearest node of the start is land, the height between nodes is void.
    problem, path = straight(elevation, (80.0, 80.0, 60.0), (560.0, 560.0, 60.0))
    evaluation = Evaluator(problem, threads=1).evaluate(np.array(path))
    assert not evaluation.feasible
    clear, path = straight(elevation, (100.0, 100.0, 60.0), (560.0, 560.0, 60.0))
    terms = Evaluator(clear, threads=1).evaluate(np.array(path))
    assert evaluation.distance_under_terrain_m > terms.distance_under_terrain_m > 30


def test_a_clearance_over_a_void_is_unknown():
    elevation = np.full((21, 21), 10.0)
    elevation[:, 10] = np.nan
    problem, path = straight(elevation, (80.0, 80.0, 60.0), (560.0, 560.0, 60.0))
    evaluation = Evaluator(problem, threads=1).evaluate(np.array(path))
    summary = terms(evaluation)
    assert (evaluation.feasible, summary["minimum_clearance_m"]) == (False, None)
    worst = summary["limits"][0]
    assert (worst["limit"], worst["worst"], worst["allowed"]) == ("clearance", None, 30.0)
    assert broken_limit(summary["limits"]).startswith("breaks the limit clearance over a void, ")


def test_greatest_ground_speed_of_an_arc_is_exact():
    rng = np.random.default_rng(0)
    flat = land(np.full((5, 5), 10.0))
    for _ in range(200):
        wind, first, angle = rng.uniform(0, 15), rng.uniform(0, 2 * math.pi), rng.uniform(0, 3.14)
        side = rng.choice([-1.0, 1.0])
        problem = Problem(flat, (0, 0, 50), (100, 100, 50), wind=(wind, 0.0))
        constants = Evaluator(problem, threads=1).course.c
        found = fastest_over_ground(constants, 22.0, math.cos(first), math.sin(first), side, angle)
        headings = first + side * np.linspace(0, angle, 20_001)
        speeds = wind * np.cos(headings) + np.sqrt(22.0**2 - (wind * np.sin(headings)) ** 2)
        assert found == pytest.approx(speeds.max(), rel=1e-8)
        assert found >= speeds.max() - 1e-9
