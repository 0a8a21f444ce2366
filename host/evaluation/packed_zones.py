"""Zones with their margin, compiled: their borders, their inside, their heights and times.

Pieces, rows, fractions and marks as in :mod:`pathgene.host.evaluation.crossings`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.constants import Floats
from pathgene.host.evaluation.crossings import Box, Line, box_of, cross_circle, cross_line
from pathgene.host.evaluation.jit import compiled, inlined
from pathgene.host.evaluation.laying import AIR, ANGLE, LENGTH, RISE, RUN, SIDE, UX, UY, Z
from pathgene.host.evaluation.pieces import ARC_PARTS_IN_WIND, time_in_wind
from pathgene.host.problem.rings import EDGE_M, edges
from pathgene.host.problem.zones import Zone


__all__ = [
    "EDGE_BOX",
    "EDGE_LENGTH",
    "EX",
    "EY",
    "HIGH",
    "LOW",
    "RADIUS",
    "REACH",
    "T0",
    "T1",
    "XA",
    "XB",
    "YA",
    "YB",
    "ZONE_BOX",
    "ZONE_X",
    "ZONE_Y",
    "PackedZones",
    "apart",
    "applies",
    "crosses_ray",
    "edge_distance_square",
    "gap_square",
    "holds",
    "mark_border",
    "pack_zones",
]


# Fields of a zone. The circle's radius is its own, the reach that with the margin; the box (west,
# south, east, north) and the heights are with the margin.
ZONE_X, ZONE_Y, RADIUS, REACH, LOW, HIGH, T0, T1 = range(8)
ZONE_BOX = 8
_ZONE_FIELDS = 12
# Fields of an edge: its ends, its unit direction, its length, and its box with the margin.
XA, YA, XB, YB, EX, EY, EDGE_LENGTH = range(7)
EDGE_BOX = 7
_EDGE_FIELDS = 11

# Seconds by which the time of a part of an arc in wind may differ from the exact time.
_PART_TIME_S = 0.1

# Maximum crossings of a piece with an edge: two with each parallel, two with its start's circle.
_MARKS_PER_EDGE = 6


class PackedZones(NamedTuple):
    """Zones as flat arrays, for the kernels; see :func:`pack_zones`.

    Parameters
    ----------
    zones : (n, 12) float64
        A row per zone.
    edges : (m, 11) float64
        Edges of all polygons, zone by zone.
    bounds : (n, 2) int64
        First edge of a zone, and the one after its last; equal for a circle.
    reach_m : float
        The margin and a micrometre.
    marks : int
        Length of the scratch array that :func:`zone_metres_with` needs.
    wind_x_m_s, wind_y_m_s : float
        Wind that the times of the pieces are laid in.
    """

    zones: Floats
    edges: Floats
    bounds: NDArray[np.int64]
    reach_m: float
    marks: int
    wind_x_m_s: float
    wind_y_m_s: float


def pack_zones(
    zones: Sequence[Zone], margin_m: float, wind: tuple[float, float] = (0.0, 0.0)
) -> PackedZones:
    """Return ``zones``, widened by ``margin_m`` (0 or more), for the kernels of this module."""
    reach = margin_m + EDGE_M
    rows: list[tuple[float, ...]] = []
    edge_rows: list[tuple[float, ...]] = []
    bounds: list[tuple[int, int]] = []
    for zone in zones:
        first = len(edge_rows)
        footprint = zone.footprint
        x, y, radius = footprint.disc or (0.0, 0.0, 0.0)
        far = radius + reach
        box = (x - far, y - far, x + far, y + far)
        for ring in footprint.rings:
            edge_rows += [_edge_row(*edge, reach) for edge in edges(ring)]
        if footprint.rings:
            west, south, east, north = footprint.box
            box = (west - reach, south - reach, east + reach, north + reach)
        low, high = _heights(zone, margin_m)
        t0 = -math.inf if zone.t0_s is None else zone.t0_s
        t1 = math.inf if zone.t1_s is None else zone.t1_s
        rows.append((x, y, radius, far, low, high, t0, t1, *box))
        bounds.append((first, len(edge_rows)))
    most = max((last - first for first, last in bounds), default=0)
    return PackedZones(
        np.array(rows, dtype=np.float64).reshape(-1, _ZONE_FIELDS),
        np.array(edge_rows, dtype=np.float64).reshape(-1, _EDGE_FIELDS),
        np.array(bounds, dtype=np.int64).reshape(-1, 2),
        reach,
        # The end of the piece; a distance to an edge takes 8.
        max(_MARKS_PER_EDGE * most + 1, 8),
        float(wind[0]),
        float(wind[1]),
    )


def _heights(zone: Zone, margin_m: float) -> tuple[float, float]:
    """Return the altitudes between which a zone with its margin applies; they are free."""
    low = -math.inf if zone.lower_m is None else zone.lower_m - margin_m
    high = math.inf if zone.upper_m is None else zone.upper_m + margin_m
    if high - low > 4 * EDGE_M:
        return low + EDGE_M, high - EDGE_M
    return low, high


def _edge_row(xa: float, ya: float, xb: float, yb: float, reach: float) -> tuple[float, ...]:
    length = math.hypot(xb - xa, yb - ya)
    ex, ey = ((xb - xa) / length, (yb - ya) / length) if length > 0 else (0.0, 0.0)
    box = min(xa, xb) - reach, min(ya, yb) - reach, max(xa, xb) + reach, max(ya, yb) + reach
    return (xa, ya, xb, yb, ex, ey, length, *box)


# Parallels of an edge are crossed this far beyond its ends, for rounding.
_BEYOND_M = 1.0


@inlined
def apart(
    west: float, south: float, east: float, north: float, table: Floats, i: int, at: int
) -> bool:
    """Return whether a rectangle and the box of a table's row have no point in common."""
    return bool(
        (east < table[i, at])
        | (north < table[i, at + 1])
        | (west > table[i, at + 2])
        | (south > table[i, at + 3])
    )


