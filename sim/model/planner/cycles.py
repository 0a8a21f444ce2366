"""Cycles of a run, equal to those of the gateware: the one place that knows how its units overlap.

Cycles are counted from the first one of a run. A path passes scorer, decision and walker in the
order in which paths come. The scorer takes a point in every slot of two cycles and never waits
inside a path; the decision follows a fixed time behind, and the walker takes the paths that are to
be walked one right after the other. So the cycle of a path's key follows from the cycle in which
its points are there, the number of its points, the cycles of its walk, and the paths before it.

Kernels of the compiled model and the plain definition both call these functions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hdl.config import Config
from sim.model.planner.compiled import compiled, inlined
from sim.model.planner.walk import Integers


__all__ = [
    "BREED",
    "CYCLES",
    "ENDED",
    "GENERATIONS",
    "MEMO_HIT",
    "MERGED",
    "ROW",
    "SCANNED",
    "SCORE",
    "SHARED",
    "SORT",
    "WALK",
    "WAVEFRONT",
    "begin",
    "bred",
    "collect",
    "counters_vector",
    "delays_vector",
    "enter",
    "finish",
    "revised",
    "seeded",
    "settle",
    "totals",
    "walking",
]

#: Cycles of the walker for a segment that the memo answers.
MEMO_HIT = 1

#: Places of the counters. CYCLES: in which the next step of the run begins; then generations, and
#: cycles of each unit.
CYCLES, GENERATIONS, BREED, SCORE, WALK, SORT, WAVEFRONT = range(7)
#: First slot of the scorer that is free, first cycle in which the walker is, the latest key, the
#: cycle in which the scorer takes the latest goal, paths that have entered, and the cycle in which
#: the builder of children is free.
_SLOT, _WALKER, _KEY, _GOAL, _ENTERED, _BUILT = range(7, 13)
#: Keys pass from _OPEN on, but not from _CLOSES to before _REOPENS.
_OPEN, _CLOSES, _REOPENS = range(13, 16)
#: Cycles of the latest keys of as many paths as can be inside at once.
_KEYS, _INSIDE = 16, 16
_NEVER = 1 << 60


@inlined
def walking(corners: int, lanes: int) -> int:
    """Return the cycles of a segment of so many corners that the memo does not answer."""
    return (corners + lanes - 1) // lanes


#: Places of the delays that depend on the sizes of a chip.
_SCORED, _WALKED, ROW = range(3)

# Cycles between the units. Those that depend on the sizes of a chip are in `delays_vector`.
#: From a path's second point to its first slot, at least.
_LAUNCH = 1
#: From a key to the first slot of a path that its place lets in.
_ROOM = 2
#: From a score to the key of a path that is not walked, and to the launch of one that is.
_DECIDED, _TO_WALKER = 3, 8
#: From the last slot of a path to the cycle in which its goal was taken.
_TAKEN = 2
#: From the begin of a generation to its last plan, and to the first plan that the builder takes.
_PLANNING, _FIRST_PLAN, _PLAN = 190, 14, 8
#: From the builder's begin of a child to its second point on offer.
_BUILT_TO_POINT = 10
#: From the begin of a generation, and of the last collection, to a pass; and its length.
_TO_PASS, _TO_LAST_PASS, _PASS = 192, 2, 34
#: From the last key, or the end of the pass, to the population in its memory; keys pass earlier.
_STORE, _TO_OPEN = 38, 36
#: From a set of first paths to the first of its points, and from a goal to those of the next path.
_FIRST_SEED, _NEXT_SEED = 40, 40
_FIRST_REVISED, _NEXT_REVISED = 10, 10
#: From the last key of a set of first paths to the population in its memory.
_SETTLED = 44
#: Around the scan of the blocks; to share the time among islands, to merge them, and to end.
SCANNED, SHARED, MERGED, ENDED = 4, 8, 110, 4


def delays_vector(config: Config) -> Integers:
    """Return the delays that depend on the sizes of ``config``, (3,) int64."""
    levels = config.lanes.bit_length() - 1
    delays = (145, 11 + config.memory_latency + levels, config.memory_latency + 4)
    return np.array(delays, dtype=np.int64)


def counters_vector() -> Integers:
    """Return the counters at the beginning of a run, (32,) int64."""
    return np.zeros(_KEYS + _INSIDE, dtype=np.int64)


@compiled
def enter(
    delays: Integers, counters: Integers, offered: int, points: int, walk: int, has_exit: int
) -> int:
    """Return the cycle of the key of the next path.

    Parameters
    ----------
    delays, counters : (n,) int64
    offered : int
        Cycle in which its second point is there; the others follow as they are taken.
    points : int
        Its points, with entry and exit.
    walk : int
        Cycles of its segments and chords in the walker; 0 if it is not walked.
    has_exit : int
        Its last point is the exit, which is not among those that come.
    """
    entered = counters[_ENTERED]
    start = max(counters[_SLOT], offered + _LAUNCH)
    if entered >= _INSIDE:
        start = max(start, counters[_KEYS + entered % _INSIDE] + _ROOM)
    start += start & 1
    counters[_SLOT] = start + 2 * points
    counters[_GOAL] = counters[_SLOT] - _TAKEN - 2 * has_exit
    counters[SCORE] += 2 * points
    scored = counters[_SLOT] + delays[_SCORED]
    key: int = scored + _DECIDED
    if walk:
        counters[_WALKER] = max(scored + _TO_WALKER, counters[_WALKER]) + walk
        key = counters[_WALKER] + delays[_WALKED]
    key = max(key, counters[_KEY] + 1, counters[_OPEN])
    if counters[_CLOSES] <= key < counters[_REOPENS]:
        key = counters[_REOPENS]
    counters[_KEY] = counters[_KEYS + entered % _INSIDE] = key
    counters[_ENTERED] += 1
    return key


@compiled
def seeded(counters: Integers, number: int) -> int:
    """Return the cycle in which the second point of a seed is there, ``number`` of its island."""
    ready: int = counters[CYCLES] + _FIRST_SEED
    if number:
        ready = counters[_GOAL] + _NEXT_SEED
    return ready


@compiled
def revised(counters: Integers, number: int, dropped: int) -> int:
    """Return the same of a path that is lifted or revived, ``number`` of its population."""
    ready: int = counters[CYCLES] + _FIRST_REVISED
    if number:
        ready = counters[_GOAL] + _NEXT_REVISED
    return ready + dropped


@compiled
def settle(counters: Integers) -> None:
    """Go on to the cycle in which a first population is in its memory."""
    counters[CYCLES] = counters[_KEY] + _SETTLED


@compiled
def begin(counters: Integers, pending: bool) -> int:
    """Begin a generation; return the cycle.

    With ``pending``, keys do not pass while the members of the population are gone through. Without
    it the next generation may begin when this one is planned.
    """
    now: int = counters[CYCLES]
    counters[GENERATIONS] += 1
    counters[BREED] += _PLANNING
    if pending:
        counters[_CLOSES], counters[_REOPENS] = now + _TO_PASS, now + _TO_PASS + _PASS
    else:
        counters[CYCLES] += _PLANNING
    return now


@compiled
def bred(counters: Integers, begun: int, number: int, points: int) -> int:
    """Return the cycle in which the second point of a child is there at the earliest."""
    built: int = max(begun + _FIRST_PLAN + _PLAN * number, counters[_BUILT])
    counters[_BUILT] = built + points
    return built + _BUILT_TO_POINT


@compiled
def finish(counters: Integers) -> None:
    """Begin to collect the last generation."""
    now = counters[CYCLES]
    counters[_CLOSES], counters[_REOPENS] = now + _TO_LAST_PASS, now + _TO_LAST_PASS + _PASS


@compiled
def collect(counters: Integers) -> None:
    """Go on to the cycle in which a population can be read, all of whose children have keys."""
    sorted_at = max(counters[_KEY] + 1, counters[_REOPENS])
    counters[CYCLES] = sorted_at + _STORE
    counters[_OPEN] = sorted_at + _TO_OPEN
    counters[SORT] += _PASS + _STORE


def totals(counters: Integers) -> dict[str, Any]:
    """Return generations, cycles, and the cycles of each unit, by their names."""
    names = ("cycles", "generations", "breed", "score", "walk", "sort", "wavefront")
    return dict(zip(names, counters[: len(names)].tolist(), strict=True))
