"""GeoJSON: paths and zones, in WGS84 degrees or in metres of a terrain's local frame."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.files.output import json_bytes, reading
from pathgene.host.formats.areas import (
    MOST_NAME,
    Placing,
    areas,
    named_system,
    require_outside,
    unread,
    unread_texts,
)
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import (
    Bad,
    Edges,
    Feature,
    LeftOut,
    Read,
    label,
)
from pathgene.host.formats.limits import Own, own_limits, plain_number, stated_limits
from pathgene.host.formats.places import DEGREE_DECIMALS
from pathgene.host.formats.shapes import Ring, Shape, wound
from pathgene.host.formats.track import Point, Track
from pathgene.host.inputs import parse_json, read_text
from pathgene.host.numeric import is_number, rows
from pathgene.host.terrain import Terrain


__all__ = ["features", "heights_datum", "path_document", "read_path", "recognises", "write"]

# Values of the property ``kind`` of the lines and points in a ``path.geojson`` that are not zones.
_OWN_KINDS = {
    "LineString": ("waypoints", "smoothed track"),
    "Point": ("start", "via", "goal", "return"),
}
# Properties of a zone that are numbers, and all that are read.
_NUMBERS = ("radius_m", "t0", "t1")
_NAMES = ("name", "Name", "NAME", "title")
_READ = (*_NUMBERS, "lower", "upper", *_NAMES, "kind")
# Properties that make a line a corridor; stroke-width and the like are of its drawing.
_WIDTHS = re.compile(r"buffer|radius|width(?![a-z])|corridor", re.IGNORECASE)


def write(track: Track) -> bytes:
    """Return a FeatureCollection, with points of the track one terrain cell apart."""
    return json_bytes(path_document(track, min(track.terrain.dx_m, track.terrain.dy_m)))


def path_document(track: Track, step_m: float) -> dict[str, Any]:
    """Return a FeatureCollection: waypoints and smoothed track, the points of the mission, zones.

    The first two features are LineStrings. The points of the mission are Points with a ``name``, in
    the order of the flight. A circular zone is a Point with the property ``radius_m``, as
    :func:`features` reads it. Positions are WGS84 longitude, latitude and altitude if the
    terrain has a CRS; otherwise they are local metres, and the member ``crs_local`` is true.

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
    heights = terrain.reading.facts.get("heights", {})
    if heights.get("datum") == "ellipsoid":
        return "above the ellipsoid WGS84, not AMSL"
    if heights.get("datum_from", "assumed") != "assumed":
        return f"AMSL ({heights['datum']})"
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


def features(content: Content) -> Iterator[Read]:
    """Yield the polygons and circles of GeoJSON; a multi-polygon is several polygons.

    A circle is a point with the property ``radius_m``; so is each point of a multi-point. A closed
    line, and a point with a radius by another name, are bad. Other points, and lines, are left
    out. The lines and marks of the path in a ``path.geojson`` are passed over, so that its zones
    can be read. A polygon, and a point with ``radius_m``, is kept whatever its properties say.

    Coordinates are longitude and latitude, or local metres if the document has the member
    ``"crs_local": true``. A third coordinate is ignored.

    Raises
    ------
    InputError
        If the document is not GeoJSON, or its reference system is unknown.
    """
    document = content.json
    if isinstance(document, list):
        raise InputError(
            'it is a bare list; put its features into {"type": "FeatureCollection", "features": '
            "[...]}."
        )
    if not isinstance(document, dict):
        raise InputError("not a GeoJSON object.")
    if kind := _other_kind(document):
        raise InputError(f"it is {kind}, not GeoJSON; save or request it as GeoJSON.")
    local = document.get("crs_local", False)
    if not isinstance(local, bool):
        raise InputError(f'"crs_local" must be true or false, not {local!r}.')
    placing = Placing(local, None if local else named_system(document))
    # The edges of a file of our own are straight in the frame of the terrain.
    is_own = isinstance(document.get("heights"), str)
    for number, feature in enumerate(_members(document), start=1):
        yield from _read(number, feature, placing, is_own)


def _other_kind(document: dict[str, Any]) -> str:
    """Return the kind of JSON with areas that is not GeoJSON, or an empty string."""
    if document.get("type") == "Topology":
        return "TopoJSON"
    listed = document.get("features")
    first = listed[0] if isinstance(listed, list) and listed else None
    return "the JSON of ArcGIS" if isinstance(first, dict) and "attributes" in first else ""


