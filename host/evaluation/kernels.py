"""The fitness of paths, compiled: the definition as small scalar functions.

The functions take numbers, tuples, plain arrays and one
:class:`~host.evaluation.constants.Constants`, allocate nothing and know no Python object, so the
same source serves a CPU core and a CUDA thread. The arithmetic of points follows
:mod:`host.evaluation.geometry` operation by operation, so that both see the same samples. All in
one file, because the cache on disk notices a change in the file of the outermost function only.

Source: Roberge and Tarbouchi, sections 3.1 and 3.2, equations (1) to (3).
"""

import math

import numpy as np
from numpy.typing import NDArray

from host.evaluation.constants import COORDINATE_LIMIT_M, Constants, Flags, Floats, Point, Totals
from host.evaluation.jit import compiled


__all__ = ["BELOW_TWO", "WORST_FITNESS", "evaluate_share", "fitness_of", "path_terms",
           "penalty_cost"]

# The ends of the open interval of fitness values.
WORST_FITNESS = float(np.finfo(np.float64).tiny)
BELOW_TWO = float(np.nextafter(2.0, 0.0))

_COLLINEAR_RAD = 1e-12
_SLOPE_TOLERANCE_RAD = 1e-9
_ARC_PARTS_IN_WIND = 8
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
    column = math.floor(min(max(x / c.dx_m + 0.5, 0.0), c.columns - 1.0))
    row = math.floor(min(max(y / c.dy_m + 0.5, 0.0), c.rows - 1.0))
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


@compiled
def straight_general(
    ground: Floats, nofly: Flags, c: Constants, a: Point, b: Point, parts: int,
) -> tuple[int, int]:
    """As :func:`straight_under_nofly` for any end points and any reading of the ground."""
    (x, y, z), ex, ey, ez = a, b[0] - a[0], b[1] - a[1], b[2] - a[2]
    under = 0
    inside = 0
    for part in range(parts):
        t = (part + 0.5) / parts
        hit, zone = sample(ground, nofly, c, x + ex * t, y + ey * t, z + ez * t)
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


@compiled
def count_arc(
    ground: Floats, nofly: Flags, c: Constants, a: Point, ux: float, uy: float, side: float,
    angle: float, rise: float, parts: int,
) -> tuple[int, int]:
    """Parts of an arc under the terrain and in a no-fly zone.

    It is entered at ``a`` with the unit heading ux, uy; ``side`` is 1 to the left, else -1.
    """
    x, y, z = a
    under = 0
    inside = 0
    for part in range(parts):
        t = (part + 0.5) / parts
        half_sin = math.sin(0.5 * (angle * t))
        ahead = c.turn_radius_m * math.sin(angle * t)
        aside = side * c.turn_radius_m * 2.0 * half_sin * half_sin
        hit, zone = sample(ground, nofly, c, x + (ahead * ux - aside * uy),
                           y + (ahead * uy + aside * ux), z + rise * t)
        under += hit
        inside += zone
    return under, inside


@compiled
def turn(
    ax: float, ay: float, bx: float, by: float, run_a: float, run_b: float, radius_m: float,
) -> tuple[float, float, float]:
    """Unsigned turn angle, side (1 left, -1 right) and tangent length of a waypoint.

    The tangent is infinite at a reversal and beside a segment without horizontal length.
    """
    if run_a == 0.0 or run_b == 0.0:
        return 0.0, 1.0, math.inf
    cross = ax * by - ay * bx
    angle = math.atan2(abs(cross), ax * bx + ay * by)
    if angle <= _COLLINEAR_RAD:
        return 0.0, 1.0, 0.0
    side = 1.0 if cross >= 0.0 else -1.0
    if cross == 0.0:
        return math.pi, side, math.inf
    return angle, side, radius_m * math.tan(0.5 * angle)


@compiled
def air_density(altitude_m: float) -> float:
    """Density of the International Standard Atmosphere, kg/m^3."""
    density = 1.225 * math.pow(1.0 - 0.0065 * min(altitude_m, 11000.0) / 288.15, 4.255876)
    if altitude_m > 11000.0:
        density *= math.exp(-(altitude_m - 11000.0) / 6341.62)
    return density


@compiled
def air_time(c: Constants, horizontal_m_s: float, ux: float, uy: float, run: float) -> float:
    """Seconds to fly ``run`` metres over the ground towards (ux, uy); negative if impossible."""
    cross = c.wind_x_m_s * uy - c.wind_y_m_s * ux
    square = horizontal_m_s * horizontal_m_s - cross * cross
    if not square > 0.0:
        return -1.0
    ground_speed = c.wind_x_m_s * ux + c.wind_y_m_s * uy + math.sqrt(square)
    if not ground_speed > 0.0:
        return -1.0
    return run / ground_speed


