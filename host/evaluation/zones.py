"""The strict rule on no-fly zones, compiled: exact on the lines and arcs of a track.

A zone is widened by a margin on every side: outwards to all places within the margin of it, its
limits of height upwards and downwards. Its times stay. Nothing is sampled. For every piece and
zone, the part of the piece within the zone's heights and times is cut at all places where it
crosses the border of the widened zone; each interval between is inside or outside as a whole, and
its mid-point tells which. A cut too many is harmless. A cut is missing only where the piece
touches the border without entering by more than some nanometres, so the border is set a micrometre
further out: a track that enters the widened zone itself is never free by rounding.

Heights have their micrometre in the opposite direction: a track that keeps exactly the margin above
or below a zone is free, as one that keeps exactly its clearance is.

Polygons hold by the even-odd rule, their holes included, and so do their edges.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pathgene.host.evaluation.constants import Floats
from pathgene.host.evaluation.crossings import (
    Line,
    box_of,
    cross_line,
    mark_parallel,
    mark_towards,
    place,
    sort_marks,
)
from pathgene.host.evaluation.jit import allocating, compiled, inlined
from pathgene.host.evaluation.laying import LENGTH
from pathgene.host.evaluation.packed_zones import (
    EDGE_BOX,
    EDGE_LENGTH,
    EX,
    EY,
    RADIUS,
    XA,
    XB,
    YA,
    YB,
    ZONE_BOX,
    ZONE_X,
    ZONE_Y,
    PackedZones,
    apart,
    applies,
    crosses_ray,
    edge_distance_square,
    gap_square,
    holds,
    mark_border,
    pack_zones,
)
from pathgene.host.problem.rings import EDGE_M


__all__ = [
    "Intrusion",
    "PackedZones",
    "Spot",
    "pack_zones",
    "zone_intrusions",
    "zone_metres",
    "zone_metres_with",
]

# Fields of an intrusion.
_METRES, _ROW, _T, _DISTANCE, _NEAREST_ROW, _NEAREST_T = range(6)


class Intrusion(NamedTuple):
    """Metres of a track inside one zone, and its minimum distance from the zone.

    Parameters
    ----------
    metres : float
        Length of the track, in three dimensions, inside the zone with its margin; 0 if it is free.
    entry : Spot or None
        Where the track first enters; None if it never does.
    distance_m : float
        Minimum horizontal distance from the track to the zone without its margin, where the zone
        applies: within its heights (with the margin) and its times. 0 inside, infinite if the zone
        applies nowhere.
    nearest : Spot or None
        The place of that distance; None if the zone applies nowhere.
    """

    metres: float
    entry: Spot | None
    distance_m: float
    nearest: Spot | None


class Spot(NamedTuple):
    """A place on a track: the row of its piece, the fraction of the piece, and metres flown."""

    row: int
    t: float
    at_m: float


@compiled
def _inside(
    pieces: Floats, row: int, times: Floats, packed: PackedZones, zone: int, marks: Floats
) -> tuple[float, float]:
    """Return the fraction of a piece inside a zone, and where that begins."""
    low, high = applies(pieces, row, times, packed, zone)
    if not low < high:
        return 0.0, 0.0
    count = mark_border(pieces, row, packed, zone, low, high, marks)
    sort_marks(marks, count)
    marks[count] = high
    share, entry = 0.0, high
    start = low
    for i in range(count + 1):
        stop = marks[i]
        if stop > start:
            x, y = place(pieces, row, 0.5 * (start + stop))
            if holds(packed, zone, x, y):
                share += stop - start
                entry = min(entry, start)
            start = stop
    return share, entry


@compiled
def zone_metres_with(
    pieces: Floats, rows: int, times: Floats, packed: PackedZones, marks: Floats
) -> float:
    """Return the metres of a track inside zones; see :func:`zone_metres`.

    ``marks`` is scratch, (``packed.marks``,) float64: so a kernel that must not allocate can call.
    """
    total = 0.0
    for row in range(rows):
        length = pieces[row, LENGTH]
        if length > 0.0:
            west, south, east, north = box_of(pieces, row)
            for zone in range(packed.zones.shape[0]):
                if not apart(west, south, east, north, packed.zones, zone, ZONE_BOX):
                    share, _ = _inside(pieces, row, times, packed, zone, marks)
                    total += share * length
    return total


@allocating
def zone_metres(pieces: Floats, rows: int, times: Floats, packed: PackedZones) -> float:
    """Return the metres of a track inside zones with their margin; 0 if it is free.

    Every zone counts on its own: metres inside two count twice.

    Parameters
    ----------
    pieces : (at least rows, PIECE_FIELDS) float64
        Pieces of the track, as :func:`pathgene.host.evaluation.kernels.path_terms` leaves them;
        rows of length 0 are not pieces.
    rows : int
        Number of rows that count: 2 n - 1 for n waypoints.
    times : (at least rows + 1,) float64
        Seconds from the start of the path to the start of each piece, and to the end of the last;
        the time is linear within a piece, except on arcs in wind. Used only by zones with times;
        where it is not finite they count as active.
    packed : PackedZones
        The zones, by :func:`pack_zones`.
    """
    return zone_metres_with(pieces, rows, times, packed, np.empty(packed.marks))


@inlined
def _piece_distance_square(
    pieces: Floats, row: int, packed: PackedZones, zone: int, t: float
) -> float:
    """Return the square of the distance from a place of a piece to a circle, 0 inside."""
    x, y = place(pieces, row, t)
    px, py = x - packed.zones[zone, ZONE_X], y - packed.zones[zone, ZONE_Y]
    distance: float = max(math.sqrt(px * px + py * py) - packed.zones[zone, RADIUS], 0.0)
    return distance * distance


@compiled
def _nearest(
    pieces: Floats,
    row: int,
    packed: PackedZones,
    zone: int,
    low: float,
    high: float,
    best: float,
    marks: Floats,
) -> tuple[float, float]:
    """Return the least square distance from a piece to a zone without its margin, and its place.

    Both are of the part from ``low`` to ``high``, if that is nearer than ``best``; otherwise they
    are ``best`` and -1.
    """
    where = -1.0
    first, last = packed.bounds[zone]
    if first == last:
        marks[0], marks[1] = low, high
        x, y = packed.zones[zone, ZONE_X], packed.zones[zone, ZONE_Y]
        for i in range(mark_towards(pieces, row, x, y, low, high, marks, 2)):
            square = _piece_distance_square(pieces, row, packed, zone, marks[i])
            if square < best:
                best, where = square, marks[i]
        return best, where
    edge_table, reach = packed.edges, packed.reach_m
    box = box_of(pieces, row)
    if gap_square(box, packed.zones, zone, ZONE_BOX, reach) >= best:
        return best, where
    x, y = place(pieces, row, low)
    inside = False
    for i in range(first, last):
        inside ^= crosses_ray(edge_table, i, x, y)
    if inside:
        return 0.0, low
    for i in range(first, last):
        if gap_square(box, edge_table, i, EDGE_BOX, reach) >= best:
            continue
        # A distance to an edge is least at an end of the piece, opposite a corner, where the piece
        # runs along the edge, or where they cross.
        xa, ya = edge_table[i, XA], edge_table[i, YA]
        ex, ey, length = edge_table[i, EX], edge_table[i, EY], edge_table[i, EDGE_LENGTH]
        marks[0], marks[1] = low, high
        count = mark_towards(pieces, row, xa, ya, low, high, marks, 2)
        count = mark_towards(
            pieces, row, edge_table[i, XB], edge_table[i, YB], low, high, marks, count
        )
        if length > 0.0:
            line = Line(xa, ya, ex, ey, 0.0, 0.0, length)
            count = cross_line(pieces, row, line, low, high, marks, count)
            count = mark_parallel(pieces, row, ex, ey, low, high, marks, count)
        for k in range(count):
            x, y = place(pieces, row, marks[k])
            square = edge_distance_square(edge_table, i, x, y)
            if square < best:
                best, where = square, marks[k]
    return best, where


@compiled
def _fill_intrusions(
    pieces: Floats, rows: int, times: Floats, packed: PackedZones, marks: Floats, found: Floats
) -> None:
    """Write the fields of every zone's intrusion to ``found``, the distance as its square."""
    for zone in range(packed.zones.shape[0]):
        metres, entry_row, entry = 0.0, -1, 0.0
        best, nearest_row, nearest = math.inf, -1, 0.0
        for row in range(rows):
            length = pieces[row, LENGTH]
            if not length > 0.0:
                continue
            low, high = applies(pieces, row, times, packed, zone)
            if not low < high:
                continue
            square, t = _nearest(pieces, row, packed, zone, low, high, best, marks)
            if t >= 0.0:
                best, nearest_row, nearest = square, row, t
            west, south, east, north = box_of(pieces, row)
            if apart(west, south, east, north, packed.zones, zone, ZONE_BOX):
                continue
            share, t = _inside(pieces, row, times, packed, zone, marks)
            if share > 0.0:
                metres += share * length
                if entry_row < 0:
                    entry_row, entry = row, t
        found[zone, _METRES], found[zone, _ROW], found[zone, _T] = metres, entry_row, entry
        found[zone, _DISTANCE] = best
        found[zone, _NEAREST_ROW], found[zone, _NEAREST_T] = nearest_row, nearest


def zone_intrusions(
    pieces: Floats, rows: int, times: Floats, packed: PackedZones
) -> tuple[Intrusion, ...]:
    """Return metres and distances of a track in each zone, in the order of the zones.

    Arguments as for :func:`zone_metres`, the sum of whose terms per zone the ``metres``
    are.
    """
    found = np.empty((len(packed.zones), 6))
    _fill_intrusions(pieces, rows, times, packed, np.empty(packed.marks), found)
    lengths = np.maximum(pieces[:rows, LENGTH], 0.0)
    before = np.cumsum(lengths) - lengths

    def spot(row: float, t: float) -> Spot | None:
        i = int(row)
        return None if i < 0 else Spot(i, t, float(before[i] + t * lengths[i]))

    return tuple(
        Intrusion(
            metres,
            spot(row, t),
            # A crossing lies on its edge up to rounding.
            math.sqrt(square) if square > EDGE_M * EDGE_M else 0.0,
            spot(nearest_row, nearest_t),
        )
        for metres, row, t, square, nearest_row, nearest_t in found.tolist()
    )
