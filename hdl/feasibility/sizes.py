"""Numbers of the checker that its software model needs as well. Pure Python, without Amaranth."""

from __future__ import annotations

from hdl.config import Config


__all__ = ["count_places"]

_COUNTS = 16


def count_places(config: Config) -> int:
    """Return how many counts of segments can wait, those of segments under way included.

    A power of two. There is room for one of each segment of a path, and for as many as segments of
    a cell each can be under way in a walker.
    """
    return max(_COUNTS, 1 << (config.max_segments - 1).bit_length())