@compiled
def air_distance(
    c: Constants, length: float, run: float, ux: float, uy: float, side: float, angle: float,
) -> float:
    """Distance through the air along a piece of turn ``angle``, 0 if straight; negative if none."""
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
        time = air_time(c, horizontal, ux * cos - uy * sin, ux * sin + uy * cos,
                        run / _ARC_PARTS_IN_WIND)
        if time < 0.0:
            return -1.0
        total += time
    return c.airspeed_m_s * total


@compiled
def burn(
    c: Constants, weight: float, run: float, rise: float, length: float, distance: float,
    altitude: float,
) -> float:
    """Fuel of one piece in newtons: the closed solution of the Riccati equation."""
    cos = run / length
    b = rise / length
    density = air_density(altitude) if c.isa else 1.225
    pressure_area = 0.5 * density * (c.airspeed_m_s * c.airspeed_m_s) * c.wing_area_m2
    a = c.induced_drag_factor * (cos * cos) / pressure_area
    e = pressure_area * c.drag_coefficient
    thrust = a * (weight * weight) + b * weight + e
    if thrust <= 0.0:
        return 0.0
    discriminant = 4.0 * a * e - b * b
    half = 0.5 * distance * c.burn_per_m
    root = math.sqrt(abs(discriminant))
    if discriminant > 0.0:
        tau = math.tan(half * root) / root
    elif discriminant < 0.0:
        tau = math.tanh(half * root) / root
    else:
        tau = half
    return 2.0 * thrust * tau / (1.0 + (2.0 * a * weight + b) * tau)


@compiled
def add_piece(
    c: Constants, total: Totals, weight: float, run: float, rise: float, length: float,
    za: float, zb: float, ux: float, uy: float, side: float, angle: float,
) -> Totals:
    """Add the closed forms of a piece to ``(length, altitude integral, fuel, too steep)``."""
    distance = air_distance(c, length, run, ux, uy, side, angle)
    steep = total[3]
    slope = math.atan2(rise, run)
    if (slope > c.max_climb_rad + _SLOPE_TOLERANCE_RAD
            or slope < -c.max_descent_rad - _SLOPE_TOLERANCE_RAD or distance < 0.0):
        steep += length
    if distance < 0.0:
        distance = length
    altitude = 0.5 * (za + zb)
    fuel = burn(c, weight, run, rise, length, distance, altitude)
    return total[0] + length, total[1] + altitude * length, total[2] + fuel, steep


