"""KML for Google Earth and other viewers: the track in the air, the zones with their heights."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.files.fence import degrees
from pathgene.host.mission.files.flight_plan import check_place
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rings import Ring
from pathgene.host.problem.zones import Zone
from pathgene.host.report.marks import marked_waypoints
from pathgene.host.terrain import Terrain


__all__ = ["kml_text"]

_NAMESPACE = "http://www.opengis.net/kml/2.2"
# Corners of the polygon around a circle, which lies inside it.
_CIRCLE_CORNERS = 72
# A zone without upper limit is drawn so far above everything.
_DRAWN_ABOVE_M = 300.0
# Most metres between points of the track.
_STEP_M = 25.0
# Colours are alpha, blue, green, red.
_STYLES = {
    "track": {"LineStyle": {"color": "ff00a5ff", "width": "3"}, "PolyStyle": {"color": "4000a5ff"}},
    "zone": {"LineStyle": {"color": "ff0000c0", "width": "1"}, "PolyStyle": {"color": "600000ff"}},
}


def kml_text(problem: Problem, path: NDArray[np.float64], name: str) -> str:
    """Return a KML document: the smoothed track, its waypoints and the zones.

    The waypoints at start, via points, goal and return have their names.

    Each zone states name, limits of height and times as extended data, a circle its centre and
    radius as well, so that :mod:`pathgene.host.problem.kml` reads the same zones back.

    Parameters
    ----------
    problem : Problem
        The problem; its terrain has a place on Earth.
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    name : str
        Name of the document.

    Raises
    ------
    InputError
        If the terrain has no place on Earth.
    """
    terrain = problem.terrain
    check_place(terrain)
    samples = Evaluator(problem).track(path).sample(_STEP_M)
    root = ET.Element("kml", xmlns=_NAMESPACE)
    document = ET.SubElement(root, "Document")
    _text(document, "name", name)
    for style, parts in _STYLES.items():
        element = ET.SubElement(document, "Style", id=style)
        for part, values in parts.items():
            inner = ET.SubElement(element, part)
            for key, value in values.items():
                _text(inner, key, value)

    track = _placemark(document, "Track", "track")
    line = ET.SubElement(track, "LineString")
    _text(line, "extrude", "1")
    _text(line, "altitudeMode", "absolute")
    _text(line, "coordinates", _positions(terrain, samples.x, samples.y, samples.z))
    folder = ET.SubElement(document, "Folder")
    _text(folder, "name", "Waypoints")
    marks = marked_waypoints(path, problem.way)
    for number, (x, y, z) in enumerate(path):
        title = marks.get(number, f"Waypoint {number}")
        point = ET.SubElement(_placemark(folder, title), "Point")
        _text(point, "altitudeMode", "absolute")
        _text(point, "coordinates", _positions(terrain, [x], [y], [z]))
    top_m = max(terrain.highest, float(path[:, 2].max())) + _DRAWN_ABOVE_M
    folder = ET.SubElement(document, "Folder")
    _text(folder, "name", "No-fly zones")
    for number, zone in enumerate(problem.zones, start=1):
        _zone(folder, zone, f"Zone {number}", terrain, top_m)

    ET.indent(root, " ")
    # No declaration: UTF-8 is the default, and some readers of text refuse one.
    return f"{ET.tostring(root, encoding='unicode')}\n"


def _zone(folder: ET.Element, zone: Zone, title: str, terrain: Terrain, top_m: float) -> None:
    """Add a zone: a prism from its lower limit, or the ground, to its upper limit."""
    placemark = _placemark(folder, zone.name or title, "zone")
    facts = {"pathgene": "zone", "name": zone.name, "lower": "none", "upper": "none"}
    facts |= {key: str(value) for key, value in zone.limits.items()}
    if zone.footprint.disc is not None:
        x_m, y_m, radius_m = zone.footprint.disc
        ((lat, lon),) = degrees(terrain, np.array([x_m]), np.array([y_m]))
        facts |= {"centre": f"{_number(lon)},{_number(lat)}", "radius_m": str(radius_m)}
    # No part of a circle lies outside its polygon.
    rings = zone.footprint.outline(_CIRCLE_CORNERS, around=True)
    data = ET.SubElement(placemark, "ExtendedData")
    for key, value in facts.items():
        _text(ET.SubElement(data, "Data", name=key), "value", value)

    upper_m = top_m if zone.upper_m is None else zone.upper_m
    if zone.lower_m is None:
        _polygon(placemark, terrain, rings, upper_m, extrude=True)
        return
    # KML extrudes to the ground alone: lid, bottom and walls make the prism.
    parts = ET.SubElement(placemark, "MultiGeometry")
    _polygon(parts, terrain, rings, upper_m)
    _polygon(parts, terrain, rings, zone.lower_m)
    for ring in rings:
        for (xa, ya), (xb, yb) in pairwise((*ring, ring[0])):
            wall = ET.SubElement(parts, "Polygon")
            _text(wall, "altitudeMode", "absolute")
            heights = [zone.lower_m, zone.lower_m, upper_m, upper_m, zone.lower_m]
            places = _positions(terrain, [xa, xb, xb, xa, xa], [ya, yb, yb, ya, ya], heights)
            boundary = ET.SubElement(ET.SubElement(wall, "outerBoundaryIs"), "LinearRing")
            _text(boundary, "coordinates", places)


def _polygon(
    parent: ET.Element,
    terrain: Terrain,
    rings: Iterable[Ring],
    altitude_m: float,
    *,
    extrude: bool = False,
) -> None:
    """Add a horizontal polygon, its first ring the outer one."""
    polygon = ET.SubElement(parent, "Polygon")
    if extrude:
        _text(polygon, "extrude", "1")
    _text(polygon, "altitudeMode", "absolute")
    for number, ring in enumerate(rings):
        x, y = np.array((*ring, ring[0])).T
        side = ET.SubElement(polygon, "innerBoundaryIs" if number else "outerBoundaryIs")
        places = _positions(terrain, x, y, np.full(len(x), altitude_m))
        _text(ET.SubElement(side, "LinearRing"), "coordinates", places)


def _placemark(parent: ET.Element, name: str, style: str | None = None) -> ET.Element:
    placemark = ET.SubElement(parent, "Placemark")
    _text(placemark, "name", name)
    if style is not None:
        _text(placemark, "styleUrl", f"#{style}")
    return placemark


def _text(parent: ET.Element, tag: str, text: str) -> None:
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
        ",".join(map(_number, (lon, lat, alt)))
        for (lat, lon), alt in zip(places, np.asarray(z).tolist(), strict=True)
    )


def _number(value: float) -> str:
    """Return a number in full and without an exponent."""
    return np.format_float_positional(value, trim="-")
