"""Pieces of a path, compiled: their slopes, fuel and samples.

The functions take numbers, tuples, plain arrays and one
:class:`~pathgene.host.evaluation.constants.Constants`, allocate nothing and use no Python object,
so the same source serves a CPU core and a CUDA thread. The order is: turns and pieces
(:mod:`pathgene.host.evaluation.laying`), cost of each piece, samples of
:mod:`pathgene.host.evaluation.sampling`. Each step is a loop over independent rows, which the
threads of a GPU can share.

Source: Roberge and Tarbouchi, sections 3.1 and 3.2.
"""

import math

import numpy as np

from pathgene.host.evaluation.constants import SLOPE_TOLERANCE_RAD, Constants, Course, Floats, Point
from pathgene.host.evaluation.jit import inlined
from pathgene.host.evaluation.laying import (
    AIR,
    ANGLE,
    LENGTH,
    RISE,
    RUN,
    SIDE,
    STEEP,
    TAU,
    THRUST_A,
    THRUST_B,
    THRUST_E,
    UX,
    UY,
    X_END,
    Y_END,
    Z_END,
    X,
    Y,
    Z,
)
from pathgene.host.evaluation.sampling import (
    Bend,
    count_arc,
    count_straight,
    some_arc_hits,
    some_straight_hits,
)
from pathgene.host.problem.atmosphere import SEA_LEVEL_DENSITY_KG_M3


__all__ = [
    "ARC_PARTS_IN_WIND",
    "area_and_fuel",
    "burn",
    "collided_m",
    "fastest_over_ground",
    "judge_slope",
    "parts_of",
    "piece_hits",
    "prepare_burn",
    "thrust_of",
    "time_in_wind",
    "total_of",
]

ARC_PARTS_IN_WIND = 8
# Below it the series is exact to 1e-16. Nearly all pieces lie below: 1 km has less than 1e-8.
_SMALL_SQUARE = 1e-5


@inlined
def time_in_wind(
    wind_x_m_s: float, wind_y_m_s: float, horizontal_m_s: float, ux: float, uy: float, run: float
) -> float:
    """Return the seconds to fly ``run`` metres over the ground along (ux, uy); -1 if impossible."""
    cross = wind_x_m_s * uy - wind_y_m_s * ux
    square = horizontal_m_s * horizontal_m_s - cross * cross
    if not square > 0.0:
        return -1.0
    ground_speed = wind_x_m_s * ux + wind_y_m_s * uy + math.sqrt(square)
    if not ground_speed > 0.0:
        return -1.0
    return run / ground_speed


@inlined
def air_time(c: Constants, horizontal_m_s: float, ux: float, uy: float, run: float) -> float:
    """Return :func:`time_in_wind` in the wind of the problem."""
    return time_in_wind(c.wind_x_m_s, c.wind_y_m_s, horizontal_m_s, ux, uy, run)


@inlined
def fastest_over_ground(
    c: Constants, horizontal_m_s: float, ux: float, uy: float, side: float, angle: float
) -> float:
    """Return the greatest ground speed on a piece, m/s; it must be possible in this wind.

    On an arc it is reached with a tail wind, where the arc points so, or at one of its ends.
    """
    time = air_time(c, horizontal_m_s, ux, uy, 1.0)
    fastest = 1.0 / time if time > 0.0 else 0.0
    if angle > 0.0:
        turned = side * angle
        cos, sin = math.cos(turned), math.sin(turned)
        time = air_time(c, horizontal_m_s, ux * cos - uy * sin, ux * sin + uy * cos, 1.0)
        if time > 0.0:
            fastest = max(fastest, 1.0 / time)
        along = c.wind_x_m_s * ux + c.wind_y_m_s * uy
        aside = side * (c.wind_y_m_s * ux - c.wind_x_m_s * uy)
        behind = math.atan2(aside, along)
        if 0.0 <= behind <= angle:
            fastest = horizontal_m_s + math.sqrt(along * along + aside * aside)
    return fastest


