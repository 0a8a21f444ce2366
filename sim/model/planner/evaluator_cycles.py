"""Cycles between the units of the evaluator of paths, as in the gateware.

The scorer takes a point in every slot of two cycles, entry and exit included. It does not take a
path while sixteen are inside. From then on all takes fixed numbers of cycles, but for two queues:
of the walker, and of the keys, which leave in the order of the paths.
:func:`pathgene.sim.model.planner.cycles.enter` has the maxima that follow.
"""

from __future__ import annotations


__all__ = ["DECISION", "KEY", "PLACES", "QUEUE"]

#: Paths that may be inside.
PLACES = 16
#: Cycles from a score to its decision, from there to the offer of the first segment to the walker,
#: and from a decision or the result of a walk to the key.
DECISION, QUEUE, KEY = 1, 3, 3
