"""The stretches of a track that break a limit, by the same tests as the strict verdict."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from pathgene.host.evaluation import laying as fields
from pathgene.host.evaluation.constants import Floats
from pathgene.host.evaluation.crossings import sort_marks
from pathgene.host.evaluation.jit import compiled
from pathgene.host.evaluation.laid_track import LaidTrack
from pathgene.host.evaluation.laying import is_impossible
from pathgene.host.evaluation.packed_zones import PackedZones, applies, holds, mark_border
from pathgene.host.evaluation.rule_kernels import FUEL, THRUST
from pathgene.host.evaluation.terrain_rule import (
    STACK_SHAPE,
    Part,
    Required,
    Surface,
    extreme,
    is_near_end,
    room_on_map_m,
    track_point,
)


__all__ = [
    "Stretch",
    "above",
    "impossible_turns",
    "merged",
    "off_demand",
    "out_of_fuel",
    "too_steep",
    "too_weak",
    "within_zone",
]

# Heights are compared up to rounding, as in the verdict.
_ROUNDING_M = 1e-9
# Maximum number of parts of a track: a picture shows no more.
_PARTS = 4000
# Stretches of one limit that are nearer than this are one, metres flown.
_JOIN_M = 1e-6

Span = tuple[float, float]


class Stretch(NamedTuple):
    """A stretch of a track that breaks a limit.

    Parameters
    ----------
    limit : str
        Name of the limit as in the report.
    from_m, to_m : float
        Metres flown to its start and to its end.
    """

    limit: str
    from_m: float
    to_m: float


def merged(limit: str, spans: Iterable[Span]) -> list[Stretch]:
    """Return the stretches of one limit in flying order, with touching ones merged."""
    stretches: list[Stretch] = []
    for start, stop in sorted(spans):
        if stretches and start <= stretches[-1].to_m + _JOIN_M:
            start, stop = stretches[-1].from_m, max(stop, stretches[-1].to_m)
            stretches.pop()
        stretches.append(Stretch(limit, start, stop))
    return stretches


@compiled
def _mark_parts(
    surface: Surface,
    required: Required,
    below: Required,
    pieces: Floats,
    row: int,
    parts: int,
    stack: Floats,
    marks: Floats,
) -> None:
    """Write 1 for each part of a piece that violates a requirement, 2 off the map, otherwise 0.

    A part is off the map if its strip is, to the half width of the requirement.
    """
    run = pieces[row, fields.RUN]
    for number in range(parts):
        part = Part(row, run * number / parts, run * (number + 1) / parts)
        if not room_on_map_m(surface.c, pieces, part, required.half_width_m) >= 0.0:
            marks[number] = 2.0
            continue
        excess, _ = extreme(surface, required, pieces, part, _ROUNDING_M, 0.0, True, stack)
        if excess <= _ROUNDING_M and is_near_end(required, pieces, part):
            excess, _ = extreme(surface, below, pieces, part, _ROUNDING_M, 0.0, True, stack)
        marks[number] = 1.0 if excess > _ROUNDING_M else 0.0


def off_demand(
    surface: Surface, required: Required, below: Required, track: LaidTrack
) -> tuple[list[Span], list[Span]]:
    """Return the parts that violate the required height, and the parts whose strip is off the map.

    A part is at most ``ds_m`` long, or a 4000th of a longer track, and counts whole.
    """
    stack = np.empty(STACK_SHAPE)
    step_m = max(surface.c.ds_m, track.length_m / _PARTS)
    broken: tuple[list[Span], list[Span]] = ([], [])
    for row, start, length in _rows(track):
        run = float(track.pieces[row, fields.RUN])
        parts = max(math.ceil(run / step_m), 1)
        marks = np.empty(parts)
        _mark_parts(surface, required, below, track.pieces, row, parts, stack, marks)
        for part in np.flatnonzero(marks).tolist():
            span = start + length * part / parts, start + length * (part + 1) / parts
            broken[int(marks[part]) - 1].append(span)
    return broken


@compiled
def _inside(
    pieces: Floats,
    row: int,
    times: Floats,
    packed: PackedZones,
    zone: int,
    marks: Floats,
    places: Floats,
) -> int:
    """Write the marks where a piece crosses a zone's border, with its first and last place."""
    low, high = applies(pieces, row, times, packed, zone)
    if not low < high:
        return 0
    count = mark_border(pieces, row, packed, zone, low, high, marks)
    places[0] = low
    for i in range(count):
        places[i + 1] = marks[i]
    places[count + 1] = high
    return count + 2


