"""Clamped uniform B-splines of order 4 by de Boor's algorithm, compiled: many curves at once.

Source: *cheng*, section II.B and table II. The knots are uniform inside and repeated at the ends,
so that a curve begins and ends at its first and last control point. With fewer points than the
order, the order is lowered: two points give a straight line.
"""

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.jit import allocating, compiled


__all__ = ["ORDER", "equal_steps", "last_two", "point_at", "sample"]

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Order of the splines: one more than their degree.
ORDER = 4

# Number of chords, for each step of a curve, that measure its length.
_CHORDS = 8


@compiled
def last_two(control: Floats, count: int, t: float, work: Floats) -> float:
    """Run de Boor's algorithm except for its last step.

    The point lies between the last two rows of ``work`` that the degree uses, and the curve leads
    from the first to the second. The result is the weight of the second. Parameters are as for
    :func:`point_at`.
    """
    degree = min(ORDER, count) - 1
    spans = count - degree
    u = t * spans
    span = min(int(u), spans - 1)
    for r in range(degree + 1):
        for axis in range(control.shape[1]):
            work[r, axis] = control[span + r, axis]
    for step in range(1, degree):
        for r in range(degree, step - 1, -1):
            # Knot i lies at i - degree, but never beyond the ends 0 and spans.
            low = max(span + r - degree, 0)
            high = min(span + r - step + 1, spans)
            share = (u - low) / (high - low)
            for axis in range(control.shape[1]):
                work[r, axis] = (1.0 - share) * work[r - 1, axis] + share * work[r, axis]
    return u - span


@compiled
def point_at(control: Floats, count: int, t: float, work: Floats, point: Floats) -> None:
    """Write the point at ``t``, 0..1, of the curve over ``control[:count]`` to ``point``, (d,).

    ``work``, (ORDER, d), is scratch.
    """
    share = last_two(control, count, t, work)
    degree = min(ORDER, count) - 1
    for axis in range(control.shape[1]):
        point[axis] = (1.0 - share) * work[degree - 1, axis] + share * work[degree, axis]


@allocating
def sample(control: Floats, counts: Counts, samples: int) -> Floats:
    """Return points of curves at equal steps of the parameter, including both ends.

    Parameters
    ----------
    control : (m, n, d) float64
        Control points; rows at ``counts[i]`` and beyond are not read.
    counts : (m,) int64
        Control points of each curve, 2 to n.
    samples : int
        Points of each curve, 2 or more.

    Returns
    -------
    ndarray
        (m, samples, d) float64.
    """
    curves, _, dimensions = control.shape
    points = np.empty((curves, samples, dimensions))
    work = np.empty((ORDER, dimensions))
    for curve in range(curves):
        for k in range(samples):
            point_at(control[curve], counts[curve], k / (samples - 1), work, points[curve, k])
    return points


@allocating
def equal_steps(control: Floats, counts: Counts, steps: int) -> Floats:
    """Return points at equal steps of arc length, both ends included: (m, steps + 1, d) float64.

    Lengths are measured along ``8 steps`` chords, between whose ends the parameter is linear in
    length; the points lie on the curve. All further parameters are as for :func:`sample`.
    """
    curves, _, dimensions = control.shape
    chords = _CHORDS * steps
    points = np.empty((curves, steps + 1, dimensions))
    along = np.empty(chords + 1)
    work = np.empty((ORDER, dimensions))
    before = np.empty(dimensions)
    here = np.empty(dimensions)
    for curve in range(curves):
        own, count = control[curve], counts[curve]
        along[0] = 0.0
        point_at(own, count, 0.0, work, before)
        for k in range(1, chords + 1):
            point_at(own, count, k / chords, work, here)
            square = 0.0
            for axis in range(dimensions):
                square += (here[axis] - before[axis]) ** 2
                before[axis] = here[axis]
            along[k] = along[k - 1] + np.sqrt(square)
        k = 0
        for step in range(steps + 1):
            wanted = along[chords] * step / steps
            while k < chords - 1 and along[k + 1] < wanted:
                k += 1
            chord = along[k + 1] - along[k]
            part = min(max((wanted - along[k]) / chord, 0.0), 1.0) if chord > 0.0 else 0.0
            t = 1.0 if step == steps else (k + part) / chords
            point_at(own, count, t, work, points[curve, step])
    return points
