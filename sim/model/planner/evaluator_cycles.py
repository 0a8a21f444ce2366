"""Cycles of the evaluator of paths, equal to those of the gateware."""

from __future__ import annotations


__all__ = ["DECISION", "KEY", "PLACES", "QUEUE"]

#: Paths that may be inside.
PLACES = 16
#: Cycles from a score to its decision, from there to the offer of the first segment to the walker,
#: and from a decision or the result of a walk to the key.
DECISION, QUEUE, KEY = 1, 3, 3
