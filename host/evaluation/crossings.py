"""Crossings of a piece with circles and lines, compiled, in closed form.

A piece is a row of the pieces of :mod:`pathgene.host.evaluation.pieces`: a horizontal straight or
arc, or a vertical. Its places are named by the fraction t of its length, from 0 to 1. Every
function takes ``pieces`` and ``row`` and, where it finds crossings, appends their fractions between
``low`` and ``high`` to ``marks`` starting at ``count``, and returns the new count: at most 2 a
call.

Rounding moves a crossing by about 1e-9 m across the track. If the piece touches a line or a
circle without entering by more than that, its crossings may be missing.
"""

import math
from typing import NamedTuple

from pathgene.host.evaluation.constants import Floats
from pathgene.host.evaluation.jit import compiled, inlined
from pathgene.host.evaluation.laying import ANGLE, RUN, SIDE, UX, UY, X_END, Y_END, X, Y


__all__ = [
    "Line",
    "box_of",
    "centre_of",
    "cross_circle",
    "cross_line",
    "mark_parallel",
    "mark_towards",
    "place",
    "sort_marks",
]

Box = tuple[float, float, float, float]


class Line(NamedTuple):
    """A parallel of a line through a point along a unit direction, and the part that counts.

    Parameters
    ----------
    x, y, ex, ey : float
        The point and the direction.
    aside : float
        Metres to the left of the line.
    first, last : float
        Only crossings from ``first`` to ``last`` metres along it count.
    """

    x: float
    y: float
    ex: float
    ey: float
    aside: float
    first: float
    last: float


@inlined
def centre_of(pieces: Floats, row: int) -> tuple[float, float, float]:
    """Return the centre x, y and the radius of an arc."""
    radius = pieces[row, RUN] / pieces[row, ANGLE]
    aside = pieces[row, SIDE] * radius
    return (
        pieces[row, X] - aside * pieces[row, UY],
        pieces[row, Y] + aside * pieces[row, UX],
        radius,
    )


@inlined
def place(pieces: Floats, row: int, t: float) -> tuple[float, float]:
    """Return the x and y at the fraction ``t``."""
    x, y = pieces[row, X], pieces[row, Y]
    angle = pieces[row, ANGLE]
    if angle > 0.0:
        radius = pieces[row, RUN] / angle
        ux, uy = pieces[row, UX], pieces[row, UY]
        # 1 - cos as 2 sin^2 keeps its digits on a short arc.
        half = math.sin(0.5 * angle * t)
        ahead = radius * math.sin(angle * t)
        aside = pieces[row, SIDE] * radius * 2.0 * half * half
        return x + (ahead * ux - aside * uy), y + (ahead * uy + aside * ux)
    return x + (pieces[row, X_END] - x) * t, y + (pieces[row, Y_END] - y) * t


@inlined
def box_of(pieces: Floats, row: int) -> Box:
    """Return a rectangle that holds the piece: west, south, east, north."""
    x, y = pieces[row, X], pieces[row, Y]
    if pieces[row, ANGLE] > 0.0:
        cx, cy, radius = centre_of(pieces, row)
        run = pieces[row, RUN]
        return (
            max(x - run, cx - radius),
            max(y - run, cy - radius),
            min(x + run, cx + radius),
            min(y + run, cy + radius),
        )
    x_end, y_end = pieces[row, X_END], pieces[row, Y_END]
    return min(x, x_end), min(y, y_end), max(x, x_end), max(y, y_end)


@inlined
def _mark(t: float, low: float, high: float, marks: Floats, count: int) -> int:
    if low < t and t < high:
        marks[count] = t
        return count + 1
    return count


@inlined
def _arc_fraction(pieces: Floats, row: int, vx: float, vy: float) -> float:
    """Return the fraction where the arc's radius has the direction (vx, vy); above 1 beyond it."""
    ux, uy = pieces[row, UX], pieces[row, UY]
    turned = math.atan2(vx * ux + vy * uy, pieces[row, SIDE] * (vx * uy - vy * ux))
    if turned < 0.0:
        turned += 2.0 * math.pi
    fraction: float = turned / pieces[row, ANGLE]
    return fraction


