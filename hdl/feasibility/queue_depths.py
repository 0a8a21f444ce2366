"""Depths of the checker's queues, also needed by its software model. Pure Python."""

from __future__ import annotations

from pathgene.hdl.config import Config


__all__ = ["count_depth"]

_FEWEST_COUNTS = 16


def count_depth(config: Config) -> int:
    """Return the number of segment counts that can wait, including segments in flight.

    It is a power of two, with room for one count of each segment of a path, and for all one-cell
    segments that can be in flight in a walker.
    """
    return max(_FEWEST_COUNTS, 1 << (config.max_segments - 1).bit_length())
