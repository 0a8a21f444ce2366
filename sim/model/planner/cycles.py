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
from sim.model.planner.evaluator_cycles import DECISION, KEY, PLACES, QUEUE
from sim.model.planner.evolver_cycles import begun as child_begun
from sim.model.planner.evolver_cycles import (
    merging,
    moving,
    opening,
    plan,
    planning,
    settling,
    storing,
)
from sim.model.planner.evolver_cycles import offered as point_offered
from sim.model.planner.first_paths_cycles import member_offered, seed_offered
from sim.model.planner.run_control_cycles import (
    AIMED,
    BEGIN,
    END,
    EVALUATED,
    MERGED,
    NEXT_ISLAND,
    POPULATION,
    SPLIT_TO_AIM,
)
from sim.model.planner.scorer_cycles import ScorerCycles, freed, launched
from sim.model.planner.walk import Integers
from sim.model.planner.walker_cycles import FRONT, back
from sim.model.planner.wavefront_cycles import seeded as word_cycles


__all__ = [
    "BREED",
    "CYCLES",
    "GENERATIONS",
    "ROW",
    "SCORE",
    "SORT",
    "WALK",
    "WAVEFRONT",
    "aim",
    "begin",
    "bred",
    "collect",
    "counters_vector",
    "delays_vector",
    "end",
    "enter",
    "finish",
    "goal",
    "merge",
    "next_island",
    "revised",
    "seeded",
    "settle",
    "share_out",
    "spread",
    "totals",
    "vacate",
]

#: Places of the counters. CYCLES: in which the next step of the run begins; then generations, and
#: cycles of each unit.
CYCLES, GENERATIONS, BREED, SCORE, WALK, SORT, WAVEFRONT = range(7)
#: First cycles in which the scorer can take the first point of a path, in which its slots are free,
#: and in which the walker is; cycles of the latest key, and in which the scorer takes the latest
#: goal; paths that have entered, and points of the latest child with the cycle of its begin.
_LAUNCHER, _SLOTS, _WALKER, _KEY, _GOAL, _ENTERED, _BEGUN, _POINTS = range(7, 15)
#: Keys pass from _OPEN on, but not from _CLOSES to before _REOPENS.
_OPEN, _CLOSES, _REOPENS = range(15, 18)
#: Cycles of the latest keys, of as many paths as can be inside at once.
_KEYS = 18

#: Places of the delays that depend on the sizes of a chip.
_SCORED, _WALKED, ROW, _POPULATION, _CHILDREN, _LONGEST = range(6)


def delays_vector(config: Config) -> Integers:
    """Return the delays of a chip of ``config``, and the sizes that they depend on, (6,) int64."""
    delays = (
        ScorerCycles.of(config).scored(0, 0) + DECISION,
        back(config.lanes, config.memory_latency) - 1,
        config.memory_latency + 4,
        config.population,
        config.children,
        config.max_waypoints,
    )
    return np.array(delays, dtype=np.int64)


def counters_vector() -> Integers:
    """Return the counters at the beginning of a run, (34,) int64."""
    counters = np.zeros(_KEYS + PLACES, dtype=np.int64)
    counters[_KEY] = counters[_KEYS:] = -1
    return counters


@compiled
def enter(
    delays: Integers, counters: Integers, offered: int, points: int, walk: int, has_exit: int
) -> int:
    """Return the cycle of the key of the next path.

    Parameters
    ----------
    delays, counters : (n,) int64
    offered : int
        Cycle from which its points are offered, one after another.
    points : int
        Its points, with entry and exit.
    walk : int
        Cycles of its segments and chords in the walker; 0 if it is not walked.
    has_exit : int
        Its last point is the exit, which is not among those that come.
    """
    place = _KEYS + counters[_ENTERED] % PLACES
    first = max(offered, counters[_LAUNCHER], counters[place] + 1)
    launch = launched(first, first + 1, counters[_SLOTS], 0)
    counters[_SLOTS] = freed(launch, points)
    counters[_GOAL] = launch + 2 * (points - 2 - has_exit)
    counters[_LAUNCHER] = counters[_GOAL] + 2
    counters[SCORE] += 2 * points
    decided = launch + 2 * points + delays[_SCORED]
    key: int = decided + KEY
    if walk:
        counters[_WALKER] = max(decided + QUEUE + FRONT, counters[_WALKER]) + walk
        key = counters[_WALKER] + delays[_WALKED] + KEY
    key = max(key, counters[_KEY] + 1, counters[_OPEN])
    if counters[_CLOSES] <= key < counters[_REOPENS]:
        key = counters[_REOPENS]
    counters[_KEY] = counters[place] = key
    counters[_ENTERED] += 1
    return key


