"""No-fly zones as fences of an autopilot, which are flat: circles, and polygons without holes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.problem.rings import Ring, wound
from pathgene.host.problem.zones import Circle, Polygon, Zone
from pathgene.host.terrain import Terrain


__all__ = [
    "DEGREE_DECIMALS",
    "Fence",
    "FenceCircle",
    "FencePolygon",
    "degrees",
    "fences",
    "without_holes",
]

#: Decimals of a degree in files: nine are a tenth of a millimetre.
DEGREE_DECIMALS = 9

# The track is compared with zones at points this far apart.
_STEP_M = 1.0


@dataclass(frozen=True)
class FenceCircle:
    """A circle that an autopilot keeps out of, or in.

    Parameters
    ----------
    lat, lon : float
        Centre, WGS84 degrees.
    radius_m : float
        Radius.
    inclusion : bool
        Keep in rather than out.
    """

    lat: float
    lon: float
    radius_m: float
    inclusion: bool = False


@dataclass(frozen=True)
class FencePolygon:
    """A polygon that an autopilot keeps out of, or in.

    Parameters
    ----------
    corners : tuple of (float, float)
        Latitude and longitude of each corner, WGS84 degrees; three or more.
    inclusion : bool
        Keep in rather than out.
    """

    corners: tuple[tuple[float, float], ...]
    inclusion: bool = False


Fence = FenceCircle | FencePolygon


def degrees(terrain: Terrain, x: NDArray[np.float64], y: NDArray[np.float64]) -> Ring:
    """Return (latitude, longitude) of points in local metres, rounded as in every file."""
    lat, lon = terrain.to_geographic(x, y)
    return tuple(
        (round(north, DEGREE_DECIMALS), round(east, DEGREE_DECIMALS))
        for north, east in zip(lat.tolist(), lon.tolist(), strict=True)
    )


def fences(
    zones: tuple[Zone, ...], track: SmoothedTrack, terrain: Terrain
) -> tuple[tuple[Fence, ...], tuple[str, ...]]:
    """Return the fences of zones, and a sentence for each zone that has none.

    A fence forbids the whole column for the whole flight. So a zone with limits of height or time
    that the track passes above, below, before or after has none: the autopilot would break off its
    own mission.

    Parameters
    ----------
    zones : tuple of Zone
        The zones, without margin.
    track : SmoothedTrack
        The path to be flown.
    terrain : Terrain
        Places the zones on Earth.
    """
    samples = track.sample(_STEP_M)
    made: list[Fence] = []
    left_out: list[str] = []
    for number, zone in enumerate(zones, start=1):
        limits = (zone.lower_m, zone.upper_m, zone.t0_s, zone.t1_s)
        if any(limit is not None for limit in limits) and _enters(zone, samples.x, samples.y):
            left_out.append(
                f"No fence for {zone.name or f'zone {number}'}: the path crosses it above, below, "
                "before or after its limits, which a fence cannot express."
            )
        else:
            made.append(_fence(zone, terrain))
    return tuple(made), tuple(left_out)


def without_holes(ring: Ring, holes: tuple[Ring, ...]) -> Ring:
    """Return one ring that covers ``ring`` less its ``holes``.

    Each hole is joined to the ring by a cut without width, which is walked there and back and so
    covers nothing. Holes wind the other way than the ring, so that the rule of even and odd
    crossings and that of winding numbers agree.
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
    if isinstance(zone, Circle):
        ((lat, lon),) = degrees(terrain, np.array([zone.x_m]), np.array([zone.y_m]))
        return FenceCircle(lat, lon, zone.radius_m)
    if isinstance(zone, Polygon):
        x, y = np.array(without_holes(zone.ring, zone.holes)).T
        return FencePolygon(degrees(terrain, x, y))
    raise TypeError(f"No fence for a zone of the type {type(zone).__name__}")


def _enters(zone: Zone, x: NDArray[np.float64], y: NDArray[np.float64]) -> bool:
    """Return whether one of the points, seen from above, lies in the zone."""
    if isinstance(zone, Circle):
        return bool((np.hypot(x - zone.x_m, y - zone.y_m) <= zone.radius_m).any())
    if not isinstance(zone, Polygon):
        return True
    inside = np.zeros(len(x), dtype=bool)
    for ring in (zone.ring, *zone.holes):
        for (xa, ya), (xb, yb) in zip(ring, (*ring[1:], ring[0]), strict=True):
            rows = (ya <= y) != (yb <= y)
            if rows.any():
                inside[rows] ^= x[rows] < xa + (y[rows] - ya) * ((xb - xa) / (yb - ya))
    return bool(inside.any())
