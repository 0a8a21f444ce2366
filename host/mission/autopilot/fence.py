"""No-fly zones as fences of an autopilot, which are flat: circles, and polygons without holes."""

from __future__ import annotations

import math

import numpy as np

from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.formats.flight_plan import Fence, FenceCircle, FencePolygon
from pathgene.host.formats.places import degrees
from pathgene.host.formats.shapes import Ring, wound
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


__all__ = ["fences", "without_holes"]

# The track is compared with zones at points this far apart.
_STEP_M = 1.0


def fences(
    zones: tuple[Zone, ...], track: SmoothedTrack, terrain: Terrain
) -> tuple[tuple[Fence, ...], tuple[str, ...]]:
    """Return the fences of zones, and a sentence for each zone that has none.

    A fence forbids the whole column for the whole flight. So a zone whose height or time limits let
    the track pass above, below, before or after it has no fence: the autopilot would abort its own
    mission.

    Parameters
    ----------
    zones : tuple of Zone
        The zones, without margin.
    track : SmoothedTrack
        The path to be flown.
    terrain : Terrain
        Gives the zones their place on Earth.
    """
    samples = track.sample(_STEP_M)
    made: list[Fence] = []
    left_out: list[str] = []
    for number, zone in enumerate(zones, start=1):
        limits = (zone.lower_m, zone.upper_m, zone.t0_s, zone.t1_s)
        if (
            any(limit is not None for limit in limits)
            and zone.footprint.contains(samples.x, samples.y).any()
        ):
            left_out.append(
                f"No fence for {zone.name or f'zone {number}'}: the path crosses it above, below, "
                "before or after its limits, which a fence cannot express."
            )
        else:
            made.append(_fence(zone, terrain))
    # The tiles of one zone have one name.
    return tuple(made), tuple(dict.fromkeys(left_out))


def without_holes(ring: Ring, holes: tuple[Ring, ...]) -> Ring:
    """Return one ring that covers ``ring`` less its ``holes``.

    Each hole is joined to the ring by a cut of zero width, traversed in both directions, so that
    the cut covers nothing. Holes wind opposite to the ring, so that the even-odd rule and the
    winding-number rule agree.
    """
    if holes:
        ring = wound(ring, left=True)
    for hole in (wound(hole, left=False) for hole in holes):
        pairs = (
            (math.dist(corner, other), i, j)
            for i, corner in enumerate(ring)
            for j, other in enumerate(hole)
        )
        _, i, j = min(pairs)
        ring = (*ring[: i + 1], *hole[j:], *hole[: j + 1], *ring[i:])
    return ring


def _fence(zone: Zone, terrain: Terrain) -> Fence:
    if zone.footprint.disc is not None:
        x_m, y_m, radius_m = zone.footprint.disc
        ((lat, lon),) = degrees(terrain, np.array([x_m]), np.array([y_m]))
        return FenceCircle(lat, lon, radius_m)
    ring, *holes = zone.footprint.rings
    x, y = np.array(without_holes(ring, tuple(holes))).T
    return FencePolygon(degrees(terrain, x, y))
