"""Sizes of the checker that its software model shares. Pure Python, without Amaranth."""

from __future__ import annotations

from hdl.config import Config


__all__ = ["count_places"]

_COUNTS = 16


def count_places(config: Config) -> int:
    """Return the capacity of the queue of segment counts, segments in flight included.

    The capacity is a power of two. It suffices for every segment of a path, and for all segments of
    one cell that a walker can have in flight.
    """
    return max(_COUNTS, 1 << (config.max_segments - 1).bit_length())
