"""The strict rule on terrain, compiled: exact heights over the surface along a whole track.

The surface under a point is the greater of its nearest node's height and the height between the
four nodes around it. A stretch of a piece, as wide as the corridor, is bounded by the altitudes at
its ends and the extremes of the surface in a rectangle around it. A stretch whose bound does not
decide is halved, down to millimetres: a violation of more than a millimetre is never missed.

The surface beyond the edge of the map is unknown, so the corridor must stay on the map. Its extent
is known in closed form; only a corridor on the map is searched.
"""

import math
from typing import NamedTuple

import numpy as np

from pathgene.host.evaluation import laying as fields
from pathgene.host.evaluation.constants import Constants, Floats
from pathgene.host.evaluation.jit import compiled, inlined


__all__ = ["STACK_SHAPE", "Part", "Required", "Surface", "excess_m", "extreme", "room_on_map_m"]

# Depth-first search: a halving leaves one half on the stack.
STACK_SHAPE = (192, 4)
# Half extents of the smallest stretch, metres: its corners stand for it.
_LEAF_M = 0.001
# Heights are compared up to rounding.
_ROUNDING_M = 1e-9
# A corridor may reach this far beyond the edge of the map: coordinates are rounded, too.
_BEYOND_EDGE_M = 1e-6
_NEVER = -1e300

_X, _Y, _Z = fields.X, fields.Y, fields.Z
_UX, _UY, _SIDE, _ANGLE = fields.UX, fields.UY, fields.SIDE, fields.ANGLE
_RUN, _RISE, _LENGTH = fields.RUN, fields.RISE, fields.LENGTH


class Required(NamedTuple):
    """Required height over the surface; metres.

    ``sign`` is 1 for a least height and -1 for a greatest one, ``height_m`` that height, and
    ``half_width_m`` half the width of the strip on which it holds. The least height is lower near
    the ends: at most ``start_height_m`` plus ``start_slope`` times the horizontal distance from
    ``start_x``, ``start_y``, and likewise at the goal.
    """

    sign: float
    height_m: float
    half_width_m: float
    start_x: float
    start_y: float
    start_height_m: float
    start_slope: float
    goal_x: float
    goal_y: float
    goal_height_m: float
    goal_slope: float


class Surface(NamedTuple):
    """The raster of the terrain, flat and very high at voids, and the constants of the problem."""

    ground: Floats
    c: Constants


class Part(NamedTuple):
    """A stretch of a piece: the piece's row, and horizontal metres along the piece."""

    row: int
    first: float
    last: float


@inlined
def between_nodes(ground: Floats, c: Constants, x: float, y: float) -> float:
    """Return the height between the four nodes around a point given in cells, on the map."""
    column = min(np.int32(x), np.int32(c.columns - 2))
    row = min(np.int32(y), np.int32(c.rows - 2))
    east, north = x - column, y - row
    node = row * np.int32(c.columns) + column
    above = node + np.int32(c.columns)
    low = (1.0 - east) * ground[np.uint64(node)] + east * ground[np.uint64(node + 1)]
    high = (1.0 - east) * ground[np.uint64(above)] + east * ground[np.uint64(above + 1)]
    height: float = (1.0 - north) * low + north * high
    return height


@compiled
def surface_extremes(
    ground: Floats, c: Constants, x0: float, x1: float, y0: float, y1: float
) -> tuple[float, float]:
    """Return a lower and an upper bound of the surface in a rectangle; exact as it shrinks.

    The rectangle is given in cells; off the map, the nearest point of its edge is used.
    """
    last_x, last_y = c.columns - 1.0, c.rows - 1.0
    x0, x1 = min(max(x0, 0.0), last_x), min(max(x1, 0.0), last_x)
    y0, y1 = min(max(y0, 0.0), last_y), min(max(y1, 0.0), last_y)
    nearest_low, nearest_high = 1e301, _NEVER
    for row in range(np.int32(y0 + 0.5), np.int32(y1 + 1.5)):
        for column in range(np.int32(x0 + 0.5), np.int32(x1 + 1.5)):
            height = ground[np.uint64(row * np.int32(c.columns) + column)]
            nearest_low = min(nearest_low, height)
            nearest_high = max(nearest_high, height)
    # Between nodes, the extremes lie on the lines of nodes and the rim.
    low, high = 1e301, nearest_high
    first_x, first_y = np.int32(math.ceil(x0)), np.int32(math.ceil(y0))
    lines_x, lines_y = np.int32(math.floor(x1)) - first_x, np.int32(math.floor(y1)) - first_y
    for row in range(first_y, first_y + lines_y + 1):
        for column in range(first_x, first_x + lines_x + 1):
            low = min(low, ground[np.uint64(row * np.int32(c.columns) + column)])
    for i in range(lines_x + 3):
        x = x0 if i == 0 else x1 if i == 1 else first_x + (i - 2.0)
        for end in range(2):
            height = between_nodes(ground, c, x, y0 if end == 0 else y1)
            low, high = min(low, height), max(high, height)
    for i in range(lines_y + 1):
        for end in range(2):
            height = between_nodes(ground, c, x0 if end == 0 else x1, first_y + float(i))
            low, high = min(low, height), max(high, height)
    # The surface is the greater of two heights: a lower bound of either is one of both.
    return max(nearest_low, low), high


