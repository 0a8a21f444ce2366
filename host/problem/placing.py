"""Features of a file as shapes over a terrain: unwrapped, cut to the map, densified, projected.

An edge is straight in longitude and latitude unless its file says otherwise, so it bends in the
terrain's frame and gets corners until it lies within :data:`TOLERANCE_M` of its line. Features far
from the map are cut, never refused, because other continents cannot be projected here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from pathgene.host.formats.features import Edges, Feature, Position
from pathgene.host.formats.shapes import Ring
from pathgene.host.problem.edges import Corners, clipped, densified, lined, unwrapped
from pathgene.host.problem.loops import Untangled, drawn_once, untangled
from pathgene.host.terrain import Terrain


__all__ = [
    "Placed",
    "Swapped",
    "goes_short_way",
    "in_degrees_on_map",
    "is_mirrored_on_map",
    "long_way_on_map",
    "place",
    "swapped_on_map",
]

Floats = NDArray[np.float64]

# Margin around the map to which zones are cut: as a share of the map, and at least, metres.
_AROUND, _AROUND_M = 0.25, 20_000.0
# Metres of a degree of latitude, rounded down.
_DEGREE_M = 110_000.0
# Degrees around the map in which circles, and files written by pathgene, are projected unchanged.
_NEAR_DEG = 5.0
# An inclusion fence becomes a zone around it that reaches this many metres beyond map and fence.
_BEYOND_M = 1000.0
# Corners of the polygon inside an inclusion circle, and around a circle that is far away.
_CIRCLE_CORNERS = 180
_FAR_CIRCLE_CORNERS = 720
# Share of the map that counts as nothing.
_NO_SHARE = 1e-6
# Diagonals of the map, and degrees, above which an area that covers it counts as one of a country:
# control zones are smaller, and often larger than a map.
_VAST, _VAST_DEG = 5.0, 3.0
# Points on each side of the map, for its box in degrees.
_BORDER_POINTS = 33


@dataclass(frozen=True)
class Placed:
    """A part of a feature over a terrain.

    Parameters
    ----------
    rings : tuple of rings
        Outer ring and holes in local metres, or the centre of a circle.
    radius_m : float, optional
        Radius of a circle; None for a polygon.
    is_tangled : bool
        Its outline in the file crosses itself or is drawn twice.
    """

    rings: tuple[Ring, ...]
    radius_m: float | None = None
    is_tangled: bool = False


class Swapped(Enum):
    """Place of a feature with longitude and latitude swapped."""

    OFF = "off the map"
    ON = "on the map"
    AROUND = "around the whole map, and many times as large"


@dataclass(frozen=True)
class _Box:
    """A box of longitudes, which may lie beyond 180, and latitudes."""

    west: float
    south: float
    east: float
    north: float

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """West, south, east and north."""
        return self.west, self.south, self.east, self.north

    @property
    def area(self) -> float:
        """Square degrees."""
        return (self.east - self.west) * (self.north - self.south)

    @property
    def diagonal(self) -> float:
        """Degrees from corner to corner."""
        return math.hypot(self.east - self.west, self.north - self.south)

    def holds_inside(self, position: Position) -> bool:
        """Return whether a position lies inside, off the border."""
        return self.west < position[0] < self.east and self.south < position[1] < self.north

    def widened(self, degrees: float) -> _Box:
        """Return the box with some degrees more on each side."""
        return _Box(
            self.west - degrees, self.south - degrees, self.east + degrees, self.north + degrees
        )

    def holds(self, other: _Box) -> bool:
        """Return whether another box lies inside."""
        return (
            self.west <= other.west
            and other.east <= self.east
            and self.south <= other.south
            and other.north <= self.north
        )

    def meets(self, other: _Box) -> bool:
        """Return whether another box has points in common."""
        return (
            self.west <= other.east
            and other.west <= self.east
            and self.south <= other.north
            and other.south <= self.north
        )

    def moved(self, degrees: float) -> _Box:
        """Return the box shifted to the east."""
        return _Box(self.west + degrees, self.south, self.east + degrees, self.north)

    def turns(self, other: _Box) -> Iterator[float]:
        """Yield the multiples of 360 degrees that shift a box so that it meets this one."""
        first = math.ceil((self.west - other.east) / 360)
        last = math.floor((self.east - other.west) / 360)
        for turn in range(first, last + 1):
            if self.meets(other.moved(360.0 * turn)):
                yield 360.0 * turn


def place(features: Sequence[Feature], terrain: Terrain) -> list[tuple[Placed, ...]]:
    """Return the parts of each feature over a terrain; none for a feature far from the map.

    All positions are projected at once, because each call is slow. The terrain must have a place on
    Earth unless all features are local.

    Raises
    ------
    InputError
        If positions cannot be expressed in the terrain's reference system.
    """
    if all(feature.is_local for feature in features):
        return [_finished(feature, list(_local(feature)), terrain) for feature in features]
    around = _box_around(terrain)
    parts = [list(_local(f) if f.is_local else _cut(f, around)) for f in features]
    rings = [
        (ring, feature.edges is not Edges.FRAME and part.radius_m is None)
        for feature, own in zip(features, parts, strict=True)
        if not feature.is_local
        for part in own
        for ring in part.rings
    ]
    moved = iter(densified(rings, terrain))
    placed = []
    for feature, own in zip(features, parts, strict=True):
        if not feature.is_local:
            own = [replace(part, rings=tuple(next(moved) for _ in part.rings)) for part in own]
        placed.append(_finished(feature, own, terrain))
    return placed


def swapped_on_map(features: Sequence[Feature], terrain: Terrain) -> list[Swapped]:
    """Return where each feature lies with longitude and latitude swapped."""
    if not features:
        return []
    around = _box_around(terrain, 0.0)
    return [_swapped(feature, around) for feature in features]


def _swapped(feature: Feature, around: _Box) -> Swapped:
    corners = [(lat, lon) for lon, lat in feature.rings[0]]
    if any(abs(lat) > 90 for _, lat in corners):
        return Swapped.OFF
    ring = unwrapped(corners)
    box = _box_of(ring)
    for turn in around.turns(box):
        kept = clipped(tuple((lon + turn, lat) for lon, lat in ring), around.bounds)
        share = _area(kept) / around.area
        # Where a ring misses the box, its part has no area and runs along the border.
        if share < _NO_SHARE and not any(around.holds_inside(corner) for corner in kept):
            continue
        covers = share > 1 - _NO_SHARE
        is_vast = box.diagonal > max(_VAST * around.diagonal, _VAST_DEG)
        return Swapped.AROUND if covers and is_vast and not feature.keeps_in else Swapped.ON
    return Swapped.OFF


def _area(ring: Sequence[Position]) -> float:
    """Return the area of a ring in square degrees."""
    if len(ring) < 3:
        return 0.0
    # Next to the first corner, where rounding is small.
    x, y = (np.array(ring) - ring[0]).T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def goes_short_way(feature: Feature) -> bool:
    """Return whether an edge crosses the meridian of 180 degrees, to be shorter than as drawn."""
    ring = feature.rings[0]
    pairs = zip(ring, unwrapped(ring), strict=False)
    return not feature.is_local and any(drawn[0] != moved[0] for drawn, moved in pairs)


def long_way_on_map(features: Sequence[Feature], terrain: Terrain) -> list[bool]:
    """Return for each feature whether it reaches the map if its long edges stay as drawn."""
    return [
        goes_short_way(feature) and _box_of(feature.rings[0]).meets(_box_around(terrain, 0.0))
        for feature in features
    ]


def in_degrees_on_map(feature: Feature, terrain: Terrain) -> bool:
    """Return whether a feature meets the map if its numbers are degrees, in either order."""
    if terrain.crs is None:
        return False
    around, ring = _box_around(terrain, 0.0), feature.rings[0]
    boxes = _box_of(ring), _box_of([(y, x) for x, y in ring])
    return any(True for box in boxes for _ in around.turns(box))


def is_mirrored_on_map(feature: Feature, terrain: Terrain) -> bool:
    """Return whether a feature in degrees meets the map with other signs."""
    if feature.is_local or terrain.crs is None:
        return False
    around, ring = _box_around(terrain, 0.0), feature.rings[0]
    signs = ((-1, 1), (1, -1), (-1, -1))
    boxes = [_box_of([(x * east, y * north) for x, y in ring]) for east, north in signs]
    return any(True for box in boxes for _ in around.turns(box))


def _local(feature: Feature) -> Iterator[Placed]:
    """Yield the parts of a feature that is in the terrain's frame already."""
    if feature.radius_m is not None:
        yield Placed(feature.rings, feature.radius_m)
    else:
        found = _untangled(feature, feature.rings)
        yield from (Placed(rings, None, found.is_tangled) for rings in found.areas)


