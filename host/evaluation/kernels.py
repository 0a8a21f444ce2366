"""The fitness of paths, compiled: the definition as small scalar functions.

The functions sum the measures of :mod:`pathgene.host.evaluation.pieces`. Like them, they
serve a CPU core and a CUDA thread alike.

Source: Roberge and Tarbouchi, sections 3.1 and 3.2, equations (1) to (3).
"""

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.constants import (
    COORDINATE_LIMIT_M,
    Constants,
    Course,
    Floats,
    Scratch,
)
from pathgene.host.evaluation.jit import compiled, inlined
from pathgene.host.evaluation.laying import (
    LENGTH,
    PIECE_FIELDS,
    STEEP,
    TURN_FIELDS,
    count_impossible,
    lay_segment,
    lay_turn,
)
from pathgene.host.evaluation.pieces import (
    area_and_fuel,
    collided_m,
    judge_slope,
    prepare_burn,
    total_of,
)


__all__ = [
    "BELOW_TWO",
    "WORST_FITNESS",
    "corners_m",
    "cost_of",
    "evaluate_share",
    "fitness_above",
    "fitness_of",
    "path_terms",
    "penalty_cost",
    "scratch",
]

# The ends of the open interval of fitness values.
WORST_FITNESS = float(np.finfo(np.float64).tiny)
BELOW_TWO = float(np.nextafter(2.0, 0.0))


@compiled
def path_terms(
    path: Floats, n: int, course: Course, scratch: Scratch
) -> tuple[float, float, float, float, float, float, int, float]:
    """Return every term of one path.

    Parameters
    ----------
    path : (max_n, 3) float64, metres as x, y, z
        The first ``n`` rows count, n >= 2. Finite and within ``COORDINATE_LIMIT_M``.
    scratch : Scratch
        Holds the turns and pieces of the path afterwards.

    Returns
    -------
    tuple
        Length, altitude integral (m^2), fuel (N), distance too steep, distance under the terrain,
        distance in no-fly zones (all m), the number of impossible arcs, and the distance beyond
        the limits of safe flight (m).
    """
    c = course.c
    turns, pieces = scratch
    rows = 2 * n - 1
    for i in range(n):
        lay_turn(path, n, i, c, turns)
    for i in range(n - 1):
        lay_segment(path, n, i, c, turns, pieces)
    for row in range(rows):
        judge_slope(c, pieces, row)
        prepare_burn(c, pieces, row)
    area, fuel, beyond = area_and_fuel(c, pieces, rows)
    under_m = 0.0
    nofly_m = 0.0
    if c.sampled:
        for row in range(rows):
            under, zone = collided_m(course, pieces, row)
            under_m += under
            nofly_m += zone
    return (
        total_of(pieces, rows, LENGTH),
        area,
        fuel,
        total_of(pieces, rows, STEEP),
        under_m,
        nofly_m,
        count_impossible(turns, n),
        beyond,
    )


@inlined
def cost_of(c: Constants, area: float, fuel: float) -> float:
    """Equation (2)."""
    return 0.5 * area / c.utopia_area_m2 + 0.5 * fuel / c.utopia_fuel


@inlined
def fitness_of(penalty: float, cost: float) -> float:
    """Return equation (3), kept finite and inside (0, 2); NaN gives the least value."""
    if not penalty >= 0.0 or math.isnan(cost):
        return WORST_FITNESS
    if penalty > 0.0:
        return max(1.0 / (1.0 + penalty), WORST_FITNESS)
    if cost <= 0.0:
        return BELOW_TWO
    return min(1.0 + 1.0 / (1.0 + cost), BELOW_TWO)


@compiled
def penalty_cost(
    path: Floats, n: int, course: Course, scratch: Scratch, counted_m: float
) -> tuple[float, float]:
    """Return penalty, equation (1), and cost, equation (2); both infinite for a bad path.

    ``counted_m`` is added to d_ut + d_nf: the distance counted elsewhere, if nothing is sampled.
    """
    for i in range(n):
        for axis in range(3):
            if not abs(path[i, axis]) <= COORDINATE_LIMIT_M:
                return math.inf, math.inf
    length, area, fuel, steep, under, zone, _, beyond = path_terms(path, n, course, scratch)
    if not length > 0.0:
        return math.inf, math.inf
    penalty = under + zone + counted_m + steep
    penalty += corners_m(course.c, scratch.turns, n, length)
    penalty += beyond
    return penalty, cost_of(course.c, area, fuel)


