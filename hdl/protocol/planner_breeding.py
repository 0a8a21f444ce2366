"""Breeding by the planner core: its odds, and the places of its draws in the random words.

Gateware and models read them here. Pure Python.
"""

from __future__ import annotations


__all__ = [
    "CUT",
    "DELETE",
    "INSERT",
    "MUTATIONS",
    "OFFSETS",
    "OPERATOR",
    "PARENT_DRAWS",
    "PLACE",
    "SETTLE",
    "SIZE",
    "SURVIVOR_BITS",
]

#: Uniform draws, the best of which is a parent's rank. The first parent's draws begin at bit 0 of
#: the selection word; the second parent's are above them.
PARENT_DRAWS = 4
#: Width of the draw of a survivor, above the parents' draws.
SURVIVOR_BITS = 24
#: Out of ``MUTATIONS`` equally likely draws, the first perturb; the draws from each of the first
#: three numbers on insert, delete and settle.
INSERT, DELETE, SETTLE, MUTATIONS = 8, 11, 14, 18
#: First bit in the mutation word, and width, of the draws of the operator, the place, the size, the
#: offset in x (with y and altitude above it), and the cut of the parents.
OPERATOR, PLACE, SIZE = (0, 8), (8, 8), (16, 4)
OFFSETS, CUT = (20, 14), (62, 2)
