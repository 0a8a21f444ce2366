"""GeoJSON: paths and zones, in WGS84 degrees or in metres of a terrain's local frame."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.files.output import json_bytes, reading
from pathgene.host.formats.content import Content
from pathgene.host.formats.places import DEGREE_DECIMALS
from pathgene.host.formats.shapes import Ring, Shape, wound
from pathgene.host.formats.track import Point, Track
from pathgene.host.inputs import parse_json, read_text
from pathgene.host.numeric import is_number, rows
from pathgene.host.terrain import Terrain


__all__ = ["heights_datum", "path_document", "read_path", "recognises", "write", "zones"]

# Values of the property ``kind`` of the lines and points in a ``path.geojson`` that are not zones.
_OWN_KINDS = {
    "LineString": ("waypoints", "smoothed track"),
    "Point": ("start", "via", "goal", "return"),
}


def write(track: Track) -> bytes:
    """Return a FeatureCollection, with points of the track one terrain cell apart."""
    return json_bytes(path_document(track, min(track.terrain.dx_m, track.terrain.dy_m)))


def path_document(track: Track, step_m: float) -> dict[str, Any]:
    """Return a FeatureCollection: waypoints and smoothed track, the points of the mission, zones.

    The first two features are LineStrings. The points of the mission are Points with a ``name``, in
    the order of the flight. A circular zone is a Point with the property ``radius_m``, as
    :func:`zones` reads it. Positions are WGS84 longitude, latitude and altitude if the terrain has
    a CRS; otherwise they are local metres, and the member ``crs_local`` is true.

    Parameters
    ----------
    track : Track
        The path.
    step_m : float
        Maximum distance between points of the smoothed track, metres.
    """
    terrain = track.terrain
    samples = track.curve.sample(step_m)
    smooth = np.stack((samples.x, samples.y, samples.z), axis=1)
    document: dict[str, Any] = {"type": "FeatureCollection"}
    if terrain.crs is None:
        document["crs_local"] = True
    document["heights"] = heights_datum(terrain)
    corners, flown = _positions_of(track.waypoints, terrain), _positions_of(smooth, terrain)
    document["features"] = [
        _feature("LineString", corners, {"kind": "waypoints"}),
        _feature("LineString", flown, {"kind": "smoothed track", "length_m": track.curve.length_m}),
        *_marks(track.points, terrain),
        *_zone_features(track.zones, terrain),
    ]
    return document


def _marks(points: Sequence[tuple[str, Point]], terrain: Terrain) -> Iterator[dict[str, Any]]:
    """Yield the points of a mission as features."""
    places = _positions_of(np.array([place for _, place in points], dtype=np.float64), terrain)
    for (name, _), place in zip(points, places, strict=True):
        yield _feature("Point", place, {"kind": name.split()[0].lower(), "name": name})


def heights_datum(terrain: Terrain) -> str:
    """Return the datum of the altitudes of a terrain, and of paths over it."""
    system = re.search(r'VERT(?:_CS|CRS)\["([^"]+)"', terrain.crs or "")
    if system:
        return f"AMSL ({system.group(1)})"
    if "SRTM" in terrain.source or terrain.source.lower().endswith(".hgt"):
        return "AMSL (EGM96, the geoid of SRTM)"
    return f"AMSL (the datum of the terrain {terrain.name!r}, which its file does not name)"


def _zone_features(zones: Sequence[Shape], terrain: Terrain) -> Iterator[dict[str, Any]]:
    """Yield zones as features; all positions are converted at once, because each call is slow."""
    closed = [_closed(zone) for zone in zones]
    corners = np.array([corner for rings in closed for ring in rings for corner in ring])
    positions = iter(_positions_of(corners.reshape(-1, 2), terrain))
    for zone, rings in zip(zones, closed, strict=True):
        placed = [list(islice(positions, len(ring))) for ring in rings]
        coordinates = placed[0][0] if zone.kind == "Point" else placed
        yield _feature(zone.kind, coordinates, {"kind": "zone", **zone.properties})


def _closed(zone: Shape) -> Sequence[Ring]:
    """Return the closed rings of a zone, metres; the centre of a circle."""
    if zone.kind == "Point":
        return zone.rings
    outer, *holes = zone.rings
    # Outer rings are counter-clockwise and holes clockwise, as RFC 7946 requires.
    rings = [wound(outer, left=True), *(wound(hole, left=False) for hole in holes)]
    return [(*ring, ring[0]) for ring in rings]


def _positions_of(points: NDArray[np.float64], terrain: Terrain) -> list[list[float]]:
    """Return points (n, 2 or 3) as GeoJSON positions."""
    if terrain.crs is None:
        plain: list[list[float]] = points.tolist()
        return plain
    latitude, longitude = terrain.to_geographic(points[:, 0], points[:, 1])
    return [
        [round(east, DEGREE_DECIMALS), round(north, DEGREE_DECIMALS), *rest]
        for east, north, rest in zip(
            longitude.tolist(), latitude.tolist(), points[:, 2:].tolist(), strict=True
        )
    ]


def _feature(kind: str, coordinates: Any, properties: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "Feature",
        "properties": properties,
        "geometry": {"type": kind, "coordinates": coordinates},
    }


def read_path(file: Path, terrain: Terrain) -> NDArray[np.float64]:
    """Return the first LineString of a GeoJSON file as waypoints, (n, 3) float64 metres.

    Raises
    ------
    InputError
        If the file cannot be read, has no LineString with altitudes, or its positions are
        geographic and the terrain has no CRS.
    """
    try:
        with reading("path", file):
            document = parse_json(read_text(file))
    except ValueError:
        raise InputError(f"{file}: not JSON; give GeoJSON, a CSV or a summary.") from None
    positions = _first_line(document)
    if positions is None:
        raise InputError(
            f"{file}: there is no LineString in it to take as the path; give GeoJSON with one, a "
            "CSV or a summary."
        )
    try:
        points = rows(positions, 3)
    except ValueError:
        points = np.empty(0)
    if len(points) < 2:
        raise InputError(
            f"{file}: the LineString must have two or more positions of three numbers "
            "each, the third the altitude."
        )
    if document.get("crs_local") is True:
        return points
    if terrain.crs is None:
        raise InputError(
            f"{file}: its positions are geographic, which a terrain without a "
            "coordinate reference system cannot place; give local metres with "
            '"crs_local": true.'
        )
    x, y = terrain.to_local(points[:, 1], points[:, 0])
    return np.stack((x, y, points[:, 2]), axis=1)


def _first_line(document: Any) -> Any:
    """Return the coordinates of the first LineString in a collection, a feature or a geometry."""
    if not isinstance(document, dict):
        return None
    if document.get("type") == "LineString":
        return document.get("coordinates")
    features = document.get("features")
    for feature in features if isinstance(features, list) else [document]:
        geometry = feature.get("geometry") if isinstance(feature, dict) else None
        if isinstance(geometry, dict) and geometry.get("type") == "LineString":
            return geometry.get("coordinates")
    return None


def recognises(content: Content) -> bool:
    """Return whether a text is JSON."""
    return content.json_error is None


def zones(content: Content, terrain: Terrain) -> list[Shape]:
    """Return the points and polygons of GeoJSON; a multi-polygon is several polygons.

    The lines and marks of the path in a ``path.geojson`` are left out, so that its zones can be
    read. A polygon, and a point with ``radius_m``, is kept whatever its properties say.

    Coordinates are WGS84 longitude and latitude, converted to the terrain's frame corner by corner,
    or local metres if the document has the member ``"crs_local": true``. A third coordinate is
    ignored.

    Raises
    ------
    InputError
        If the document has anything else, or has geographic coordinates although the terrain has no
        coordinate reference system.
    """
    document = content.json
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
    """Return whether a feature is a line or mark that ``path.geojson`` adds to zones."""
    kinds = _OWN_KINDS.get(str(geometry.get("type")), ())
    return properties.get("kind") in kinds and properties.get("radius_m") is None


def _check_wgs84(document: dict[str, Any]) -> None:
    """Refuse the reference systems of old GeoJSON instead of misreading them as WGS84."""
    if document.get("crs") is None:
        return
    name = json.dumps(document["crs"])
    if not any(known in name for known in ("CRS84", "EPSG::4326", "EPSG:4326")):
        raise InputError("its coordinates are not WGS84 longitude and latitude; convert it first.")


def _geometries(document: dict[str, Any]) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """Geometries of a FeatureCollection, a Feature or a bare geometry, with their properties."""
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
    """Convert shapes from WGS84 to the terrain's frame, all at once, because each call is slow."""
    pairs = [pair for shape in found for ring in shape.rings for pair in ring]
    longitudes, latitudes = np.array(pairs).reshape(-1, 2).T
    x, y = terrain.to_local(latitudes, longitudes)
    local = zip(x.tolist(), y.tolist(), strict=True)
    return [
        shape._replace(rings=tuple(tuple(islice(local, len(ring))) for ring in shape.rings))
        for shape in found
    ]
