"""Payloads of the streams of the collision checker."""

from amaranth.lib import data

from hdl.config import Config


__all__ = ["count_layout", "verdict_layout"]

#: Width of a number of cycles.
CYCLES_BITS = 24


def verdict_layout(config: Config) -> data.StructLayout:
    """What became of one path.

    ``collision`` (else the path is free), ``segment``, ``x``, ``y`` (cell that hit first, in the
    cells of its map), ``coarse`` (it is one of the coarse map); these four are 0 without collision.
    ``cells`` from the path's first to the colliding one, ``reads`` that the memory was given,
    ``cycles``, and the number of ``entries`` in the stream of counts (:func:`count_layout`).
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
    """Colliding cells of one segment that has any: those of terrain, and blocked ones."""
    return data.StructLayout(
        {
            "segment": config.segment_bits,
            "terrain": config.segment_cells_bits,
            "nofly": config.segment_cells_bits,
        }
    )
