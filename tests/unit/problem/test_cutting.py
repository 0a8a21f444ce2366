"""Cuts of areas along a line, compared with Shapely's."""

import math
import random

import pytest
import shapely

from pathgene.host.problem.cutting import cut


RANDOM = 300
FAR = 99.0


def star(rng, x, y, size):
    corners = rng.randint(3, 10)
    angles = [2 * math.pi * (k + rng.uniform(0, 0.8)) / corners for k in range(corners)]
    reach = [size * rng.uniform(0.3, 1) for _ in range(corners)]
    return tuple(
        (x + r * math.cos(a), y + r * math.sin(a)) for r, a in zip(reach, angles, strict=True)
    )


def area(rng):
    """Return an outer ring with up to three holes inside."""
    rings = [star(rng, 0, 0, 10)]
    for _ in range(rng.randint(0, 3)):
        hole = star(rng, rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(0.5, 3))
        taken = shapely.Polygon(rings[0], rings[1:])
        if taken.contains_properly(shapely.Polygon(hole)):
            rings.append(hole)
    return rings


def side(axis, bound, sign):
    low, high = (bound, FAR) if sign > 0 else (-FAR, bound)
    return shapely.box(*((low, -FAR, high, FAR) if axis == 0 else (-FAR, low, FAR, high)))


def compare(rings, axis, bound, sign):
    """Compare a cut with Shapely's; return the number of areas."""
    whole = shapely.Polygon(rings[0], rings[1:])
    wanted = whole & side(axis, bound, sign)
    found = [shapely.Polygon(outer, holes) for outer, *holes in cut(rings, axis, bound, sign)]
    areas = [shapely.make_valid(each) for each in found]
    assert shapely.union_all(areas).symmetric_difference(wanted).area < 1e-9
    # No edge runs where no area is.
    for each in found:
        assert whole.buffer(1e-6).covers(each.boundary)
    return len(found)


def test_random_areas_are_cut_as_shapely_cuts_them():
    counts = set()
    for seed in range(RANDOM):
        rng = random.Random(seed)
        rings = area(rng)
        counts.add(compare(rings, rng.randrange(2), rng.uniform(-6, 6), rng.choice((1, -1))))
    assert counts >= {0, 1, 2}


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("bound", [0.0, 1.0, 2.0, 3.0, 4.0])
def test_lines_through_corners_and_along_edges(axis, bound, sign):
    steps = ((0, 0), (4, 0), (4, 4), (3, 4), (3, 1), (2, 1), (2, 3), (0, 3))
    compare([tuple((float(x), float(y)) for x, y in steps)], axis, bound, sign)


def test_a_hole_leaves_no_wall_in_it():
    square = ((0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0))
    hole = ((3.0, 3.0), (6.0, 3.0), (6.0, 6.0), (3.0, 6.0))
    (found,) = cut([square, hole], 0, 4.5, 1)
    assert len(found) == 1
    assert shapely.Polygon(found[0]).area == 4.5 * 9 - 1.5 * 3
    (west,) = cut([square, hole], 0, 3.5, -1)
    assert not shapely.Polygon(west[0]).contains(shapely.Point(3.25, 4.5))