@inlined
def gap_square(box: Box, table: Floats, i: int, at: int, reach: float) -> float:
    """Return the square distance of a rectangle from the box of a table's row without margin."""
    west, south, east, north = box
    dx = max(table[i, at] + reach - east, west - table[i, at + 2] + reach, 0.0)
    dy = max(table[i, at + 1] + reach - north, south - table[i, at + 3] + reach, 0.0)
    square: float = dx * dx + dy * dy
    return square


@inlined
def _clip(
    start: float, change: float, least: float, most: float, low: float, high: float
) -> tuple[float, float]:
    """Return the part of ``low`` to ``high`` where a linear value is between two limits."""
    if change == 0.0:
        return (low, high) if least < start and start < most else (1.0, 0.0)
    a, b = (least - start) / change, (most - start) / change
    return max(low, min(a, b)), min(high, max(a, b))


@inlined
def applies(
    pieces: Floats, row: int, times: Floats, packed: PackedZones, zone: int
) -> tuple[float, float]:
    """Return the part of a piece within a zone's heights and times; none if not first < last."""
    low, high = 0.0, 1.0
    zones = packed.zones
    if zones[zone, LOW] > -math.inf or zones[zone, HIGH] < math.inf:
        low, high = _clip(
            pieces[row, Z], pieces[row, RISE], zones[zone, LOW], zones[zone, HIGH], low, high
        )
    if zones[zone, T0] > -math.inf or zones[zone, T1] < math.inf:
        start, seconds = times[row], times[row + 1] - times[row]
        # If the wind cannot be flown, the time is not known: the zone may be active.
        if math.isfinite(start) and math.isfinite(seconds):
            first, last = _clip(start, seconds, zones[zone, T0], zones[zone, T1], low, high)
            if pieces[row, ANGLE] > 0.0 and pieces[row, AIR] != pieces[row, LENGTH]:
                first, last = _parts_in_time(pieces, row, packed, zone, start, seconds)
                first, last = max(low, first), min(high, last)
            low, high = first, last
    return low, high


