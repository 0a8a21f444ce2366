"""Cycles of the wavefront's units, as the gateware takes them: each unit's ``busy``."""

from __future__ import annotations

from pathgene.hdl.protocol.planner import BLOCKS
from pathgene.sim.model.planner.compiled import inlined


__all__ = [
    "PASS",
    "WAYPOINT",
    "launched",
    "routing",
    "scanned",
    "scanning",
    "seeded",
    "seeding",
    "spreading",
]

#: Cycles of a pass over the blocks: a block a cycle, and the pipeline.
PASS = BLOCKS**2 + 15
#: Cycles to fill the memories of surface and costs.
_FILL = BLOCKS**2 + 2
#: Cycles for a block of a route, and for a straight line.
_ROUTE_STEP, _STRAIGHT = 20, 4 + 64
#: Cycles from the word of a waypoint of a seed to the waypoint.
WAYPOINT = 18


def scanning(marked: int, shift: int, lanes: int, latency: int) -> int:
    """Return the cycles of a scan of ``marked`` blocks of ``2**shift`` corners along each edge.

    ``latency`` is the latency of the map's memory.
    """
    rows = max(1, (1 << shift) // lanes) << shift
    return BLOCKS**2 + marked * (rows - 1) + BLOCKS + latency + lanes.bit_length() + 3


@inlined
def spreading(limit_passes: int, passes: int) -> int:
    """Return the cycles of a wavefront; ``limit_passes`` is 0 if slopes are not limited."""
    return 2 * _FILL + (limit_passes + passes) * PASS + 1 + (limit_passes > 0)


@inlined
def routing(blocks: int, is_straight: bool) -> int:
    """Return the cycles of a route."""
    return _STRAIGHT if is_straight else blocks * _ROUTE_STEP


@inlined
def seeding(longest: int) -> int:
    """Return the cycles in which the words of a path are taken, if there always is one.

    ``longest`` is the maximum number of waypoints of a seed.
    """
    return longest + 1


def scanned(marked: int, shift: int, lanes: int, latency: int) -> int:
    """Return the cycles in which the source of seeds is busy with a scan: see :func:`scanning`."""
    return scanning(marked, shift, lanes, latency) + 1


@inlined
def launched(limit_passes: int, passes: int, blocks: int, is_straight: bool) -> int:
    """Return the cycles of a wavefront and its route: see :func:`spreading` and :func:`routing`."""
    return spreading(limit_passes, passes) + routing(blocks, is_straight) + 2


@inlined
def seeded(longest: int) -> int:
    """Return the cycles of a path: see :func:`seeding`."""
    return seeding(longest) + 1
