"""Cycles of the evolver, as in the gateware.

The cycles of a plan do not depend on the draws; the cycles of the sorter depend on its members. A
member that is taken in cycle t and passes k members is inserted in the cycles up to t + 1 + k; from
t + 2 + k on, the sorter is *free* and can take the next one. In a first population, the worst
member is dropped for each surplus member that is better, and counts as passed. After a ``store`` in
cycle s, such a population is complete and keys are taken again in cycle s + 1 + N, or when the
sorter is free.

A generation of n children begins in cycle b, with populations of N members. ::

    planned   b + 8 n + 6    ready, if none was pending
    first     b + 8 n + 7    keys are no longer taken
    passed    the later of `first` and the first cycle in which the sorter is free, plus N, plus
              1 + k for each member that stays and passes k children: keys are taken again
    sorted    the later of `passed` and the first cycle after the insertion of the last child
    ready     sorted + N + 1: keys are taken again; none was since the key of the last child

After a ``finish`` in cycle f, ``first`` is f + 2, as after a ``merge``, which passes over 2 N
ranks, of which N stay; the rest is the same. The cycle of a key is the cycle in which ``evaluated``
transfers.

Points. Child j can be begun in cycle b + 13 + 8 j or later, and a child takes one cycle per point,
including start and goal; the next child follows immediately. So, where T(i) is the cycle in which
child i is begun, p(i) its number of points, and children are counted through all generations::

    T(i) = max(b + 13 + 8 j, T(i - 1) + p(i - 1))

and its points are offered in cycles T(i) + 9, T(i) + 10, and so on, if nothing stalls them. At most
16 points are in flight or being offered. Once a point has waited for 8 cycles, a later one is late:
it is made in the cycle after the sixteenth point before it is taken, and offered 8 cycles later. A
receiver takes it at least 16 cycles after that sixteenth point, when it has been on offer for 7
cycles. Therefore a receiver, whatever its pauses, takes all points in the same cycles as if each
were offered in the cycle that follows from T. It must have room for five children of which no point
has arrived.
"""

from __future__ import annotations

from pathgene.sim.model.compiled import inlined


__all__ = [
    "PLAN",
    "begun",
    "inserted",
    "inserting",
    "merging",
    "offered",
    "passing",
    "passing_over",
    "plan",
    "planning",
    "ready",
    "settled",
]

#: Cycles that a plan takes.
PLAN = 8
#: Cycles from the beginning of a generation until the builder can take its first plan, without
#: draws.
_FIRST_PLAN = 13
#: Cycles from the beginning of a child to the offer of its first point.
_BUILDER = 9


@inlined
def plan(begin: int, child: int) -> int:
    """Return the first cycle in which a child of a generation can be begun, counted from 0."""
    return begin + _FIRST_PLAN + PLAN * child


@inlined
def begun(plan: int, begun_before: int, points_before: int) -> int:
    """Return the cycle in which a child is begun.

    Parameters
    ----------
    plan : int
        Its :func:`plan`.
    begun_before, points_before : int
        Cycle in which the previous child was begun, and its number of points, including start and
        goal.
    """
    return max(plan, begun_before + points_before)


@inlined
def offered(begun: int, point: int) -> int:
    """Return the cycle in which a point of a child, counted from 0, is offered without stalls."""
    return begun + _BUILDER + point


@inlined
def planning(children: int) -> int:
    """Return the cycles from the beginning of a generation to ``ready``, if none is pending."""
    return PLAN * children + 6


@inlined
def inserting(passed: int) -> int:
    """Return the cycles of the insertion of a member that passes ``passed`` members."""
    return 1 + passed


@inlined
def inserted(taken: int, passed: int) -> int:
    """Return the first cycle in which the sorter has finished with a member taken in ``taken``."""
    return taken + 1 + inserting(passed)


@inlined
def passing(since: int, children: int) -> int:
    """Return the first cycle of a pass, during which keys are not taken.

    Parameters
    ----------
    since : int
        Cycle of ``begin``, or of ``finish`` or ``merge``.
    children : int
        Children planned before the pass; none after ``finish`` and ``merge``.
    """
    return since + (planning(children) + 1 if children else 2)


@inlined
def passing_over(ranks: int, stay: int, passed: int) -> int:
    """Return the cycles of a pass, counted from when it has begun and the sorter is free.

    Parameters
    ----------
    ranks, stay : int
        Number of ranks that are passed over, and number of members that stay.
    passed : int
        Total number of members that these pass in the sorter.
    """
    return ranks + stay * inserting(0) + passed


@inlined
def ready(is_sorted: int, population: int) -> int:
    """Return the cycle of ``ready``, in which keys are taken again.

    Parameters
    ----------
    is_sorted : int
        The first cycle after the pass in which the sorter has finished with the last child.
    """
    return is_sorted + population + 1


@inlined
def settled(store: int, free: int, population: int) -> int:
    """Return the cycle of ``ready`` after ``store``, if the sorter is free starting in ``free``."""
    return max(store + 1, free) + population


@inlined
def merging(population: int, passed: int) -> int:
    """Return the cycles from ``merge`` to ``ready``; ``passed`` as for :func:`passing_over`."""
    return ready(passing(0, 0) + passing_over(2 * population, population, passed), population)
