"""Random zones and paths, and the pieces of a path in the form of the kernels."""

import numpy as np
import shapely

from pathgene.host.evaluation.constants import Constants
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.evaluation.kernels import scratch
from pathgene.host.evaluation.laying import AIR, LENGTH, lay_segment, lay_turn
from pathgene.host.problem.zones import Circle, Polygon
from tests.support.host.zone_oracle import distances, outline


CEILING_M = 300.0
CRUISE_M_S = 20.0


def random_limits(rng):
    """Return heights within ``CEILING_M`` for half of the zones, times for a third."""
    limits = {}
    low, high = sorted(rng.uniform(0, CEILING_M, 2).tolist())
    for name, value in (("lower_m", low), ("upper_m", high)):
        if rng.random() < 0.3:
            limits[name] = value
    start, stop = sorted(rng.uniform(0, 60, 2).tolist())
    for name, value in (("t0_s", start), ("t1_s", stop)):
        if rng.random() < 0.15:
            limits[name] = value
    return limits


def star(rng, x, y, radius, corners):
    """Return a ring that is star-shaped around (x, y), so it does not cross itself."""
    angles = 2 * np.pi * (np.arange(corners) + rng.uniform(0.05, 0.95, corners)) / corners
    radii = radius * rng.uniform(0.3, 1, corners)
    return list(
        zip(
            (x + radii * np.cos(angles)).tolist(),
            (y + radii * np.sin(angles)).tolist(),
            strict=True,
        )
    )


def scaled(ring, x, y, factor):
    return [(x + factor * (px - x), y + factor * (py - y)) for px, py in ring]


def wall(rng, width_m, height_m):
    """Return a thin ring across the map, from 1 mm to 80 m wide."""
    (xa, xb), (ya, yb) = rng.uniform(0, width_m, 2), rng.uniform(0, height_m, 2)
    kind = rng.integers(4)
    if kind == 0:
        xb = xa
    elif kind == 1:
        yb = ya
    length = max(np.hypot(xb - xa, yb - ya), 1.0)
    thick = 10 ** rng.uniform(-3, 1.9) / length
    ex, ey = thick * (ya - yb), thick * (xb - xa)
    return [(xa, ya), (xb, yb), (xb + ex, yb + ey + thick), (xa + ex, ya + ey + thick)]


def random_zones(rng, width_m, height_m, most=4):
    """Return 1 to ``most`` zones on a map: circles, polygons with and without holes, thin walls."""
    zones = []
    for _ in range(rng.integers(1, most + 1)):
        x, y = rng.uniform(0, width_m), rng.uniform(0, height_m)
        radius = 10 ** rng.uniform(0, np.log10(0.4 * min(width_m, height_m)))
        limits = random_limits(rng)
        kind = rng.integers(5)
        if kind == 0:
            zones.append(Circle(x, y, radius, **limits))
        elif kind == 1:
            ring = wall(rng, width_m, height_m)
            if shapely.Polygon(ring).is_valid:
                zones.append(Polygon(ring, **limits))
        else:
            ring = star(rng, x, y, radius, rng.integers(3, 12))
            holes = [scaled(ring, x, y, rng.uniform(0.2, 0.9))] if kind == 2 else []
            # Whole metres make corners, edges and places of a path collinear.
            whole = [(float(round(px)), float(round(py))) for px, py in ring]
            if rng.random() < 0.3 and shapely.Polygon(whole, holes).is_valid:
                ring = whole
            zones.append(Polygon(ring, tuple(holes), **limits))
    return tuple(zones) or random_zones(rng, width_m, height_m, most)


def random_path(rng, width_m, height_m, zones=(), points=None):
    """Return a path, (n, 3) float64 metres, of 2 to 6 points; some of them on corners of zones."""
    count = points or rng.integers(2, 7)
    path = rng.uniform((0, 0, 0), (width_m, height_m, CEILING_M), (count, 3))
    if rng.random() < 0.3:
        path = np.round(path)
    corners = [corner for zone in zones if isinstance(zone, Polygon) for corner in zone.ring]
    if corners and rng.random() < 0.2:
        for i in rng.integers(count, size=2):
            path[i, :2] = corners[rng.integers(len(corners))]
    if rng.random() < 0.2:
        path[:, 2] = path[0, 2]
    if rng.random() < 0.05 or len(np.unique(path, axis=0)) == 1:
        path[1] = path[0] + np.array((0, 0, 40))
    return path


def near_a_limit(rng, path, zone, margin_m, radius_m):
    """Return ``path`` moved so that its track passes a limit of a widened zone within a metre.

    The limit is its border or, by chance and if it has one, a height limit.
    """
    points = np.concatenate(
        [
            piece.points(np.linspace(0, 1, int(piece.length_m / 2) + 2))
            for piece in track_of(path, radius_m)
        ]
    )
    gaps = distances(zone, points[:, 0], points[:, 1])
    aim = rng.uniform(-1, 1)
    limits = [
        (limit + sign * margin_m, sign)
        for limit, sign in ((zone.lower_m, -1), (zone.upper_m, 1))
        if limit is not None
    ]
    near = gaps <= margin_m
    if limits and near.any() and rng.random() < 0.7:
        limit, sign = limits[rng.integers(len(limits))]
        closest = (sign * points[near, 2]).min()
        return path + np.array((0, 0, sign * (sign * limit + aim - closest)))
    nearest = int(gaps.argmin())
    shape = shapely.Point(zone.x_m, zone.y_m) if isinstance(zone, Circle) else outline(zone)
    line = shapely.shortest_line(shapely.Point(points[nearest, :2]), shape)
    (xa, ya), (xb, yb) = shapely.get_coordinates(line)
    far = np.hypot(xb - xa, yb - ya)
    if gaps[nearest] == 0 or far == 0:
        return path
    move = (gaps[nearest] - margin_m - aim) / far
    return path + move * np.array((xb - xa, yb - ya, 0))


def piece_rows(path, radius_m):
    """Return the pieces of a path as rows of the kernels, and their number.

    The smoothed track of :func:`pathgene.host.evaluation.geometry.smooth` has the pieces with a
    length above 0.
    """
    constants = Constants(*(0,) * len(Constants._fields))._replace(turn_radius_m=radius_m)
    n = len(path)
    turns, pieces = scratch(n)
    for i in range(n):
        lay_turn(path, n, i, constants, turns)
    for i in range(n - 1):
        lay_segment(path, n, i, constants, turns, pieces)
    # Without wind.
    pieces[:, AIR] = pieces[:, LENGTH]
    return pieces, 2 * n - 1


def piece_times(pieces, rows, speed_m_s=CRUISE_M_S):
    """Return the seconds at the start of each row and at the end of the last, at one speed."""
    lengths = np.where(pieces[:rows, LENGTH] > 0, pieces[:rows, LENGTH], 0.0)
    return np.concatenate(([0.0], np.cumsum(lengths / speed_m_s)))


def track_of(path, radius_m):
    """Return the pieces of the smoothed path, by the definition."""
    return smooth(path, radius_m).pieces
