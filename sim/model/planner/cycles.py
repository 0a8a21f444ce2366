"""Cycles of a run, as in the gateware: the only place that knows how the units overlap.

Cycles are counted from the first cycle of a run. Paths pass scorer, decision and walker in order of
arrival. The scorer takes a point in every slot of one or two cycles and never waits inside a path;
the decision follows a fixed time later, and the walker takes the paths to be walked without gaps.
The cycle of a path's key depends on the cycle in which its points are available, the number of its
points, the cycles of its walk, the earlier paths, and the number of members that each of them
passes in the sorter.

The kernels of the compiled model and the plain definition both call these functions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import UNITS
from pathgene.sim.model.compiled import compiled, inlined
from pathgene.sim.model.planner.evaluator_cycles import (
    DECISION,
    FRONT,
    KEY,
    PLACES,
    QUEUE,
    ScorerCycles,
    back,
    freed,
    launched,
)
from pathgene.sim.model.planner.evolver_cycles import begun as child_begun
from pathgene.sim.model.planner.evolver_cycles import (
    inserted,
    inserting,
    merging,
    passing,
    passing_over,
    plan,
    planning,
    ready,
    settled,
)
from pathgene.sim.model.planner.evolver_cycles import offered as point_offered
from pathgene.sim.model.planner.run_cycles import (
    AIMED,
    BEGIN,
    END,
    EVALUATED,
    MERGED,
    NEXT_ISLAND,
    POPULATION,
    SPLIT_TO_AIM,
    member_offered,
    seed_offered,
)
from pathgene.sim.model.planner.walk import Integers


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
    "pass_over",
    "passes",
    "revised",
    "seeded",
    "settle",
    "share_out",
    "spread",
    "take",
    "totals",
]

#: Places of the counters. CYCLES: the cycle in which the next step of the run begins; then
#: generations, and cycles of each unit.
CYCLES, GENERATIONS, BREED, SCORE, WALK, SORT, WAVEFRONT = range(7)
#: First cycles in which the scorer can take the first point of a path, in which its slots are free,
#: and in which the walker is free; cycle of the latest key, and cycle in which the scorer takes the
#: latest goal; number of paths that have entered, and points of the latest child with the cycle of
#: its beginning.
_LAUNCHER, _SLOTS, _WALKER, _KEY, _GOAL, _ENTERED, _BEGUN, _POINTS = range(7, 15)
#: Keys are taken from _FREE on; the next pass begins in _PASS, or when the sorter is free.
_FREE, _PASS = range(15, 17)
#: Cycles of the latest keys, for as many paths as can be inside at once.
_KEYS = 17

#: Places of the delays that depend on the sizes of a chip.
_SCORED, _WALKED, ROW, _POPULATION, _CHILDREN, _SLOT = range(6)


def delays_vector(config: Config) -> Integers:
    """Return the delays of a chip of ``config`` and the sizes that they depend on, (6,) int64."""
    delays = (
        ScorerCycles.of(config).scored(0, 0) + DECISION,
        back(config.lanes, config.memory_latency) - 1,
        config.memory_latency + 4,
        config.population,
        config.children,
        config.point_cycles,
    )
    return np.array(delays, dtype=np.int64)


def counters_vector() -> Integers:
    """Return the counters at the beginning of a run, (33,) int64."""
    counters = np.zeros(_KEYS + PLACES, dtype=np.int64)
    counters[_KEY] = counters[_KEYS:] = -1
    return counters


@compiled
def enter(
    delays: Integers, counters: Integers, offered: int, points: int, walk: int, has_exit: int
) -> int:
    """Return the cycle in which the next path's key is made; call :func:`take` after it.

    Parameters
    ----------
    delays, counters : (n,) int64
    offered : int
        Cycle from which the path's points are offered, one after another.
    points : int
        Number of points, including entry and exit.
    walk : int
        Cycles of its segments and chords in the walker; 0 if the path is not walked.
    has_exit : int
        1 if its last point is the exit, which is not one of the arriving points.
    """
    place, slot = _KEYS + counters[_ENTERED] % PLACES, delays[_SLOT]
    first = max(offered, counters[_LAUNCHER], counters[place] + 1)
    launch = launched(first, first + 1, counters[_SLOTS], 0, slot)
    counters[_SLOTS] = freed(launch, points, slot)
    counters[_GOAL] = launch + slot * (points - 2 - has_exit)
    counters[_LAUNCHER] = counters[_GOAL] + slot
    counters[SCORE] += slot * points
    decided = launch + slot * points + delays[_SCORED]
    key: int = decided + KEY
    if walk:
        counters[_WALKER] = max(decided + QUEUE + FRONT, counters[_WALKER]) + walk
        key = counters[_WALKER] + delays[_WALKED] + KEY
    return key


@inlined
def passes(counters: Integers, key: int) -> bool:
    """Return whether the next pass precedes a key that becomes ready in cycle ``key``."""
    comes: bool = max(key, counters[_FREE]) >= counters[_PASS]
    return comes


@inlined
def pass_over(delays: Integers, counters: Integers, passed: int) -> None:
    """Pass over the population, whose members pass ``passed`` members in the sorter in total."""
    population = delays[_POPULATION]
    spent = passing_over(population, population - delays[_CHILDREN], passed)
    counters[_FREE] = max(counters[_PASS], counters[_FREE]) + spent
    counters[SORT] += spent


@inlined
def take(counters: Integers, key: int, passed: int) -> int:
    """Return the cycle in which the latest path's key, made in cycle ``key``, is taken.

    ``passed``: number of members that it passes in the sorter.
    """
    taken: int = max(key, counters[_FREE])
    counters[_KEY] = counters[_KEYS + counters[_ENTERED] % PLACES] = taken
    counters[_ENTERED] += 1
    counters[_FREE] = inserted(taken, passed)
    counters[SORT] += inserting(passed)
    return taken


def goal(counters: Integers) -> int:
    """Return the cycle in which the scorer takes the goal of the latest path."""
    return int(counters[_GOAL])


@compiled
def spread(counters: Integers, spent: int, further: int) -> None:
    """Continue after a scan or a route that takes ``spent`` cycles, plus ``further`` ones."""
    counters[CYCLES] += spent + further
    counters[WAVEFRONT] += spent


@compiled
def seeded(counters: Integers, number: int) -> int:
    """Return the cycle from which the points of an island's seed ``number`` are offered."""
    return seed_offered(_free_after(counters, number))