@compiled
def path_terms(
    path: Floats, n: int, ground: Floats, nofly: Flags, c: Constants,
) -> tuple[float, float, float, float, float, float, int]:
    """Every term of one path.

    Parameters
    ----------
    path : (max_n, 3) float64, metres as x, y, z
        The first ``n`` rows count, n >= 2. Finite and within ``COORDINATE_LIMIT_M``.
    ground : (rows * columns,) float64, metres
        Flat raster, ``VOID_HEIGHT_M`` for a void.
    nofly : (rows * columns,) uint8
        Flat raster of 0 and 1; a single element will do when ``c.zones`` is 0.
    c : Constants

    Returns
    -------
    tuple
        Length, altitude integral (m^2), fuel (N), distance too steep, distance under the terrain,
        distance in no-fly zones (all m), and the number of impossible arcs.
    """
    total = (0.0, 0.0, 0.0, 0.0)
    under_m = 0.0
    nofly_m = 0.0
    impossible = 0

    # A window over the path: the segment flown now (a) and the next one (b), the tangents of the
    # waypoints before, at and after the end of the segment.
    xa, ya, za = path[0, 0], path[0, 1], path[0, 2]
    ax, ay, az = path[1, 0] - xa, path[1, 1] - ya, path[1, 2] - za
    run_a = math.hypot(ax, ay)
    before = 0.0                        # Tangent the waypoint at the start of the segment wants,
    cut_start = 0.0                     # and what it takes: 0 when its arc is impossible.
    bx, by, bz, run_b = 0.0, 0.0, 0.0, 0.0
    angle, side, here = 0.0, 1.0, 0.0
    if n > 2:
        bx, by, bz = path[2, 0] - path[1, 0], path[2, 1] - path[1, 1], path[2, 2] - path[1, 2]
        run_b = math.hypot(bx, by)
        angle, side, here = turn(ax, ay, bx, by, run_a, run_b, c.turn_radius_m)

    for i in range(n - 1):
        cx, cy, cz, run_c = 0.0, 0.0, 0.0, 0.0
        next_angle, next_side, after = 0.0, 1.0, 0.0
        if i + 3 < n:
            cx = path[i + 3, 0] - path[i + 2, 0]
            cy = path[i + 3, 1] - path[i + 2, 1]
            cz = path[i + 3, 2] - path[i + 2, 2]
            run_c = math.hypot(cx, cy)
            next_angle, next_side, after = turn(bx, by, cx, cy, run_b, run_c, c.turn_radius_m)
        cut_stop = here
        if here > 0.0 and not (before + here <= run_a and here + after <= run_b):
            cut_stop = 0.0
            impossible += 1

        # The straight part of the segment.
        xb, yb, zb = path[i + 1, 0], path[i + 1, 1], path[i + 1, 2]
        ux, uy, climb = 0.0, 0.0, 0.0
        run, rise = 0.0, az
        if run_a > 0.0:
            ux, uy, climb = ax / run_a, ay / run_a, az / run_a
            run = max(run_a - cut_start - cut_stop, 0.0)
            rise = climb * run
            xa, ya, za = xa + ux * cut_start, ya + uy * cut_start, za + climb * cut_start
            xb, yb, zb = xb - ux * cut_stop, yb - uy * cut_stop, zb - climb * cut_stop
        length = math.hypot(run, rise)
        if length > 0.0:
            total = add_piece(c, total, c.weight - total[2], run, rise, length, za, zb,
                              ux, uy, 1.0, 0.0)
            if c.sampled:
                parts = math.ceil(length / c.ds_m)
                hit, zone = count_straight(ground, nofly, c, (xa, ya, za), (xb, yb, zb), parts)
                under_m += hit * (length / parts)
                nofly_m += zone * (length / parts)

        # The arc at its end.
        if cut_stop > 0.0:
            run = c.turn_radius_m * angle
            rise = cut_stop * (climb + bz / run_b)
            length = math.hypot(run, rise)
            total = add_piece(c, total, c.weight - total[2], run, rise, length, zb, zb + rise,
                              ux, uy, side, angle)
            if c.sampled:
                parts = math.ceil(length / c.ds_m)
                hit, zone = count_arc(ground, nofly, c, (xb, yb, zb), ux, uy, side, angle, rise,
                                      parts)
                under_m += hit * (length / parts)
                nofly_m += zone * (length / parts)

        xa, ya, za = path[i + 1, 0], path[i + 1, 1], path[i + 1, 2]
        ax, ay, az, run_a = bx, by, bz, run_b
        bx, by, bz, run_b = cx, cy, cz, run_c
        before, cut_start = here, cut_stop
        angle, side, here = next_angle, next_side, after
    return total[0], total[1], total[2], total[3], under_m, nofly_m, impossible


@compiled
def fitness_of(penalty: float, cost: float) -> float:
    """Equation (3), kept finite and inside (0, 2); what is no number is the worst."""
    if not penalty >= 0.0 or math.isnan(cost):
        return WORST_FITNESS
    if penalty > 0.0:
        return max(1.0 / (1.0 + penalty), WORST_FITNESS)
    if cost <= 0.0:
        return BELOW_TWO
    return min(1.0 + 1.0 / (1.0 + cost), BELOW_TWO)


@compiled
def penalty_cost(
    path: Floats, n: int, ground: Floats, nofly: Flags, c: Constants, counted_m: float,
) -> tuple[float, float]:
    """Penalty, equation (1), and cost, equation (2); infinite for what is no path.

    ``counted_m`` is added to d_ut + d_nf: what was counted elsewhere where nothing is sampled here.
    """
    for i in range(n):
        for axis in range(3):
            if not abs(path[i, axis]) <= COORDINATE_LIMIT_M:
                return math.inf, math.inf
    length, altitude, fuel, steep, under, zone, impossible = path_terms(path, n, ground, nofly, c)
    if not length > 0.0:
        return math.inf, math.inf
    penalty = under + zone + counted_m + steep
    if n > 2:
        penalty += impossible / (n - 2) * length
    cost = 0.5 * altitude / c.utopia_area_m2 + 0.5 * fuel / c.utopia_fuel
    return penalty, cost


@compiled
def evaluate_share(
    paths: Floats, lengths: NDArray[np.int64], first: int, stride: int, ground: Floats,
    nofly: Flags, c: Constants, counted_m: Floats, penalty: Floats, cost: Floats, fitness: Floats,
) -> None:
    """Evaluate every ``stride``-th path from ``first`` on; holds no lock, so shares run at once.

    ``paths`` is (m, max_n, 3), ``counted_m`` (m,) as for :func:`penalty_cost`; results go to
    ``penalty``, ``cost`` and ``fitness``, (m,) each.
    """
    for i in range(first, paths.shape[0], stride):
        penalty[i], cost[i] = penalty_cost(paths[i], lengths[i], ground, nofly, c, counted_m[i])
        fitness[i] = fitness_of(penalty[i], cost[i])
