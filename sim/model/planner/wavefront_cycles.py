"""Cycles of the wavefront's units, as the gateware takes them: of each, those of its ``busy``."""

from __future__ import annotations

from hdl.protocol.planner import BLOCKS
from sim.model.planner.compiled import compiled


__all__ = ["PASS", "routing", "scanning", "seeding", "spreading"]

#: Cycles of a pass over the blocks: a block a cycle, and the pipeline.
PASS = BLOCKS**2 + 23
#: Cycles to fill the memories of surface and costs.
_FILL = BLOCKS**2 + 2
#: Cycles for a block of a route, and for a straight line.
_ROUTE_STEP, _STRAIGHT = 27, 3 + 64


def scanning(marked: int, shift: int, lanes: int, latency: int) -> int:
    """Return the cycles of a scan of ``marked`` blocks of ``2**shift`` corners along each edge.

    ``latency`` is that of the map's memory.
    """
    rows = max(1, (1 << shift) // lanes) << shift
    return BLOCKS**2 + marked * (rows - 1) + BLOCKS + latency + lanes.bit_length() + 3


@compiled
def spreading(limit_passes: int, passes: int) -> int:
    """Return the cycles of a wavefront of so many passes; without a limit of slopes, 0 of these."""
    return 2 * _FILL + (limit_passes + passes) * PASS + 1 + (limit_passes > 0)


@compiled
def routing(blocks: int, is_straight: bool) -> int:
    """Return the cycles of a route."""
    return _STRAIGHT if is_straight else blocks * _ROUTE_STEP


def seeding(paths: int, longest: int) -> int:
    """Return the cycles in which words are taken, if there always is one and waypoints are taken.

    ``longest`` is the greatest number of waypoints of a path.
    """
    return paths * (longest + 1)
