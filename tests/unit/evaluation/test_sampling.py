"""Samples on arcs and straight pieces: fast loops, general loops and plain arithmetic."""

import math

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.sampling import (
    Bend,
    arc_general,
    arc_point,
    count_arc,
    count_straight,
    half_turn,
    some_arc_hits,
    some_straight_hits,
    straight_general,
)
from pathgene.host.problem.zones import Circle


@pytest.fixture(params=[(), (Circle(2600, 2000, 700),)], ids=["no zone", "zone"])
def evaluator(make_problem, request):
    """Evaluator over rough ground, which reveals every missed cell."""
    elevation = np.random.default_rng(1).uniform(0, 1000, (45, 60))
    elevation[[0, -1], [0, -1]] = 100.0
    return Evaluator(make_problem((0, 0, 400), (5900, 4400, 500), elevation, zones=request.param))


def test_sine_and_cosine():
    for half in np.linspace(0, math.pi / 2, 20_001):
        sin, cos = half_turn(half)
        assert abs(sin - math.sin(half)) < 4e-16
        assert abs(cos - math.cos(half)) < 4e-16


def arcs(rng, count):
    """Yield arcs that begin on the map; some leave it."""
    for _ in range(count):
        heading = rng.uniform(0, 2 * math.pi)
        yield Bend(
            (*rng.uniform(0, (5900, 4400)), rng.uniform(0, 1000)),
            math.cos(heading),
            math.sin(heading),
            rng.choice([-1.0, 1.0]),
            rng.uniform(1e-9, math.pi),
            rng.uniform(-300, 300),
        )


def test_points_of_an_arc(evaluator):
    c = evaluator.course.c
    for bend in arcs(np.random.default_rng(2), 500):
        a, ux, uy, side, angle, rise = bend
        for t in (0.0, 0.1, 0.5, 0.99, 1.0):
            x, y, z = arc_point(c, bend, t)
            # Rotate about the centre, which lies a radius to the side.
            centre = np.array(a[:2]) + side * c.turn_radius_m * np.array((-uy, ux))
            turned = side * angle * t
            cos, sin = math.cos(turned), math.sin(turned)
            out = np.array(a[:2]) - centre
            expected = centre + np.array([[cos, -sin], [sin, cos]]) @ out
            assert (x, y) == pytest.approx(tuple(expected), abs=1e-11)
            assert z == a[2] + rise * t


def test_quick_and_general_arcs_count_the_same(evaluator):
    course = evaluator.course
    c = course.c
    seen = set()
    for arc in arcs(np.random.default_rng(3), 3000):
        parts = int(np.ceil(c.turn_radius_m * arc.angle / 7))
        told = tuple(count_arc(course, arc, parts))
        assert told == tuple(arc_general(course, arc, parts))
        seen.add(told)
    assert len(seen) > 30
    assert any(zone for _, zone in seen) == np.isnan(course.zoned).any()


@pytest.mark.parametrize("along", ["anything", "a border east", "a border north"])
def test_quick_and_general_straights_count_the_same(evaluator, along):
    course = evaluator.course
    c = course.c
    rng = np.random.default_rng(4)
    corner = ((c.columns - 1) * c.dx_m, (c.rows - 1) * c.dy_m)
    seen = set()
    for _ in range(1500):
        ends = rng.uniform(0, corner, (2, 2))
        if along != "anything":
            axis = int(along == "a border east")
            cells = (c.columns, c.rows)[axis] - 1
            ends[:, axis] = (rng.integers(cells) + 0.5) * (c.dx_m, c.dy_m)[axis]
        a, b = ((*end, z) for end, z in zip(ends, rng.uniform(0, 1000, 2), strict=True))
        parts = int(rng.integers(1, 300))
        told = tuple(count_straight(course, a, b, parts))
        assert told == tuple(straight_general(course, a, b, parts))
        seen.add(told)
    assert len(seen) > 200


@pytest.mark.parametrize("kind", ["nearest", "roofed"])
def test_shares_of_a_piece_add_up_to_its_counts(evaluator, kind):
    course = evaluator.course
    if kind == "roofed":
        roof = np.random.default_rng(5).uniform(400, 1500, course.ground.shape)
        ground = np.concatenate((course.ground, -roof))
        course = course._replace(ground=ground, c=course.c._replace(roofed=1))
    rng = np.random.default_rng(6)
    seen = set()
    for arc in arcs(rng, 1000):
        parts, stride = int(rng.integers(1, 100)), int(rng.integers(1, 40))
        told = count_arc(course, arc, parts)
        # Off the map for some.
        b = (*rng.uniform(-300, (6200, 4700)), rng.uniform(0, 1000))
        straight = count_straight(course, arc.a, b, parts)
        for counts, some, piece in (
            (told, some_arc_hits, (arc,)),
            (straight, some_straight_hits, (arc.a, b)),
        ):
            shares = [some(course, *piece, parts, first, stride) for first in range(stride)]
            assert sum(shares) == sum(counts)
            seen.add(sum(shares))
    assert len(seen) > 30


def test_samples_off_the_map_are_under_the_ground(evaluator):
    course = evaluator.course
    c = course.c
    east = (c.columns - 1) * c.dx_m
    under, _ = count_straight(course, (east, 500.0, 2000.0), (east + 100, 500.0, 2000.0), 10)
    assert under == 10
    under, _ = count_arc(course, Bend((east - 1e-9, 500.0, 2000.0), 1.0, 0.0, 1.0, 3.0, 0.0), 9)
    assert under == 9
    under, _ = count_arc(course, Bend((east, 500.0, 2000.0), -1.0, 0.0, 1.0, 3.0, 0.0), 9)
    assert under == 0
