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

#: Uniform draws of which the best is a parent's rank: of the first parent from bit 0 of the
#: selection word on, those of the second above them.
PARENT_DRAWS = 4
#: Width of the draw of a survivor, above those of the parents.
SURVIVOR_BITS = 24
#: Out of so many mutations the first perturb, those from each of these numbers on insert, delete
#: and settle.
INSERT, DELETE, SETTLE, MUTATIONS = 8, 11, 14, 18
#: First bit in the mutation word, and width: of operator, place, size, and of where parents are
#: cut; of the offset in x, above which are those in y and altitude.
OPERATOR, PLACE, SIZE = (0, 8), (8, 8), (16, 4)
OFFSETS, CUT = (20, 14), (62, 2)
