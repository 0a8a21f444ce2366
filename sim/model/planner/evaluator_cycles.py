"""Cycles of the evaluator of paths, its walker and its scorer, as in the gateware.

The scorer takes a point in every slot of one or two cycles, including entry and exit: m points take
m or 2 m cycles. Cycles in which its ``phase`` is 1, the second of a slot of two, are odd here. It
does not take a path while sixteen are inside. After that, everything takes fixed numbers of cycles
except for two queues: the walker's, and the queue of keys, which leave in the order of the paths.
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
#: Latency of the fitter.
_FITTER = 2


@inlined
def launched(first: int, second: int, free: int, room: int, slot: int) -> int:
    """Return the cycle in which ``launches`` is set for a path; its slots begin in the next cycle.

    Parameters
    ----------
    first, second : int
        First cycles in which its first two points are offered. A point is offered later if the
        scorer takes the previous point later.
    free : int
        Result of :func:`freed` for the previous path, or 0.
    room : int
        Cycle from which there is room.
    slot : int
        Cycles of a slot, 1 or 2.
    """
    # Odd if a slot is two cycles.
    return max(first + 1, second, free, room + 1) | (slot - 1)


@inlined
def freed(launch: int, points: int, slot: int) -> int:
    """Return the first cycle in which the path after one of ``points`` points may be launched."""
    return launch + slot * points


@dataclass(frozen=True)
class ScorerCycles:
    """Latencies of the scorer of one configuration.

    Attributes
    ----------
    chord : int
        Cycles from the launch of a path to the record of its first segment.
    score : int
        Cycles from the record of a path's last segment to its score.
    slot : int
        Cycles of a slot.
    """

    chord: int
    score: int
    slot: int

    @classmethod
    @cache
    def of(cls, config: Config) -> ScorerCycles:
        """Return the latencies of ``config``."""
        widths, slot = Widths.of(config), config.point_cycles
        # From ``launches`` to the slot of the path's fourth point, in which the record of its first
        # segment leaves the fitter.
        sent = 1 + 3 * slot + _measuring(widths, slot) + _FITTER
        return cls(sent + _laying(widths, slot), _pricing(widths, slot), slot)

    def sent(self, launch: int, segment: int) -> int:
        """Return the cycle of the chord record of a segment, counted from 0."""
        return launch + self.chord + self.slot * segment

    def scored(self, launch: int, points: int) -> int:
        """Return the cycle of the score of a path of ``points`` points."""
        return self.sent(launch, points - 2) + self.score


def _measuring(widths: Widths, slot: int) -> int:
    """Return the cycles of a segment and its turn: a root and a quotient, one bit per cycle."""
    side = widths.side
    segment = 2 + slot + _product(side, SCALE_FRACTION + 1) + _product(side, side) + widths.length
    quotient = SHARPEST_BITS + TURN_FRACTION
    turn = 5 + slot + _product(side, side) + quotient + _product(RADIUS_BITS, widths.half_turn)
    return _held(segment, slot) + _held(turn, slot)


def _laying(widths: Widths, slot: int) -> int:
    """Return the cycles of an arc's length and shares, then of its ends."""
    arc = 4 + 2 * slot + _product(RADIUS_BITS, TURN_BITS)
    ends = 1 + slot + _product(widths.part + 1, widths.share)
    return _held(max(widths.share + slot - 1, arc), slot) + _held(ends, slot)


def _pricing(widths: Widths, slot: int) -> int:
    """Return the cycles from the last pieces of a path to its value."""
    up = widths.part + 1 + RISE_BITS - RISE_FRACTION
    squares = max(
        1 + _product(widths.part + 1, RISE_BITS) + _product(up, up),
        _product(widths.run, widths.run),
    )
    flown = squares + 1 + widths.flown + 1 + 1
    fuel = 5 + _product(DRAG_FRACTION, widths.flown) + _product(widths.pull, FUEL_BITS)
    piece = flown + max(fuel, _product(widths.level, widths.flown)) + 1
    return _held(1 + slot + piece, slot) + slot + _held(6, slot)


def _product(first: int, second: int) -> int:
    """Return the cycles of a product of numbers of ``first`` and ``second`` bits, with sign."""
    multipliers = -(-first // _CELL_BITS) * -(-second // _CELL_BITS)
    return 1 + (multipliers - 1).bit_length()


def _held(cycles: int, slot: int) -> int:
    """Return the cycles until a value that takes ``cycles`` is held through a slot."""
    return (cycles | 1) + 1 if slot == 2 else cycles
