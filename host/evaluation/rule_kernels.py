"""The strict verdict on a path, compiled: every rule of safe flight on the exact smoothed track."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import kernels
from pathgene.host.evaluation import laying as fields
from pathgene.host.evaluation.constants import (
    COORDINATE_LIMIT_M,
    Constants,
    Course,
    Floats,
    Scratch,
)
from pathgene.host.evaluation.jit import compiled, inlined
from pathgene.host.evaluation.kernels import corners_m, cost_of, path_terms
from pathgene.host.evaluation.laying import lay_segment, lay_turn
from pathgene.host.evaluation.packed_zones import PackedZones
from pathgene.host.evaluation.pieces import burn, fastest_over_ground, judge_slope, thrust_of
from pathgene.host.evaluation.terrain_rule import (
    STACK_SHAPE,
    Part,
    Required,
    Surface,
    excess_m,
    extreme,
    room_on_map_m,
)
from pathgene.host.evaluation.zones import zone_metres_with


__all__ = [
    "FIGURES",
    "FLOWN",
    "FUEL",
    "STACK_SHAPE",
    "THRUST",
    "VERTICAL_SPEED",
    "StrictCourse",
    "StrictScratch",
    "add_zone_metres",
    "extreme_of_track",
    "first_kept",
    "least_room_on_map",
    "piece_figures",
    "scratch",
    "strict_penalties",
    "strict_penalty",
    "strict_terms",
]

_LENGTH, _AIR, _RUN, _RISE = fields.LENGTH, fields.AIR, fields.RUN, fields.RISE

#: Figures of a piece: metres flown before it, vertical speed (m/s), thrust (N), fuel (N).
FLOWN, VERTICAL_SPEED, THRUST, FUEL = range(4)
FIGURES = 4


class StrictCourse(NamedTuple):
    """The terrain, and the requirements of the strict rule for every path over it.

    Parameters
    ----------
    surface : Surface
        The terrain and constants; nothing is sampled.
    low, below, high : Required
        Minimum height over the corridor and right below the track, and maximum height; an infinite
        maximum height is not searched.
    """

    surface: Surface
    low: Required
    below: Required
    high: Required
    zones: PackedZones


class StrictScratch(NamedTuple):
    """Work space of the strict rule for one path at a time; see :func:`scratch`.

    Parameters
    ----------
    times : (2 n,) float64
        The second at which each piece begins, and the end of the last piece.
    stack : STACK_SHAPE float64
        Work space of the search on terrain.
    marks : (zones.marks,) float64
        Work space of the search in zones.
    """

    path: Scratch
    times: Floats
    stack: Floats
    marks: Floats


@inlined
def course_of(surface: Surface) -> Course:
    """Return a course without zones, whose constants let nothing be sampled."""
    return Course(surface.ground, surface.ground, surface.c)


@compiled
def strict_terms(
    path: Floats, n: int, strict: StrictCourse, scratch: StrictScratch
) -> tuple[float, float, float, float, float, float, int, float]:
    """Return every term of one path by the strict rule, as ``path_terms`` does.

    The distance under the terrain adds up the parts with a point too low, or with a corridor that
    leaves the map, and the parts with a point above the ceiling over ground. The distance in
    no-fly zones is exact.

    Parameters
    ----------
    path, n
        As for :func:`pathgene.host.evaluation.kernels.path_terms`.
    scratch : StrictScratch
        Holds the turns, pieces and times of the path afterwards.
    """
    surface, high = strict.surface, strict.high
    pieces, times, stack = scratch.path.pieces, scratch.times, scratch.stack
    rows = 2 * n - 1
    terms = path_terms(path, n, course_of(surface), scratch.path)
    length, area, fuel, steep, _, _, impossible, beyond = terms
    lay_times(surface.c, pieces, rows, times)
    under = excess_m(surface, strict.low, strict.below, pieces, rows, stack)
    if high.height_m < math.inf:
        under += excess_m(surface, high, high, pieces, rows, stack)
    zone = zone_metres_with(pieces, rows, times, strict.zones, scratch.marks)
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
    surface: Surface,
    required: Required,
    pieces: Floats,
    rows: int,
    known: float,
    step: float,
    stack: Floats,
) -> tuple[float, int, float]:
    """Return the greatest excess of a track to within ``step``, its piece, and the piece's share.

    If no excess is greater than ``known``, ``known`` is returned, and piece and share have no
    meaning. See :func:`pathgene.host.evaluation.terrain_rule.extreme` for the remaining parameters.
    """
    ds_m = surface.c.ds_m
    best = known
    worst_row = 0
    place = 0.0
    # First the middle of every part: a good incumbent prunes most of the search.
    for search in range(2):
        for row in range(rows):
            run = pieces[row, _RUN]
            if not pieces[row, _LENGTH] > 0.0:
                continue
            parts = np.int64(math.ceil(run / ds_m)) if run > 0.0 else 1
            for number in range(parts):
                first, last = run * number / parts, run * (number + 1) / parts
                if search == 0:
                    first = last = 0.5 * (first + last)
                part = Part(row, first, last)
                found, along = extreme(surface, required, pieces, part, best, step, False, stack)
                if found > best:
                    best, worst_row, place = found, row, along / run if run > 0.0 else 0.0
    return best, worst_row, place


@compiled
def least_room_on_map(
    c: Constants, pieces: Floats, rows: int, half_width_m: float
) -> tuple[float, int, float]:
    """Return the least distance of a track's strip to the edge of the map, its piece and share.

    The share belongs to the middle of a part of at most ``ds_m``. See
    :func:`pathgene.host.evaluation.terrain_rule.room_on_map_m`.
    """
    least = math.inf
    worst_row = 0
    share = 0.0
    for row in range(rows):
        run = pieces[row, _RUN]
        if not pieces[row, _LENGTH] > 0.0:
            continue
        parts = np.int64(math.ceil(run / c.ds_m)) if run > 0.0 else 1
        for number in range(parts):
            part = Part(row, run * number / parts, run * (number + 1) / parts)
            room = room_on_map_m(c, pieces, part, half_width_m)
            if room < least:
                least, worst_row, share = room, row, (number + 0.5) / parts
    return least, worst_row, share


@compiled
def strict_penalty(
    path: Floats, n: int, strict: StrictCourse, scratch: StrictScratch
) -> tuple[float, float]:
    """Return penalty and cost by the strict rule; both infinite for a bad path."""
    for i in range(n):
        for axis in range(3):
            if not abs(path[i, axis]) <= COORDINATE_LIMIT_M:
                return math.inf, math.inf
    length, area, fuel, steep, under, zone, _, beyond = strict_terms(path, n, strict, scratch)
    if not length > 0.0:
        return math.inf, math.inf
    c = strict.surface.c
    penalty = under + zone + steep + corners_m(c, scratch.path.turns, n, length) + beyond
    return penalty, cost_of(c, area, fuel)


@compiled
def strict_penalties(
    paths: Floats,
    lengths: NDArray[np.int64],
    strict: StrictCourse,
    scratch: StrictScratch,
    penalty: Floats,
    cost: Floats,
) -> None:
    """Write :func:`strict_penalty` of each of paths (m, max_n, 3), (m,) each."""
    for i in range(paths.shape[0]):
        penalty[i], cost[i] = strict_penalty(paths[i], lengths[i], strict, scratch)


@compiled
def first_kept(
    paths: Floats, lengths: NDArray[np.int64], strict: StrictCourse, scratch: StrictScratch
) -> int:
    """Return the index of the first path without a penalty by the strict rule; -1 if there is none.

    A path is left at the first limit that it breaks, and heights, which take longest, come last.
    Paths are (m, max_n, 3), of finite coordinates; see :func:`strict_terms`.
    """
    surface, high = strict.surface, strict.high
    pieces, times, stack = scratch.path.pieces, scratch.times, scratch.stack
    for i in range(paths.shape[0]):
        n = lengths[i]
        rows = 2 * n - 1
        terms = path_terms(paths[i], n, course_of(surface), scratch.path)
        length, _, _, steep, _, _, impossible, beyond = terms
        if not length > 0.0 or impossible > 0 or steep > 0.0 or beyond > 0.0:
            continue
        lay_times(surface.c, pieces, rows, times)
        if zone_metres_with(pieces, rows, times, strict.zones, scratch.marks) > 0.0:
            continue
        if excess_m(surface, strict.low, strict.below, pieces, rows, stack) > 0.0:
            continue
        is_capped = high.height_m < math.inf
        if is_capped and excess_m(surface, high, high, pieces, rows, stack) > 0.0:
            continue
        return i
    return -1


@compiled
def add_zone_metres(
    paths: Floats,
    lengths: NDArray[np.int64],
    c: Constants,
    zones: PackedZones,
    scratch: StrictScratch,
    penalty: Floats,
) -> None:
    """Add the metres of each path in ``zones`` to ``penalty``, (m,); infinite ones stay.

    Paths are (m, max_n, 3).
    """
    turns, pieces = scratch.path
    times, marks = scratch.times, scratch.marks
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
    """Write the figures of every piece with a length, (rows, FIGURES)."""
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


def scratch(points: int, zones: PackedZones) -> StrictScratch:
    """Return work space for paths of at most ``points`` points."""
    return StrictScratch(
        kernels.scratch(points), np.empty(2 * points), np.empty(STACK_SHAPE), np.empty(zones.marks)
    )
