"""Turns and pieces of a path, compiled: their geometry.

The order is: turns at the waypoints, pieces between them; :mod:`pathgene.host.evaluation.pieces`
measures the pieces. The arithmetic of points follows :mod:`pathgene.host.evaluation.geometry`, with
faster forms of roots and tangents: both see the same samples up to rounding.

Source: Roberge and Tarbouchi, section 3.1.
"""

import math

from pathgene.host.evaluation.constants import (
    COLLINEAR_RAD,
    TURN_AT_END_RAD,
    Constants,
    Floats,
    Point,
)
from pathgene.host.evaluation.jit import inlined


__all__ = [
    "AIR",
    "ANGLE",
    "LENGTH",
    "PIECE_FIELDS",
    "RISE",
    "RUN",
    "SIDE",
    "STEEP",
    "TANGENT",
    "TAU",
    "THRUST_A",
    "THRUST_B",
    "THRUST_E",
    "TURN_FIELDS",
    "UX",
    "UY",
    "X_END",
    "Y_END",
    "Z_END",
    "X",
    "Y",
    "Z",
    "count_impossible",
    "lay_segment",
    "lay_turn",
]

# Fields of a turn and of a piece: the heading's unit vector is (UX, UY), AIR the distance through
# the air, STEEP the length if it is too steep, and the last four describe the thrust.
ANGLE, SIDE, RUN, TANGENT = range(4)
TURN_FIELDS = 4
RISE, LENGTH, X, Y, Z, X_END, Y_END, Z_END, UX, UY = range(3, 13)
AIR, STEEP, THRUST_A, THRUST_B, THRUST_E, TAU = range(13, 19)
PIECE_FIELDS = 19


@inlined
def turn(
    ax: float, ay: float, bx: float, by: float, run_a: float, run_b: float, radius_m: float
) -> tuple[float, float, float]:
    """Return the unsigned turn angle, side (1 left, -1 right) and tangent length of a waypoint.

    The tangent is infinite at a reversal and next to a segment without horizontal length.
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
    # The tangent of half the angle, in the form that loses no digits.
    lengths = run_a * run_b
    half = abs(cross) / (lengths + dot) if dot > 0.0 else (lengths - dot) / abs(cross)
    return angle, side, radius_m * half


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
    elif i == 0:
        if c.start_east != 0.0 or c.start_north != 0.0:
            angle, side, tangent = turn(
                c.start_east, c.start_north, bx, by, 1.0, run_b, c.turn_radius_m
            )
    elif c.goal_east != 0.0 or c.goal_north != 0.0:
        ax, ay = path[i, 0] - path[i - 1, 0], path[i, 1] - path[i - 1, 1]
        run_a = math.sqrt(ax * ax + ay * ay)
        angle, side, tangent = turn(ax, ay, c.goal_east, c.goal_north, run_a, 1.0, c.turn_radius_m)
    turns[i, ANGLE] = angle
    turns[i, SIDE] = side
    turns[i, TANGENT] = tangent
    turns[i, RUN] = run_b


@inlined
def is_impossible(turns: Floats, n: int, i: int) -> bool:
    """Return whether the arc at point ``i`` does not fit next to the arcs of its neighbours."""
    here = turns[i, TANGENT]
    if not here > 0.0:
        return False
    at_end = turns[i, ANGLE] <= TURN_AT_END_RAD
    before = at_end if i == 0 else turns[i - 1, TANGENT] + here <= turns[i - 1, RUN]
    after = at_end if i == n - 1 else here + turns[i + 1, TANGENT] <= turns[i, RUN]
    return not (before and after)


@inlined
def count_impossible(turns: Floats, n: int) -> int:
    """Return the number of arcs that do not fit."""
    impossible = 0
    for i in range(n):
        impossible += 1 if is_impossible(turns, n, i) else 0
    return impossible


@inlined
def lay_piece(
    pieces: Floats,
    row: int,
    a: Point,
    b: Point,
    heading: tuple[float, float],
    bend: tuple[float, float],
    run: float,
    rise: float,
) -> None:
    """Write the geometry of a piece; ``bend`` is its side and angle, an angle of 0 if straight."""
    pieces[row, X], pieces[row, Y], pieces[row, Z] = a
    pieces[row, X_END], pieces[row, Y_END], pieces[row, Z_END] = b
    pieces[row, UX], pieces[row, UY] = heading
    pieces[row, SIDE], pieces[row, ANGLE] = bend
    pieces[row, RUN], pieces[row, RISE] = run, rise
    pieces[row, LENGTH] = math.sqrt(run * run + rise * rise)


@inlined
def lay_arc(
    pieces: Floats,
    row: int,
    c: Constants,
    turns: Floats,
    i: int,
    at: Point,
    heading: tuple[float, float],
    rise: float,
) -> None:
    """Write the geometry of the arc of turn ``i``, entered at a point with a heading."""
    angle = turns[i, ANGLE]
    b = (0.0, 0.0, at[2] + rise)
    lay_piece(pieces, row, at, b, heading, (turns[i, SIDE], angle), c.turn_radius_m * angle, rise)


@inlined
def lay_segment(path: Floats, n: int, i: int, c: Constants, turns: Floats, pieces: Floats) -> None:
    """Write the straight part of segment ``i`` to row ``2 i + 1``, the arc at its end to the next.

    Segment 0 also writes row 0, the arc from the heading at the start.
    """
    cut_start = 0.0 if is_impossible(turns, n, i) else turns[i, TANGENT]
    cut_stop = 0.0 if is_impossible(turns, n, i + 1) else turns[i + 1, TANGENT]
    xa, ya, za = path[i, 0], path[i, 1], path[i, 2]
    xb, yb, zb = path[i + 1, 0], path[i + 1, 1], path[i + 1, 2]
    ux, uy, climb = 0.0, 0.0, 0.0
    run, rise = 0.0, zb - za
    run_a = turns[i, RUN]
    if run_a > 0.0:
        ux, uy, climb = (xb - xa) / run_a, (yb - ya) / run_a, rise / run_a
        run = max(run_a - cut_start - cut_stop, 0.0)
        rise = climb * run
        xa, ya, za = xa + ux * cut_start, ya + uy * cut_start, za + climb * cut_start
        xb, yb, zb = xb - ux * cut_stop, yb - uy * cut_stop, zb - climb * cut_stop
    lay_piece(pieces, 2 * i + 1, (xa, ya, za), (xb, yb, zb), (ux, uy), (1.0, 0.0), run, rise)
    if i == 0:
        if cut_start > 0.0:
            # The lead-in to the start and the lead-out from the goal are level.
            rise = cut_start * climb
            at = (
                path[0, 0] - c.start_east * cut_start,
                path[0, 1] - c.start_north * cut_start,
                path[0, 2],
            )
            lay_arc(pieces, 0, c, turns, 0, at, (c.start_east, c.start_north), rise)
        else:
            pieces[0, LENGTH] = 0.0
    if cut_stop > 0.0:
        if i + 2 < n:
            climb += (path[i + 2, 2] - path[i + 1, 2]) / turns[i + 1, RUN]
        rise = cut_stop * climb
        lay_arc(pieces, 2 * i + 2, c, turns, i + 1, (xb, yb, zb), (ux, uy), rise)
    else:
        pieces[2 * i + 2, LENGTH] = 0.0
