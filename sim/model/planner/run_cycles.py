"""Cycles of the steps of a run, of the wavefront and of first paths, as in the gateware.

The scan of the blocks begins in cycle 0. The random source and the memo are ready long before the
scan ends. A unit of the wavefront takes the cycles in which it is ``busy``. All first paths are
made one by one: each begins when the goal of the previous one is taken, the first when they are
launched. The words of a seed have been taken before its last point is offered.
"""

from __future__ import annotations

from pathgene.sim.model.compiled import inlined


__all__ = [
    "AIMED",
    "BEGIN",
    "END",
    "EVALUATED",
    "MEMBER",
    "MERGED",
    "NEXT_ISLAND",
    "POPULATION",
    "ROUTED",
    "SCANNED",
    "SEED",
    "SPLIT",
    "SPLIT_TO_AIM",
    "WAYPOINT",
    "launched",
    "member_offered",
    "passing",
    "routing",
    "scanned",
    "scanning",
    "seed_offered",
    "seeded",
    "seeding",
    "spreading",
]


#: Cycles of the pipeline of a pass over the blocks, and of the memories of surface and costs.
_PASS, _FILL = 15, 2
#: Cycles for a block of a route, and for a straight line.
_ROUTE_STEP, _STRAIGHT = 20, 4 + 64
#: Cycles from the word of a waypoint of a seed to the waypoint.
WAYPOINT = 20


def scanning(edge: int, marked: int, shift: int, lanes: int, latency: int) -> int:
    """Return the cycles of a scan of ``marked`` blocks of ``2**shift`` corners along each edge.

    ``edge`` is the number of blocks along each edge of the map, ``latency`` the latency of the
    map's memory.
    """
    rows = max(1, (1 << shift) // lanes) << shift
    return edge * edge + marked * (rows - 1) + edge + latency + lanes.bit_length() + 3


@inlined
def passing(edge: int) -> int:
    """Return the cycles of a pass over ``edge**2`` blocks."""
    return edge * edge + _PASS


@inlined
def spreading(edge: int, limit_passes: int, passes: int) -> int:
    """Return the cycles of a wavefront; ``limit_passes`` is 0 if slopes are not limited."""
    fill = edge * edge + _FILL
    return 2 * fill + (limit_passes + passes) * passing(edge) + 1 + (limit_passes > 0)


@inlined
def routing(blocks: int, is_straight: bool) -> int:
    """Return the cycles of a route."""
    return _STRAIGHT if is_straight else blocks * _ROUTE_STEP


@inlined
def seeding(waypoints: int) -> int:
    """Return the cycles in which the words of a path are taken, if one is always available."""
    return waypoints + 1


def scanned(edge: int, marked: int, shift: int, lanes: int, latency: int) -> int:
    """Return the cycles in which the source of seeds is busy with a scan: see :func:`scanning`."""
    return scanning(edge, marked, shift, lanes, latency) + 1


@inlined
def launched(edge: int, limit_passes: int, passes: int, blocks: int, is_straight: bool) -> int:
    """Return the cycles of a wavefront and its route: see :func:`spreading` and :func:`routing`."""
    return spreading(edge, limit_passes, passes) + routing(blocks, is_straight) + 2


@inlined
def seeded(waypoints: int) -> int:
    """Return the cycles of a path: see :func:`seeding`."""
    return seeding(waypoints) + 1


#: Cycles from the launch, or from the goal of the previous path, to the offer of a member's first
#: point.
MEMBER = 9
#: The same for a seed: one cycle until it begins, two words, then a waypoint and its queue.
SEED = 1 + 2 + WAYPOINT + 1


@inlined
def member_offered(free: int, dropped: int) -> int:
    """Return the cycle from which the points of a member are offered.

    Parameters
    ----------
    free : int
        Cycle of the launch, or in which the goal of the previous path is taken.
    dropped : int
        Number of waypoints that it loses.
    """
    return free + MEMBER + dropped


@inlined
def seed_offered(free: int) -> int:
    """Return the same for a seed."""
    return free + SEED


#: From cycle 0 to the beginning of the first route, or of the paths of a warm run, without the
#: cycles of the scan.
SCANNED = 2
#: From the beginning of a route to the beginning of its seeds, without the cycles of the route.
ROUTED = 2
#: From the first cycle in which no path is being made or evaluated to the store of the population.
EVALUATED = 1
#: From the first cycle with a complete first population to the beginning of the next paths or
#: route; after the last population, to the split, or to the aim if there is only one island.
POPULATION = 1
#: From the split, from whose cycle parts are computed, to the first aim.
SPLIT, SPLIT_TO_AIM = POPULATION, 7
#: From an aim, from whose cycle an island's limit is counted, to the first cycle in which a
#: generation may be ready to begin.
AIMED = 1
#: From the first cycle of a ready population, in which limits are compared, to the beginning of a
#: generation, or to the finish of the last one.
BEGIN = 1
#: From that cycle without a generation to finish: to the aim of the next island, to the merge, and
#: from there to the aim; and to the number of cycles of the run.
NEXT_ISLAND, MERGED, END = 2, (2, 1), 3
