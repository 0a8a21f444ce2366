"""Zones of a KML file, in metres of a terrain's local frame."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.numeric import parse
from pathgene.host.problem.geojson import Shape
from pathgene.host.problem.rings import Ring
from pathgene.host.terrain import Terrain


__all__ = ["kml_shapes"]

_NUMBERS = ("radius_m", "lower", "upper", "t0", "t1")


def kml_shapes(text: str, terrain: Terrain) -> Iterator[Shape]:
    """Yield the zones of a KML document.

    A zone is a polygon with its holes, or a point or polygon whose placemark has the extended data
    ``radius_m`` (and ``centre``, longitude and latitude, for a polygon). Other points and lines are
    none. Its name is that of the placemark. Limits and times are the extended data ``lower``,
    ``upper``, ``t0`` and ``t1``, ``none`` for no limit. Otherwise the upper limit is that of a
    polygon extruded to the ground: its highest altitude, or, relative to the ground, that above the
    highest ground under it. Every other polygon has no limit.

    Raises
    ------
    InputError
        If the text is not KML, has no zone, or a bad number, or the terrain has no place on Earth.
    """
    try:
        root = ET.fromstring(text)
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
    """Return the upper limit of a polygon extruded to the ground, if its heights say one."""
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
    # Unknown ground may be as high as any.
    highest = terrain.highest if np.isnan(ground).any() else float(ground.max())
    return {"upper": highest + max(heights)}


def _ring(text: str, terrain: Terrain) -> tuple[Ring, list[float]]:
    """Return positions ``lon,lat[,alt]`` as local x, y and altitudes, 0 where there is none."""
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
    """Return the name of an element without its namespace: versions of KML differ there."""
    return element.tag.rpartition("}")[2]


def _all(parent: ET.Element, tag: str) -> Iterator[ET.Element]:
    return (element for element in parent.iter() if _tag(element) == tag)


def _text(parent: ET.Element, tag: str) -> str:
    """Return the text of the first child of this name, or nothing."""
    found = next((child for child in parent if _tag(child) == tag), None)
    return "" if found is None else (found.text or "").strip()
