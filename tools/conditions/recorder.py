"""Vectors of decisions: the value of each condition, and the outcome."""

from __future__ import annotations

from typing import Any

import numpy as np

from tools.conditions.decisions import BEGIN, END, NOTE, ONE, PICK
from tools.conditions.pairs import Vector


__all__ = ["Recorder"]


class Recorder:
    """Keeps every vector of every decision once; any thread may call it.

    A comparison of arrays is evaluated element by element and has no outcome: it is left out.

    Attributes
    ----------
    vectors : dict
        Vectors by the key of the decision.
    arrays : set
        Keys of decisions that are comparisons of arrays.
    choices : set
        Keys of decisions whose outcome is no truth but an operand, as in ``name or number``.
    """

    def __init__(self) -> None:
        self.vectors: dict[str, set[Vector]] = {}
        self.arrays: set[str] = set()
        self.choices: set[str] = set()

    def names(self) -> dict[str, Any]:
        """Return the functions that an instrumented module calls, by their names there."""
        vectors, arrays, choices = self.vectors, self.arrays, self.choices

        def begin(conditions: int) -> list[Any]:
            return [None] * conditions

        def note(vector: list[Any], number: int, value: Any) -> Any:
            vector[number] = _ARRAY if getattr(value, "shape", ()) else bool(value)
            return value

        def end(key: str, vector: list[Any], value: Any) -> Any:
            if _ARRAY in vector:
                arrays.add(key)
            else:
                vectors.setdefault(key, set()).add((tuple(vector), bool(value)))
            return value

        def pick(key: str, vector: list[Any], value: Any) -> Any:
            if isinstance(value, bool | np.bool_):
                return end(key, vector, value)
            choices.add(key)
            # Python does not ask for the truth of the last operand.
            vector[-1] = None
            end(key, vector, False)
            return value

        def one(key: str, value: Any) -> Any:
            if getattr(value, "shape", ()):
                arrays.add(key)
            else:
                truth = bool(value)
                vectors.setdefault(key, set()).add(((truth,), truth))
            return value

        return {BEGIN: begin, NOTE: note, END: end, PICK: pick, ONE: one}


_ARRAY = object()