def goal(counters: Integers) -> int:
    """Return the cycle in which the scorer takes the goal of the latest path."""
    return int(counters[_GOAL])


def vacate(counters: Integers) -> None:
    """Let a path in at once, however many are inside."""
    counters[_KEYS:] = -1


@compiled
def spread(counters: Integers, spent: int, further: int) -> None:
    """Go on behind a scan or a route that takes ``spent`` cycles, and ``further`` ones."""
    counters[CYCLES] += spent + further
    counters[WAVEFRONT] += spent


@compiled
def seeded(delays: Integers, counters: Integers, number: int) -> int:
    """Return the cycle from which the points of a seed are offered, ``number`` of its island."""
    begun = counters[CYCLES] + 1
    if number:
        # The words of the seed before are taken by then, or the goal is.
        begun = max(counters[_GOAL] + 1, counters[_BEGUN] + word_cycles(delays[_LONGEST]) + 1)
    counters[_BEGUN] = begun
    return seed_offered(begun)


@compiled
def revised(counters: Integers, number: int, dropped: int) -> int:
    """Return the same of a path that is lifted or revived, ``number`` of its population."""
    free = counters[_GOAL] if number else counters[CYCLES]
    return member_offered(free, dropped)


@compiled
def settle(delays: Integers, counters: Integers) -> None:
    """Go on to the step behind a first population, all of whose paths have keys."""
    store = counters[_KEY] + 1 + EVALUATED
    counters[CYCLES] = store + settling(delays[_POPULATION]) + POPULATION
    counters[SORT] += moving(delays[_POPULATION])


@compiled
def share_out(counters: Integers) -> None:
    """Go on behind the division of the time among islands."""
    counters[CYCLES] += SPLIT_TO_AIM
    counters[_BEGUN] = counters[_POINTS] = 0


@compiled
def aim(counters: Integers) -> None:
    """Go on to the first cycle of a population that limits are compared with."""
    counters[CYCLES] += AIMED


@compiled
def begin(delays: Integers, counters: Integers, pending: bool) -> int:
    """Begin a generation; return the cycle.

    With ``pending``, keys do not pass while the members of the population are gone through. Without
    it the next generation may begin when this one is planned.
    """
    begun: int = counters[CYCLES] + BEGIN
    planned = planning(delays[_CHILDREN])
    counters[GENERATIONS] += 1
    counters[BREED] += planned - 1
    if pending:
        _close(delays, counters, begun + planned + 1)
    else:
        counters[CYCLES] = begun + planned
    return begun


@compiled
def bred(counters: Integers, begun: int, number: int, points: int) -> int:
    """Return the cycle from which the points of a child are offered, if all are taken at once."""
    child: int = child_begun(plan(begun, number), counters[_BEGUN], counters[_POINTS])
    counters[_BEGUN], counters[_POINTS] = child, points
    return point_offered(child, 0)


@compiled
def finish(delays: Integers, counters: Integers) -> None:
    """Begin to collect the last generation."""
    _close(delays, counters, counters[CYCLES] + BEGIN + 2)


@inlined
def _close(delays: Integers, counters: Integers, first: int) -> None:
    """Let no key pass in as many cycles as a population has members."""
    counters[_CLOSES], counters[_REOPENS] = first, first + delays[_POPULATION]


@compiled
def collect(delays: Integers, counters: Integers) -> None:
    """Go on to the cycle in which a population can be read, all of whose children have keys."""
    last = max(counters[_KEY], counters[_REOPENS] - 1)
    counters[_OPEN] = opening(last, delays[_POPULATION])
    counters[CYCLES] = last + storing(delays[_POPULATION])
    counters[SORT] += delays[_POPULATION] + moving(delays[_POPULATION])


@compiled
def next_island(counters: Integers) -> None:
    """Go on to the aim of the next island."""
    counters[CYCLES] += NEXT_ISLAND


@compiled
def merge(delays: Integers, counters: Integers) -> None:
    """Go on to the first cycle of the population that two islands become."""
    merged = counters[CYCLES] + MERGED[0]
    counters[SORT] += 2 * delays[_POPULATION] + moving(delays[_POPULATION])
    counters[CYCLES] = max(merged + MERGED[1] + AIMED, merged + merging(delays[_POPULATION]))


@compiled
def end(counters: Integers) -> None:
    """Go on to the end of the run."""
    counters[CYCLES] += END


def totals(counters: Integers) -> dict[str, Any]:
    """Return generations, cycles, and the cycles of each unit, by their names."""
    names = ("cycles", "generations", "breed", "score", "walk", "sort", "wavefront")
    return dict(zip(names, counters[: len(names)].tolist(), strict=True))
