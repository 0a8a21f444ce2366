"""Depths of the checker's queues, which its software model needs, too. Pure Python."""

from __future__ import annotations

from pathgene.hdl.config import Config


__all__ = ["count_depth"]

_FEWEST_COUNTS = 16


def count_depth(config: Config) -> int:
    """Return the number of counts of segments that can wait, segments in flight included.

    A power of two. There is room for one count of each segment of a path, and for all one-cell
    segments that can be in flight in a walker.
    """
    return max(_FEWEST_COUNTS, 1 << (config.max_segments - 1).bit_length())
