"""Height limits of files, in metres of the terrain's datum, with a safety margin.

A limit above the ground follows the ground: the zone is divided into tiles until the ground under
each is nearly level, or the maximum number is reached. In each tile the upper limit is measured
from the highest ground, the lower limit from the lowest. The zone itself keeps such a limit.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pathgene.host.formats.features import Feature, Limit, Reference
from pathgene.host.formats.limits import above_ground
from pathgene.host.formats.shapes import Ring
from pathgene.host.problem.cutting import cut
from pathgene.host.problem.placing import Placed
from pathgene.host.terrain import Terrain


__all__ = [
    "Band",
    "Heights",
    "Stated",
    "encloses_nothing",
    "follows_ground",
    "ground_under",
    "tiles",
    "tiles_each",
]

# Ground counts as level if it varies by less than this, metres.
_LEVEL_M = 10.0
# Tiles of one zone, and of all zones of a file.
_TILES, _ALL_TILES = 128, 512
# Distance that is no more than the rounding of a file.
_EDGE_M = 1e-3
# Distance around the map that tiles cover, metres.
_BEYOND_M = 1000.0
# Corners of the polygon around a divided circle.
_CIRCLE_CORNERS = 180
# Heights of the geoid over the ellipsoid anywhere on Earth.
_GEOID_M = (-107.0, 86.0)
# Usual range of the pressure at sea level, hPa.
_PRESSURES_HPA = (950.0, 1050.0)
_STANDARD_HPA = 1013.25
# Standard atmosphere: scale height of an altimeter, metres, and the exponent of its pressure.
_SCALE_M, _EXPONENT = 44_330.77, 0.190263


#: Metres of the terrain's datum, a text such as ``120 m AGL``, or None for no limit.
Stated = float | str | None


@dataclass(frozen=True)
class Band:
    """A part of a zone with its limits in metres of the terrain's datum; None for no limit."""

    part: Placed
    lower_m: float | None = None
    upper_m: float | None = None

    @property
    def is_empty(self) -> bool:
        """True if there is nothing between the limits."""
        return (
            self.lower_m is not None and self.upper_m is not None and self.lower_m >= self.upper_m
        )


@dataclass(frozen=True)
class Heights:
    """Conversion of limits to metres of a terrain's datum.

    Parameters
    ----------
    terrain : Terrain
        The terrain.
    qnh_hpa : float, optional
        Pressure at sea level; None for any usual pressure.
    zones : int
        Number of zones with limits above the ground, which share the tiles.
    """

    terrain: Terrain
    qnh_hpa: float | None = None
    zones: int = 1

    def bands(self, feature: Feature, part: Placed) -> list[Band]:
        """Return a part of a feature, or its tiles, with limits in metres."""
        if not follows_ground(feature):
            return [self._band(feature, part, 0.0, 0.0)]
        found = tiles(part, self.terrain, tiles_each(self.zones))
        return [self._band(feature, *tile) for tile in found]

    def stated(self, feature: Feature, bands: Sequence[Band]) -> tuple[Stated, Stated]:
        """Return the limits of a zone with some ``bands``: metres, or a text above the ground."""
        lower, upper = (
            above_ground(limit.height_m) if limit and limit.reference is Reference.AGL else metres
            for limit, metres in zip(
                _limits(feature), (bands[0].lower_m, bands[0].upper_m), strict=True
            )
        )
        return lower, upper

    def _band(self, feature: Feature, part: Placed, lowest_m: float, highest_m: float) -> Band:
        lower, upper = _limits(feature)
        return Band(
            part,
            None if lower is None else lower.height_m + self._shift(lower, lowest_m, 0),
            None if upper is None else upper.height_m + self._shift(upper, highest_m, 1),
        )

    def _shift(self, limit: Limit, ground_m: float, side: int) -> float:
        """Return the metres to add to a limit: minimum for a lower, maximum for an upper limit."""
        if limit.reference is Reference.AGL:
            return ground_m
        if limit.reference is Reference.WGS84:
            return -geoid_m(self.terrain)[1 - side]
        if limit.reference is Reference.STANDARD:
            pressure = _PRESSURES_HPA[side] if self.qnh_hpa is None else self.qnh_hpa
            return float(_SCALE_M * ((pressure / _STANDARD_HPA) ** _EXPONENT - 1.0))
        return 0.0


def encloses_nothing(feature: Feature) -> bool:
    """Return whether limits above the ground are reversed, or any limits are equal."""
    lower, upper = _limits(feature)
    if lower is None or upper is None:
        return False
    are_above_ground = lower.reference is upper.reference is Reference.AGL
    return lower == upper or (are_above_ground and lower.height_m >= upper.height_m)


def follows_ground(feature: Feature) -> bool:
    """Return whether a limit of a feature is measured above the ground."""
    return any(limit and limit.reference is Reference.AGL for limit in _limits(feature))


def _limits(feature: Feature) -> tuple[Limit | None, Limit | None]:
    """Return the limits; a lower limit at the ground is dropped: the zone reaches below it."""
    lower = feature.lower
    if lower is not None and lower.reference is Reference.AGL and lower.height_m <= 0:
        lower = None
    return lower, feature.upper