@inlined
def air_distance(
    c: Constants, length: float, run: float, ux: float, uy: float, side: float, angle: float
) -> float:
    """Return the air distance of a piece of turn ``angle``, 0 if straight, or a negative number."""
    if c.wind_x_m_s == 0.0 and c.wind_y_m_s == 0.0:
        return length
    if run == 0.0:
        return -1.0
    horizontal = c.airspeed_m_s * run / length
    if angle == 0.0:
        return c.airspeed_m_s * air_time(c, horizontal, ux, uy, run)
    total = 0.0
    for part in range(ARC_PARTS_IN_WIND):
        turned = side * angle * (part + 0.5) / ARC_PARTS_IN_WIND
        cos, sin = math.cos(turned), math.sin(turned)
        time = air_time(
            c, horizontal, ux * cos - uy * sin, ux * sin + uy * cos, run / ARC_PARTS_IN_WIND
        )
        if time < 0.0:
            return -1.0
        total += time
    return c.airspeed_m_s * total


@inlined
def judge_slope(c: Constants, pieces: Floats, row: int) -> None:
    """Write the air distance of a piece, and its length if it is too steep, otherwise 0."""
    run, rise, length = pieces[row, RUN], pieces[row, RISE], pieces[row, LENGTH]
    steep = 0.0
    if length > 0.0:
        distance = air_distance(
            c,
            length,
            run,
            pieces[row, UX],
            pieces[row, UY],
            pieces[row, SIDE],
            pieces[row, ANGLE],
        )
        if c.in_air and distance >= 0.0:  # In wind a vertical piece has no distance.
            speed = rise / run
            if rise != 0.0:
                speed *= fastest_over_ground(
                    c,
                    c.airspeed_m_s * run / length,
                    pieces[row, UX],
                    pieces[row, UY],
                    pieces[row, SIDE],
                    pieces[row, ANGLE],
                )
            if not -c.descent_m_s <= speed <= c.climb_m_s:
                steep = length
        # An angle is below its tangent, so gentle slopes, the usual case, need no arc tangent.
        elif not -c.max_descent_rad * run <= rise <= c.max_climb_rad * run or distance < 0.0:
            slope = math.atan2(rise, run)
            if (
                slope > c.max_climb_rad + SLOPE_TOLERANCE_RAD
                or slope < -c.max_descent_rad - SLOPE_TOLERANCE_RAD
                or distance < 0.0
            ):
                steep = length
        pieces[row, AIR] = distance if distance >= 0.0 else length
    pieces[row, STEEP] = steep


@inlined
def prepare_burn(c: Constants, pieces: Floats, row: int) -> None:
    """Write the constants of a piece for :func:`burn`."""
    length = pieces[row, LENGTH]
    if length > 0.0:
        cos = pieces[row, RUN] / length
        b = pieces[row, RISE] / length
        pressure_area = (
            0.5 * SEA_LEVEL_DENSITY_KG_M3 * (c.airspeed_m_s * c.airspeed_m_s) * c.wing_area_m2
        )
        a = c.induced_drag_factor * (cos * cos) / pressure_area
        e = pressure_area * c.drag_coefficient
        discriminant = 4.0 * a * e - b * b
        half = 0.5 * pieces[row, AIR] * c.burn_per_m
        # The square of the argument, with the sign of the discriminant.
        square = discriminant * (half * half)
        if abs(square) < _SMALL_SQUARE:
            # The series of tan(x) / x and of tanh(x) / x, in one.
            tau = half * (1.0 + square * (1.0 / 3.0 + square * (2.0 / 15.0)))
        else:
            root = math.sqrt(abs(discriminant))
            swing = math.tan(half * root) if discriminant > 0.0 else math.tanh(half * root)
            tau = swing / root
        pieces[row, THRUST_A], pieces[row, THRUST_B], pieces[row, THRUST_E] = a, b, e
        pieces[row, TAU] = tau


@inlined
def thrust_of(pieces: Floats, row: int, weight: float) -> float:
    """Return the thrust at the start of a piece, newtons; it falls along the piece."""
    a, b = pieces[row, THRUST_A], pieces[row, THRUST_B]
    thrust: float = a * (weight * weight) + b * weight + pieces[row, THRUST_E]
    return thrust


