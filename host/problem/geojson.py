"""Shapes of a GeoJSON file, in metres of a terrain's local frame."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.numeric import is_number
from pathgene.host.problem.rings import Ring
from pathgene.host.terrain import Terrain


__all__ = ["Shape", "shapes"]

# Values of the property ``kind`` of the lines and points in a ``path.geojson`` that are no zones.
_OWN_KINDS = {
    "LineString": ("waypoints", "smoothed track"),
    "Point": ("start", "via", "goal", "return"),
}


class Shape(NamedTuple):
    """A point (one ring of one position) or a polygon (its ring and its holes), with properties."""

    kind: str
    rings: tuple[Ring, ...]
    properties: dict[str, Any]


def shapes(document: Any, terrain: Terrain) -> list[Shape]:
    """Return the points and polygons of GeoJSON; a multi-polygon is several polygons.

    The lines and marks of the path in a ``path.geojson`` are left out, so that its zones can be
    read. A polygon, and a point with ``radius_m``, is kept whatever its properties say.

    Coordinates are WGS84 longitude and latitude, moved into the terrain's frame corner by corner,
    or local metres where the document has the member ``"crs_local": true``. A third coordinate is
    ignored.

    Raises
    ------
    InputError
        If the document has anything else, or has geographic coordinates where the terrain has no
        coordinate reference system.
    """
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
    found = list(_shapes(document, local))
    return found if local else _placed(found, terrain)


def _shapes(document: dict[str, Any], local: bool) -> Iterator[Shape]:
    """Yield the shapes at the positions of the file."""
    for geometry, properties in _geometries(document):
        if _is_own(geometry, properties):
            continue
        kind, coordinates = geometry.get("type"), geometry.get("coordinates")
        if kind == "Point":
            yield Shape("Point", (_positions([coordinates], local),), properties)
        elif kind in ("Polygon", "MultiPolygon"):
            polygons = [coordinates] if kind == "Polygon" else coordinates
            if not isinstance(polygons, list):
                raise InputError(f"the coordinates of a {kind} must be a list.")
            for rings in polygons:
                if not isinstance(rings, list) or not rings:
                    raise InputError(f"a {kind} must have at least one ring.")
                yield Shape("Polygon", tuple(_positions(ring, local) for ring in rings), properties)
        else:
            raise InputError(
                "a geometry must be a Polygon, a MultiPolygon or a Point with "
                f'"radius_m", not {kind!r}.'
            )


def _is_own(geometry: dict[str, Any], properties: dict[str, Any]) -> bool:
    """Return whether a feature is a line or a mark that ``path.geojson`` has beside the zones."""
    kinds = _OWN_KINDS.get(str(geometry.get("type")), ())
    return properties.get("kind") in kinds and properties.get("radius_m") is None


def _check_wgs84(document: dict[str, Any]) -> None:
    """Refuse the reference systems of the old GeoJSON, rather than misread them as WGS84."""
    if document.get("crs") is None:
        return
    name = json.dumps(document["crs"])
    if not any(known in name for known in ("CRS84", "EPSG::4326", "EPSG:4326")):
        raise InputError("its coordinates are not WGS84 longitude and latitude; convert it first.")


def _geometries(document: dict[str, Any]) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """Geometries and their properties of a FeatureCollection, a Feature or a bare geometry."""
    if document.get("type") == "FeatureCollection":
        features = document.get("features")
        if not isinstance(features, list):
            raise InputError('a FeatureCollection must have a list of "features".')
        yield from map(_geometry, features)
    else:
        yield _geometry(document)


def _geometry(feature: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the geometry and the properties of a Feature or a bare geometry."""
    if not isinstance(feature, dict):
        raise InputError("a feature is not a GeoJSON object.")
    if feature.get("type") != "Feature":
        return feature, {}
    geometry, properties = feature.get("geometry"), feature.get("properties") or {}
    if not isinstance(geometry, dict) or not isinstance(properties, dict):
        raise InputError('a Feature must have a "geometry".')
    return geometry, properties


def _positions(points: Any, local: bool) -> Ring:
    """Return positions of the file, whose heights are ignored."""
    if not isinstance(points, list) or not all(
        isinstance(point, list) and len(point) >= 2 and all(map(is_number, point[:2]))
        for point in points
    ):
        raise InputError("a position must be a list of two finite numbers.")
    pairs = tuple((float(point[0]), float(point[1])) for point in points)
    for longitude, latitude in pairs:
        if not local and (abs(longitude) > 180 or abs(latitude) > 90):
            raise InputError(
                f"({longitude:g}, {latitude:g}) is no WGS84 longitude and latitude; "
                'for local metres add the member "crs_local": true.'
            )
    return pairs


def _placed(found: list[Shape], terrain: Terrain) -> list[Shape]:
    """Move shapes from WGS84 into the terrain's frame, all at once: each call takes a while."""
    pairs = [pair for shape in found for ring in shape.rings for pair in ring]
    longitudes, latitudes = np.array(pairs).reshape(-1, 2).T
    x, y = terrain.to_local(latitudes, longitudes)
    local = zip(x.tolist(), y.tolist(), strict=True)
    return [
        shape._replace(rings=tuple(tuple(islice(local, len(ring))) for ring in shape.rings))
        for shape in found
    ]