def _members(document: dict[str, Any]) -> list[Any]:
    """Return the members of a FeatureCollection; a Feature or a bare geometry stands for itself."""
    if document.get("type") != "FeatureCollection":
        return [document]
    members = document.get("features")
    if not isinstance(members, list):
        raise InputError('a FeatureCollection must have a list of "features".')
    return members


def _read(number: int, feature: Any, placing: Placing, is_own: bool) -> Iterator[Read]:
    """Yield the areas of a feature."""
    if not isinstance(feature, dict):
        yield Bad(label("feature", number), "it is not a GeoJSON object.")
        return
    is_feature = feature.get("type") == "Feature"
    properties = (feature.get("properties") or {}) if is_feature else {}
    if not isinstance(properties, dict):
        yield Bad(label("feature", number), "its properties must be an object.")
        return
    name = _name(properties)
    tag = label("feature", number, name)
    geometry = feature.get("geometry") if is_feature else feature
    if geometry is None and (not is_feature or "geometry" in feature):
        yield LeftOut(tag, "it has no geometry")
        return
    if isinstance(geometry, dict) and _is_own(geometry, properties):
        return
    try:
        found, others = areas(geometry, placing, is_circle=properties.get("radius_m") is not None)
        require_outside(properties)
        common = _numbers(properties)
        heights = _heights(properties)
    except InputError as error:
        yield Bad(tag, str(error))
        return
    if not found and not others:
        yield LeftOut(tag, "its geometry is empty")
    for kind in dict.fromkeys(others):
        yield _left_out(tag, kind, properties)
    for rings in found:
        is_circle = len(rings) == 1 and len(rings[0]) == 1
        yield Feature(
            number,
            name,
            rings,
            radius_m=common["radius_m"] if is_circle else None,
            lower=heights.lower,
            upper=heights.upper,
            edges=Edges.FRAME if is_own and properties.get("kind") == "zone" else Edges.DEGREES,
            t0_s=common["t0"],
            t1_s=common["t1"],
            is_local=placing.is_local,
            unread=unread(properties, _read_names(is_circle=is_circle, more=heights.read)),
            # Files of our own always state metres above sea level by numbers.
            remarks=()
            if is_own
            else (*heights.remarks, *unread_texts(properties, properties.get("description"))),
        )


def _read_names(*, is_circle: bool, more: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the properties that are read; a radius is not of a polygon."""
    return tuple(name for name in (*_READ, *more) if is_circle or name != "radius_m")


def _left_out(tag: str, kind: str, properties: dict[str, Any]) -> LeftOut | Bad:
    """Return the reason why a point or line is no zone; one that may forbid flight is bad."""
    sized = next((key for key in properties if "radius" in key.lower()), None)
    if kind in ("Point", "MultiPoint") and sized is not None:
        return Bad(tag, f'the radius of a circle is the property "radius_m", not {sized!r}.')
    if kind.startswith("closed"):
        return Bad(tag, f"a {kind} is not an area; save it as a polygon.")
    wide = next((key for key in properties if _WIDTHS.match(key)), None)
    if wide is not None:
        reason = f"a {kind} is not an area, also with {wide!r}; draw its corridor as a polygon"
        return LeftOut(tag, reason, True)
    return LeftOut(tag, f"a {kind} is not an area")


def _name(properties: dict[str, Any]) -> str:
    """Return the name of a feature: names are for people, and some programs write numbers."""
    found = next((properties[key] for key in _NAMES if properties.get(key) is not None), "")
    return " ".join(str(found).split())[:MOST_NAME] if isinstance(found, str | int | float) else ""


def _numbers(properties: dict[str, Any]) -> dict[str, float | None]:
    """Return radius and times of a feature; None for no limit."""
    values: dict[str, float | None] = {}
    for key in _NUMBERS:
        value = plain_number(properties.get(key))
        if value is not None and not is_number(value):
            raise InputError(f"{key} must be a finite number, not {value!r}.")
        values[key] = None if value is None else float(value)
    return values


def _heights(properties: dict[str, Any]) -> Own:
    """Return the limits: our own in metres AMSL, or as foreign properties state them."""
    own = own_limits(properties)
    if any(properties.get(key) is not None for key in ("lower", "upper")):
        return own
    return stated_limits(properties)


def _is_own(geometry: dict[str, Any], properties: dict[str, Any]) -> bool:
    """Return whether a feature is a line or mark that ``path.geojson`` adds to zones."""
    kinds = _OWN_KINDS.get(str(geometry.get("type")), ())
    return properties.get("kind") in kinds and properties.get("radius_m") is None
