"""No-fly zones as flat arrays, for the kernels of :mod:`pathgene.host.evaluation.zones`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.constants import Floats
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
    """

    zones: Floats
    edges: Floats
    bounds: NDArray[np.int64]
    reach_m: float
    marks: int


def pack_zones(zones: Sequence[Zone], margin_m: float) -> PackedZones:
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
