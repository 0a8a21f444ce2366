"""The compiled order of a population: members are sorted by their keys.

Each function returns the number of slots that new ones pass in the sorter, which determines its
cycles.
"""

from __future__ import annotations

import numpy as np

from pathgene.sim.model.compiled import allocating, compiled
from pathgene.sim.model.planner.walk import Integers


__all__ = ["join", "merge", "place"]


@compiled
def place(order: Integers, keys: Integers, slot: int, used: int) -> int:
    """Insert a slot after its equals in the first ``used``; return the number that follow it."""
    rank = used
    while rank > 0 and keys[order[rank - 1]] > keys[slot]:
        order[rank] = order[rank - 1]
        rank -= 1
    order[rank] = slot
    return used - rank


@compiled
def join(order: Integers, keys: Integers, kept: Integers, used: int, stay: int) -> int:
    """Insert the sorted slots that stay before their equals in the first ``used`` slots.

    Return the total number of the ``used`` slots that follow each.
    """
    passed, other = 0, used - 1
    for i in range(stay - 1, -1, -1):
        while other >= 0 and keys[order[other]] >= keys[kept[i]]:
            order[other + i + 1] = order[other]
            other -= 1
        order[other + i + 1] = kept[i]
        passed += used - 1 - other
    return passed


@allocating
def merge(
    paths: Integers, points: Integers, keys: Integers, order: Integers, population: int
) -> int:
    """Make the population of island 0 from the best of all islands, an equal number from each.

    Return the total number of earlier slots that each slot passes.
    """
    islands = len(paths)
    each = population // islands
    merged = np.zeros((population, paths.shape[2], 4), dtype=np.int64)
    lengths, values = np.zeros(population, dtype=np.int64), np.zeros(population, dtype=np.int64)
    for i in range(islands):
        for rank in range(each):
            to, slot = i * each + rank, order[i, rank]
            merged[to], lengths[to], values[to] = paths[i, slot], points[i, slot], keys[i, slot]
    passed = 0
    for slot in range(population):
        paths[0, slot], points[0, slot], keys[0, slot] = merged[slot], lengths[slot], values[slot]
        passed += place(order[0], keys[0], slot, slot)
    return passed