@inlined
def burn(pieces: Floats, row: int, weight: float) -> float:
    """Return the fuel of one piece in newtons: the closed solution of the Riccati equation."""
    a, b = pieces[row, THRUST_A], pieces[row, THRUST_B]
    thrust = thrust_of(pieces, row, weight)
    if thrust <= 0.0:
        return 0.0
    tau = pieces[row, TAU]
    fuel: float = 2.0 * thrust * tau / (1.0 + (2.0 * a * weight + b) * tau)
    return fuel


@inlined
def total_of(pieces: Floats, rows: int, field: int) -> float:
    """Return the sum of one field over the pieces, in flying order."""
    total = 0.0
    for row in range(rows):
        total += pieces[row, field]
    return total


@inlined
def share_above(low: float, high: float, ceiling_m: float) -> float:
    """Return the share of a piece above the ceiling; one of its two altitudes is above it."""
    if min(low, high) >= ceiling_m:
        return 1.0
    return (max(low, high) - ceiling_m) / abs(high - low)


@inlined
def area_and_fuel(c: Constants, pieces: Floats, rows: int) -> tuple[float, float, float]:
    """Return three sums: altitude by length (m^2), fuel (N) and metres beyond the limits.

    Altitudes count from ``c.base_m``.
    The weight is carried from piece to piece. Beyond the limits are pieces that need more than the
    greatest thrust, the parts of pieces above the ceiling, and the share of the path for which fuel
    is missing.
    """
    area = 0.0
    fuel = 0.0
    beyond = 0.0
    flown = 0.0
    for row in range(rows):
        length = pieces[row, LENGTH]
        if length > 0.0:
            low, high = pieces[row, Z], pieces[row, Z_END]
            area += (0.5 * (low + high) - c.base_m) * length
            weight = c.weight - fuel
            if c.thrust < thrust_of(pieces, row, weight):
                beyond += length
            if max(low, high) > c.ceiling_m:
                beyond += length * share_above(low, high, c.ceiling_m)
            fuel += burn(pieces, row, weight)
            flown += length
    if fuel > c.fuel:
        beyond += flown * (1.0 - c.fuel / fuel)
    return area, fuel, beyond


@inlined
def parts_of(c: Constants, pieces: Floats, row: int) -> int:
    """Return the number of equal parts of a piece; 0 if the row is not a piece."""
    length = pieces[row, LENGTH]
    # CUDA's ceil does not return an integer.
    return int(np.int64(math.ceil(length / c.ds_m))) if length > 0.0 else 0


@inlined
def ends_of(pieces: Floats, row: int) -> tuple[Point, Point]:
    """Return both ends of a straight piece."""
    a = (pieces[row, X], pieces[row, Y], pieces[row, Z])
    b = (pieces[row, X_END], pieces[row, Y_END], pieces[row, Z_END])
    return a, b


@inlined
def bend_of(pieces: Floats, row: int) -> Bend:
    """Return a piece that turns, as an arc."""
    return Bend(
        (pieces[row, X], pieces[row, Y], pieces[row, Z]),
        pieces[row, UX],
        pieces[row, UY],
        pieces[row, SIDE],
        pieces[row, ANGLE],
        pieces[row, RISE],
    )


@inlined
def piece_hits(
    course: Course, pieces: Floats, row: int, parts: int, first: int, stride: int
) -> int:
    """Count hits on every ``stride``-th part of a piece, starting at ``first``.

    A part under the terrain is one hit, and so is one in a no-fly zone.
    """
    if pieces[row, ANGLE] > 0.0:
        return some_arc_hits(course, bend_of(pieces, row), parts, first, stride)
    a, b = ends_of(pieces, row)
    return some_straight_hits(course, a, b, parts, first, stride)


@inlined
def collided_m(course: Course, pieces: Floats, row: int) -> tuple[float, float]:
    """Return the metres of a piece under the terrain and in a no-fly zone."""
    parts = parts_of(course.c, pieces, row)
    if parts == 0:
        return 0.0, 0.0
    part_m = pieces[row, LENGTH] / parts
    if pieces[row, ANGLE] > 0.0:
        under, zone = count_arc(course, bend_of(pieces, row), parts)
    else:
        a, b = ends_of(pieces, row)
        under, zone = count_straight(course, a, b, parts)
    return under * part_m, zone * part_m
