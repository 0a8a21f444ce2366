"""KML for Google Earth and other viewers: the track in the air, the zones with their heights."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import pairwise
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import LeftOut, Read
from pathgene.host.formats.kml_lines import kml_mission
from pathgene.host.formats.limits import height_of
from pathgene.host.formats.mission_items import MissionFile
from pathgene.host.formats.placemarks import TIMES, placemark, tag_of, text_of
from pathgene.host.formats.places import degrees, number_text
from pathgene.host.formats.shapes import Ring, Shape
from pathgene.host.formats.track import Track
from pathgene.host.terrain import Terrain


__all__ = [
    "document_of",
    "features",
    "holds_mission",
    "links_of",
    "mission",
    "parts",
    "recognises",
    "with_areas",
    "write",
]

# Roots that Google Earth reads.
_ROOTS = ("kml", "Document", "Folder", "Placemark")
# Parts that may hold or show zones.
_NOT_READ = {
    "NetworkLink": "linked zones are not read; save them in one file",
    "GroundOverlay": "a picture on the ground is not an area; draw its zones as polygons",
    "PhotoOverlay": "a picture is not an area",
    "Update": "changes of other files are not applied",
}
# Parts that show something else.
_NO_AREA = {
    "ScreenOverlay": "a picture on the screen is not an area",
    "Tour": "a Tour is not an area",
}
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
    :func:`features` reads the same zones back.
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

    upper, lower = _height(limits.get("upper", top_m)), limits.get("lower")
    if lower is None:
        _polygon(placemark, terrain, rings, upper, extrude=True)
        return
    # KML extrudes only to the ground: lid, bottom and walls make the prism.
    (upper_m, mode), (lower_m, below) = upper, _height(lower)
    parts = ET.SubElement(placemark, "MultiGeometry")
    _polygon(parts, terrain, rings, upper)
    _polygon(parts, terrain, rings, (lower_m, below))
    # A wall has one mode.
    for ring in rings if mode == below else ():
        for (xa, ya), (xb, yb) in pairwise((*ring, ring[0])):
            wall = ET.SubElement(parts, "Polygon")
            _add(wall, "altitudeMode", mode)
            heights = [lower_m, lower_m, upper_m, upper_m, lower_m]
            places = _positions(terrain, [xa, xb, xb, xa, xa], [ya, yb, yb, ya, ya], heights)
            boundary = ET.SubElement(ET.SubElement(wall, "outerBoundaryIs"), "LinearRing")
            _add(boundary, "coordinates", places)


def _polygon(
    parent: ET.Element,
    terrain: Terrain,
    rings: Iterable[Ring],
    height: tuple[float, str],
    *,
    extrude: bool = False,
) -> None:
    """Add a polygon of one height and mode, whose first ring is the outer one."""
    altitude_m, mode = height
    polygon = ET.SubElement(parent, "Polygon")
    if extrude:
        _add(polygon, "extrude", "1")
    _add(polygon, "altitudeMode", mode)
    for number, ring in enumerate(rings):
        x, y = np.array((*ring, ring[0])).T
        side = ET.SubElement(polygon, "innerBoundaryIs" if number else "outerBoundaryIs")
        places = _positions(terrain, x, y, np.full(len(x), altitude_m))
        _add(ET.SubElement(side, "LinearRing"), "coordinates", places)


def _height(limit: float | str) -> tuple[float, str]:
    """Return the height of a limit and its ``altitudeMode``."""
    if isinstance(limit, str):
        return height_of(limit, "limit of a zone").height_m, "relativeToGround"
    return limit, "absolute"


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


def holds_mission(content: Content) -> bool:
    """Return whether a text is KML."""
    return content.xml is not None and tag_of(content.xml) in _ROOTS


def mission(content: Content) -> MissionFile:
    """Return the first line of a KML document; see :func:`kml_mission`."""
    return kml_mission(document_of(content))


def features(content: Content) -> Iterator[Read]:
    """Yield the areas of a KML document; see :func:`pathgene.host.formats.placemarks.placemark`.

    Links to more features and pictures on the ground are left out and named.

    Raises
    ------
    InputError
        If the text is not KML, or has no area.
    """
    yield from with_areas(parts(document_of(content)))


def document_of(content: Content) -> ET.Element:
    """Return the root of a KML document.

    Raises
    ------
    InputError
        If the text is not KML.
    """
    root = content.xml
    if root is None:
        raise InputError(f"not KML: {content.xml_error}.")
    if tag_of(root) not in _ROOTS:
        raise InputError(
            f"not KML: its root is no kml element; it looks like {content.looks_like}."
        )
    return root


def links_of(root: ET.Element) -> Iterator[tuple[ET.Element, str]]:
    """Yield the links to more features, each with its address as in the document."""
    for element in root.iter():
        if tag_of(element) == "NetworkLink":
            for link in element:
                if tag_of(link) in ("Link", "Url"):
                    yield element, text_of(link, "href")


def parts(
    root: ET.Element, prefix: str = "", read_links: Collection[ET.Element] = ()
) -> Iterator[Read]:
    """Yield the parts of a document.

    Parameters
    ----------
    root : Element
        Its root.
    prefix : str
        Beginning of the labels.
    read_links : collection of Element
        Links whose documents are read, too.
    """
    count = 0
    waiting: list[tuple[ET.Element, tuple[str, ...]]] = [(root, ())]
    while waiting:
        element, around = waiting.pop()
        tag = tag_of(element)
        if tag == "Placemark":
            count += 1
            yield from placemark(count, element, kind=f"{prefix}placemark", around=around)
            continue
        if (tag in _NOT_READ or tag in _NO_AREA) and element not in read_links:
            name = text_of(element, "name")
            what = (
                f'{prefix}{tag} "{name}"'
                if name
                else f"{prefix}{'an' if tag == 'Update' else 'a'} {tag}"
            )
            yield LeftOut(what, (_NOT_READ | _NO_AREA)[tag], tag in _NOT_READ)
        if tag != "Tour":
            limiting = tuple(tag_of(child) for child in element if tag_of(child) in TIMES)
            # A few names, however many folders are around.
            inside = tuple(dict.fromkeys((*around, *limiting)))
            waiting += ((child, inside) for child in reversed(element))


def with_areas(reads: Iterable[Read]) -> Iterator[Read]:
    """Yield parts of documents, and check that one of them is an area.

    Raises
    ------
    InputError
        If none is.
    """
    has_areas = False
    left_out: list[LeftOut] = []
    for read in reads:
        has_areas |= not isinstance(read, LeftOut)
        left_out += [read] if isinstance(read, LeftOut) else []
        yield read
    if not has_areas:
        least = "".join(f"; {each.label}: {each.reason}" for each in left_out[:3])
        raise InputError(f"there is no polygon or circle in it{least}.")
