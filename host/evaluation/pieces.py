"""Turns and pieces of a path, compiled: their geometry, slopes, fuel and samples.

The functions take numbers, tuples, plain arrays and one
:class:`~host.evaluation.constants.Constants`, allocate nothing and use no Python object, so the
same source serves a CPU core and a CUDA thread. The arithmetic of points follows
:mod:`host.evaluation.geometry`, with faster forms of roots and tangents: both see the same samples
up to rounding. The order is: turns at the waypoints, pieces between them, cost of each piece,
samples of :mod:`host.evaluation.sampling`. Each step is a loop over independent rows, which the
threads of a GPU can share.

Source: Roberge and Tarbouchi, sections 3.1 and 3.2.
"""

import math

import numpy as np

from host.evaluation.constants import (
    COLLINEAR_RAD,
    SLOPE_TOLERANCE_RAD,
    Constants,
    Floats,
    Point,
)
from host.evaluation.jit import inlined
from host.evaluation.sampling import arc_part, count_arc, count_straight, straight_part


__all__ = [
    "LENGTH",
    "PIECE_FIELDS",
    "STEEP",
    "TURN_FIELDS",
    "area_and_fuel",
    "collided_m",
    "count_impossible",
    "judge_slope",
    "lay_segment",
    "lay_turn",
    "parts_of",
    "piece_part",
    "prepare_burn",
    "total_of",
]

_ARC_PARTS_IN_WIND = 8
# Below it the series is exact to 1e-16. Most pieces lie below: 1 km has less than 1e-8.
_SMALL_SQUARE = 1e-5

# Fields of a turn and of a piece: the heading's unit vector is (UX, UY), AIR the distance through
# the air, STEEP the length if it is too steep, and the last four are those of the thrust.
_ANGLE, _SIDE, _RUN, _TANGENT = range(4)
TURN_FIELDS = 4
_RISE, LENGTH, _X, _Y, _Z, _X_END, _Y_END, _Z_END, _UX, _UY = range(3, 13)
_AIR, STEEP, _THRUST_A, _THRUST_B, _THRUST_E, _TAU = range(13, 19)
PIECE_FIELDS = 19


@inlined
def turn(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    run_a: float,
    run_b: float,
    radius_m: float,
) -> tuple[float, float, float]:
    """Return the unsigned turn angle, side (1 left, -1 right) and tangent length of a waypoint.

    The tangent is infinite at a reversal and beside a segment without horizontal length.
    """
    if run_a == 0.0 or run_b == 0.0:
        return 0.0, 1.0, math.inf
    cross, dot = ax * by - ay * bx, ax * bx + ay * by
    angle = math.atan2(abs(cross), dot)
    if angle <= COLLINEAR_RAD:
        return 0.0, 1.0, 0.0
    side = 1.0 if cross >= 0.0 else -1.0
    if cross == 0.0:
        return math.pi, side, math.inf
    # The tangent of half the angle, by that of its two forms which loses no digits.
    lengths = run_a * run_b
    half = abs(cross) / (lengths + dot) if dot > 0.0 else (lengths - dot) / abs(cross)
    return angle, side, radius_m * half


@inlined
def air_density(altitude_m: float) -> float:
    """Return the density of the International Standard Atmosphere, kg/m^3."""
    density = 1.225 * math.pow(1.0 - 0.0065 * min(altitude_m, 11000.0) / 288.15, 4.255876)
    if altitude_m > 11000.0:
        density *= math.exp(-(altitude_m - 11000.0) / 6341.62)
    return density


@inlined
def air_time(c: Constants, horizontal_m_s: float, ux: float, uy: float, run: float) -> float:
    """Return the seconds to fly ``run`` metres over the ground along (ux, uy); -1 if impossible."""
    cross = c.wind_x_m_s * uy - c.wind_y_m_s * ux
    square = horizontal_m_s * horizontal_m_s - cross * cross
    if not square > 0.0:
        return -1.0
    ground_speed = c.wind_x_m_s * ux + c.wind_y_m_s * uy + math.sqrt(square)
    if not ground_speed > 0.0:
        return -1.0
    return run / ground_speed


