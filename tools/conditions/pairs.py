"""Conditions that a pair of vectors shows to decide an outcome alone."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence

from tools.conditions.decisions import Decision


__all__ = ["Vector", "lacking"]

#: Value of each condition, None if it was not evaluated, and the outcome.
Vector = tuple[Sequence[bool | None], bool]


def lacking(decision: Decision, vectors: Collection[Vector], *, is_choice: bool) -> list[int]:
    """Return the conditions of a decision that have no pair of vectors.

    Two vectors are a pair of a condition if they differ in it, in the outcome, and in no other
    condition that was evaluated in both. A choice, as ``name or number``, has no outcome: each of
    its operands but the last must have been true and false.
    """
    numbers = range(len(decision.conditions))
    if is_choice:
        seen = {(i, value) for values, _ in vectors for i, value in enumerate(values)}
        return [i for i in numbers[:-1] if not {(i, True), (i, False)} <= seen]
    false, true = ([v for v, outcome in vectors if outcome is each] for each in (False, True))
    found = set()
    for one, other in itertools.product(false, true):
        differing = [
            i for i in numbers if None not in (one[i], other[i]) and one[i] is not other[i]
        ]
        if len(differing) == 1:
            found.add(differing[0])
    return [i for i in numbers if i not in found]
