"""Samples of a path on the rasters, compiled: d_ut and d_nf of equation (1).

Each piece is cut into equal parts; the mid-point stands for the part. Scalar functions as in
:mod:`host.evaluation.pieces`.
"""

import math

import numpy as np

from host.evaluation.constants import Constants, Flags, Floats, Point
from host.evaluation.jit import compiled, inlined


__all__ = ["arc_part", "count_arc", "count_straight", "straight_part"]

_QUICK_PARTS = 1_000_000_000


@compiled
def inside_map(x: float, y: float, c: Constants) -> bool:
    """Whether a point lies in the rectangle of the nodes, its edge included."""
    on_x: bool = 0.0 <= x <= (c.columns - 1) * c.dx_m
    on_y: bool = 0.0 <= y <= (c.rows - 1) * c.dy_m
    return on_x and on_y


@compiled
def sample(
    ground: Floats, nofly: Flags, c: Constants, x: float, y: float, z: float,
) -> tuple[int, int]:
    """Whether a point is under the terrain, and in a no-fly zone, as two integers 0 or 1.

    Takes any point: outside the map it is under the terrain, and over the nearest node of the edge
    as far as no-fly zones go.
    """
    # CUDA's floor is no integer.
    column = np.int64(math.floor(min(max(x / c.dx_m + 0.5, 0.0), c.columns - 1.0)))
    row = np.int64(math.floor(min(max(y / c.dy_m + 0.5, 0.0), c.rows - 1.0)))
    node = row * c.columns + column
    under = 1
    if inside_map(x, y, c):
        height = bilinear_ground(ground, c, x, y) if c.bilinear else ground[node]
        under = 1 if z < height else 0
    return under, int(nofly[node]) if c.zones else 0


@compiled
def bilinear_ground(ground: Floats, c: Constants, x: float, y: float) -> float:
    """Height between the four nodes around a point inside the map; a void weighing in is high."""
    column = min(np.int32(x / c.dx_m), np.int32(c.columns - 2))
    row = min(np.int32(y / c.dy_m), np.int32(c.rows - 2))
    east = x / c.dx_m - column
    north = y / c.dy_m - row
    south_west = row * np.int32(c.columns) + column
    north_west = south_west + np.int32(c.columns)
    below = (1.0 - east) * ground[np.uint64(south_west)] + east * ground[np.uint64(south_west + 1)]
    above = (1.0 - east) * ground[np.uint64(north_west)] + east * ground[np.uint64(north_west + 1)]
    height: float = (1.0 - north) * below + north * above
    return height


@compiled
def straight_under(ground: Floats, c: Constants, a: Point, b: Point, parts: int) -> int:
    """Parts of a straight piece under the terrain, by nearest nodes; both ends inside the map.

    One part is a dozen arithmetic operations, one load and no branch: the loop vectorises. True
    divisions, because a path along the border between two cells must fall as the definition says.
    """
    (x, y, z), ex, ey, ez = a, b[0] - a[0], b[1] - a[1], b[2] - a[2]
    under = 0
    for part in range(np.int32(parts)):
        t = (part + 0.5) / parts
        column = np.int32((x + ex * t) / c.dx_m + 0.5)
        row = np.int32((y + ey * t) / c.dy_m + 0.5)
        # Unsigned: no test for Python's negative indices.
        under += z + ez * t < ground[np.uint64(row * np.int32(c.columns) + column)]
    return under


@compiled
def straight_under_nofly(
    ground: Floats, nofly: Flags, c: Constants, a: Point, b: Point, parts: int,
) -> tuple[int, int]:
    """As :func:`straight_under`, and the parts in a no-fly zone beside it."""
    (x, y, z), ex, ey, ez = a, b[0] - a[0], b[1] - a[1], b[2] - a[2]
    under = 0
    inside = 0
    for part in range(np.int32(parts)):
        t = (part + 0.5) / parts
        column = np.int32((x + ex * t) / c.dx_m + 0.5)
        row = np.int32((y + ey * t) / c.dy_m + 0.5)
        node = np.uint64(row * np.int32(c.columns) + column)
        under += z + ez * t < ground[node]
        inside += nofly[node]
    return under, inside


@compiled
def straight_under_bilinear(ground: Floats, c: Constants, a: Point, b: Point, parts: int) -> int:
    """As :func:`straight_under`, by the height between nodes."""
    (x, y, z), ex, ey, ez = a, b[0] - a[0], b[1] - a[1], b[2] - a[2]
    under = 0
    for part in range(np.int32(parts)):
        t = (part + 0.5) / parts
        under += z + ez * t < bilinear_ground(ground, c, x + ex * t, y + ey * t)
    return under


@inlined
def straight_part(
    ground: Floats, nofly: Flags, c: Constants, a: Point, b: Point, part: int, parts: int,
) -> tuple[int, int]:
    """:func:`sample` of the mid-point of one of the equal parts of a straight piece."""
    t = (part + 0.5) / parts
    return sample(ground, nofly, c, a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t,
                  a[2] + (b[2] - a[2]) * t)


@compiled
def straight_general(
    ground: Floats, nofly: Flags, c: Constants, a: Point, b: Point, parts: int,
) -> tuple[int, int]:
    """As :func:`straight_under_nofly` for any end points and any reading of the ground."""
    under = 0
    inside = 0
    for part in range(parts):
        hit, zone = straight_part(ground, nofly, c, a, b, part, parts)
        under += hit
        inside += zone
    return under, inside


@compiled
def count_straight(
    ground: Floats, nofly: Flags, c: Constants, a: Point, b: Point, parts: int,
) -> tuple[int, int]:
    """Parts of a straight piece under the terrain and in a no-fly zone."""
    # The quick loops count in 32 bits and do not look whether they are on the map.
    if parts > _QUICK_PARTS or not (inside_map(a[0], a[1], c) and inside_map(b[0], b[1], c)):
        return straight_general(ground, nofly, c, a, b, parts)
    hit, zone = 0, 0
    if c.zones:
        hit, zone = straight_under_nofly(ground, nofly, c, a, b, parts)
    elif not c.bilinear:
        hit = straight_under(ground, c, a, b, parts)
    if c.bilinear:
        hit = straight_under_bilinear(ground, c, a, b, parts)
    return hit, zone


@inlined
def arc_part(
    ground: Floats, nofly: Flags, c: Constants, a: Point, ux: float, uy: float, side: float,
    angle: float, rise: float, part: int, parts: int,
) -> tuple[int, int]:
    """:func:`sample` of the mid-point of one of the equal parts of an arc.

    It is entered at ``a`` with the unit heading ux, uy; ``side`` is 1 to the left, else -1.
    """
    t = (part + 0.5) / parts
    half_sin = math.sin(0.5 * (angle * t))
    ahead = c.turn_radius_m * math.sin(angle * t)
    aside = side * c.turn_radius_m * 2.0 * half_sin * half_sin
    return sample(ground, nofly, c, a[0] + (ahead * ux - aside * uy),
                  a[1] + (ahead * uy + aside * ux), a[2] + rise * t)


@compiled
def count_arc(
    ground: Floats, nofly: Flags, c: Constants, a: Point, ux: float, uy: float, side: float,
    angle: float, rise: float, parts: int,
) -> tuple[int, int]:
    """Parts of an arc under the terrain and in a no-fly zone; arguments of :func:`arc_part`."""
    under = 0
    inside = 0
    for part in range(parts):
        hit, zone = arc_part(ground, nofly, c, a, ux, uy, side, angle, rise, part, parts)
        under += hit
        inside += zone
    return under, inside
