"""Numbers of the checker that its software model needs as well. Pure Python, without Amaranth."""

from __future__ import annotations

from hdl.config import Config


__all__ = ["COLUMN_TASKS", "SPAN_STAGES", "VERDICT_PLACES", "count_places"]

#: Verdicts that can wait to be transferred, those of paths under way included: as many as paths of
#: a segment and a cell each can be under way in a walker, so that they follow each other at full
#: rate.
VERDICT_PLACES = 8

#: Clocks from the transfer of a point to the offer of the segment that it ends, in the hierarchical
#: build: stages, a segment each.
SPAN_STAGES = 10

#: Columns of the hierarchical build between their test in the coarse map and their walk.
COLUMN_TASKS = 16

_COUNTS = 16


def count_places(config: Config) -> int:
    """Return how many counts of segments can wait, those of segments under way included.

    A power of two. There is room for one of each segment of a path, and for as many as segments of
    a cell each can be under way in a walker.
    """
    return max(_COUNTS, 1 << (config.max_segments - 1).bit_length())
