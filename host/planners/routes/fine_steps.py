"""Points of B-splines, close enough to see every slope under the curve, compiled.

If steps are even in the parameter, the curve's control points can bunch them in the valleys, so
that one long step crosses a hill. Steps even in arc length avoid that, but a bend shorter than a
step can still climb a slope unseen, between two steps along the contour. So steps in bends are
halved.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.jit import compiled
from pathgene.host.planners.routes.spline import ORDER, last_two, point_at


__all__ = ["fine_steps"]

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]

# Number of chords, for each polynomial of a curve, that measure its length.
_CHORDS = 16
# Maximum number of halvings of a step, and the share of the longest step below which a bend counts
# as a corner.
_HALVINGS = 24
_CORNER = 1e-3
_ROOM = 512  # Initial room for points of a curve.


def fine_steps(
    control: Floats, counts: Counts, longest: float, fewest: int, bend: float
) -> tuple[Floats, Floats, Counts]:
    """Return points of curves, even in arc length, with more of them in bends.

    The number of steps of a curve is its length divided by ``longest``, rounded up, and at least
    ``fewest``. The length of each polynomial of the curve is measured along 16 chords, between
    whose ends the parameter is linear in length. A step is halved in the parameter if the curve at
    its ends is not within ``bend`` of the chord's direction, and its halves are halved again until
    they are straight enough or a thousandth of ``longest`` long. The points lie on the curve.

    Parameters
    ----------
    control : (m, n, d) float64
        Control points; rows at ``counts[i]`` and beyond are not read.
    counts : (m,) int64
        Control points of each curve, 2 to n.
    longest : float
        Length of a step, above 0, in the unit of the control points.
    fewest : int
        Minimum number of steps, 1 or more.
    bend : float
        Largest angle between a step and the curve at its ends, radians, above 0.

    Returns
    -------
    tuple
        Points of all curves, one curve after another with both ends, (p, d) float64; the unit
        tangents at these points, (p, d) float64, zero where a curve stands still; and the number of
        points of each curve, (m,) int64.
    """
    curves, most, dimensions = control.shape
    points_of = np.empty(curves, dtype=np.int64)
    along = np.zeros((most - 1) * _CHORDS + 1)
    work = np.empty((ORDER + 2, dimensions))
    ends = np.empty((_HALVINGS + 1, 2 * dimensions + 1))
    room = _ROOM * curves
    while True:
        points, directions = np.empty((2, room, dimensions))
        filled = (points, directions, points_of)
        found = fill(control, counts, longest, fewest, math.cos(bend), *filled, along, work, ends)
        if found <= room:
            return points[:found], directions[:found], points_of
        room = found


@compiled
def fill(
    control: Floats,
    counts: Counts,
    longest: float,
    fewest: int,
    cosine: float,
    points: Floats,
    directions: Floats,
    points_of: Counts,
    along: Floats,
    work: Floats,
    ends: Floats,
) -> int:
    """Write the result of :func:`fine_steps`; return the number of points.

    If there is no room for all points, the numbers are right and the points are not. ``along``,
    ``work`` and ``ends`` are scratch: lengths up to each chord; points; and the ends of the parts
    of a step that are not yet judged, each a parameter, a point and a unit vector.
    """
    dimensions = control.shape[2]
    room = len(points)
    found = 0
    for curve in range(len(counts)):
        own, count = control[curve], counts[curve]
        chords = _CHORDS * (count - min(ORDER, count) + 1)
        measure_chords(own, count, chords, along, work)
        steps = max(fewest, math.ceil(along[chords] / longest))
        first = found
        t = 0.0
        k = 0
        for step in range(steps + 1):
            wanted = along[chords] * step / steps
            while k < chords - 1 and along[k + 1] < wanted:
                k += 1
            chord = along[k + 1] - along[k]
            part = min(max((wanted - along[k]) / chord, 0.0), 1.0) if chord > 0.0 else 0.0
            ends[0, 0] = 1.0 if step == steps else (k + part) / chords
            place(own, count, work, ends[0])
            last = 0
            while last >= 0:
                # Beyond the available room, only the last point is kept.
                before = min(found, room) - 1
                if (
                    step > 0
                    and last < _HALVINGS
                    and is_bent(points, directions, before, ends[last], cosine, _CORNER * longest)
                ):
                    ends[last + 1, 0] = (t + ends[last, 0]) / 2.0
                    last += 1
                    place(own, count, work, ends[last])
                else:
                    at = min(found, room - 1)
                    for axis in range(dimensions):
                        points[at, axis] = ends[last, 1 + axis]
                        directions[at, axis] = ends[last, 1 + dimensions + axis]
                    t = ends[last, 0]
                    found += 1
                    last -= 1
        points_of[curve] = found - first
    return found


@compiled
def measure_chords(control: Floats, count: int, chords: int, along: Floats, work: Floats) -> None:
    """Write the cumulative lengths of a curve's chords to ``along``, starting at 0."""
    here, before = work[ORDER], work[ORDER + 1]
    point_at(control, count, 0.0, work, before)
    along[0] = 0.0
    for k in range(1, chords + 1):
        point_at(control, count, k / chords, work, here)
        square = 0.0
        for axis in range(control.shape[1]):
            square += (here[axis] - before[axis]) ** 2
            before[axis] = here[axis]
        along[k] = along[k - 1] + math.sqrt(square)


@compiled
def place(control: Floats, count: int, work: Floats, end: Floats) -> None:
    """Write the point and the unit vector at the parameter ``end[0]`` into ``end[1:]``."""
    dimensions = control.shape[1]
    share = last_two(control, count, end[0], work)
    degree = min(ORDER, count) - 1
    square = 0.0
    for axis in range(dimensions):
        before, after = work[degree - 1, axis], work[degree, axis]
        end[1 + axis] = (1.0 - share) * before + share * after
        end[1 + dimensions + axis] = after - before
        square += (after - before) ** 2
    if square > 0.0:
        length = math.sqrt(square)
        for axis in range(dimensions):
            end[1 + dimensions + axis] /= length


@compiled
def is_bent(
    points: Floats, directions: Floats, before: int, end: Floats, cosine: float, corner: float
) -> bool:
    """Return whether the curve deviates too far from the step from a point to ``end``."""
    dimensions = points.shape[1]
    square = 0.0
    leaving = 0.0
    reaching = 0.0
    for axis in range(dimensions):
        chord = end[1 + axis] - points[before, axis]
        square += chord * chord
        leaving += chord * directions[before, axis]
        reaching += chord * end[1 + dimensions + axis]
    length = math.sqrt(square)
    return length > corner and min(leaving, reaching) < cosine * length
