"""Dijkstra's shortest paths in a graph of few links, compiled.

SciPy's function finds the same, but its modules take longer to load than all searches of a plan.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.jit import allocating, compiled


__all__ = ["Graph", "shortest_paths"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]


class Graph(NamedTuple):
    """Links between points, in the order of the points that they leave.

    Parameters
    ----------
    costs : (m,) float64
        Cost of each link, 0 or more; nothing passes a link of infinite cost.
    heads : (m,) int32
        The point that each link reaches.
    firsts : (n + 1,) int32
        First link of each of the n points, and the number of links.
    """

    costs: Floats
    heads: Integers
    firsts: Integers

    @classmethod
    def of_pairs(
        cls, tails: NDArray[np.integer], heads: NDArray[np.integer], costs: Floats, points: int
    ) -> Graph:
        """Return the graph of links from ``tails`` to ``heads``, in any order."""
        order = np.argsort(tails, kind="stable")
        firsts = np.searchsorted(tails[order], np.arange(points + 1)).astype(np.int32)
        return cls(costs[order], heads[order].astype(np.int32), firsts)


@allocating
def shortest_paths(
    costs: Floats, heads: Integers, firsts: Integers, source: int
) -> tuple[Floats, Integers]:
    """Return the cost of the cheapest path from ``source`` to each point, and its last link.

    The parameters are the fields of a :class:`Graph`.

    Returns
    -------
    costs : (n,) float64
        Infinite for a point that no path reaches.
    before : (n,) int32
        Previous point on the path to each point; -1 for ``source`` and points that are not reached.
    """
    points = len(firsts) - 1
    found = np.full(points, math.inf)
    before = np.full(points, -1, dtype=np.int32)
    # A binary heap of points, the cheapest first, and the place of each point in it.
    heap = np.empty(points, dtype=np.int32)
    place = np.full(points, -1, dtype=np.int32)
    found[source] = 0.0
    heap[0] = source
    place[source] = 0
    size = 1
    while size > 0:
        point = heap[0]
        cost = found[point]
        size -= 1
        if size > 0:
            _sink(heap, place, found, heap[size], size)
        for link in range(firsts[point], firsts[point + 1]):
            head = heads[link]
            there = cost + costs[link]
            if there < found[head]:
                # A point that has left the heap is never cheaper by another way.
                if place[head] < 0:
                    place[head] = size
                    size += 1
                found[head] = there
                before[head] = point
                _rise(heap, place, found, head)
    return found, before


@compiled
def _sink(heap: Integers, place: Integers, found: Floats, point: int, size: int) -> None:
    """Put a point into the first place of a heap, and move cheaper points up."""
    at = 0
    while True:
        child = 2 * at + 1
        if child >= size:
            break
        if child + 1 < size and found[heap[child + 1]] < found[heap[child]]:
            child += 1
        if found[heap[child]] >= found[point]:
            break
        heap[at] = heap[child]
        place[heap[at]] = at
        at = child
    heap[at] = point
    place[point] = at


@compiled
def _rise(heap: Integers, place: Integers, found: Floats, point: int) -> None:
    """Move a point up in a heap, from its place, past dearer points."""
    at = place[point]
    while at > 0:
        parent = (at - 1) // 2
        if found[heap[parent]] <= found[point]:
            break
        heap[at] = heap[parent]
        place[heap[at]] = at
        at = parent
    heap[at] = point
    place[point] = at