@inlined
def air_distance(
    c: Constants,
    length: float,
    run: float,
    ux: float,
    uy: float,
    side: float,
    angle: float,
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
    for part in range(_ARC_PARTS_IN_WIND):
        turned = side * angle * (part + 0.5) / _ARC_PARTS_IN_WIND
        cos, sin = math.cos(turned), math.sin(turned)
        time = air_time(
            c, horizontal, ux * cos - uy * sin, ux * sin + uy * cos, run / _ARC_PARTS_IN_WIND
        )
        if time < 0.0:
            return -1.0
        total += time
    return c.airspeed_m_s * total


@inlined
def lay_turn(path: Floats, n: int, i: int, c: Constants, turns: Floats) -> None:
    """Write the turn at point ``i`` and the horizontal length to the next one to ``turns[i]``."""
    bx, by, run_b = 0.0, 0.0, 0.0
    if i + 1 < n:
        bx, by = path[i + 1, 0] - path[i, 0], path[i + 1, 1] - path[i, 1]
        run_b = math.sqrt(bx * bx + by * by)
    angle, side, tangent = 0.0, 1.0, 0.0
    if 0 < i < n - 1:
        ax, ay = path[i, 0] - path[i - 1, 0], path[i, 1] - path[i - 1, 1]
        run_a = math.sqrt(ax * ax + ay * ay)
        angle, side, tangent = turn(ax, ay, bx, by, run_a, run_b, c.turn_radius_m)
    turns[i, _ANGLE] = angle
    turns[i, _SIDE] = side
    turns[i, _TANGENT] = tangent
    turns[i, _RUN] = run_b


@inlined
def is_impossible(turns: Floats, i: int) -> bool:
    """Return whether the arc at point ``i`` does not fit beside those of its neighbours."""
    here = turns[i, _TANGENT]
    return here > 0.0 and not (
        turns[i - 1, _TANGENT] + here <= turns[i - 1, _RUN]
        and here + turns[i + 1, _TANGENT] <= turns[i, _RUN]
    )


@inlined
def count_impossible(turns: Floats, n: int) -> int:
    """Return the number of arcs that do not fit."""
    impossible = 0
    for i in range(1, n - 1):
        impossible += 1 if is_impossible(turns, i) else 0
    return impossible


@inlined
def lay_piece(
    pieces: Floats,
    row: int,
    a: Point,
    b: Point,
    ux: float,
    uy: float,
    side: float,
    angle: float,
    run: float,
    rise: float,
) -> None:
    """Write the geometry of a piece; a straight one has the angle 0."""
    pieces[row, _X], pieces[row, _Y], pieces[row, _Z] = a
    pieces[row, _X_END], pieces[row, _Y_END], pieces[row, _Z_END] = b
    pieces[row, _UX], pieces[row, _UY] = ux, uy
    pieces[row, _SIDE], pieces[row, _ANGLE] = side, angle
    pieces[row, _RUN], pieces[row, _RISE] = run, rise
    pieces[row, LENGTH] = math.sqrt(run * run + rise * rise)


@inlined
def lay_segment(path: Floats, i: int, c: Constants, turns: Floats, pieces: Floats) -> None:
    """Write the straight part of segment ``i`` to row ``2 i``, the arc at its end to the next."""
    cut_start = 0.0 if is_impossible(turns, i) else turns[i, _TANGENT]
    cut_stop = 0.0 if is_impossible(turns, i + 1) else turns[i + 1, _TANGENT]
    xa, ya, za = path[i, 0], path[i, 1], path[i, 2]
    xb, yb, zb = path[i + 1, 0], path[i + 1, 1], path[i + 1, 2]
    ux, uy, climb = 0.0, 0.0, 0.0
    run, rise = 0.0, zb - za
    run_a = turns[i, _RUN]
    if run_a > 0.0:
        ux, uy, climb = (xb - xa) / run_a, (yb - ya) / run_a, rise / run_a
        run = max(run_a - cut_start - cut_stop, 0.0)
        rise = climb * run
        xa, ya, za = xa + ux * cut_start, ya + uy * cut_start, za + climb * cut_start
        xb, yb, zb = xb - ux * cut_stop, yb - uy * cut_stop, zb - climb * cut_stop
    lay_piece(pieces, 2 * i, (xa, ya, za), (xb, yb, zb), ux, uy, 1.0, 0.0, run, rise)
    if cut_stop > 0.0:
        angle = turns[i + 1, _ANGLE]
        climb += (path[i + 2, 2] - path[i + 1, 2]) / turns[i + 1, _RUN]
        rise = cut_stop * climb
        lay_piece(
            pieces,
            2 * i + 1,
            (xb, yb, zb),
            (0.0, 0.0, zb + rise),
            ux,
            uy,
            turns[i + 1, _SIDE],
            angle,
            c.turn_radius_m * angle,
            rise,
        )
    else:
        pieces[2 * i + 1, LENGTH] = 0.0


@inlined
def judge_slope(c: Constants, pieces: Floats, row: int) -> None:
    """Write the air distance of a piece, and its length if it is too steep, else 0."""
    run, rise, length = pieces[row, _RUN], pieces[row, _RISE], pieces[row, LENGTH]
    steep = 0.0
    if length > 0.0:
        distance = air_distance(
            c,
            length,
            run,
            pieces[row, _UX],
            pieces[row, _UY],
            pieces[row, _SIDE],
            pieces[row, _ANGLE],
        )
        # An angle is below its tangent, so gentle slopes, the usual case, need no arc tangent.
        if not -c.max_descent_rad * run <= rise <= c.max_climb_rad * run or distance < 0.0:
            slope = math.atan2(rise, run)
            if (
                slope > c.max_climb_rad + SLOPE_TOLERANCE_RAD
                or slope < -c.max_descent_rad - SLOPE_TOLERANCE_RAD
                or distance < 0.0
            ):
                steep = length
        pieces[row, _AIR] = distance if distance >= 0.0 else length
    pieces[row, STEEP] = steep


@inlined
def prepare_burn(c: Constants, pieces: Floats, row: int) -> None:
    """Write the constants of a piece for :func:`burn`."""
    length = pieces[row, LENGTH]
    if length > 0.0:
        cos = pieces[row, _RUN] / length
        b = pieces[row, _RISE] / length
        altitude = 0.5 * (pieces[row, _Z] + pieces[row, _Z_END])
        density = air_density(altitude) if c.isa else 1.225
        pressure_area = 0.5 * density * (c.airspeed_m_s * c.airspeed_m_s) * c.wing_area_m2
        a = c.induced_drag_factor * (cos * cos) / pressure_area
        e = pressure_area * c.drag_coefficient
        discriminant = 4.0 * a * e - b * b
        half = 0.5 * pieces[row, _AIR] * c.burn_per_m
        # The square of the argument, its sign that of the discriminant.
        square = discriminant * (half * half)
        if abs(square) < _SMALL_SQUARE:
            # The series of tan(x) / x and of tanh(x) / x, in one.
            tau = half * (1.0 + square * (1.0 / 3.0 + square * (2.0 / 15.0)))
        else:
            root = math.sqrt(abs(discriminant))
            swing = math.tan(half * root) if discriminant > 0.0 else math.tanh(half * root)
            tau = swing / root
        pieces[row, _THRUST_A], pieces[row, _THRUST_B], pieces[row, _THRUST_E] = a, b, e
        pieces[row, _TAU] = tau


@inlined
def burn(pieces: Floats, row: int, weight: float) -> float:
    """Return the fuel of one piece in newtons: the closed solution of the Riccati equation."""
    a, b = pieces[row, _THRUST_A], pieces[row, _THRUST_B]
    thrust = a * (weight * weight) + b * weight + pieces[row, _THRUST_E]
    if thrust <= 0.0:
        return 0.0
    tau = pieces[row, _TAU]
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
def area_and_fuel(c: Constants, pieces: Floats, rows: int) -> tuple[float, float]:
    """Return the integral of altitude by length (m^2) and the fuel (N), the weight carried on."""
    area = 0.0
    fuel = 0.0
    for row in range(rows):
        length = pieces[row, LENGTH]
        if length > 0.0:
            area += 0.5 * (pieces[row, _Z] + pieces[row, _Z_END]) * length
            fuel += burn(pieces, row, c.weight - fuel)
    return area, fuel


@inlined
def parts_of(c: Constants, pieces: Floats, row: int) -> int:
    """Return the number of equal parts of a piece; 0 where there is no piece."""
    length = pieces[row, LENGTH]
    # CUDA's ceil is no integer.
    return int(np.int64(math.ceil(length / c.ds_m))) if length > 0.0 else 0


@inlined
def piece_part(
    ground: Floats,
    zoned: Floats,
    c: Constants,
    pieces: Floats,
    row: int,
    part: int,
    parts: int,
) -> tuple[int, int]:
    """Sample one of the equal parts of a piece; see :func:`host.evaluation.sampling.sample`."""
    a = (pieces[row, _X], pieces[row, _Y], pieces[row, _Z])
    if pieces[row, _ANGLE] > 0.0:
        return arc_part(
            ground,
            zoned,
            c,
            a,
            pieces[row, _UX],
            pieces[row, _UY],
            pieces[row, _SIDE],
            pieces[row, _ANGLE],
            pieces[row, _RISE],
            part,
            parts,
        )
    b = (pieces[row, _X_END], pieces[row, _Y_END], pieces[row, _Z_END])
    return straight_part(ground, zoned, c, a, b, part, parts)


@inlined
def collided_m(
    ground: Floats,
    zoned: Floats,
    c: Constants,
    pieces: Floats,
    row: int,
) -> tuple[float, float]:
    """Return the metres of a piece under the terrain and in a no-fly zone."""
    parts = parts_of(c, pieces, row)
    if parts == 0:
        return 0.0, 0.0
    part_m = pieces[row, LENGTH] / parts
    a = (pieces[row, _X], pieces[row, _Y], pieces[row, _Z])
    if pieces[row, _ANGLE] > 0.0:
        under, zone = count_arc(
            ground,
            zoned,
            c,
            a,
            pieces[row, _UX],
            pieces[row, _UY],
            pieces[row, _SIDE],
            pieces[row, _ANGLE],
            pieces[row, _RISE],
            parts,
        )
    else:
        b = (pieces[row, _X_END], pieces[row, _Y_END], pieces[row, _Z_END])
        under, zone = count_straight(ground, zoned, c, a, b, parts)
    return under * part_m, zone * part_m
