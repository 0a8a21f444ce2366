"""The score of a path: the compiled score equals the definition, whose integers never overflow."""

import dataclasses
import math

import numpy as np
import pytest

from pathgene.hdl.protocol.planner import ALTITUDE_FRACTION, POSITION_FRACTION
from pathgene.sim.model.planner.course import problem_vector
from pathgene.sim.model.planner.definition.score import corner_of
from pathgene.sim.model.planner.definition.score import score as defined
from pathgene.sim.model.planner.score import WORK_ROWS, score
from pathgene.sim.model.planner.wavefront import root
from tests.support.planner.cases import LARGE, SMALL, USUAL, any_record, headed, path, record, rows
from tests.support.planner.scorer_cases import compiled_chords


def compiled(config, problem, points, *, first=False):
    count = len(points) + problem.has_entry + problem.has_exit
    # Remains of an earlier path must not count.
    work = np.full((WORK_ROWS, count), 1 << 40, dtype=np.int64)
    result = score(problem_vector(config, problem), rows(points), len(points), work, first)
    return result, compiled_chords(work)


def assert_same(config, problem, points):
    expected = defined(problem, points)
    result, chords = compiled(config, problem, points)
    assert result == (expected.cost, expected.penalty)
    assert chords == [None if arc is None else arc.chord for arc in expected.arcs]
    result, _ = compiled(config, problem, points, first=True)
    assert result == (0 if expected.penalty else expected.cost, expected.penalty)


@pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])
def test_compiled_score_is_the_defined_one(config):
    rng = np.random.default_rng(4)
    for _ in range(400):
        assert_same(config, record(config, rng), path(config, rng))
        assert_same(config, any_record(config, rng), path(config, rng))
        for any_problem in (record(config, rng), any_record(config, rng)):
            assert_same(config, headed(config, rng, any_problem), path(config, rng))


def test_an_entry_and_an_exit_are_points_of_the_path():
    """A path scores as the path without its first and last point, which are entry and exit."""
    rng = np.random.default_rng(20)
    for _ in range(200):
        problem, points = record(USUAL, rng), path(USUAL, rng, waypoints=6)
        points[0], points[-1] = corner_of(problem, "start"), corner_of(problem, "goal")
        ends = {
            f"{end}_{axis}": value << (ALTITUDE_FRACTION if axis == "altitude" else 8)
            for end, point in (("start", points[1]), ("goal", points[-2]))
            for axis, value in zip(("x", "y", "altitude"), point, strict=True)
        }
        outer = {
            f"{outer}_{axis}": getattr(problem, f"{end}_{axis}")
            for outer, end in (("entry", "start"), ("exit", "goal"))
            for axis in ("x", "y", "altitude")
        }
        inner = dataclasses.replace(problem, **ends, **outer, has_entry=1, has_exit=1)
        assert defined(inner, points[1:-1]) == defined(problem, points)


