"""Terms of the segments of an AUV's path, compiled: *cheng*, section II.C.

Everything is in one file, because the cache on disk only notices changes in the file of the
outermost function.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.auv.landscape import LANDSCAPES, scale
from pathgene.host.evaluation.jit import allocating, compiled


__all__ = ["least_angle", "measure", "seabed"]

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]
# Number of the landscape, sigma and the constants of table I.
Seabed = tuple[int, float, float, float, float, float, float]


def seabed(landscape: int) -> Seabed:
    """Return the constants of a landscape, as the kernels take them."""
    return (landscape, scale(landscape), *LANDSCAPES[landscape])


@compiled
def height(bed: Seabed, x: float, y: float) -> float:
    """Equations (1) and (2); the same as :func:`pathgene.host.auv.landscape.height`."""
    number, sigma, a, b, c, d, e = bed
    u = 4.0 * math.pi * x
    v = 4.0 * math.pi * y
    waves = c * math.sin(d * math.sqrt(v * v + u * u))
    if number == 1:
        waves += math.sin(v + a) + b * math.cos(u) + e * math.sin(v)
    else:
        waves += math.cos(v + a) + b * math.sin(u) + e * math.cos(v)
    return sigma * waves * waves


@compiled
def slope(bed: Seabed, x: float, y: float, along_x: float, along_y: float) -> float:
    """Slope of the seabed in the direction of a unit vector, 0 or more.

    At the origin, the apex of the conical ripples, the slope of the ripples is left out.
    """
    number, sigma, a, b, c, d, e = bed
    u = 4.0 * math.pi * x
    v = 4.0 * math.pi * y
    r = math.sqrt(v * v + u * u)
    waves = c * math.sin(d * r)
    ripples = c * d * math.cos(d * r) / r if r > 0.0 else 0.0
    by_u = ripples * u
    by_v = ripples * v
    if number == 1:
        waves += math.sin(v + a) + b * math.cos(u) + e * math.sin(v)
        by_u -= b * math.sin(u)
        by_v += math.cos(v + a) + e * math.cos(v)
    else:
        waves += math.cos(v + a) + b * math.sin(u) + e * math.cos(v)
        by_u += b * math.cos(u)
        by_v -= math.sin(v + a) + e * math.sin(v)
    return abs(8.0 * math.pi * sigma * waves * (by_u * along_x + by_v * along_y))


@compiled
def least_angle(control: Floats, count: int) -> float:
    """Minimum interior angle at a middle point of ``control[:count]``, radians; pi is straight on.

    A repeated point has no angle and counts as 0.
    """
    least = math.pi
    for i in range(1, count - 1):
        ax, ay = control[i - 1, 0] - control[i, 0], control[i - 1, 1] - control[i, 1]
        bx, by = control[i + 1, 0] - control[i, 0], control[i + 1, 1] - control[i, 1]
        least = min(least, math.atan2(abs(ax * by - ay * bx), ax * bx + ay * by))
        if (ax == 0.0 and ay == 0.0) or (bx == 0.0 and by == 0.0):
            least = 0.0
    return least


@allocating
def measure(
    control: Floats,
    counts: Counts,
    points: Floats,
    points_of: Counts,
    directions: Floats,
    bed: Seabed,
    in_space: bool,
) -> Floats:
    """Length, ``1 - least angle / pi`` and greatest elevation rate: equations (4) to (6).

    Parameters
    ----------
    control : (m, n, 2) float64
        Control points of the segments, including the ends; rows from ``counts[i]`` on are not read.
    counts : (m,) int64
        Number of control points of each segment.
    points : (p, 2) float64
        Points along the curves, one curve after another.
    points_of : (m,) int64
        Number of points of each curve, 1 or more.
    directions : (p, 2) float64, or (0, 2)
        Unit tangents of the curves at the points. If given, the slopes at the points count as rates
        too, because they may exceed the rate of the step between two points.
    bed : tuple
        Result of :func:`seabed`.
    in_space : bool
        Measure the length over the seabed rather than the horizontal length.

    Returns
    -------
    ndarray
        (m, 3) float64: v1, v2 and v3 of each segment.
    """
    terms = np.empty((len(counts), 3))
    directed = len(directions) > 0
    end = 0
    for i in range(len(counts)):
        begin, end = end, end + points_of[i]
        length = 0.0
        rate = 0.0
        x, y = points[begin, 0], points[begin, 1]
        z = height(bed, x, y)
        if directed:
            rate = slope(bed, x, y, directions[begin, 0], directions[begin, 1])
        for k in range(begin + 1, end):
            x_next, y_next = points[k, 0], points[k, 1]
            z_next = height(bed, x_next, y_next)
            square = (x_next - x) ** 2 + (y_next - y) ** 2
            rise = abs(z_next - z)
            length += math.sqrt(square + rise * rise if in_space else square)
            if square > 0.0:
                rate = max(rate, rise / math.sqrt(square))
            if directed:
                rate = max(rate, slope(bed, x_next, y_next, directions[k, 0], directions[k, 1]))
            x, y, z = x_next, y_next, z_next
        terms[i, 0] = length
        terms[i, 1] = 1.0 - least_angle(control[i], counts[i]) / math.pi
        terms[i, 2] = rate
    return terms