@compiled
def _meets(
    pieces: Floats,
    rows: int,
    times: Floats,
    packed: PackedZones,
    zone: int,
    marks: Floats,
    places: Floats,
) -> bool:
    """Return whether a track is inside a zone anywhere; see :func:`within_zone`.

    Most of many zones are met by none, and a loop of Python over the pieces of each would take
    seconds.
    """
    for row in range(rows):
        if pieces[row, fields.LENGTH] > 0.0:
            count = _inside(pieces, row, times, packed, zone, marks, places)
            sort_marks(places, count)
            for i in range(count - 1):
                along = 0.5 * (places[i] + places[i + 1]) * pieces[row, fields.RUN]
                x, y, _, _ = track_point(pieces, row, along, 0.0)
                if places[i + 1] > places[i] and holds(packed, zone, x, y):
                    return True
    return False


def within_zone(track: LaidTrack, packed: PackedZones, zone: int) -> Iterator[Span]:
    """Yield the stretches of a track inside one of the packed zones with its margin."""
    marks, places = np.empty(packed.marks), np.empty(packed.marks + 2)
    if not _meets(track.pieces, track.rows, track.times, packed, zone, marks, places):
        return
    for row, start, length in _rows(track):
        count = _inside(track.pieces, row, track.times, packed, zone, marks, places)
        cuts = np.sort(places[:count]).tolist()
        for first, last in itertools.pairwise(cuts):
            if last > first and holds(packed, zone, *track.place(row, 0.5 * (first + last))):
                yield start + first * length, start + last * length


def too_steep(track: LaidTrack, sign: int) -> Iterator[Span]:
    """Yield the pieces that climb (``sign`` 1) or descend (-1) too steeply."""
    for row, start, length in _rows(track):
        rise = track.pieces[row, fields.RISE]
        if track.pieces[row, fields.STEEP] > 0 and (rise >= 0) == (sign > 0):
            yield start, start + length


def too_weak(track: LaidTrack, thrust: float) -> Iterator[Span]:
    """Yield the pieces that need more than ``thrust``."""
    for row, start, length in _rows(track):
        if track.figures[row, THRUST] > thrust:
            yield start, start + length


def above(track: LaidTrack, ceiling_m: float) -> Iterator[Span]:
    """Yield the stretches above a ceiling."""
    for row, start, length in _rows(track):
        low, rise = track.pieces[row, fields.Z], track.pieces[row, fields.RISE]
        first, last = low > ceiling_m, low + rise > ceiling_m
        if first or last:
            share = float((ceiling_m - low) / rise) if first != last else 0.0
            yield (
                start + (0.0 if first else share) * length,
                start + (1.0 if last else share) * length,
            )


def out_of_fuel(track: LaidTrack, fuel: float) -> Iterator[Span]:
    """Yield the stretch on which more than ``fuel`` is burned, to the end of the track."""
    burned = 0.0
    for row, start, length in _rows(track):
        used = float(track.figures[row, FUEL])
        if burned + used > fuel:
            yield start + length * max(fuel - burned, 0.0) / used, track.length_m
            return
        burned += used


def impossible_turns(track: LaidTrack, reach_m: float) -> list[Span]:
    """Return the surroundings of waypoints whose turn does not fit, ``reach_m`` to either side."""
    lengths = np.maximum(track.pieces[: track.rows, fields.LENGTH], 0.0)
    flown = np.cumsum(lengths)
    spans = []
    for i in range(track.points):
        if is_impossible(track.turns, track.points, i):
            at = float(flown[2 * i - 1]) if i else 0.0
            at += 0.5 * float(lengths[2 * i])
            spans.append((max(at - reach_m, 0.0), min(at + reach_m, track.length_m)))
    return spans


def _rows(track: LaidTrack) -> Iterator[tuple[int, float, float]]:
    """Yield each piece's row, the metres flown before it, and its length."""
    flown = 0.0
    for row in range(track.rows):
        length = float(track.pieces[row, fields.LENGTH])
        if length > 0.0:
            yield row, flown, length
            flown += length
