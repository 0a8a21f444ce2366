"""Samples of a path on the rasters, compiled: d_ut and d_nf of equation (1).

Each piece is cut into equal parts; the mid-point stands for the part. Scalar functions as in
:mod:`pathgene.host.evaluation.pieces`.
"""

import math
from typing import NamedTuple

import numpy as np

from pathgene.host.evaluation.constants import Constants, Course, Floats, Point
from pathgene.host.evaluation.jit import compiled, inlined


__all__ = ["Bend", "count_arc", "count_straight", "some_arc_hits", "some_straight_hits"]

_QUICK_PARTS = 1_000_000_000

_QUARTER, _ROOT_HALF = math.pi / 4, math.sqrt(0.5)
_S3, _S5, _S7, _S9, _S11, _S13, _S15 = (
    (-1) ** (power // 2) / math.factorial(power) for power in range(3, 16, 2)
)
_C2, _C4, _C6, _C8, _C10, _C12, _C14, _C16 = (
    (-1) ** (power // 2) / math.factorial(power) for power in range(2, 17, 2)
)


class Bend(NamedTuple):
    """An arc: its entry, the unit heading there, 1 to the left or -1, the turn (rad), the climb."""

    a: Point
    ux: float
    uy: float
    side: float
    angle: float
    rise: float


@compiled
def inside_map(x: float, y: float, c: Constants) -> bool:
    """Return whether a point lies in the rectangle of the nodes, its edge included."""
    on_x: bool = (x >= 0.0) & (x <= (c.columns - 1) * c.dx_m)
    on_y: bool = (y >= 0.0) & (y <= (c.rows - 1) * c.dy_m)
    return on_x & on_y


@compiled
def sample(course: Course, x: float, y: float, z: float) -> tuple[int, int]:
    """Return two integers 0 or 1: the point is under the terrain; the point is in a no-fly zone.

    A point above the roof of its node counts as under the terrain.

    A point outside the map is under the terrain; for no-fly zones, the nearest node of the edge
    stands in for it.
    """
    c = course.c
    node = quick_node(
        c,
        min(max(x / c.dx_m + 0.5, 0.0), c.columns - 1.0),
        min(max(y / c.dy_m + 0.5, 0.0), c.rows - 1.0),
    )
    inside = inside_map(x, y, c)
    height = course.zoned[node]
    zone = math.isnan(height)
    under = (not inside) | (z < (course.ground[node] if zone else height))
    if c.roofed:
        under = under | (-z < course.ground[node + np.uint64(c.rows * c.columns)])
    return int(under), int(zone)


@inlined
def quick_node(c: Constants, column: float, row: float) -> np.uint64:
    """Return the node nearest to a point on the map, given its place in nodes plus 1/2."""
    # Unsigned: no test for Python's negative indices.
    return np.uint64(np.int32(row) * np.int32(c.columns) + np.int32(column))


@inlined
def straight_steps(
    c: Constants, a: Point, b: Point, parts: int
) -> tuple[float, float, float, float, float, float]:
    """Return ``a`` in nodes plus 1/2 and metres of altitude, and the steps from part to part."""
    column, row, z = a[0] / c.dx_m + 0.5, a[1] / c.dy_m + 0.5, a[2]
    ex, ey, ez = (
        (b[0] - a[0]) / c.dx_m / parts,
        (b[1] - a[1]) / c.dy_m / parts,
        (b[2] - z) / parts,
    )
    return column, row, z, ex, ey, ez


@compiled
def straight_hits(ground: Floats, c: Constants, a: Point, b: Point, parts: int) -> tuple[int, int]:
    """Count the parts of a straight piece below ``ground``, and at NaN; both ends are on the map.

    By nearest nodes. One part takes a dozen arithmetic operations, one load, no division and no
    branch, so the loop vectorizes. The ends are converted to nodes once, by true divisions, so a
    path along the border between two cells falls on the side that the definition gives.
    """
    column, row, z, ex, ey, ez = straight_steps(c, a, b, parts)
    under = 0
    missing = 0
    for part in range(np.int32(parts)):
        t = part + 0.5
        height = ground[quick_node(c, column + ex * t, row + ey * t)]
        under += z + ez * t < height
        missing += math.isnan(height)
    return under, missing


@inlined
def straight_part(course: Course, a: Point, b: Point, part: int, parts: int) -> tuple[int, int]:
    """Return :func:`sample` at the mid-point of one of the equal parts of a straight piece."""
    t = (part + 0.5) / parts
    return sample(
        course,
        a[0] + (b[0] - a[0]) * t,
        a[1] + (b[1] - a[1]) * t,
        a[2] + (b[2] - a[2]) * t,
    )


@compiled
def straight_general(course: Course, a: Point, b: Point, parts: int) -> tuple[int, int]:
    """As :func:`count_straight`, for ends that may lie off the map."""
    under = 0
    inside = 0
    for part in range(parts):
        hit, zone = straight_part(course, a, b, part, parts)
        under += hit
        inside += zone
    return under, inside


@compiled
def count_straight(course: Course, a: Point, b: Point, parts: int) -> tuple[int, int]:
    """Count the parts of a straight piece under the terrain and in a no-fly zone."""
    ground, zoned, c = course
    # The quick loops count in 32 bits and do not check that samples are on the map.
    if parts > _QUICK_PARTS or not (inside_map(a[0], a[1], c) and inside_map(b[0], b[1], c)):
        return straight_general(course, a, b, parts)
    under, zone = straight_hits(zoned, c, a, b, parts)
    # The height in a zone is not in this raster, but few pieces touch a zone.
    if zone:
        under = straight_hits(ground, c, a, b, parts)[0]
    if c.roofed:
        # Above a roof is below it, upside down; a floor and a roof leave room between them.
        upside_down = (a[0], a[1], -a[2]), (b[0], b[1], -b[2])
        under += straight_hits(ground[c.rows * c.columns :], c, *upside_down, parts)[0]
    return under, zone


@inlined
def half_turn(half: float) -> tuple[float, float]:
    """Return sine and cosine of an angle from 0 to pi / 2, to about 2e-16.

    Taylor's series about pi / 4. They use arithmetic only, so a loop over the parts of an arc
    vectorizes and sees the same samples on every machine.
    """
    g = half - _QUARTER
    q = g * g
    sin = g * (
        1.0 + q * (_S3 + q * (_S5 + q * (_S7 + q * (_S9 + q * (_S11 + q * (_S13 + q * _S15))))))
    )
    cos = 1.0 + q * (
        _C2 + q * (_C4 + q * (_C6 + q * (_C8 + q * (_C10 + q * (_C12 + q * (_C14 + q * _C16))))))
    )
    return (cos + sin) * _ROOT_HALF, (cos - sin) * _ROOT_HALF


@inlined
def arc_point(c: Constants, bend: Bend, t: float) -> Point:
    """Return the point at the fraction ``t`` of an arc."""
    a, ux, uy, side, angle, rise = bend
    sin, cos = half_turn(0.5 * (angle * t))
    ahead = c.turn_radius_m * (2.0 * sin * cos)
    aside = side * c.turn_radius_m * (2.0 * sin * sin)
    return (a[0] + (ahead * ux - aside * uy), a[1] + (ahead * uy + aside * ux), a[2] + rise * t)


@inlined
def arc_part(course: Course, bend: Bend, part: int, parts: int) -> tuple[int, int]:
    """Return :func:`sample` at the mid-point of one of the equal parts of an arc."""
    x, y, z = arc_point(course.c, bend, (part + 0.5) / parts)
    return sample(course, x, y, z)


@inlined
def arc_axes(c: Constants, ux: float, uy: float, side: float) -> tuple[float, float, float, float]:
    """Return twice the turn radius ahead (x, y) and to the side (x, y) of a heading, in nodes."""
    across = 2.0 * c.turn_radius_m
    ahead_x, ahead_y = across * ux / c.dx_m, across * uy / c.dy_m
    aside_x, aside_y = -side * across * uy / c.dx_m, side * across * ux / c.dy_m
    return ahead_x, ahead_y, aside_x, aside_y


@compiled
def arc_hits(ground: Floats, c: Constants, bend: Bend, parts: int) -> tuple[int, int]:
    """As :func:`straight_hits`, for an arc."""
    a, ux, uy, side, angle, rise = bend
    column, row, z = a[0] / c.dx_m + 0.5, a[1] / c.dy_m + 0.5, a[2]
    ahead_x, ahead_y, aside_x, aside_y = arc_axes(c, ux, uy, side)
    half, ez = 0.5 * angle / parts, rise / parts
    under = 0
    missing = 0
    for part in range(np.int32(parts)):
        t = part + 0.5
        sin, cos = half_turn(half * t)
        ahead, aside = sin * cos, sin * sin
        height = ground[
            quick_node(
                c,
                column + (ahead * ahead_x + aside * aside_x),
                row + (ahead * ahead_y + aside * aside_y),
            )
        ]
        under += z + ez * t < height
        missing += math.isnan(height)
    return under, missing


@compiled
def arc_general(course: Course, bend: Bend, parts: int) -> tuple[int, int]:
    """As :func:`count_arc`, for an arc that may leave the map."""
    under = 0
    inside = 0
    for part in range(parts):
        hit, zone = arc_part(course, bend, part, parts)
        under += hit
        inside += zone
    return under, inside


@compiled
def count_arc(course: Course, bend: Bend, parts: int) -> tuple[int, int]:
    """Count the parts of an arc under the terrain and in a no-fly zone."""
    ground, zoned, c = course
    a = bend.a
    # No point of the arc is farther from its entry.
    reach = c.turn_radius_m * min(bend.angle, 2.0)
    if parts > _QUICK_PARTS or not (
        inside_map(a[0] - reach, a[1] - reach, c) and inside_map(a[0] + reach, a[1] + reach, c)
    ):
        return arc_general(course, bend, parts)
    under, zone = arc_hits(zoned, c, bend, parts)
    if zone:
        under = arc_hits(ground, c, bend, parts)[0]
    if c.roofed:
        entry = a[0], a[1], -a[2]
        upside_down = Bend(entry, bend.ux, bend.uy, bend.side, bend.angle, -bend.rise)
        under += arc_hits(ground[c.rows * c.columns :], c, upside_down, parts)[0]
    return under, zone


@inlined
def hits_at(course: Course, column: float, row: float, z: float) -> int:
    """Count the hits at a point of the map by its nearest node: terrain, roof and no-fly zone."""
    ground, c = course.ground, course.c
    node = quick_node(c, column, row)
    height = course.zoned[node]
    zone = math.isnan(height)
    hits = int(zone) + int(z < (ground[node] if zone else height))
    if c.roofed:
        hits += int(-z < ground[node + np.uint64(c.rows * c.columns)])
    return hits


@inlined
def some_straight_hits(
    course: Course, a: Point, b: Point, parts: int, first: int, stride: int
) -> int:
    """As the sum of :func:`count_straight`, of every ``stride``-th part: a CUDA thread's share."""
    c = course.c
    hits = 0
    if not (inside_map(a[0], a[1], c) and inside_map(b[0], b[1], c)):
        for part in range(first, parts, stride):
            under, zone = straight_part(course, a, b, part, parts)
            hits += under + zone
        return hits
    column, row, z, ex, ey, ez = straight_steps(c, a, b, parts)
    for part in range(first, parts, stride):
        t = part + 0.5
        hits += hits_at(course, column + ex * t, row + ey * t, z + ez * t)
    return hits


@inlined
def some_arc_hits(course: Course, bend: Bend, parts: int, first: int, stride: int) -> int:
    """As the sum of :func:`count_arc`, of every ``stride``-th part: a CUDA thread's share."""
    c = course.c
    a, ux, uy, side, angle, rise = bend
    hits = 0
    reach = c.turn_radius_m * min(angle, 2.0)
    if not (
        inside_map(a[0] - reach, a[1] - reach, c) and inside_map(a[0] + reach, a[1] + reach, c)
    ):
        for part in range(first, parts, stride):
            under, zone = arc_part(course, bend, part, parts)
            hits += under + zone
        return hits
    column, row, z = a[0] / c.dx_m + 0.5, a[1] / c.dy_m + 0.5, a[2]
    ahead_x, ahead_y, aside_x, aside_y = arc_axes(c, ux, uy, side)
    half, ez = 0.5 * angle / parts, rise / parts
    for part in range(first, parts, stride):
        t = part + 0.5
        sin, cos = half_turn(half * t)
        ahead, aside = sin * cos, sin * sin
        hits += hits_at(
            course,
            column + (ahead * ahead_x + aside * aside_x),
            row + (ahead * ahead_y + aside * aside_y),
            z + ez * t,
        )
    return hits
