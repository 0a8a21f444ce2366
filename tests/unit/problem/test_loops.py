"""Outlines that cross themselves, compared with winding numbers."""

import random

import numpy as np
import pytest
import shapely

from pathgene.host.problem.loops import drawn_once, untangled


SQUARE = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0))
SMALL = ((2.0, 2.0), (2.0, 4.0), (4.0, 4.0), (4.0, 2.0))


def is_inside(areas, x, y):
    """Return whether a point lies in an area, by Shapely."""
    point = shapely.Point(x, y)
    return any(
        shapely.Polygon(ring).buffer(0).contains(point)
        and not any(shapely.Polygon(hole).buffer(0).contains(point) for hole in holes)
        for ring, *holes in areas
    )


def winding(ring, x, y):
    """Return how often a ring turns around a point, by the angles that its edges span."""
    around = np.array(ring) - (x, y)
    ahead = np.roll(around, -1, axis=0)
    cross = around[:, 0] * ahead[:, 1] - around[:, 1] * ahead[:, 0]
    turns = np.arctan2(cross, (around * ahead).sum(axis=1)).sum() / (2 * np.pi)
    return round(float(turns))


@pytest.mark.parametrize("on_grid", [False, True])
def test_ground_that_an_outline_turns_around_is_inside(on_grid):
    rng = random.Random(int(on_grid))
    tangled = 0
    for _ in range(60):
        ring = tuple(
            (float(rng.randrange(6)), float(rng.randrange(6)))
            if on_grid
            else (6 * rng.random(), 6 * rng.random())
            for _ in range(rng.randint(4, 12))
        )
        ring = tuple(each for number, each in enumerate(ring) if each != ring[number - 1])
        if len(ring) < 3:
            continue
        found = untangled(ring)
        tangled += found.is_tangled
        for _ in range(15):
            x, y = 6 * rng.random(), 6 * rng.random()
            if winding(ring, x, y):
                assert is_inside(found.areas, x, y), (ring, x, y)
    assert tangled > 30


@pytest.mark.parametrize(
    "ring",
    [
        SQUARE,
        SQUARE[::-1],
        # A spike, and a corner on an edge.
        (*SQUARE[:2], (25.0, 0.0), *SQUARE[1:]),
        (*SQUARE, (0.0, 5.0)),
        # A hole that is joined to the outline by a cut, and two areas that touch.
        (*SQUARE, SQUARE[0], *SMALL, SMALL[0]),
        (*SQUARE, SQUARE[0], (-3.0, 0.0), (-3.0, -3.0)),
    ],
)
def test_an_outline_that_encloses_nothing_twice_stays_as_it_is(ring):
    assert untangled(ring) == (((ring,),), False)


@pytest.mark.parametrize(
    "ring",
    [
        SQUARE * 2,
        (*SQUARE, *SQUARE[:1], *SQUARE),
        # Forth and back, and with other corners.
        (*SQUARE, SQUARE[0], *SQUARE[:0:-1]),
        (*SQUARE, (0.0, 0.0), (5.0, 0.0), *SQUARE[1:]),
    ],
)
def test_an_outline_drawn_twice_is_its_ground(ring):
    found = untangled(ring, (SMALL,))
    assert found.is_tangled
    assert is_inside(found.areas, 5.0, 7.0)
    assert not is_inside(found.areas, 3.0, 3.0)
    assert not is_inside(found.areas, 11.0, 5.0)


def test_a_repeated_ring_is_drawn_once():
    for ring in (SQUARE * 2, SQUARE * 3, (*SQUARE, *SQUARE[:1], *SQUARE)):
        assert drawn_once(ring) == SQUARE
    other = (*SQUARE, *SMALL)
    assert drawn_once(other) == other


def test_a_hole_that_is_the_outline_is_none():
    assert untangled(SQUARE, (SQUARE[::-1], SMALL)) == (((SQUARE, SMALL),), True)


def test_a_scribble_counts_as_its_box():
    rng = np.random.default_rng(1)
    ring = tuple(map(tuple, rng.random((2000, 2)).tolist()))
    (((corners),),), is_tangled = untangled(ring)
    assert is_tangled
    assert np.array_equal(np.ptp(corners, axis=0), np.ptp(ring, axis=0))
