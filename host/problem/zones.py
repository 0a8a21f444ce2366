"""No-fly zones: circles and polygons, their raster, GeoJSON and the form they have in a summary.

A zone is a cylinder of infinite height. Source: Roberge and Tarbouchi, section 3.1; polygons are
ours.
"""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.errors import InputError
from host.terrain import Terrain


__all__ = ["Circle", "Polygon", "Zone", "raster", "read_geojson", "zone_from_dict"]

# Nodes this near an edge are on it: products like 7 * 30.87 carry rounding, borders do not.
_EDGE_M = 1e-6

Ring = tuple[tuple[float, float], ...]


class Zone(ABC):
    """A no-fly zone: a cylinder of infinite height over a circle or a polygon."""

    @staticmethod
    def circle(x_m: float, y_m: float, radius_m: float) -> Circle:
        """Return the circle around (``x_m``, ``y_m``), metres in the terrain's local frame.

        Raises
        ------
        InputError
            If a value is not a finite number, or the radius is negative.
        """
        return Circle(x_m, y_m, radius_m)

    @staticmethod
    def polygon(
        corners: Sequence[Sequence[float]],
        holes: Sequence[Sequence[Sequence[float]]] = (),
    ) -> Polygon:
        """Return the polygon with ``corners`` (x, y) in either direction, less its ``holes``.

        Raises
        ------
        InputError
            If a ring has fewer than three corners or a coordinate that is not a finite number, or
            ``holes`` are no rings.
        """
        try:
            rings = [_plain(hole) for hole in holes]
        except TypeError:
            raise InputError(f"No-fly polygon: holes must be rings, not {holes!r}.") from None
        return Polygon(_ring(_plain(corners)), tuple(map(_ring, rings)))

    @staticmethod
    def read(path: str | Path, terrain: Terrain) -> tuple[Zone, ...]:
        """Read the zones of a GeoJSON file; see :func:`read_geojson`."""
        return read_geojson(path, terrain)

    @abstractmethod
    def covers(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return the nodes inside, (ny, nx) bool, of a grid of columns ``x`` and rows ``y``."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The zone as in ``summary.json``."""


@dataclass(frozen=True)
class Circle(Zone):
    """A circular zone around (``x_m``, ``y_m``), local metres.

    A node is in it when its distance to the axis is at most ``radius_m``, which is 0 or more.

    Raises
    ------
    InputError
        If a value is not a finite number, or the radius is negative.
    """

    x_m: float
    y_m: float
    radius_m: float

    def __post_init__(self) -> None:
        for name in ("x_m", "y_m", "radius_m"):
            value = getattr(self, name)
            if not _is_number(value):
                raise InputError(f"No-fly circle: {name} must be a finite number, not {value!r}.")
            object.__setattr__(self, name, float(value))
        if self.radius_m < 0:
            raise InputError(
                f"No-fly circle: radius_m must not be negative, not {self.radius_m:g}."
            )

    def covers(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return the nodes inside, (ny, nx) bool, of a grid of columns ``x`` and rows ``y``."""
        inside: NDArray[np.bool_] = (
            np.hypot(x[None, :] - self.x_m, y[:, None] - self.y_m) <= self.radius_m
        )
        return inside

    def to_dict(self) -> dict[str, Any]:
        """The zone as in ``summary.json``."""
        return {"x": self.x_m, "y": self.y_m, "radius_m": self.radius_m}


@dataclass(frozen=True)
class Polygon(Zone):
    """A polygonal zone, local metres.

    A node is in it when it lies inside ``ring`` and not inside a hole, or on an edge of either
    (within a micrometre). A ring that crosses itself covers by the even-odd rule.

    Parameters
    ----------
    ring : tuple of (x, y)
        At least three corners in either direction; a closing corner equal to the first is dropped.
    holes : tuple of rings
        Parts left out, inside ``ring``.

    Raises
    ------
    InputError
        If a ring has fewer than three corners or a coordinate that is not a finite number.
    """

    ring: Ring
    holes: tuple[Ring, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "ring", _ring(self.ring))
        object.__setattr__(self, "holes", tuple(_ring(hole) for hole in self.holes))

    def covers(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return the nodes inside, (ny, nx) bool, of a grid of columns ``x`` and rows ``y``."""
        inside = np.zeros((len(y), len(x)), dtype=bool)
        for ring in (self.ring, *self.holes):
            inside ^= _inside(ring, x, y)
        for ring in (self.ring, *self.holes):
            _add_edges(inside, ring, x, y)
        return inside

    def to_dict(self) -> dict[str, Any]:
        """The zone as in ``summary.json``; ``holes`` only where there are some."""
        table: dict[str, Any] = {"polygon": [list(corner) for corner in self.ring]}
        if self.holes:
            table["holes"] = [[list(corner) for corner in hole] for hole in self.holes]
        return table


def raster(zones: Iterable[Zone], terrain: Terrain) -> NDArray[np.bool_]:
    """Return the nodes of ``terrain`` in a zone, (ny, nx) bool, row 0 the southernmost."""
    rows, columns = terrain.elevation.shape
    x: NDArray[np.float64] = np.arange(columns, dtype=np.float64) * terrain.dx_m
    y: NDArray[np.float64] = np.arange(rows, dtype=np.float64) * terrain.dy_m
    inside = np.zeros((rows, columns), dtype=bool)
    for zone in zones:
        inside |= zone.covers(x, y)
    return inside


def zone_from_dict(table: Any) -> Zone:
    """Make a zone from the form it has in ``summary.json``.

    Raises
    ------
    InputError
        If the form is neither a circle's nor a polygon's, or its values are bad.
    """
    if isinstance(table, dict) and set(table) == {"x", "y", "radius_m"}:
        return Circle(table["x"], table["y"], table["radius_m"])
    if isinstance(table, dict) and "polygon" in table and set(table) <= {"polygon", "holes"}:
        holes = table.get("holes", [])
        if isinstance(holes, list):
            return Polygon(table["polygon"], tuple(holes))
    raise InputError(
        'A no-fly zone must be {"x", "y", "radius_m"} or {"polygon": [[x, y], ...]}, '
        f"not {table!r}."
    )


def read_geojson(path: str | Path, terrain: Terrain) -> tuple[Zone, ...]:
    """Read zones from a GeoJSON file.

    Polygons and multi-polygons, with holes, and points with the property ``radius_m``, in metres of
    the terrain's plane. Coordinates are WGS84 longitude and latitude, moved into the terrain's
    frame corner by corner, or local metres where the file has the member ``"crs_local": true``.
    A third coordinate is ignored.

    Raises
    ------
    InputError
        If the file cannot be read or is not such GeoJSON, or has geographic coordinates where the
        terrain has no coordinate reference system.
    """
    try:
        document = json.loads(Path(path).read_text("utf-8"))
    except OSError as error:
        reason = error.strerror or "unknown reason"
        raise InputError(f"Cannot read no-fly file {str(path)!r}: {reason}.") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"No-fly file {str(path)!r} is not JSON: {error}.") from None
    try:
        return tuple(_zones(document, terrain))
    except InputError as error:
        raise InputError(f"No-fly file {str(path)!r}: {error}") from None


def _zones(document: Any, terrain: Terrain) -> Iterator[Zone]:
    if not isinstance(document, dict):
        raise InputError("not a GeoJSON object.")
    local = document.get("crs_local", False)
    if not isinstance(local, bool):
        raise InputError(f'"crs_local" must be true or false, not {local!r}.')
    if not local:
        _check_wgs84(document)
        if terrain.crs is None:
            raise InputError(
                "the terrain has no coordinate reference system, so give the zones in "
                'local metres and add the member "crs_local": true.'
            )
    for geometry, properties in _geometries(document):
        kind, coordinates = geometry.get("type"), geometry.get("coordinates")
        if kind == "Point":
            radius = properties.get("radius_m")
            if radius is None:
                raise InputError('a Point needs the property "radius_m".')
            ((x, y),) = _local([coordinates], terrain, local)
            yield Circle(x, y, radius)
        elif kind in ("Polygon", "MultiPolygon"):
            polygons = [coordinates] if kind == "Polygon" else coordinates
            if not isinstance(polygons, list):
                raise InputError(f"the coordinates of a {kind} must be a list.")
            for rings in polygons:
                if not isinstance(rings, list) or not rings:
                    raise InputError(f"a {kind} must have at least one ring.")
                outer, *holes = (_local(ring, terrain, local) for ring in rings)
                yield Polygon(outer, tuple(holes))
        else:
            raise InputError(
                "a geometry must be a Polygon, a MultiPolygon or a Point with "
                f'"radius_m", not {kind!r}.'
            )


def _check_wgs84(document: dict[str, Any]) -> None:
    """Refuse the reference systems of the old GeoJSON, rather than misread them as WGS84."""
    if document.get("crs") is None:
        return
    name = json.dumps(document["crs"])
    if not any(known in name for known in ("CRS84", "EPSG::4326", "EPSG:4326")):
        raise InputError("its coordinates are not WGS84 longitude and latitude; convert it first.")


def _geometries(document: Any) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """Geometries and their properties of a FeatureCollection, a Feature or a bare geometry."""
    if not isinstance(document, dict):
        raise InputError("a feature is not a GeoJSON object.")
    if document.get("type") == "FeatureCollection":
        features = document.get("features")
        if not isinstance(features, list):
            raise InputError('a FeatureCollection must have a list of "features".')
        for feature in features:
            yield from _geometries(feature)
    elif document.get("type") == "Feature":
        geometry, properties = document.get("geometry"), document.get("properties") or {}
        if not isinstance(geometry, dict) or not isinstance(properties, dict):
            raise InputError('a Feature must have a "geometry".')
        yield geometry, properties
    else:
        yield document, {}


def _local(points: Any, terrain: Terrain, local: bool) -> Ring:
    """Positions of the file as x, y in the terrain's frame, metres."""
    if not isinstance(points, list) or not all(
        isinstance(point, list) and len(point) >= 2 and all(map(_is_number, point[:2]))
        for point in points
    ):
        raise InputError("a position must be a list of two finite numbers.")
    pairs = tuple((float(point[0]), float(point[1])) for point in points)
    if local:
        return pairs
    for longitude, latitude in pairs:
        if abs(longitude) > 180 or abs(latitude) > 90:
            raise InputError(
                f"({longitude:g}, {latitude:g}) is no WGS84 longitude and latitude; "
                'for local metres add the member "crs_local": true.'
            )
    longitudes, latitudes = np.array(pairs).reshape(-1, 2).T
    x, y = terrain.to_local(latitudes, longitudes)
    return tuple(zip(x.tolist(), y.tolist(), strict=True))


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)


