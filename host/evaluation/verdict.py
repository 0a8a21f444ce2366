"""The strict verdict on a path, compiled: every rule of safe flight on the exact smoothed track."""

import math

import numpy as np
from numpy.typing import NDArray

from host.evaluation import laying as fields
from host.evaluation.constants import COORDINATE_LIMIT_M, Constants, Floats
from host.evaluation.jit import compiled
from host.evaluation.kernels import corners_m, cost_of, path_terms
from host.evaluation.laying import lay_segment, lay_turn
from host.evaluation.packed_zones import PackedZones
from host.evaluation.pieces import burn, fastest_over_ground, judge_slope, thrust_of
from host.evaluation.strict import STACK_SHAPE, Required, excess_m, extreme
from host.evaluation.zones import zone_metres_with


__all__ = [
    "FIGURES",
    "FLOWN",
    "FUEL",
    "STACK_SHAPE",
    "THRUST",
    "VERTICAL_SPEED",
    "add_zone_metres",
    "extreme_of_track",
    "first_kept",
    "piece_figures",
    "scratch",
    "strict_penalty",
    "strict_terms",
]

_LENGTH, _AIR, _RUN, _RISE = fields.LENGTH, fields.AIR, fields.RUN, fields.RISE

#: Figures of a piece: metres flown before it, vertical speed (m/s), thrust (N), fuel (N).
FLOWN, VERTICAL_SPEED, THRUST, FUEL = range(4)
FIGURES = 4


@compiled
def strict_terms(
    path: Floats,
    n: int,
    ground: Floats,
    c: Constants,
    low: Required,
    below: Required,
    high: Required,
    zones: PackedZones,
    turns: Floats,
    pieces: Floats,
    times: Floats,
    stack: Floats,
    marks: Floats,
) -> tuple[float, float, float, float, float, float, int, float]:
    """Return every term of one path by the strict rule, as ``path_terms`` does.

    The distance under the terrain is that of the parts with a point too low, or off the map, and
    of the parts with a point above the ceiling over ground. The distance in no-fly zones is exact.

    Parameters
    ----------
    path, n, c, turns, pieces
        As for :func:`host.evaluation.kernels.path_terms`; nothing is sampled.
    ground : (rows * columns,) float64, metres
        Flat raster of the terrain itself, very high at voids.
    low, below, high : Required
        Least height over the corridor and right below the track, and greatest height; an infinite
        greatest height is not looked at.
    zones : PackedZones
        All zones, widened by their margin.
    times : (2 n,) float64
        Scratch; holds the second at which each piece begins, and the end of the last.
    stack, marks
        Scratch of the terrain's and the zones' search.
    """
    rows = 2 * n - 1
    terms = path_terms(path, n, ground, ground, c, turns, pieces)
    length, area, fuel, steep, _, _, impossible, beyond = terms
    lay_times(c, pieces, rows, times)
    under = excess_m(ground, c, low, below, pieces, rows, stack)
    if high.height_m < math.inf:
        under += excess_m(ground, c, high, high, pieces, rows, stack)
    zone = zone_metres_with(pieces, rows, times, zones, marks)
    return length, area, fuel, steep, under, zone, impossible, beyond


@compiled
def lay_times(c: Constants, pieces: Floats, rows: int, times: Floats) -> None:
    """Write the second at which each piece begins, and the end of the last one."""
    second = 0.0
    for row in range(rows):
        times[row] = second
        if pieces[row, _LENGTH] > 0.0:
            second += pieces[row, _AIR] / c.airspeed_m_s
    times[rows] = second


@compiled
def extreme_of_track(
    ground: Floats,
    c: Constants,
    required: Required,
    pieces: Floats,
    rows: int,
    known: float,
    step: float,
    stack: Floats,
) -> tuple[float, int, float]:
    """Return the greatest excess of a track to within ``step``, its piece, and the share of that.

    Where no excess is greater than ``known``, that is returned, and piece and share mean nothing.
    The other parameters are those of :func:`host.evaluation.strict.extreme`.
    """
    best = known
    worst_row = 0
    place = 0.0
    # First the middle of every part: a good incumbent prunes most of the search.
    for search in range(2):
        for row in range(rows):
            run = pieces[row, _RUN]
            if not pieces[row, _LENGTH] > 0.0:
                continue
            parts = np.int64(math.ceil(run / c.ds_m)) if run > 0.0 else 1
            for part in range(parts):
                first, last = run * part / parts, run * (part + 1) / parts
                if search == 0:
                    first = last = 0.5 * (first + last)
                found, along = extreme(
                    ground, c, required, pieces, row, first, last, best, step, False, stack
                )
                if found > best:
                    best, worst_row, place = found, row, along / run if run > 0.0 else 0.0
    return best, worst_row, place


