"""Layouts of the collision checker's results."""

from amaranth.lib import data

from hdl.config import Config


__all__ = ["count_layout", "verdict_layout"]

#: Width of a count of cycles.
CYCLES_BITS = 24


def verdict_layout(config: Config) -> data.StructLayout:
    """Return the layout of the verdict on one path.

    ``collision`` (else the path is clear); ``segment``, ``x``, ``y`` of the first colliding cell,
    in cells of its map, and ``coarse`` if that is the coarse map: these four are 0 without a
    collision. ``cells`` from the path's first to the colliding one; ``reads``, addresses given to
    the memory; ``cycles``; and the number of ``entries`` in the stream of counts
    (:func:`count_layout`).
    """
    return data.StructLayout(
        {
            "collision": 1,
            "segment": config.segment_bits,
            "x": config.coordinate_bits,
            "y": config.coordinate_bits,
            "coarse": 1,
            "cells": config.path_cells_bits,
            "reads": config.path_cells_bits + 1,
            "cycles": CYCLES_BITS,
            "entries": config.segment_bits + 1,
        }
    )


def count_layout(config: Config) -> data.StructLayout:
    """Return the layout of one segment's colliding cells: those of terrain, and blocked ones."""
    return data.StructLayout(
        {
            "segment": config.segment_bits,
            "terrain": config.segment_cells_bits,
            "nofly": config.segment_cells_bits,
        }
    )
