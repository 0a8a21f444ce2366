"""B-splines, and points that miss no slope under them, compared with SciPy."""

import math

import numpy as np
import pytest
from scipy.interpolate import BSpline

from pathgene.host.planners.routes import fine_steps as module
from pathgene.host.planners.routes.fine_steps import fine_steps
from pathgene.host.planners.routes.spline import ORDER, equal_steps, sample


COUNTS = np.arange(2, 11)


def curves(dimensions, seed=0):
    """Return curves of every number of control points; values beyond must not be read."""
    control = np.random.default_rng(seed).uniform(-1, 1, (len(COUNTS), 10, dimensions))
    control[np.arange(10) >= COUNTS[:, None]] = np.nan
    return control


def scipy_curve(control):
    """Return the clamped uniform spline of order 4, or of the number of points if less."""
    degree = min(ORDER, len(control)) - 1
    inside = np.linspace(0, 1, len(control) - degree + 1)
    return BSpline(np.r_[[0] * degree, inside, [1] * degree], control, degree)


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("samples", [2, 21, 100])
def test_matches_scipy(dimensions, samples):
    control = curves(dimensions)
    points = sample(control, COUNTS, samples)
    for own, count, curve in zip(control, COUNTS, points, strict=True):
        expected = scipy_curve(own[:count])(np.linspace(0, 1, samples))
        assert np.abs(curve - expected).max() < 1e-14


def test_begins_and_ends_at_its_control_points_exactly():
    control = curves(3, seed=1) * 1e5
    for points in (sample(control, COUNTS, 7), equal_steps(control, COUNTS, 8)):
        assert np.array_equal(points[:, 0], control[:, 0])
        assert np.array_equal(points[:, -1], control[np.arange(len(COUNTS)), COUNTS - 1])


def test_equal_steps_are_equal_and_on_the_curve():
    control = curves(3, seed=2)
    fine = np.linspace(0, 1, 20_001)
    for own, count, points in zip(control, COUNTS, equal_steps(control, COUNTS, 8), strict=True):
        curve = scipy_curve(own[:count])(fine)
        along = np.r_[0, np.cumsum(np.sqrt((np.diff(curve, axis=0) ** 2).sum(axis=1)))]
        far = np.sqrt(((points[:, None] - curve) ** 2).sum(axis=2))
        nearest = far.argmin(axis=1)
        assert far.min(axis=1).max() < 1e-3
        # Chords are a little shorter than the curve.
        assert np.abs(np.diff(along[nearest]) - along[-1] / 8).max() < 0.01 * along[-1]


def test_equal_steps_of_a_curve_without_length():
    control = np.ones((1, 4, 2))
    assert np.array_equal(equal_steps(control, np.array([4]), 3), np.ones((1, 4, 2)))


LONGEST, FEWEST, BEND = 0.01, 20, 0.1


def split(control, counts, bend=BEND):
    """Return the points and the unit vectors of each curve."""
    points, directions, points_of = fine_steps(control, counts, LONGEST, FEWEST, bend)
    assert len(points) == len(directions) == points_of.sum()
    ends = np.cumsum(points_of)[:-1]
    return list(zip(np.split(points, ends), np.split(directions, ends), strict=True))


@pytest.mark.parametrize("dimensions", [2, 3])
def test_points_and_unit_vectors_lie_on_the_curve(dimensions):
    few = [0, 2, 8]
    control, counts = curves(dimensions, seed=3)[few], COUNTS[few]
    fine = np.linspace(0, 1, 20_001)
    for own, count, (points, directions) in zip(
        control, counts, split(control, counts), strict=True
    ):
        spline = scipy_curve(own[:count])
        curve = spline(fine)
        nearest = np.array([((curve - point) ** 2).sum(axis=1).argmin() for point in points])
        assert (np.diff(nearest) >= 0).all()
        assert np.abs(points - curve[nearest]).max() < 1e-3
        assert np.array_equal(points[0], own[0])
        assert np.array_equal(points[-1], own[count - 1])
        assert np.hypot.reduce(directions, axis=1) == pytest.approx(np.ones(len(points)))
        tangents = spline.derivative()(fine[nearest])
        tangents /= np.hypot.reduce(tangents, axis=1)[:, None]
        assert (tangents * directions).sum(axis=1).min() > math.cos(0.02)


def test_steps_are_short_and_straight():
    control = curves(2, seed=4)
    for points, directions in split(control, COUNTS):
        steps = np.diff(points, axis=0)
        lengths = np.hypot(*steps.T)
        # The chords that give the lengths are not quite equal to the curve.
        assert lengths.max() < 1.3 * LONGEST
        for vectors in (directions[:-1], directions[1:]):
            straight = (steps * vectors).sum(axis=1) >= math.cos(BEND) * lengths - 1e-12
            assert (straight | (lengths < 1e-3 * LONGEST)).all()


def test_even_steps_without_bends():
    control = curves(2, seed=5)
    for points, _ in split(control, COUNTS, bend=math.pi):
        lengths = np.hypot(*np.diff(points, axis=0).T)
        assert lengths.max() < 1.3 * lengths.mean()
        assert len(lengths) == pytest.approx(lengths.sum() / LONGEST, abs=2)


def test_a_hairpin_gets_more_points():
    """The curve turns by half a circle within a hundredth of a step."""
    control = np.zeros((1, 10, 2))
    control[0, :7] = [
        (0, 0), (0.3, 0), (0.5, 0), (0.5001, 0.00005), (0.5, 0.0001), (0.3, 0.0001), (0, 0.0001)
    ]  # fmt: skip
    counts = np.array([7])
    (points, directions), (even, _) = split(control, counts)[0], split(control, counts, math.pi)[0]
    assert len(points) >= len(even) + 8
    assert np.abs(directions[:, 1]).max() > math.cos(2 * BEND)


def test_a_short_curve_has_the_fewest_steps():
    control = curves(2) * 1e-6
    assert all(len(points) >= FEWEST + 1 for points, _ in split(control, COUNTS))
    straight = np.array([[(0.0, 0.0), (1e-5, 0.0)]])
    assert len(split(straight, np.array([2]))[0][0]) == FEWEST + 1


def test_a_curve_without_length():
    ((points, directions),) = split(np.ones((1, 4, 2)), np.array([4]))
    assert np.array_equal(points, np.ones((FEWEST + 1, 2)))
    assert not directions.any()


def test_room_does_not_matter(monkeypatch):
    control = curves(2, seed=6)
    expected = fine_steps(control, COUNTS, LONGEST, FEWEST, BEND)
    monkeypatch.setattr(module, "_ROOM", 1)
    for one, other in zip(
        fine_steps(control, COUNTS, LONGEST, FEWEST, BEND), expected, strict=True
    ):
        assert np.array_equal(one, other)
