"""Payloads between the units of the walker."""

from amaranth.hdl import ShapeLike, signed
from amaranth.lib import data


__all__ = [
    "MARKS",
    "chord_layout",
    "corner_layout",
    "identity_layout",
    "segment_request_layout",
    "walked_layout",
]

#: Marks of a segment or chord in its path: ``begins`` and ``last``, ``chord``, and ``first`` (the
#: path's hits end with its first colliding segment or chord).
MARKS = data.StructLayout({"begins": 1, "last": 1, "chord": 1, "first": 1})


def corner_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a corner of the map and an altitude there."""
    return data.StructLayout(
        {"x": coordinate_bits, "y": coordinate_bits, "altitude": altitude_bits}
    )


def chord_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of the chord at a point; usually, none is ``present``."""
    corner = corner_layout(coordinate_bits, altitude_bits)
    return data.StructLayout({"present": 1, "start": corner, "stop": corner})


def identity_layout(row_bits: int) -> data.StructLayout:
    """Return the layout of a segment's marks, its memo row, and whether the memo answers."""
    return data.StructLayout({"marks": MARKS, "row": row_bits, "answered": 1})


def segment_request_layout(
    coordinate_bits: int, altitude_bits: int, identity: ShapeLike
) -> data.StructLayout:
    """Return the layout of a segment by its ends, with its ``identity``."""
    corner = corner_layout(coordinate_bits, altitude_bits)
    return data.StructLayout({"start": corner, "stop": corner, "identity": identity})


def walked_layout(
    coordinate_bits: int, altitude_bits: int, identity: ShapeLike
) -> data.StructLayout:
    """Return the layout of the results of a walk, which are ``valid`` for one cycle.

    ``hits``: number of colliding corners. ``margin``: minimum altitude above the ground, in steps.
    """
    return data.StructLayout(
        {
            "valid": 1,
            "hits": coordinate_bits + 1,
            "margin": signed(altitude_bits + 1),
            "identity": identity,
        }
    )