@inlined
def track_point(
    pieces: Floats, row: int, along: float, aside: float
) -> tuple[float, float, float, float]:
    """Return the x and y of a point ``aside`` (left) of a piece, and the unit heading there."""
    ux, uy = pieces[row, _UX], pieces[row, _UY]
    x, y = pieces[row, _X], pieces[row, _Y]
    if pieces[row, _ANGLE] > 0.0:
        side = pieces[row, _SIDE]
        radius = pieces[row, _RUN] / pieces[row, _ANGLE]
        turned = along / radius
        sin, cos = math.sin(turned), math.cos(turned)
        half = math.sin(0.5 * turned)
        ahead, left = radius * sin, side * radius * 2.0 * half * half
        x, y = x + ahead * ux - left * uy, y + ahead * uy + left * ux
        ux, uy = cos * ux - side * sin * uy, cos * uy + side * sin * ux
    else:
        x, y = x + along * ux, y + along * uy
    return x - aside * uy, y + aside * ux, ux, uy


@inlined
def surface_at(ground: Floats, c: Constants, x: float, y: float) -> float:
    """Return the surface under a point in metres; off the map the nearest point of its edge."""
    column = min(max(x / c.dx_m, 0.0), c.columns - 1.0)
    row = min(max(y / c.dy_m, 0.0), c.rows - 1.0)
    node = np.int32(row + 0.5) * np.int32(c.columns) + np.int32(column + 0.5)
    highest: float = max(ground[np.uint64(node)], between_nodes(ground, c, column, row))
    return highest


@inlined
def height_between(ground: Floats, c: Constants, x: float, y: float) -> float:
    """Return the height between the nodes around a point in metres, as for the surface."""
    column = min(max(x / c.dx_m, 0.0), c.columns - 1.0)
    row = min(max(y / c.dy_m, 0.0), c.rows - 1.0)
    return between_nodes(ground, c, column, row)


@inlined
def shape_of_patch(ground: Floats, c: Constants, x: float, y: float) -> tuple[float, float]:
    """Return twist (metres a cell) and greatest slope of the height around a point in cells."""
    column = min(max(np.int32(x), np.int32(0)), np.int32(c.columns - 2))
    row = min(max(np.int32(y), np.int32(0)), np.int32(c.rows - 2))
    node = row * np.int32(c.columns) + column
    above = node + np.int32(c.columns)
    sw, se = ground[np.uint64(node)], ground[np.uint64(node + 1)]
    nw, ne = ground[np.uint64(above)], ground[np.uint64(above + 1)]
    slope = max(abs(se - sw), abs(ne - nw)) / c.dx_m + max(abs(nw - sw), abs(ne - se)) / c.dy_m
    return abs(ne - nw - se + sw), slope


@inlined
def same_patch(x0: float, x1: float, y0: float, y1: float) -> bool:
    """Return whether a rectangle, in cells, has one nearest node and lies between four nodes."""
    by_x = math.floor(2.0 * x0) == math.floor(2.0 * x1)
    by_y = math.floor(2.0 * y0) == math.floor(2.0 * y1)
    return by_x and by_y


@inlined
def demands(required: Required, x: float, y: float) -> tuple[float, float, float]:
    """Return the heights whose minimum is required at a point of the track."""
    if required.sign < 0.0:
        return required.height_m, required.height_m, required.height_m
    dx, dy = x - required.start_x, y - required.start_y
    at_start = required.start_height_m + required.start_slope * math.sqrt(dx * dx + dy * dy)
    dx, dy = x - required.goal_x, y - required.goal_y
    at_goal = required.goal_height_m + required.goal_slope * math.sqrt(dx * dx + dy * dy)
    return required.height_m, at_start, at_goal


