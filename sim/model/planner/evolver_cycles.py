"""Cycles of the evolver, equal to those of the gateware; none depends on what is drawn.

A generation of n children begins in cycle b, with populations of N members. ::

    planned   b + 8 n + 6    ready, if none was pending
    passing   b + 8 n + 7    first of N cycles in which keys are not taken
    last                     last of these, or that of the last pending child's key if it is later
    opens     last + N + 2   keys are taken again; from that last key on they were not
    ready     last + N + 4

After a ``finish`` in cycle f the first of the N cycles is f + 2; the rest is the same. The cycle of
a key is the one in which ``evaluated`` transfers.

Points. Child j can be begun from b + 13 + 8 j on, and a child takes a cycle for each point, start
and goal included; the next one follows at once. So, with T(i) the cycle in which child i is begun,
p(i) its points, and children counted on through all generations::

    T(i) = max(b + 13 + 8 j, T(i - 1) + p(i - 1))

and its points are offered in cycles T(i) + 9, T(i) + 10, and so on, if nothing holds them up. At
most 16 points are on their way or on offer. So once a point has waited for 8 cycles, a later one
is made late: in the cycle after the sixteenth point before it is taken, to be offered 8 cycles
later. A receiver that takes a point every two cycles at most takes it 32 cycles after that
sixteenth one at the earliest: it has been on offer for 23 cycles by then. So such a receiver,
whatever pauses it makes, takes all points in the same cycles as if each was offered in the cycle
that follows from T. It must have room for five children that it has no points of yet.
"""

from __future__ import annotations

from sim.model.planner.compiled import inlined


__all__ = [
    "PLAN",
    "begun",
    "merging",
    "moving",
    "offered",
    "opening",
    "passing",
    "plan",
    "planning",
    "settling",
    "storing",
]

#: Cycles of a plan.
PLAN = 8
#: Cycles from the begin of a generation until the builder can take its first plan, without draws.
_FIRST_PLAN = 13
#: Cycles from the begin of a child to the offer of its first point.
_BUILDER = 9


@inlined
def plan(begin: int, child: int) -> int:
    """Return the first cycle in which a child of a generation can be begun, from 0 on."""
    return begin + _FIRST_PLAN + PLAN * child


@inlined
def begun(plan: int, begun_before: int, points_before: int) -> int:
    """Return the cycle in which a child is begun.

    Parameters
    ----------
    plan : int
        Its :func:`plan`.
    begun_before, points_before : int
        Cycle in which the child before was begun, and its points, start and goal included.
    """
    return max(plan, begun_before + points_before)


@inlined
def offered(begun: int, point: int) -> int:
    """Return the cycle in which a point of a child, from 0 on, is offered if none is held up."""
    return begun + _BUILDER + point


@inlined
def planning(children: int) -> int:
    """Return the cycles from the begin of a generation to ``ready``, if none is pending."""
    return PLAN * children + 6


def passing(since: int, population: int, children: int | None = None) -> tuple[int, int]:
    """Return the first and the last cycle of a pass, in which keys are not taken.

    Parameters
    ----------
    since : int
        Cycle of ``begin``, or of ``finish``.
    population : int
    children : int, optional
        Those planned before the pass; none after ``finish``.
    """
    first = since + 2 if children is None else since + planning(children) + 1
    return first, first + population - 1


@inlined
def opening(last: int, population: int) -> int:
    """Return the cycle from which on keys are taken again.

    Parameters
    ----------
    last : int
        The last cycle of the pass, or the cycle of the last child's key if that is later.
    population : int
    """
    return last + population + 2


@inlined
def storing(population: int) -> int:
    """Return the cycles from ``last``, as in :func:`opening`, to ``ready``."""
    return population + 4


@inlined
def settling(population: int) -> int:
    """Return the cycles from the ``store`` of a first population to ``ready``."""
    return population + 3


@inlined
def moving(population: int) -> int:
    """Return the cycles in which a population moves from the sorter to the memory of ranks."""
    return population + 2


@inlined
def merging(population: int) -> int:
    """Return the cycles from ``merge`` to ``ready``."""
    return 2 * population + 1 + storing(population)
