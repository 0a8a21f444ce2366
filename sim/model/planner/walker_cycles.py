"""Cycles of the walker of paths, as in the gateware.

A path costs the sum of the costs of its segments and chords, in the order in which they are walked,
all after a first collision included: one cycle on a hit of the memo, otherwise a cycle for each
group of as many corners as there are lanes. Paths follow each other without a gap. The memo is as
in the definition, looked up and filled segment by segment in this order; lengths of pipelines
change neither its answers nor the sum, only the delay of the first segment and of the last result.
"""

from __future__ import annotations

from collections.abc import Iterable

from pathgene.sim.model.planner.compiled import inlined


__all__ = ["FRONT", "MEMO_HIT", "back", "cost", "walked", "walking"]

#: Cycles of a segment that the memo answers.
MEMO_HIT = 1

#: Cycles from the offer of a path's first segment to its launch.
FRONT = 5


@inlined
def walking(corners: int, lanes: int) -> int:
    """Return the cycles of a segment of ``corners`` corners that the memo does not answer."""
    return (corners + lanes - 1) // lanes


def back(lanes: int, memory_latency: int) -> int:
    """Return the cycles from the last one of a path's last segment to the path's result."""
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