@inlined
def corners_m(c: Constants, turns: Floats, n: int, length: float) -> float:
    """Return the last term of equation (1): the share of impossible arcs, times the length."""
    arcs = n - 2 + c.headings
    return count_impossible(turns, n) / arcs * length if arcs > 0 else 0.0


@compiled
def fitness_above(
    path: Floats, n: int, course: Course, scratch: Scratch, incumbent: float
) -> tuple[float, bool]:
    """Return the fitness of a candidate if it exceeds ``incumbent``, otherwise a bound.

    The evaluation stops as soon as the fitness cannot exceed ``incumbent``. The result is the
    fitness and True, or a value from the fitness to ``incumbent`` and False: ``value > incumbent``
    holds for the same candidates as without the stops, and then the value equals the full
    evaluation, bit by bit.

    Why: the penalty is a sum of terms of 0 or more, added in a fixed order. Rounding to nearest is
    monotone, so the same sum over a part of the terms, with 0 for the rest, is never above it.
    Equation (3), as computed by :func:`fitness_of`, never rises with the penalty: each operation in
    its branches is monotone, its values for P > 0 are at most 1, for P = 0 at least 1, and
    with P > 0 it does not depend on the cost, except that a NaN gives the least value. Hence the
    fitness at the known part of the penalty is an upper bound. A candidate that passes every
    stop has had all its terms summed in the order of :func:`penalty_cost`.

    Arguments as for :func:`path_terms`; every coordinate must be within the limits there or
    NaN.
    """
    c = course.c
    turns, pieces = scratch
    rows = 2 * n - 1
    for i in range(n):
        lay_turn(path, n, i, c, turns)
    for i in range(n - 1):
        lay_segment(path, n, i, c, turns, pieces)
    length = total_of(pieces, rows, LENGTH)
    if not length > 0.0:
        return WORST_FITNESS, True
    corners = corners_m(c, turns, n, length)
    bound = fitness_of(corners, 0.0)
    if not bound > incumbent:
        return bound, False
    for row in range(rows):
        judge_slope(c, pieces, row)
    steep = total_of(pieces, rows, STEEP)
    bound = fitness_of(steep + corners, 0.0)
    if not bound > incumbent:
        return bound, False
    for row in range(rows):
        prepare_burn(c, pieces, row)
    area, fuel, beyond = area_and_fuel(c, pieces, rows)
    cost = cost_of(c, area, fuel)
    bound = fitness_of(steep + corners + beyond, cost)
    under_m = 0.0
    nofly_m = 0.0
    # Without a turn at the goal its row is not a piece: the segments before it decide.
    last = rows if pieces[rows - 1, LENGTH] > 0.0 else rows - 1
    for row in range(last):
        if not bound > incumbent:
            return bound, False
        under, zone = collided_m(course, pieces, row)
        if under + zone > 0.0:
            under_m += under
            nofly_m += zone
            bound = fitness_of(under_m + nofly_m + steep + corners + beyond, cost)
    return bound, True


def scratch(points: int) -> Scratch:
    """Return work space for paths of at most ``points`` points."""
    return Scratch(np.empty((points, TURN_FIELDS)), np.empty((2 * points, PIECE_FIELDS)))


@compiled
def evaluate_share(
    paths: Floats,
    lengths: NDArray[np.int64],
    first: int,
    stride: int,
    course: Course,
    scratch: Scratch,
    counted_m: Floats,
    out: Floats,
) -> None:
    """Evaluate every ``stride``-th path starting at ``first``, without holding the GIL.

    ``paths`` is (m, max_n, 3), ``counted_m`` (m,) as for :func:`penalty_cost`; ``scratch`` belongs
    to one share. Penalty, cost and fitness go to the rows of ``out``, (3, m).
    """
    for i in range(first, paths.shape[0], stride):
        penalty, cost = penalty_cost(paths[i], lengths[i], course, scratch, counted_m[i])
        out[0, i], out[1, i], out[2, i] = penalty, cost, fitness_of(penalty, cost)