def test_the_longest_path_does_not_overflow():
    """It joins corners of the largest map, up and down, with every field at its maximum."""
    rng = np.random.default_rng(5)
    far, top = LARGE.map_size - 1, LARGE.blocked_altitude - 1
    # Back and forth along the diagonal, and with a right angle at every other corner.
    zigzag = [(far * (i % 2), far * (i % 2), top * (i % 2)) for i in range(66)]
    angled = [(far * (i % 2), far * (i // 2 % 2), top * (i % 2)) for i in range(66)]
    greatest = {"rise": (1 << 20) - 1, "drag": (1 << 16) - 1, "fuel": (1 << 16) - 1}
    for base in (-(1 << 24), (1 << 24) - 1):
        problem = record(LARGE, rng, base=base, radius=1, fuel_shift=0, **greatest)
        outer = headed(LARGE, rng, problem)
        outer = dataclasses.replace(outer, has_entry=1, has_exit=1)
        for points in (zigzag, angled):
            for each in (problem, outer):
                assert_same(LARGE, each, points)
                assert abs(defined(each, points).cost) < 1 << 63


def test_roots():
    rng = np.random.default_rng(6)
    assert [root(i) for i in range(5000)] == [math.isqrt(i) for i in range(5000)]
    for _ in range(5000):
        value = int(rng.integers(1 << int(rng.integers(1, 31))))
        for square in (value * value - 1, value * value, value * value + 1):
            assert square < 0 or root(square) == math.isqrt(square)


def test_lengths_and_costs_are_those_of_the_formulas():
    """A path with one turn is computed in floating point: cells of 256 units, steps of 16."""
    rng = np.random.default_rng(7)
    for _ in range(50):
        problem = record(
            USUAL, rng, x_scale=1 << 14, climb=(1 << 24) - 1, descent=(1 << 24) - 1, radius=500
        )
        points = [corner_of(problem, "start"), (250, 260, 3000), corner_of(problem, "goal")]
        places = np.array(
            [
                (problem.start_x, problem.start_y, problem.start_altitude),
                [c << POSITION_FRACTION for c in points[1][:2]] + [3000 << ALTITUDE_FRACTION],
                (problem.goal_x, problem.goal_y, problem.goal_altitude),
            ],
            dtype=float,
        )
        before, after = np.diff(places, axis=0)
        lengths = [math.hypot(*side[:2]) for side in (before, after)]
        angle = math.acos(before[:2] @ after[:2] / lengths[0] / lengths[1])
        tangent, per_part = 500 * math.tan(angle / 2), problem.rise / 65536
        heights = [
            places[1, 2] - before[2] * tangent / lengths[0],
            places[1, 2] + after[2] * tangent / lengths[1],
        ]
        altitudes = [places[0, 2], *heights, places[2, 2]]
        runs = [lengths[0] - tangent, 500 * angle, lengths[1] - tangent]
        cost = 0.0
        for run, low, high in zip(runs, altitudes, altitudes[1:], strict=False):
            flown = math.hypot(run, (high - low) * per_part)
            pull = problem.drag * flown + problem.rise * (high - low)
            cost += (low + high + problem.base) * flown + max(pull, 0) * problem.fuel / 2**13
        scored = defined(problem, points)
        assert scored.penalty == 0
        assert scored.cost == pytest.approx(cost, rel=5e-5)


def test_penalties():
    rng = np.random.default_rng(8)
    far = 20 << POSITION_FRACTION
    level = {"start_altitude": 1600, "goal_altitude": 1600, "x_scale": 1 << 14, "radius": 256}
    ends = {"start_x": 0, "start_y": 0, "goal_x": far, "goal_y": 0}
    problem = record(USUAL, rng, **ends, **level, climb=0, descent=0)
    start, goal = (0, 0, 100), (20, 0, 100)
    assert defined(problem, [start, (10, 0, 100), goal]).penalty == 0
    # Two segments, by a step or 16 parts each: up, then down.
    assert defined(problem, [start, (10, 0, 101), goal]).penalty == 2 * (64 + 4 * 16)
    # A climb of 7.5 parts in 10 cells is allowed, 8.5 are too many.
    gentle = dataclasses.replace(problem, climb=12)
    assert defined(gentle, [start, (10, 0, 101), goal]).penalty == 2 * 64 + 4 * 16 + 34
    # A reversal and a repeated waypoint have no arc.
    turned = defined(problem, [start, (30, 0, 100), goal])
    assert turned.arcs == [None]
    assert turned.penalty == 40 * 256 >> 3
    twice = defined(problem, [start, (10, 0, 100), (10, 0, 100), goal])
    assert twice.arcs == [None, None]
    assert twice.penalty == 2 * far >> 3


def test_steep_arcs_count_beside_steep_segments():
    """The arc of a right angle between two climbs at the limit is steeper than they are."""
    rng = np.random.default_rng(9)
    far = 10 << POSITION_FRACTION
    ends = {"start_x": 0, "start_y": 0, "start_altitude": 1600, "goal_x": far, "goal_y": far}
    problem = record(USUAL, rng, **ends, x_scale=1 << 14, goal_altitude=1920, climb=256, radius=512)
    points = [(0, 0, 100), (10, 0, 110), (10, 10, 120)]
    # A quarter of a circle.
    assert defined(problem, points).penalty == 804
    assert defined(dataclasses.replace(problem, radius=50), points).penalty == 256
    # A climb of one part more.
    steeper = dataclasses.replace(problem, goal_altitude=1921)
    assert defined(steeper, points).penalty == 804 + 64 + 4
    for each in (problem, steeper):
        assert_same(USUAL, each, points)