@compiled
def revised(counters: Integers, number: int, dropped: int) -> int:
    """Return the same for a lifted or revived path, ``number`` in its population."""
    return member_offered(_free_after(counters, number), dropped)


@inlined
def _free_after(counters: Integers, number: int) -> int:
    """Return the cycle of the launch, or the cycle in which the previous path's goal is taken."""
    free: int = counters[_GOAL] if number else counters[CYCLES]
    return free


@compiled
def settle(delays: Integers, counters: Integers) -> None:
    """Continue with the step after a first population in which all paths have keys."""
    store = counters[_KEY] + 1 + EVALUATED
    counters[_FREE] = settled(store, counters[_FREE], delays[_POPULATION])
    counters[CYCLES] = counters[_FREE] + POPULATION
    counters[SORT] += delays[_POPULATION]


@compiled
def share_out(counters: Integers) -> None:
    """Continue after the division of the time between islands."""
    counters[CYCLES] += SPLIT_TO_AIM
    counters[_BEGUN] = counters[_POINTS] = 0


@compiled
def aim(counters: Integers) -> None:
    """Continue with the first cycle of a population in which limits are compared."""
    counters[CYCLES] += AIMED


@compiled
def begin(delays: Integers, counters: Integers, pending: bool) -> int:
    """Begin a generation; return its cycle.

    With ``pending``, a pass over the population follows. Without it, the next generation may begin
    once this one is planned.
    """
    begun: int = counters[CYCLES] + BEGIN
    planned = planning(delays[_CHILDREN])
    counters[GENERATIONS] += 1
    counters[BREED] += planned - 1
    if pending:
        counters[_PASS] = passing(begun, delays[_CHILDREN])
    else:
        counters[CYCLES] = begun + planned
    return begun


@compiled
def bred(counters: Integers, begun: int, number: int, points: int) -> int:
    """Return the cycle from which a child's points are offered if all are taken immediately."""
    child: int = child_begun(plan(begun, number), counters[_BEGUN], counters[_POINTS])
    counters[_BEGUN], counters[_POINTS] = child, points
    return point_offered(child, 0)


@compiled
def finish(counters: Integers) -> None:
    """Begin to collect the last generation."""
    counters[_PASS] = passing(counters[CYCLES] + BEGIN, 0)


@compiled
def collect(delays: Integers, counters: Integers) -> None:
    """Continue with the cycle in which a completely sorted population can be read."""
    counters[_FREE] = counters[CYCLES] = ready(counters[_FREE], delays[_POPULATION])
    counters[SORT] += delays[_POPULATION]


@compiled
def next_island(counters: Integers) -> None:
    """Continue with the aim of the next island."""
    counters[CYCLES] += NEXT_ISLAND


@compiled
def merge(delays: Integers, counters: Integers, passed: int) -> None:
    """Continue with the first cycle of the population merged from two islands.

    ``passed``: total number of members that the second island passes in the sorter.
    """
    population = delays[_POPULATION]
    merged = counters[CYCLES] + MERGED[0]
    counters[SORT] += passing_over(2 * population, population, passed) + population
    counters[_FREE] = merged + merging(population, passed)
    counters[CYCLES] = max(merged + MERGED[1] + AIMED, counters[_FREE])


@compiled
def end(counters: Integers) -> None:
    """Continue with the end of the run."""
    counters[CYCLES] += END


def totals(counters: Integers) -> dict[str, Any]:
    """Return generations, cycles, and the cycles of each unit, by name."""
    names = ("cycles", "generations", *UNITS)
    return dict(zip(names, counters[: len(names)].tolist(), strict=True))
