"""Payloads between the units of the evaluator."""

from amaranth.lib import data

from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.population_layouts import head_layout
from pathgene.hdl.planner.walker.layouts import chord_layout
from pathgene.hdl.protocol.planner import VALUE_BITS


__all__ = [
    "PLACES",
    "PLACE_BITS",
    "decision_layout",
    "kept_layout",
    "row_bits_of",
    "stored_layout",
    "taken_layout",
]

#: Paths that may be inside, a power of two.
PLACES = 16
PLACE_BITS = 4


def row_bits_of(max_waypoints: int) -> int:
    """Return the width of a row of a path: its points beginning with the start, and its exit."""
    return (max_waypoints + 2).bit_length()


def taken_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a point in the cycle in which it is taken: ``valid``, with the rest."""
    return data.StructLayout({"valid": 1, "point": point_layout(coordinate_bits, altitude_bits)})


def stored_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a row: a point, and the chord there."""
    sizes = (coordinate_bits, altitude_bits)
    return data.StructLayout({"point": point_layout(*sizes), "chord": chord_layout(*sizes)})


def kept_layout(slot_bits: int, length_bits: int) -> data.StructLayout:
    """Return the layout of a path kept: place, head, length, and ``enters``.

    ``enters``: there is a chord at the start.
    """
    return data.StructLayout(
        {
            "place": PLACE_BITS,
            "head": head_layout(slot_bits),
            "length": length_bits,
            "enters": 1,
        }
    )


def decision_layout(slot_bits: int, length_bits: int) -> data.StructLayout:
    """Return the layout of a decision on a path: ``valid`` for a cycle, with the rest.

    ``walked``: the path is, and its key waits for it. ``infeasible`` and ``value`` as in its score.
    """
    return data.StructLayout(
        {
            "valid": 1,
            "walked": 1,
            "infeasible": 1,
            "value": VALUE_BITS,
            "path": kept_layout(slot_bits, length_bits),
        }
    )
