"""B-splines against SciPy."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

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
