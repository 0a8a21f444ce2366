"""Cycles of the evaluator of paths, its walker and its scorer, as in the gateware.

The scorer takes a point in every slot of two cycles, including entry and exit: m points take 2 m
cycles. Cycles in which its ``phase`` is 1, the second of a slot, are odd here. It does not take a
path while sixteen are inside. After that, everything takes fixed numbers of cycles except for two
queues: the walker's, and the queue of keys, which leave in the order of the paths.
:func:`pathgene.sim.model.planner.cycles.enter` has the resulting maxima.

A path costs the walker the sum of the costs of its segments and chords, in walking order, including
all after a first collision: one cycle on a hit of the memo, otherwise one cycle for each group of
as many corners as there are lanes. Paths follow each other without a gap. The memo is as in the
definition, looked up and filled segment by segment in this order; lengths of pipelines change
neither its answers nor the sum, only the delay of the first segment and of the last result.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

from pathgene.hdl.config import Config
from pathgene.hdl.planner.scorer.widths import TURN_BITS, Widths
from pathgene.hdl.protocol.planner import (
    DRAG_FRACTION,
    FUEL_BITS,
    RADIUS_BITS,
    RISE_BITS,
    RISE_FRACTION,
    SCALE_FRACTION,
    SHARPEST_BITS,
    TURN_FRACTION,
)
from pathgene.sim.model.compiled import inlined


__all__ = [
    "DECISION",
    "FRONT",
    "KEY",
    "MEMO_HIT",
    "PLACES",
    "QUEUE",
    "ScorerCycles",
    "back",
    "cost",
    "freed",
    "launched",
    "walked",
    "walking",
]


#: Maximum number of paths inside.
PLACES = 16
#: Cycles from a score to its decision, from there to the offer of the first segment to the walker,
#: and from a decision or the result of a walk to the key.
DECISION, QUEUE, KEY = 1, 3, 3


#: Cycles of a segment that the memo answers.
MEMO_HIT = 1

#: Cycles from the offer of a path's first segment to its launch.
FRONT = 5


@inlined
def walking(corners: int, lanes: int) -> int:
    """Return the cycles of a segment of ``corners`` corners that the memo does not answer."""
    return (corners + lanes - 1) // lanes


def back(lanes: int, memory_latency: int) -> int:
    """Return the cycles from the last cycle of a path's last segment to the path's result."""
    levels = lanes.bit_length() - 1
    return 10 + memory_latency + levels


def cost(start: tuple[int, int, int], stop: tuple[int, int, int], known: bool, lanes: int) -> int:
    """Return the cycles of a segment that the memo does or does not answer."""
    if known:
        return MEMO_HIT
    return walking(max(abs(stop[0] - start[0]), abs(stop[1] - start[1])) + 1, lanes)


def walked(offered: int, free: int, costs: Iterable[int]) -> int:
    """Return the cycle in which the walker is free again after a path.

    The result of the path follows :func:`back` - 1 cycles later.

    Parameters
    ----------
    offered : int
        Cycle in which the first segment of the path is offered; the rest follow as fast as they
        are taken.
    free : int
        Cycle in which the walker is free for the path.
    costs : iterable of int
        Costs of its segments and chords.
    """
    return max(offered + FRONT, free) + sum(costs)


#: Bits of a factor that a multiplier takes.
_CELL_BITS = 18
#: Cycles from ``launches`` to the slot of a path's fourth point, in which the record of its first
#: segment leaves the fitter, and latency of the fitter.
_SENT, _FITTER = 7, 2


@inlined
def launched(first: int, second: int, free: int, room: int) -> int:
    """Return the cycle in which ``launches`` is set for a path; its slots begin in the next cycle.

    Parameters
    ----------
    first, second : int
        First cycles in which its first two points are offered. A point is offered later if the
        scorer takes the previous point later; there is always a cycle in between.
    free : int
        Result of :func:`freed` for the previous path, or 0.
    room : int
        Cycle from which there is room.
    """
    return max(first + 1, second, free, room + 1) | 1


@inlined
def freed(launch: int, points: int) -> int:
    """Return the first cycle in which the path after one of ``points`` points may be launched."""
    return launch + 2 * points


@dataclass(frozen=True)
class ScorerCycles:
    """Latencies of the scorer of one configuration.

    Attributes
    ----------
    chord : int
        Cycles from the launch of a path to the record of its first segment.
    score : int
        Cycles from the record of a path's last segment to its score.
    """

    chord: int
    score: int

    @classmethod
    @cache
    def of(cls, config: Config) -> ScorerCycles:
        """Return the latencies of ``config``."""
        widths = Widths.of(config)
        return cls(_SENT + _FITTER + _measuring(widths) + _laying(widths), _pricing(widths))

    def sent(self, launch: int, segment: int) -> int:
        """Return the cycle of the chord record of a segment, counted from 0."""
        return launch + self.chord + 2 * segment

    def scored(self, launch: int, points: int) -> int:
        """Return the cycle of the score of a path of ``points`` points."""
        return self.sent(launch, points - 2) + self.score


def _measuring(widths: Widths) -> int:
    """Return the cycles of a segment and its turn: a root and a quotient, one bit per cycle."""
    side = widths.side
    segment = 4 + _product(side, SCALE_FRACTION + 1) + _product(side, side) + widths.length
    quotient = SHARPEST_BITS + TURN_FRACTION
    turn = 7 + _product(side, side) + quotient + _product(RADIUS_BITS, widths.half_turn)
    return _slots(segment) + _slots(turn)


def _laying(widths: Widths) -> int:
    """Return the cycles of an arc's length and shares, then of its ends."""
    arc = 6 + _product(RADIUS_BITS, TURN_BITS)
    return _slots(max(widths.share + 1, arc)) + _slots(3 + _product(widths.part + 1, widths.share))


def _pricing(widths: Widths) -> int:
    """Return the cycles from the last pieces of a path to its value."""
    up = widths.part + 1 + RISE_BITS - RISE_FRACTION
    squares = max(
        1 + _product(widths.part + 1, RISE_BITS) + _product(up, up),
        _product(widths.run, widths.run),
    )
    flown = squares + 1 + widths.flown + 1 + 1
    fuel = 5 + _product(DRAG_FRACTION, widths.flown) + _product(widths.pull, FUEL_BITS)
    piece = flown + max(fuel, _product(widths.level, widths.flown)) + 1
    return _slots(3 + piece) + 10


def _product(first: int, second: int) -> int:
    """Return the cycles of a product of numbers of ``first`` and ``second`` bits, with sign."""
    multipliers = -(-first // _CELL_BITS) * -(-second // _CELL_BITS)
    return 1 + (multipliers - 1).bit_length()


def _slots(cycles: int) -> int:
    """Return the cycles until a value that takes ``cycles`` is held through a slot."""
    return (cycles | 1) + 1