def _untangled(feature: Feature, rings: Sequence[Corners]) -> Untangled:
    """Return the areas of a polygon that are forbidden, or in which to stay."""
    outer, *holes = map(drawn_once, map(tuple, rings))
    found = untangled(outer, holes)
    is_tangled = found.is_tangled or len(outer) < len(rings[0])
    # Ground that a fence to stay in encloses twice lies outside, which is the safe side.
    areas = ((outer, *holes),) if feature.keeps_in else found.areas
    return Untangled(areas, is_tangled)


def _cut(feature: Feature, around: _Box) -> Iterator[Placed]:
    """Yield the parts of a feature near the map, in degrees, next to its longitudes."""
    rings, radius_m = feature.rings, feature.radius_m
    if radius_m is not None:
        ((lon, lat),) = rings[0]
        near = around.widened(_NEAR_DEG)
        for turn in near.turns(_Box(lon, lat, lon, lat)):
            yield Placed((((lon + turn, lat),),), radius_m)
            return
        if radius_m < _DEGREE_M:
            return
        rings = (_circle_far_away(lon, lat, radius_m),)
    rings = tuple(unwrapped(lined(ring, feature.edges)) for ring in rings)
    if not any(True for _ in around.turns(_box_of(rings[0]))):
        return
    found = _untangled(feature, rings)
    keeps = feature.edges is Edges.FRAME and radius_m is None
    for area in found.areas:
        for kept in _cut_area(area, around, keeps=keeps):
            yield Placed(kept, None, found.is_tangled)


