"""Estimated cycles of the units, until the gateware fixes them: the one place that knows them."""

from __future__ import annotations

from sim.model.planner.compiled import compiled, inlined


__all__ = ["FILL", "MEMO_HIT", "SEGMENT", "VISITS_PER_PASS", "overlapped", "walking"]

#: Cycles of the scorer for a segment: one for its straight piece, one for its arc.
SEGMENT = 2
#: Cycles of the walker for a segment that the memo answers.
MEMO_HIT = 1
#: Cycles from the last child of a generation through all units into the sorted population, and from
#: there to the first child of the next one.
FILL = 40
#: Cycles of a pass of the wavefront over its blocks.
VISITS_PER_PASS = 1024


@inlined
def walking(corners: int, lanes: int) -> int:
    """Return the cycles of a segment of so many corners that the memo does not answer."""
    return (corners + lanes - 1) // lanes


@compiled
def overlapped(segments: int, walker: int) -> int:
    """Return the cycles of a generation, or of a set of seeds.

    Breeding is hidden behind the scorer, and scorer and walker work on different children: the
    slower one decides.
    """
    return max(SEGMENT * segments, walker) + FILL