@compiled
def extreme(
    surface: Surface,
    required: Required,
    pieces: Floats,
    part: Part,
    incumbent: float,
    step: float,
    verdict: bool,
    stack: Floats,
) -> tuple[float, float]:
    """Return the greatest excess over a requirement on a part of a piece, and its place.

    The excess of a point is its distance below the required height, or above the allowed one.

    Parameters
    ----------
    incumbent : float
        Known excess: the result is at least this.
    step : float
        Smallest gain over the incumbent worth searching for, metres.
    verdict : bool
        Return at the first excess above the incumbent.
    """
    ground, c = surface
    row, first, last = part
    run, rise = pieces[row, _RUN], pieces[row, _RISE]
    angle = pieces[row, _ANGLE]
    radius = run / angle if angle > 0.0 else 0.0
    climb = rise / run if run > 0.0 else 0.0
    sign = required.sign
    z = pieces[row, _Z]
    if run == 0.0:  # A vertical piece: its worst altitude is at one end.
        z = min(z, z + rise) if sign > 0.0 else max(z, z + rise)
    place = first
    stack[0, 0], stack[0, 1] = first, last
    stack[0, 2], stack[0, 3] = -required.half_width_m, required.half_width_m
    size = 1
    while size > 0:
        size -= 1
        a0, a1, s0, s1 = stack[size, 0], stack[size, 1], stack[size, 2], stack[size, 3]
        along, aside = 0.5 * (a0 + a1), 0.5 * (s0 + s1)
        half_along, half_aside = 0.5 * (a1 - a0), 0.5 * (s1 - s0)
        x, y, ux, uy = track_point(pieces, row, along, aside)
        reach, across, sag = half_along, half_aside, 0.0
        if angle > 0.0:
            reach *= 1.0 + max(abs(s0), abs(s1)) / radius
            sag = 0.5 * reach * half_along / radius
            across += sag
        ex = (abs(ux) * reach + abs(uy) * across) / c.dx_m
        ey = (abs(uy) * reach + abs(ux) * across) / c.dy_m
        x_cells, y_cells = x / c.dx_m, y / c.dy_m
        low, high = surface_extremes(
            ground, c, x_cells - ex, x_cells + ex, y_cells - ey, y_cells + ey
        )
        # The track at both ends of the stretch: the required height less the altitude there is the
        # maximum between them, for each requirement on its own; on an arc, nearly.
        x0, y0, ux0, uy0 = track_point(pieces, row, a0, 0.0)
        x1, y1, ux1, uy1 = track_point(pieces, row, a1, 0.0)
        z0, z1 = z + climb * a0, z + climb * a1
        bend = sag * max(required.start_slope, required.goal_slope)
        if sign > 0.0:
            plain0, start0, goal0 = demands(required, x0, y0)
            plain1, start1, goal1 = demands(required, x1, y1)
            least = min(
                max(plain0 - z0, plain1 - z1),
                min(max(start0 - z0, start1 - z1), max(goal0 - z0, goal1 - z1)) + bend,
            )
            bound = high + least
        else:
            bound = max(z0, z1) - low - required.height_m
        if not bound > incumbent + step:
            continue
        # Corners and centre, unchanged.
        worst = _NEVER
        plain, near_start, near_goal = _NEVER, _NEVER, _NEVER
        for corner in range(5):
            at_first = corner < 2
            s = s0 if corner == 0 or corner == 2 else s1
            cx = x0 - s * uy0 if at_first else x1 - s * uy1
            cy = y0 + s * ux0 if at_first else y1 + s * ux1
            altitude = z0 if at_first else z1
            tx = x0 if at_first else x1
            ty = y0 if at_first else y1
            if corner == 4:
                cx, cy, altitude = x, y, 0.5 * (z0 + z1)
                tx, ty = x + aside * uy, y - aside * ux
            height = surface_at(ground, c, cx, cy)
            if sign > 0.0:
                demand, by_start, by_goal = demands(required, tx, ty)
                plain = max(plain, height + demand - altitude)
                near_start = max(near_start, height + by_start - altitude)
                near_goal = max(near_goal, height + by_goal - altitude)
                value = height + min(demand, by_start, by_goal) - altitude
            else:
                value = altitude - height - required.height_m
                # Over the lower bound of the surface, and over the height between nodes.
                plain = max(plain, altitude - low - required.height_m)
                between = height_between(ground, c, cx, cy)
                near_start = max(near_start, altitude - between - required.height_m)
                near_goal = near_start
            if value > worst:
                worst = value
        if worst > incumbent:
            incumbent, place = worst, along
            if verdict:
                return incumbent, place
        if half_along <= _LEAF_M and half_aside <= _LEAF_M:
            continue
        if same_patch(x_cells - ex, x_cells + ex, y_cells - ey, y_cells + ey):
            # On one patch the surface is a plane and a twist, so its corners bound it. The twist
            # bulges least along the lines of nodes.
            twist, slope = shape_of_patch(ground, c, x_cells, y_cells)
            bulge = slope * sag + bend
            if angle > 0.0:
                bulge += twist * ex * ey
            else:
                larger = max(half_along, half_aside)
                bulge += twist * abs(ux * uy) * larger * larger / (c.dx_m * c.dy_m)
            if not min(plain, near_start, near_goal) + bulge > incumbent + step:
                continue
        half_is_along = half_along >= half_aside
        middle = along if half_is_along else aside
        stack[size, 0], stack[size, 1] = a0, middle if half_is_along else a1
        stack[size, 2], stack[size, 3] = s0, s1 if half_is_along else middle
        size += 1
        stack[size, 0], stack[size, 1] = middle if half_is_along else a0, a1
        stack[size, 2], stack[size, 3] = s0 if half_is_along else middle, s1
        size += 1
    return incumbent, place


