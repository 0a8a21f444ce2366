"""Cycles of the paths of a first population, as in the gateware.

All paths are made one by one: each begins when the goal of the previous one is taken, the first
when they are launched. The words of a seed, at most 17, are taken by then: its first point is not
even offered before.
"""

from __future__ import annotations

from pathgene.sim.model.planner.compiled import inlined
from pathgene.sim.model.planner.wavefront_cycles import WAYPOINT


__all__ = ["MEMBER", "SEED", "member_offered", "seed_offered"]

#: Cycles from the launch, or from the goal of the previous path, to the offer of a member's first
#: point.
MEMBER = 9
#: The same of a seed: a cycle until it begins, two words, then a waypoint and its queue.
SEED = 1 + 2 + WAYPOINT + 1


@inlined
def member_offered(free: int, dropped: int) -> int:
    """Return the cycle from which the points of a member are offered.

    Parameters
    ----------
    free : int
        Cycle of the launch, or in which the goal of the previous path is taken.
    dropped : int
        Waypoints that it loses.
    """
    return free + MEMBER + dropped


@inlined
def seed_offered(free: int) -> int:
    """Return the same of a seed."""
    return free + SEED
