"""Cycles of the paths of a first population, equal to those of the gateware.

All paths are made one by one: each begins when the goal of the one before is taken, the first when
they are launched.
"""

from __future__ import annotations

from sim.model.planner.compiled import inlined
from sim.model.planner.wavefront_cycles import WAYPOINT, seeded


__all__ = ["MEMBER", "SEED", "member_offered", "seed_begun", "seed_offered"]

#: Cycles from the launch, or from the goal of the path before, to the offer of a member's first
#: point.
MEMBER = 9
#: Cycles from the begin of a seed to the offer of its first point: two words, then a waypoint and
#: its queue.
SEED = 2 + WAYPOINT + 1


@inlined
def member_offered(free: int, dropped: int) -> int:
    """Return the cycle in which the first point of a member is offered, and all others from then.

    Parameters
    ----------
    free : int
        Cycle of the launch, or in which the goal of the path before is taken.
    dropped : int
        Waypoints that it loses.
    """
    return free + MEMBER + dropped


def seed_begun(free: int, before: int | None, longest: int) -> int:
    """Return the cycle in which a seed begins.

    Parameters
    ----------
    free : int
        Cycle of the launch, or in which the goal of the path before is taken.
    before : int or None
        Cycle in which the seed before began, if there is one.
    longest : int
        The greatest number of waypoints of a seed: so many words and one are taken.
    """
    return free + 1 if before is None else max(free + 1, before + seeded(longest) + 1)


@inlined
def seed_offered(begun: int) -> int:
    """Return the cycle in which the first point of a seed is offered, and all others from then."""
    return begun + SEED