@compiled
def cross_circle(
    pieces: Floats,
    row: int,
    circle: tuple[float, float, float],
    low: float,
    high: float,
    marks: Floats,
    count: int,
) -> int:
    """Mark the crossings with a circle: the x and y of its centre, and its radius."""
    x, y, radius = circle
    if pieces[row, ANGLE] > 0.0:
        cx, cy, turn_radius = centre_of(pieces, row)
        ox, oy = x - cx, y - cy
        apart = math.sqrt(ox * ox + oy * oy)
        if apart == 0.0:
            return count
        ox, oy = ox / apart, oy / apart
        # The common chord is perpendicular to the line of the centres.
        ahead = 0.5 * (
            turn_radius * (turn_radius / apart) + (apart - radius) * (1.0 + radius / apart)
        )
        square = (turn_radius - ahead) * (turn_radius + ahead)
        if square < 0.0:
            return count
        aside = math.sqrt(square)
        px, py, qx, qy = ahead * ox, ahead * oy, -aside * oy, aside * ox
        count = _mark(_arc_fraction(pieces, row, px + qx, py + qy), low, high, marks, count)
        return _mark(_arc_fraction(pieces, row, px - qx, py - qy), low, high, marks, count)
    fx, fy = pieces[row, X] - x, pieces[row, Y] - y
    dx, dy = pieces[row, X_END] - pieces[row, X], pieces[row, Y_END] - pieces[row, Y]
    length = math.sqrt(dx * dx + dy * dy)
    if length == 0.0:
        return count
    ux, uy = dx / length, dy / length
    cross = fx * uy - fy * ux
    square = (radius - cross) * (radius + cross)
    if square < 0.0:
        return count
    half = math.sqrt(square)
    nearest = -(fx * ux + fy * uy)
    count = _mark((nearest - half) / length, low, high, marks, count)
    return _mark((nearest + half) / length, low, high, marks, count)


@compiled
def cross_line(
    pieces: Floats,
    row: int,
    line: Line,
    low: float,
    high: float,
    marks: Floats,
    count: int,
) -> int:
    """Mark the crossings with a line."""
    x, y, ex, ey, aside, first, last = line
    if pieces[row, ANGLE] > 0.0:
        cx, cy, radius = centre_of(pieces, row)
        across = aside - ((cy - y) * ex - (cx - x) * ey)
        square = (radius - across) * (radius + across)
        if square < 0.0:
            return count
        half = math.sqrt(square)
        along = (cx - x) * ex + (cy - y) * ey
        nx, ny = -across * ey, across * ex
        if first <= along + half and along + half <= last:
            t = _arc_fraction(pieces, row, nx + half * ex, ny + half * ey)
            count = _mark(t, low, high, marks, count)
        if first <= along - half and along - half <= last:
            t = _arc_fraction(pieces, row, nx - half * ex, ny - half * ey)
            count = _mark(t, low, high, marks, count)
        return count
    fx, fy = pieces[row, X] - x, pieces[row, Y] - y
    dx, dy = pieces[row, X_END] - pieces[row, X], pieces[row, Y_END] - pieces[row, Y]
    slope = dy * ex - dx * ey
    if slope == 0.0:
        return count
    t = (aside - (fy * ex - fx * ey)) / slope
    along = fx * ex + fy * ey + t * (dx * ex + dy * ey)
    if first <= along and along <= last:
        count = _mark(t, low, high, marks, count)
    return count


@compiled
def mark_towards(
    pieces: Floats, row: int, x: float, y: float, low: float, high: float, marks: Floats, count: int
) -> int:
    """Mark the place nearest to the point (``x``, ``y``), unless it is an end of the piece."""
    if pieces[row, ANGLE] > 0.0:
        cx, cy, _ = centre_of(pieces, row)
        return _mark(_arc_fraction(pieces, row, x - cx, y - cy), low, high, marks, count)
    dx, dy = pieces[row, X_END] - pieces[row, X], pieces[row, Y_END] - pieces[row, Y]
    square = dx * dx + dy * dy
    if square == 0.0:
        return count
    t = ((x - pieces[row, X]) * dx + (y - pieces[row, Y]) * dy) / square
    return _mark(t, low, high, marks, count)


@compiled
def mark_parallel(
    pieces: Floats,
    row: int,
    ex: float,
    ey: float,
    low: float,
    high: float,
    marks: Floats,
    count: int,
) -> int:
    """Mark the places of an arc that run along the unit direction (``ex``, ``ey``), or against."""
    if pieces[row, ANGLE] > 0.0:
        count = _mark(_arc_fraction(pieces, row, -ey, ex), low, high, marks, count)
        count = _mark(_arc_fraction(pieces, row, ey, -ex), low, high, marks, count)
    return count


@inlined
def sort_marks(marks: Floats, count: int) -> None:
    """Sort the first ``count`` marks in place by Shellsort, with gaps of 3 k + 1."""
    gap = 1
    while gap < count // 3:
        gap = 3 * gap + 1
    while gap > 0:
        for i in range(gap, count):
            mark = marks[i]
            j = i
            while j >= gap and marks[j - gap] > mark:
                marks[j] = marks[j - gap]
                j -= gap
            marks[j] = mark
        gap //= 3
