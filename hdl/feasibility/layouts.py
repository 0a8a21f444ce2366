"""Layouts of the collision checker's results."""

from amaranth.lib import data


__all__ = ["count_layout", "verdict_layout"]

#: Width of a count of cycles.
CYCLES_BITS = 24


def verdict_layout(
    coordinate_bits: int, segment_bits: int, path_cells_bits: int
) -> data.StructLayout:
    """Return the layout of the verdict on one path.

    ``collision`` (else the path is clear); ``segment``, ``x``, ``y`` of the first colliding cell,
    in cells of its map, and ``coarse`` if that is the coarse map: these four are 0 if there is no
    collision. ``cells`` from the path's first to the colliding one; ``reads``, addresses given to
    the memory; ``cycles``; and the number of ``entries`` in the stream of counts
    (:func:`count_layout`).
    """
    return data.StructLayout(
        {
            "collision": 1,
            "segment": segment_bits,
            "x": coordinate_bits,
            "y": coordinate_bits,
            "coarse": 1,
            "cells": path_cells_bits,
            "reads": path_cells_bits + 1,
            "cycles": CYCLES_BITS,
            "entries": segment_bits + 1,
        }
    )


def count_layout(coordinate_bits: int, segment_bits: int) -> data.StructLayout:
    """Return the layout of one segment's counts of colliding cells: terrain and blocked.

    Each is from 0 to the cells along an edge of the map.
    """
    return data.StructLayout(
        {"segment": segment_bits, "terrain": coordinate_bits + 1, "nofly": coordinate_bits + 1}
    )
