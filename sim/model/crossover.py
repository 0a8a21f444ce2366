"""Crossover: two parents swap their tails past the middle."""

from __future__ import annotations

from collections.abc import Sequence


__all__ = ["crossover"]


def crossover(parents: Sequence[list[int]]) -> list[list[int]]:
    """Return the children of ``parents`` joined in a ring (*allaire-2008*, section 4.5).

    Module ``i`` takes parents ``i`` and ``i + 1``, the last one the first again, so that each
    parent is used twice. Child ``2 i`` has the head of ``i`` and the tail of ``i + 1``; child
    ``2 i + 1`` the other two parts. The middle is rounded down, so that lengths stay within 2..max
    for any parents.

    Parameters
    ----------
    parents : sequence of list of int
        Packed waypoints of each parent.
    """
    heads = [path[: len(path) // 2] for path in parents]
    tails = [path[len(path) // 2 :] for path in parents]
    children = []
    for i in range(len(parents)):
        j = (i + 1) % len(parents)
        children += [heads[i] + tails[j], heads[j] + tails[i]]
    return children
