"""KML for Google Earth and other viewers: the track in the air, the zones with their heights."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.formats.content import Content
from pathgene.host.formats.places import degrees, number_text
from pathgene.host.formats.shapes import Ring, Shape
from pathgene.host.formats.track import Track
from pathgene.host.numeric import parse
from pathgene.host.terrain import Terrain


__all__ = ["recognises", "write", "zones"]

# The numeric extended data of a zone.
_NUMBERS = ("radius_m", "lower", "upper", "t0", "t1")
_NAMESPACE = "http://www.opengis.net/kml/2.2"
# Corners of the polygon drawn around a circle.
_CIRCLE_CORNERS = 72
# A zone without an upper limit is drawn up to this height above everything.
_DRAWN_ABOVE_M = 300.0
# Maximum distance between points of the track.
_STEP_M = 25.0
# Colours are alpha, blue, green, red.
_STYLES = {
    "track": {"LineStyle": {"color": "ff00a5ff", "width": "3"}, "PolyStyle": {"color": "4000a5ff"}},
    "zone": {"LineStyle": {"color": "ff0000c0", "width": "1"}, "PolyStyle": {"color": "600000ff"}},
}


def write(track: Track) -> bytes:
    """Return a KML document: the smoothed track, its waypoints and the zones.

    The waypoints at the start, via points, goal and return are named. Each zone states its name,
    height limits and times as extended data, and a circle also its centre and radius, so that
    :func:`zones` reads the same zones back.
    """
    terrain = track.terrain
    samples = track.curve.sample(_STEP_M)
    root = ET.Element("kml", xmlns=_NAMESPACE)
    document = ET.SubElement(root, "Document")
    _add(document, "name", terrain.name)
    for style, parts in _STYLES.items():
        element = ET.SubElement(document, "Style", id=style)
        for part, values in parts.items():
            inner = ET.SubElement(element, part)
            for key, value in values.items():
                _add(inner, key, value)

    line = ET.SubElement(_placemark_in(document, "Track", "track"), "LineString")
    _add(line, "extrude", "1")
    _add(line, "altitudeMode", "absolute")
    _add(line, "coordinates", _positions(terrain, samples.x, samples.y, samples.z))
    folder = ET.SubElement(document, "Folder")
    _add(folder, "name", "Waypoints")
    for number, (x, y, z) in enumerate(track.waypoints):
        title = track.names.get(number, f"Waypoint {number}")
        point = ET.SubElement(_placemark_in(folder, title), "Point")
        _add(point, "altitudeMode", "absolute")
        _add(point, "coordinates", _positions(terrain, [x], [y], [z]))
    top_m = max(terrain.highest, float(track.waypoints[:, 2].max())) + _DRAWN_ABOVE_M
    folder = ET.SubElement(document, "Folder")
    _add(folder, "name", "No-fly zones")
    for number, zone in enumerate(track.zones, start=1):
        _add_zone(folder, zone, f"Zone {number}", terrain, top_m)

    ET.indent(root, " ")
    # Without a declaration: UTF-8 is the default, and some readers refuse a declaration in text.
    return f"{ET.tostring(root, encoding='unicode')}\n".encode()


def _add_zone(folder: ET.Element, zone: Shape, title: str, terrain: Terrain, top_m: float) -> None:
    """Add a zone: a prism from its lower limit, or the ground, to its upper limit."""
    limits = {key: value for key, value in zone.properties.items() if key != "radius_m"}
    name = limits.get("name", "")
    placemark = _placemark_in(folder, name or title, "zone")
    facts = {"pathgene": "zone", "name": name, "lower": "none", "upper": "none"}
    facts |= {key: str(value) for key, value in limits.items()}
    rings = zone.rings
    if zone.kind == "Point":
        ((x, y),) = zone.rings[0]
        radius_m = zone.properties["radius_m"]
        ((lat, lon),) = degrees(terrain, np.array([x]), np.array([y]))
        facts |= {
            "centre": f"{number_text(lon)},{number_text(lat)}",
            "radius_m": str(radius_m),
        }
        rings = (_around(x, y, radius_m),)
    data = ET.SubElement(placemark, "ExtendedData")
    for key, value in facts.items():
        _add(ET.SubElement(data, "Data", name=key), "value", value)

    upper_m, lower_m = limits.get("upper", top_m), limits.get("lower")
    if lower_m is None:
        _polygon(placemark, terrain, rings, upper_m, extrude=True)
        return
    # KML extrudes only to the ground: lid, bottom and walls make the prism.
    parts = ET.SubElement(placemark, "MultiGeometry")
    _polygon(parts, terrain, rings, upper_m)
    _polygon(parts, terrain, rings, lower_m)
    for ring in rings:
        for (xa, ya), (xb, yb) in pairwise((*ring, ring[0])):
            wall = ET.SubElement(parts, "Polygon")
            _add(wall, "altitudeMode", "absolute")
            heights = [lower_m, lower_m, upper_m, upper_m, lower_m]
            places = _positions(terrain, [xa, xb, xb, xa, xa], [ya, yb, yb, ya, ya], heights)
            boundary = ET.SubElement(ET.SubElement(wall, "outerBoundaryIs"), "LinearRing")
            _add(boundary, "coordinates", places)


def _polygon(
    parent: ET.Element,
    terrain: Terrain,
    rings: Iterable[Ring],
    altitude_m: float,
    *,
    extrude: bool = False,
) -> None:
    """Add a horizontal polygon, whose first ring is the outer one."""
    polygon = ET.SubElement(parent, "Polygon")
    if extrude:
        _add(polygon, "extrude", "1")
    _add(polygon, "altitudeMode", "absolute")
    for number, ring in enumerate(rings):
        x, y = np.array((*ring, ring[0])).T
        side = ET.SubElement(polygon, "innerBoundaryIs" if number else "outerBoundaryIs")
        places = _positions(terrain, x, y, np.full(len(x), altitude_m))
        _add(ET.SubElement(side, "LinearRing"), "coordinates", places)


def _around(x_m: float, y_m: float, radius_m: float) -> Ring:
    """Return a regular polygon that circumscribes a circle."""
    angles = np.linspace(0, 2 * np.pi, _CIRCLE_CORNERS, endpoint=False)
    outer_m = radius_m / math.cos(math.pi / _CIRCLE_CORNERS)
    x, y = x_m + outer_m * np.cos(angles), y_m + outer_m * np.sin(angles)
    return tuple(zip(x.tolist(), y.tolist(), strict=True))


def _placemark_in(parent: ET.Element, name: str, style: str | None = None) -> ET.Element:
    placemark = ET.SubElement(parent, "Placemark")
    _add(placemark, "name", name)
    if style is not None:
        _add(placemark, "styleUrl", f"#{style}")
    return placemark


def _add(parent: ET.Element, tag: str, text: str) -> None:
    ET.SubElement(parent, tag).text = text


def _positions(
    terrain: Terrain,
    x: Sequence[float] | NDArray[np.float64],
    y: Sequence[float] | NDArray[np.float64],
    z: Sequence[float] | NDArray[np.float64],
) -> str:
    """Return longitude, latitude and altitude of points in local metres, as KML writes them."""
    places = degrees(terrain, np.asarray(x, np.float64), np.asarray(y, np.float64))
    return " ".join(
        ",".join(map(number_text, (lon, lat, alt)))
        for (lat, lon), alt in zip(places, np.asarray(z).tolist(), strict=True)
    )


def recognises(content: Content) -> bool:
    """Return whether a text is XML."""
    return content.is_xml


def zones(content: Content, terrain: Terrain) -> Iterator[Shape]:
    """Yield the zones of a KML document.

    A zone is a polygon with its holes, or a point or polygon whose placemark has the extended data
    ``radius_m`` (and ``centre``, longitude and latitude, for a polygon). Other points, and lines,
    are not zones. The placemark names the zone. Limits and times are the extended data ``lower``,
    ``upper``, ``t0`` and ``t1``; ``none`` means no limit. Without them, a polygon that is extruded
    to the ground has an upper limit: its highest altitude or, if relative to the ground, this
    altitude above the highest ground below it. Any other polygon has no limits.

    Raises
    ------
    InputError
        If the text is not KML, has no zone, or a bad number, or the terrain has no place on Earth.
    """
    try:
        root = ET.fromstring(content.text)
    except ET.ParseError as error:
        raise InputError(f"not KML: {error}.") from None
    if _tag(root) != "kml":
        raise InputError("not KML: its root is no kml element.")
    if terrain.crs is None:
        raise InputError(
            "the terrain has no coordinate reference system, so KML has no place on it; give "
            "--origin LAT,LON, or origin under [terrain] in a problem file."
        )
    found = 0
    for placemark in root.iter():
        if _tag(placemark) == "Placemark":
            for shape in _placemark(placemark, terrain):
                found += 1
                yield shape
    if not found:
        raise InputError("there is no polygon or circle in it.")


def _placemark(placemark: ET.Element, terrain: Terrain) -> Iterator[Shape]:
    data = _extended(placemark)
    properties: dict[str, Any] = {
        key: _number(key, data[key])
        for key in _NUMBERS
        if data.get(key, "none") not in ("", "none")
    }
    is_ours = data.get("pathgene") == "zone"
    properties["name"] = data.get("name", "") if is_ours else _text(placemark, "name")
    if "radius_m" in properties:
        centre = data.get("centre") or "".join(
            _text(point, "coordinates") for point in _all(placemark, "Point")
        )
        ring, _ = _ring(centre, terrain)
        yield Shape("Point", (ring[:1],), properties)
        return
    for polygon in _all(placemark, "Polygon"):
        rings = [
            _ring(_text(ring, "coordinates"), terrain)
            for side in ("outerBoundaryIs", "innerBoundaryIs")
            for boundary in _all(polygon, side)
            for ring in _all(boundary, "LinearRing")
        ]
        if not rings:
            raise InputError("a polygon must have an outer boundary.")
        outer, heights = rings[0]
        limits = {} if {"lower", "upper"} & set(data) else _upper(polygon, outer, heights, terrain)
        yield Shape("Polygon", tuple(ring for ring, _ in rings), properties | limits)
        if is_ours:
            return  # Its other polygons are bottom and walls.


def _upper(
    polygon: ET.Element, ring: Ring, heights: list[float], terrain: Terrain
) -> dict[str, float]:
    """Return the upper limit of a polygon extruded to the ground, if its heights state one."""
    mode = _text(polygon, "altitudeMode")
    if _text(polygon, "extrude") not in ("1", "true") or not max(heights) > 0:
        return {}
    if mode == "absolute":
        return {"upper": max(heights)}
    if mode != "relativeToGround":
        return {}
    x, y = np.array(ring).T
    south, west = terrain.nearest_nodes(x.min(), y.min())
    north, east = terrain.nearest_nodes(x.max(), y.max())
    ground = terrain.elevation[int(south) : int(north) + 1, int(west) : int(east) + 1]
    # Unknown ground may have any height.
    highest = terrain.highest if np.isnan(ground).any() else float(ground.max())
    return {"upper": highest + max(heights)}


def _ring(text: str, terrain: Terrain) -> tuple[Ring, list[float]]:
    """Return positions ``lon,lat[,alt]`` as local x, y and altitudes, 0 if not given."""
    try:
        points = [tuple(map(parse, position.split(","))) for position in text.split()]
    except ValueError:
        points = []
    if not points or not all(len(point) in (2, 3) for point in points):
        raise InputError(f"{text[:60]!r} are no positions longitude,latitude,altitude.")
    for point in points:
        if abs(point[0]) > 180 or abs(point[1]) > 90:
            raise InputError(f"({point[0]:g}, {point[1]:g}) is no WGS84 longitude and latitude.")
    x, y = terrain.to_local([point[1] for point in points], [point[0] for point in points])
    heights = [point[2] if len(point) == 3 else 0.0 for point in points]
    return tuple(zip(x.tolist(), y.tolist(), strict=True)), heights


def _extended(placemark: ET.Element) -> dict[str, str]:
    """Return the extended data of a placemark, typed or not, by name."""
    data = {item.get("name", ""): _text(item, "value") for item in _all(placemark, "Data")}
    typed = {item.get("name", ""): item.text or "" for item in _all(placemark, "SimpleData")}
    return {name: text.strip() for name, text in (data | typed).items()}


def _number(key: str, text: str) -> float:
    try:
        return parse(text)
    except ValueError:
        raise InputError(
            f"the extended data {key} must be a number or none, not {text!r}."
        ) from None


def _tag(element: ET.Element) -> str:
    """Return the name of an element without its namespace, which depends on the version of KML."""
    return element.tag.rpartition("}")[2]


def _all(parent: ET.Element, tag: str) -> Iterator[ET.Element]:
    return (element for element in parent.iter() if _tag(element) == tag)


def _text(parent: ET.Element, tag: str) -> str:
    """Return the text of the first child with this name, or an empty text."""
    found = next((child for child in parent if _tag(child) == tag), None)
    return "" if found is None else (found.text or "").strip()
