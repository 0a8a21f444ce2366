"""Edges in degrees: unwrapped beyond 180, as geodesics or rhumb lines, cut to a box, projected."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.formats.features import Edges, Position
from pathgene.host.formats.shapes import Ring
from pathgene.host.terrain import Terrain


__all__ = ["TOLERANCE_M", "Corners", "clipped", "densified", "lined", "unwrapped"]

Floats = NDArray[np.float64]
Corners = Sequence[Position]

#: Metres by which an edge in the terrain's frame may miss the edge of the file.
TOLERANCE_M = 0.25
# Maximum number of halvings of an edge: an edge around the world is then a few metres long.
_HALVINGS = 24
# Metres between the corners of a geodesic or a rhumb line, which are straight in between: an edge
# of this length bends by less than a tenth of a metre below a latitude of 85 degrees.
_STEP_M = 2000.0
# Shares of an edge at which its bend is measured.
_SHARES = (0.25, 0.5, 0.75)
# Degrees of latitude above which a ring counts as a map of the world.
_WORLD_DEG = 120.0
_WGS84_E = 0.0818191908426215


def unwrapped(ring: Corners) -> tuple[Position, ...]:
    """Return a ring whose longitudes are continuous: a jump by more than 180 takes the short way.

    A jump by exactly 360 is an edge around the world. A ring around a pole gets the pole. A ring
    from far south to far north is a map of the world, whose long edges stay as drawn.
    """
    latitudes = [latitude for _, latitude in ring]
    if max(latitudes) - min(latitudes) > _WORLD_DEG:
        return tuple(ring)
    corners = [ring[0]]
    turned = 0.0
    for (before, _), (longitude, latitude) in itertools.pairwise(ring):
        turned += _turn(before, longitude)
        corners.append((longitude + turned, latitude))
    back = ring[0][0] + turned + _turn(ring[-1][0], ring[0][0])
    if abs(back - ring[0][0]) > 180.0 and len(corners) > 2:
        mean = sum(latitudes) / len(latitudes)
        pole = math.copysign(90.0, mean)
        return (*corners, (back, corners[0][1]), (back, pole), (ring[0][0], pole))
    return tuple(corners)


def _turn(before: float, after: float) -> float:
    """Return the multiple of 360 degrees that makes a jump short."""
    jump = after - before
    if abs(jump) <= 180.0 or abs(jump) == 360.0:
        return 0.0
    return -360.0 * round(jump / 360.0)


def lined(ring: Corners, edges: Edges) -> Corners:
    """Return a ring with corners along its geodesics or rhumb lines; other rings unchanged."""
    if edges not in (Edges.GEODESIC, Edges.RHUMB) or len(ring) < 2:
        return ring
    # Loads PROJ.
    from pyproj import Geod

    geod = Geod(ellps="WGS84")
    corners: list[Position] = []
    for start, stop in zip(ring, (*ring[1:], ring[0]), strict=True):
        _, _, length_m = geod.inv(*start, *stop)
        count = min(math.ceil(length_m / _STEP_M), 20_000) - 1
        corners.append(start)
        if count < 1:
            continue
        if edges is Edges.GEODESIC:
            corners += geod.npts(*start, *stop, count)
        else:
            corners += _rhumb(start, stop, count)
    return corners


def _rhumb(start: Position, stop: Position, count: int) -> list[Position]:
    """Return points between two places on the line of constant bearing."""
    shares = np.arange(1, count + 1) / (count + 1)
    east = stop[0] - start[0]
    east -= 360.0 * round(east / 360.0)
    latitudes = start[1] + shares * (stop[1] - start[1])
    first, last = _isometric(start[1]), _isometric(stop[1])
    if abs(stop[1] - start[1]) < 1e-9:
        along = shares
    else:
        along = (np.array([_isometric(each) for each in latitudes]) - first) / (last - first)
    longitudes = start[0] + east * along
    return list(zip(longitudes.tolist(), latitudes.tolist(), strict=True))


def _isometric(latitude: float) -> float:
    """Return the isometric latitude, in which lines of constant bearing are straight."""
    sine = math.sin(math.radians(min(max(latitude, -89.999999), 89.999999)))
    return math.atanh(sine) - _WGS84_E * math.atanh(_WGS84_E * sine)


def clipped(ring: Corners, box: tuple[float, float, float, float]) -> tuple[Position, ...]:
    """Return the part of a ring in a box: west, south, east and north.

    Parts are joined along the border of the box. Edges along the border enclose no area, so by the
    even-odd rule the area in the box is unchanged.
    """
    west, south, east, north = box
    kept = list(ring)
    for axis, bound, sign in ((0, west, 1), (0, east, -1), (1, south, 1), (1, north, -1)):
        if not kept:
            break
        corners, kept = kept, []
        for start, stop in zip(corners[-1:] + corners[:-1], corners, strict=True):
            a, b = sign * (start[axis] - bound), sign * (stop[axis] - bound)
            if (a >= 0) != (b >= 0):
                share = a / (a - b)
                crossing = [start[k] + share * (stop[k] - start[k]) for k in (0, 1)]
                crossing[axis] = bound
                kept.append((crossing[0], crossing[1]))
            if b >= 0:
                kept.append(stop)
    return tuple(kept)


def densified(rings: Sequence[tuple[Corners, bool]], terrain: Terrain) -> list[Ring]:
    """Return rings of degrees in local metres; bent edges get corners if a flag says so.

    Parameters
    ----------
    rings : sequence of (corners, flag)
        Longitude and latitude of each corner, and whether edges are straight in degrees. Other
        edges are straight in the frame.
    terrain : Terrain
        The frame.
    """
    if not rings:
        return []
    lon, lat = np.array([corner for ring, _ in rings for corner in ring]).reshape(-1, 2).T
    sizes = np.array([len(ring) for ring, _ in rings])
    owner = np.repeat(np.arange(len(rings)), sizes)
    open_ = np.repeat(np.array([flag and len(ring) > 1 for ring, flag in rings]), sizes)
    x, y = map(np.asarray, terrain.to_local(lat, lon))
    for _ in range(_HALVINGS):
        ahead = _following(owner)
        tested = np.flatnonzero(open_)
        if not len(tested):
            break
        bent = _bends(terrain, lon, lat, x, y, tested, ahead[tested])
        open_[tested] = bent
        tested = tested[bent]
        if not len(tested):
            break
        stop = ahead[tested]
        middle_lon, middle_lat = 0.5 * (lon[tested] + lon[stop]), 0.5 * (lat[tested] + lat[stop])
        middle_x, middle_y = terrain.to_local(middle_lat, middle_lon)
        lon, lat, x, y = (
            np.insert(old, tested + 1, new)
            for old, new in ((lon, middle_lon), (lat, middle_lat), (x, middle_x), (y, middle_y))
        )
        owner = np.insert(owner, tested + 1, owner[tested])
        open_ = np.insert(open_, tested + 1, True)
    bounds = np.searchsorted(owner, np.arange(len(rings) + 1))
    pairs = list(zip(x.tolist(), y.tolist(), strict=True))
    return [tuple(pairs[a:b]) for a, b in itertools.pairwise(bounds)]


def _following(owner: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the index of the next corner of each corner's ring."""
    ahead = np.arange(1, len(owner) + 1)
    firsts = np.flatnonzero(np.diff(owner, prepend=-1))
    ends = np.append(firsts[1:], len(owner)) - 1
    ahead[ends] = firsts
    return ahead


def _bends(
    terrain: Terrain,
    lon: Floats,
    lat: Floats,
    x: Floats,
    y: Floats,
    start: NDArray[np.intp],
    stop: NDArray[np.intp],
) -> NDArray[np.bool_]:
    """Return whether edges, straight in degrees, leave their chord in the frame."""
    shares = np.array(_SHARES)[:, None]
    on_lon = lon[start] + shares * (lon[stop] - lon[start])
    on_lat = lat[start] + shares * (lat[stop] - lat[start])
    on_x, on_y = terrain.to_local(on_lat, on_lon)
    east, north = x[stop] - x[start], y[stop] - y[start]
    length = np.hypot(east, north)
    across = (on_x - x[start]) * north - (on_y - y[start]) * east
    direct = np.hypot(on_x - x[start], on_y - y[start])
    away = np.where(length > 0, np.abs(across) / np.where(length > 0, length, 1.0), direct)
    bent: NDArray[np.bool_] = away.max(axis=0) > TOLERANCE_M
    return bent