@compiled
def strict_penalty(
    path: Floats,
    n: int,
    ground: Floats,
    c: Constants,
    low: Required,
    below: Required,
    high: Required,
    zones: PackedZones,
    turns: Floats,
    pieces: Floats,
    times: Floats,
    stack: Floats,
    marks: Floats,
) -> tuple[float, float]:
    """Return penalty and cost by the strict rule; both infinite for a bad path."""
    for i in range(n):
        for axis in range(3):
            if not abs(path[i, axis]) <= COORDINATE_LIMIT_M:
                return math.inf, math.inf
    length, area, fuel, steep, under, zone, _, beyond = strict_terms(
        path, n, ground, c, low, below, high, zones, turns, pieces, times, stack, marks
    )
    if not length > 0.0:
        return math.inf, math.inf
    penalty = under + zone + steep + corners_m(c, turns, n, length) + beyond
    return penalty, cost_of(c, area, fuel)


@compiled
def first_kept(
    paths: Floats,
    lengths: NDArray[np.int64],
    ground: Floats,
    c: Constants,
    low: Required,
    below: Required,
    high: Required,
    zones: PackedZones,
    turns: Floats,
    pieces: Floats,
    times: Floats,
    stack: Floats,
    marks: Floats,
) -> int:
    """Return the index of the first path without a penalty by the strict rule; -1 if there is none.

    A path is left at the first limit that it breaks, and heights, which take longest, come last.
    Paths are (m, max_n, 3), of finite coordinates; see :func:`strict_terms`.
    """
    for i in range(paths.shape[0]):
        n = lengths[i]
        rows = 2 * n - 1
        terms = path_terms(paths[i], n, ground, ground, c, turns, pieces)
        length, _, _, steep, _, _, impossible, beyond = terms
        if not length > 0.0 or impossible > 0 or steep > 0.0 or beyond > 0.0:
            continue
        lay_times(c, pieces, rows, times)
        if zone_metres_with(pieces, rows, times, zones, marks) > 0.0:
            continue
        if excess_m(ground, c, low, below, pieces, rows, stack) > 0.0:
            continue
        is_capped = high.height_m < math.inf
        if is_capped and excess_m(ground, c, high, high, pieces, rows, stack) > 0.0:
            continue
        return i
    return -1


@compiled
def add_zone_metres(
    paths: Floats,
    lengths: NDArray[np.int64],
    c: Constants,
    zones: PackedZones,
    turns: Floats,
    pieces: Floats,
    times: Floats,
    marks: Floats,
    penalty: Floats,
) -> None:
    """Add the metres of each path in ``zones`` to ``penalty``, (m,); infinite ones stay.

    Other parameters are those of :func:`strict_terms`, for paths (m, max_n, 3).
    """
    for i in range(paths.shape[0]):
        if penalty[i] == math.inf:
            continue
        n = lengths[i]
        for point in range(n):
            lay_turn(paths[i], n, point, c, turns)
        for segment in range(n - 1):
            lay_segment(paths[i], n, segment, c, turns, pieces)
        rows = 2 * n - 1
        for row in range(rows):
            judge_slope(c, pieces, row)
        lay_times(c, pieces, rows, times)
        penalty[i] += zone_metres_with(pieces, rows, times, zones, marks)


@compiled
def piece_figures(c: Constants, pieces: Floats, rows: int, figures: Floats) -> None:
    """Write the figures of every piece, (rows, FIGURES); those without length stay as they are."""
    fuel = 0.0
    flown = 0.0
    for row in range(rows):
        length, run = pieces[row, _LENGTH], pieces[row, _RUN]
        if not length > 0.0:
            continue
        weight = c.weight - fuel
        speed = c.airspeed_m_s * pieces[row, _RISE] / length
        if c.in_air and run > 0.0:
            speed = (
                pieces[row, _RISE]
                / run
                * fastest_over_ground(
                    c,
                    c.airspeed_m_s * run / length,
                    pieces[row, fields.UX],
                    pieces[row, fields.UY],
                    pieces[row, fields.SIDE],
                    pieces[row, fields.ANGLE],
                )
            )
        figures[row, FLOWN] = flown
        figures[row, VERTICAL_SPEED] = speed
        figures[row, THRUST] = thrust_of(pieces, row, weight)
        figures[row, FUEL] = burn(pieces, row, weight)
        fuel += figures[row, FUEL]
        flown += length


def scratch(points: int, zones: PackedZones) -> tuple[Floats, Floats, Floats]:
    """Return the scratch arrays ``times``, ``stack`` and ``marks`` for paths of ``points``."""
    return np.empty(2 * points), np.empty(STACK_SHAPE), np.empty(zones.marks)