@compiled
def excess_m(
    surface: Surface, required: Required, below: Required, pieces: Floats, rows: int, stack: Floats
) -> float:
    """Return the metres of a track that violate a requirement, or whose strip leaves the map.

    Each piece is cut into equal parts of at most ``ds_m``; a part counts whole if any of its points
    violates the requirement. ``below`` is required right below the track, too, where ``required``
    is lower than far from the ends. See :func:`extreme` for the remaining parameters.
    """
    c = surface.c
    total = 0.0
    for row in range(rows):
        length, run = pieces[row, _LENGTH], pieces[row, _RUN]
        if not length > 0.0:
            continue
        parts = np.int64(math.ceil(run / c.ds_m)) if run > 0.0 else 1
        broken = 0
        wide = required.half_width_m
        on_map = room_on_map_m(c, pieces, Part(row, 0.0, run), wide) >= 0.0
        for number in range(parts):
            part = Part(row, run * number / parts, run * (number + 1) / parts)
            if not (on_map or room_on_map_m(c, pieces, part, wide) >= 0.0):
                broken += 1
                continue
            excess, _ = extreme(surface, required, pieces, part, _ROUNDING_M, 0.0, True, stack)
            if excess <= _ROUNDING_M and is_near_end(required, pieces, part):
                excess, _ = extreme(surface, below, pieces, part, _ROUNDING_M, 0.0, True, stack)
            broken += 1 if excess > _ROUNDING_M else 0
        total += length * broken / parts
    return total


@inlined
def is_near_end(required: Required, pieces: Floats, part: Part) -> bool:
    """Return whether less than the clearance is required on a part of a piece."""
    row, first, last = part
    x, y, _, _ = track_point(pieces, row, 0.5 * (first + last), 0.0)
    _, at_start, at_goal = demands(required, x, y)
    steepest = max(required.start_slope, required.goal_slope)
    return min(at_start, at_goal) - steepest * 0.5 * (last - first) < required.height_m


@inlined
def room_on_map_m(c: Constants, pieces: Floats, part: Part, half_width_m: float) -> float:
    """Return the distance between the edge of the map and the strip along a part of a piece.

    The strip reaches ``half_width_m`` to either side of the track. The distance is negative if the
    strip leaves the map.
    """
    row, first, last = part
    x0, y0, ux0, uy0 = track_point(pieces, row, first, 0.0)
    x1, y1, ux1, uy1 = track_point(pieces, row, last, 0.0)
    aside = max(half_width_m - _BEYOND_EDGE_M, 0.0)
    wide_x0, wide_x1 = aside * abs(uy0), aside * abs(uy1)
    wide_y0, wide_y1 = aside * abs(ux0), aside * abs(ux1)
    west, east = min(x0 - wide_x0, x1 - wide_x1), max(x0 + wide_x0, x1 + wide_x1)
    south, north = min(y0 - wide_y0, y1 - wide_y1), max(y0 + wide_y0, y1 + wide_y1)
    if pieces[row, _ANGLE] > 0.0:
        # An arc turns by less than half a circle: it is furthest out where its heading is an axis.
        radius = pieces[row, _RUN] / pieces[row, _ANGLE]
        left = pieces[row, _SIDE] * radius
        if ux0 * ux1 < 0.0:
            x = x0 - left * uy0 + math.copysign(radius, ux0)
            west, east = min(west, x - aside), max(east, x + aside)
        if uy0 * uy1 < 0.0:
            y = y0 + left * ux0 + math.copysign(radius, uy0)
            south, north = min(south, y - aside), max(north, y + aside)
    far_x, far_y = (c.columns - 1) * c.dx_m, (c.rows - 1) * c.dy_m
    return min(min(west, far_x - east), min(south, far_y - north))