def _cut_area(rings: Sequence[Corners], around: _Box, *, keeps: bool) -> Iterator[tuple[Ring, ...]]:
    """Yield the parts of an area near the map; one that ``keeps`` its form near it stays whole."""
    box = _box_of(rings[0])
    for turn in around.turns(box):
        here = box.moved(turn)
        whole = around.holds(here) or (keeps and around.widened(_NEAR_DEG).holds(here))
        cut = []
        for number, ring in enumerate(rings):
            own = box if number == 0 else _box_of(ring)
            # A hole may be unwrapped to a different turn around the Earth.
            turned = turn if number == 0 else next(iter(around.turns(own)), None)
            if turned is None:
                continue
            shifted = tuple((lon + turned, lat) for lon, lat in ring) if turned else tuple(ring)
            kept = shifted if whole else clipped(shifted, around.bounds)
            if len(kept) >= 3 or (whole and number == 0):
                cut.append(kept)
            elif number == 0:
                break
        if cut:
            yield tuple(cut)


def _finished(feature: Feature, parts: Sequence[Placed], terrain: Terrain) -> tuple[Placed, ...]:
    """Return the parts of a feature in local metres, or everything outside an inclusion fence."""
    if not feature.keeps_in:
        return tuple(parts)
    outside = tuple(
        Placed(
            _outside(
                part.rings[0]
                if part.radius_m is None
                else _circle(part.rings[0][0], part.radius_m),
                terrain,
            ),
            is_tangled=part.is_tangled,
        )
        for part in parts
    ) or (Placed(_outside((), terrain)),)
    holes = [hole for part in parts if part.radius_m is None for hole in part.rings[1:]]
    return (*outside, *(Placed((hole,)) for hole in holes))


def _circle(centre: Position, radius_m: float) -> Ring:
    angles = np.linspace(0, 2 * np.pi, _CIRCLE_CORNERS, endpoint=False)
    x, y = centre[0] + radius_m * np.cos(angles), centre[1] + radius_m * np.sin(angles)
    return tuple(zip(x.tolist(), y.tolist(), strict=True))


def _outside(ring: Ring, terrain: Terrain) -> tuple[Ring, ...]:
    """Return all of the map except a ring."""
    x, y = np.array(ring).reshape(-1, 2).T
    west, east = (
        x.min(initial=0.0) - _BEYOND_M,
        x.max(initial=terrain.width_m) + _BEYOND_M,
    )
    south, north = (
        y.min(initial=0.0) - _BEYOND_M,
        y.max(initial=terrain.height_m) + _BEYOND_M,
    )
    around = ((west, south), (east, south), (east, north), (west, north))
    return (around, ring) if ring else (around,)


def _circle_far_away(lon: float, lat: float, radius_m: float) -> tuple[Position, ...]:
    """Return a polygon around a circle whose centre is too far away to be projected."""
    from pyproj import Geod

    bearings = np.arange(_FAR_CIRCLE_CORNERS) * (360.0 / _FAR_CIRCLE_CORNERS)
    reach = np.full(len(bearings), radius_m / math.cos(math.pi / _FAR_CIRCLE_CORNERS))
    start = np.full(len(bearings), lon), np.full(len(bearings), lat)
    east, north, _ = Geod(ellps="WGS84").fwd(*start, -bearings, reach)
    return tuple(zip(east.tolist(), north.tolist(), strict=True))


def _box_of(ring: Sequence[Position]) -> _Box:
    longitudes, latitudes = zip(*ring, strict=True)
    return _Box(min(longitudes), min(latitudes), max(longitudes), max(latitudes))


def _box_around(terrain: Terrain, beyond: float = 1.0) -> _Box:
    """Return the box of the map in degrees, widened; all longitudes where a pole is near.

    ``beyond`` is a share of the usual width around the map.
    """
    steps = np.linspace(0.0, 1.0, _BORDER_POINTS)
    x = terrain.width_m * np.concatenate((steps, np.ones(33), steps[::-1], np.zeros(33)))
    y = terrain.height_m * np.concatenate((np.zeros(33), steps, np.ones(33), steps[::-1]))
    latitudes, longitudes = terrain.to_geographic(x, y)
    margin_m = beyond * max(_AROUND * max(terrain.width_m, terrain.height_m), _AROUND_M)
    high = margin_m / _DEGREE_M
    south, north = float(latitudes.min()) - high, float(latitudes.max()) + high
    turns = np.unwrap(longitudes, period=360.0)
    poleward = math.cos(math.radians(min(max(abs(south), abs(north)), 90.0)))
    if poleward * _DEGREE_M <= margin_m or abs(turns[-1] - turns[0]) > 180.0:
        middle = float(turns.mean())
        pole = 90.0 if north > 0 else -90.0
        return _Box(middle - 180.0, min(south, pole), middle + 180.0, max(north, pole))
    wide = high / poleward
    return _Box(float(turns.min()) - wide, south, float(turns.max()) + wide, north)