@inlined
def _parts_in_time(
    pieces: Floats, row: int, packed: PackedZones, zone: int, start: float, seconds: float
) -> tuple[float, float]:
    """Return the first and the last place of an arc in wind while a zone is active.

    The speed changes along the arc, so the parts that time it count whole. Without an air distance
    the arc itself counts whole.
    """
    if not pieces[row, AIR] > 0.0:
        is_active = start <= packed.zones[zone, T1] and start + seconds >= packed.zones[zone, T0]
        return (0.0, 1.0) if is_active else (1.0, 0.0)
    run, angle, side = pieces[row, RUN], pieces[row, ANGLE], pieces[row, SIDE]
    ux, uy = pieces[row, UX], pieces[row, UY]
    airspeed_m_s = pieces[row, AIR] / seconds
    horizontal_m_s = airspeed_m_s * run / pieces[row, LENGTH]
    first, last = 1.0, 0.0
    begin = start
    for part in range(ARC_PARTS_IN_WIND):
        turned = side * angle * (part + 0.5) / ARC_PARTS_IN_WIND
        cos, sin = math.cos(turned), math.sin(turned)
        time = time_in_wind(
            packed.wind_x_m_s,
            packed.wind_y_m_s,
            horizontal_m_s,
            ux * cos - uy * sin,
            ux * sin + uy * cos,
            run / ARC_PARTS_IN_WIND,
        )
        if time < 0.0:
            return 0.0, 1.0
        if (
            begin - _PART_TIME_S <= packed.zones[zone, T1]
            and begin + time + _PART_TIME_S >= packed.zones[zone, T0]
        ):
            first = min(first, part / ARC_PARTS_IN_WIND)
            last = (part + 1) / ARC_PARTS_IN_WIND
        begin += time
    return first, last


@inlined
def edge_distance_square(edge_table: Floats, i: int, x: float, y: float) -> float:
    """Return the square of the distance from a place to an edge."""
    px, py = x - edge_table[i, XA], y - edge_table[i, YA]
    ex, ey = edge_table[i, EX], edge_table[i, EY]
    along = min(max(px * ex + py * ey, 0.0), edge_table[i, EDGE_LENGTH])
    px, py = px - along * ex, py - along * ey
    square: float = px * px + py * py
    return square


@inlined
def crosses_ray(edge_table: Floats, i: int, x: float, y: float) -> bool:
    """Return whether an edge crosses the ray from a point to the east: even-odd rule."""
    ya, yb = edge_table[i, YA], edge_table[i, YB]
    if (ya <= y) == (yb <= y):
        return False
    xa = edge_table[i, XA]
    return bool(x < xa + (y - ya) * ((edge_table[i, XB] - xa) / (yb - ya)))


@compiled
def holds(packed: PackedZones, zone: int, x: float, y: float) -> bool:
    """Return whether a place is inside a zone with its margin."""
    first, last = packed.bounds[zone]
    if first == last:
        px, py = x - packed.zones[zone, ZONE_X], y - packed.zones[zone, ZONE_Y]
        return bool(math.sqrt(px * px + py * py) <= packed.zones[zone, REACH])
    edge_table = packed.edges
    square = packed.reach_m * packed.reach_m
    inside = False
    for i in range(first, last):
        if (
            not apart(x, y, x, y, edge_table, i, EDGE_BOX)
            and edge_distance_square(edge_table, i, x, y) <= square
        ):
            return True
        inside ^= crosses_ray(edge_table, i, x, y)
    return inside


@compiled
def mark_border(
    pieces: Floats, row: int, packed: PackedZones, zone: int, low: float, high: float, marks: Floats
) -> int:
    """Write the places where a piece may enter or leave a zone with its margin to ``marks``."""
    count = 0
    zones, edge_table, reach = packed.zones, packed.edges, packed.reach_m
    first, last = packed.bounds[zone]
    if first == last:
        circle = zones[zone, ZONE_X], zones[zone, ZONE_Y], zones[zone, REACH]
        return cross_circle(pieces, row, circle, low, high, marks, count)
    west, south, east, north = box_of(pieces, row)
    for i in range(first, last):
        # Edges form rings: the circle at an edge's end is also at the next one's start.
        if apart(west, south, east, north, edge_table, i, EDGE_BOX):
            continue
        x, y = edge_table[i, XA], edge_table[i, YA]
        count = cross_circle(pieces, row, (x, y, reach), low, high, marks, count)
        length = edge_table[i, EDGE_LENGTH]
        if length > 0.0:
            ex, ey = edge_table[i, EX], edge_table[i, EY]
            for side in (-reach, reach):
                line = Line(x, y, ex, ey, side, -_BEYOND_M, length + _BEYOND_M)
                count = cross_line(pieces, row, line, low, high, marks, count)
    return count