def geoid_m(terrain: Terrain) -> tuple[float, float]:
    """Return the minimum and maximum height of the geoid over the ellipsoid on a map.

    Without a grid of the geoid, these are the heights anywhere on Earth.
    """
    if terrain.crs is None or terrain.origin is None:
        return _GEOID_M
    x, y = np.meshgrid(np.linspace(0, terrain.width_m, 9), np.linspace(0, terrain.height_m, 9))
    lat, lon = terrain.to_geographic(x.ravel(), y.ravel())
    # Loads PROJ, which zones with other limits do not need.
    from pathgene.host.terrain.vertical import geoid_heights

    geoid = geoid_heights(lon, lat)
    if geoid is None:
        return _GEOID_M
    # The geoid changes by less than a metre between the points.
    return float(geoid.min()) - 1.0, float(geoid.max()) + 1.0


def ground_under(part: Placed, terrain: Terrain) -> tuple[float, float]:
    """Return the lowest and highest ground under the box of a zone; voids may have any height."""
    x, y = np.array(part.rings[0]).T
    reach = part.radius_m or 0.0
    return _ground(
        (
            float(x.min()) - reach,
            float(y.min()) - reach,
            float(x.max()) + reach,
            float(y.max()) + reach,
        ),
        terrain,
    )


_Box = tuple[float, float, float, float]


def _ground(box: _Box, terrain: Terrain) -> tuple[float, float]:
    """Return the lowest and highest ground in a box.

    A box that reaches less than :data:`_EDGE_M` beyond a line of nodes has only that share of the
    ground beyond, so that the figures do not jump where a file has rounded a corner on that line.
    """
    lowest, highest = _nodes(box, terrain, 0.0)
    low, high = _nodes(box, terrain, _EDGE_M)
    share = 2 * _EDGE_M / min(terrain.dx_m, terrain.dy_m)
    return low + share * (lowest - low), high + share * (highest - high)


def _nodes(box: _Box, terrain: Terrain, within_m: float) -> tuple[float, float]:
    """Return the lowest and highest of the nodes around a box, less a rim ``within_m`` wide."""
    west, south, east, north = box
    rows, columns = (
        slice(
            min(max(math.floor((low + within_m) / side), 0), count - 1),
            min(max(math.ceil((high - within_m) / side), 0), count - 1) + 1,
        )
        for low, high, side, count in (
            (south, north, terrain.dy_m, terrain.shape[0]),
            (west, east, terrain.dx_m, terrain.shape[1]),
        )
    )
    ground = terrain.elevation[rows, columns]
    if not ground.size or np.isnan(ground).any():
        return terrain.lowest, terrain.highest
    return float(ground.min()), float(ground.max())


def tiles_each(zones: int) -> int:
    """Return the maximum number of tiles of each of some zones that follow the ground."""
    return max(min(_ALL_TILES // max(zones, 1), _TILES), 1)


def tiles(part: Placed, terrain: Terrain, most: int) -> Iterator[tuple[Placed, float, float]]:
    """Yield tiles of a part with the lowest and the highest ground under each."""
    lowest, highest = ground_under(part, terrain)
    if highest - lowest <= _LEVEL_M or most == 1:
        yield part, lowest, highest
        return
    rings = part.rings if part.radius_m is None else (_around(part),)
    x, y = np.array(rings[0]).T
    box = (
        max(float(x.min()), -_BEYOND_M),
        max(float(y.min()), -_BEYOND_M),
        min(float(x.max()), terrain.width_m + _BEYOND_M),
        min(float(y.max()), terrain.height_m + _BEYOND_M),
    )
    if box[0] >= box[2] or box[1] >= box[3]:
        # It lies beyond the places that tiles cover.
        yield part, lowest, highest
        return
    areas = [rings]
    for side, bound in enumerate(box):
        axis, sign = side % 2, 1 if side < 2 else -1
        areas = [piece for area in areas for piece in cut(area, axis, bound, sign)]
    order = itertools.count()
    # The tile with the steepest ground is divided first.
    heap = [(lowest - highest, next(order), box, area, lowest, highest) for area in areas]
    level: list[tuple[tuple[Ring, ...], float, float]] = []
    while heap:
        _, _, box, area, lowest, highest = heapq.heappop(heap)
        sides = box[2] - box[0], box[3] - box[1]
        is_small = sides[0] <= terrain.dx_m and sides[1] <= terrain.dy_m
        if len(heap) + len(level) + 2 > most or highest - lowest <= _LEVEL_M or is_small:
            level.append((area, lowest, highest))
            continue
        axis = 0 if sides[0] >= sides[1] else 1
        halves = _halves(box, axis)
        for half, sign in zip(halves, (-1, 1), strict=True):
            low, high = _ground(half, terrain)
            for piece in cut(area, axis, halves[1][axis], sign):
                heapq.heappush(heap, (low - high, next(order), half, piece, low, high))
    for area, lowest, highest in level:
        yield Placed(area), lowest, highest


def _halves(box: _Box, axis: int) -> tuple[_Box, _Box]:
    west, south, east, north = box
    if axis == 0:
        middle = 0.5 * (west + east)
        return (west, south, middle, north), (middle, south, east, north)
    middle = 0.5 * (south + north)
    return (west, south, east, middle), (west, middle, east, north)


def _around(part: Placed) -> tuple[tuple[float, float], ...]:
    """Return a polygon around a circle."""
    angles = np.linspace(0, 2 * np.pi, _CIRCLE_CORNERS, endpoint=False)
    reach = (part.radius_m or 0.0) / math.cos(math.pi / _CIRCLE_CORNERS)
    ((x, y),) = part.rings[0]
    corners = np.stack((x + reach * np.cos(angles), y + reach * np.sin(angles)), axis=1)
    return tuple((east, north) for east, north in corners.tolist())