def _plain(corners: Any) -> Any:
    """Return the corners of an array, of numpy for example, as a list of pairs."""
    return corners.tolist() if hasattr(corners, "tolist") else corners


def _ring(corners: Any) -> Ring:
    if not isinstance(corners, list | tuple) or not all(
        isinstance(corner, list | tuple) and len(corner) == 2 and all(map(_is_number, corner))
        for corner in corners
    ):
        raise InputError("No-fly polygon: every corner must be two finite numbers, x and y.")
    ring = tuple((float(x), float(y)) for x, y in corners)
    if len(ring) > 1 and ring[0] == ring[-1]:
        ring = ring[:-1]
    if len(ring) < 3:
        raise InputError(f"No-fly polygon: a ring must have at least 3 corners, not {len(ring)}.")
    return ring


def _edges(ring: Ring) -> Iterator[tuple[float, float, float, float]]:
    for (xa, ya), (xb, yb) in zip(ring, (*ring[1:], ring[0]), strict=True):
        yield xa, ya, xb, yb


def _inside(ring: Ring, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Even-odd rule on the grid of ``x`` and ``y``; nodes on an edge may go either way."""
    crossings = np.zeros((len(y), len(x)), dtype=bool)
    for xa, ya, xb, yb in _edges(ring):
        rows = np.flatnonzero((ya <= y) != (yb <= y))
        if len(rows):
            border = xa + (y[rows] - ya) * ((xb - xa) / (yb - ya))
            crossings[rows] ^= x[None, :] < border[:, None]
    return crossings


def _add_edges(
    inside: NDArray[np.bool_],
    ring: Ring,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
) -> None:
    """Set the nodes of ``inside`` that lie on an edge of ``ring``."""
    for xa, ya, xb, yb in _edges(ring):
        west, east = np.searchsorted(x, (min(xa, xb) - _EDGE_M, max(xa, xb) + _EDGE_M))
        south, north = np.searchsorted(y, (min(ya, yb) - _EDGE_M, max(ya, yb) + _EDGE_M))
        if west == east or south == north:
            continue
        px, py = x[None, west:east] - xa, y[south:north, None] - ya
        ex, ey = xb - xa, yb - ya
        square = ex * ex + ey * ey
        along = np.clip((px * ex + py * ey) / square, 0, 1) if square > 0 else 0.0
        inside[south:north, west:east] |= np.hypot(px - along * ex, py - along * ey) <= _EDGE_M
