"""Areas of GeoJSON geometries: their rings in degrees, whatever reference system the file names."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.formats.features import Position
from pathgene.host.numeric import is_number
from pathgene.host.remarks import Grade, Remark


__all__ = [
    "MOST_NAME",
    "Placing",
    "Rings",
    "areas",
    "check_degrees",
    "named_system",
    "require_outside",
    "unread",
    "unread_texts",
]

#: Outer ring and holes, without the closing corners; one ring of one position for a point.
Rings = tuple[tuple[Position, ...], ...]

#: Characters of a name in sentences.
MOST_NAME = 80
# Map editors continue longitudes beyond 180 as the user scrolls; twice around is enough.
_MOST_LONGITUDE = 720.0
# Coordinates that are larger than metres of a terrain's frame, and than any projected metres.
_PROJECTED, _SCALED = 100_000.0, 21_000_000.0
# Largest longitude and latitude; no land lies so near the origin of a projected system.
_DEGREES = 180.0, 90.0
# A system by authority and number, with or without the version of the register.
_SYSTEM = re.compile(r"(EPSG|ESRI)\D{1,30}?(?:[\d.]+[:/])?(\d{4,6})(?!\d)", re.IGNORECASE)
# Names of properties that may limit an area in height, size or time.
_LIMITING = re.compile(
    r"upper|lower|floor|ceil|altitude|(?<![a-z])alt|height|limit|radius|(?<![a-z])(agl|amsl|fl)(?![a-z])"
    r"|flight.?level|valid|activ|schedule|(?<![a-z])time|hours|(?<![a-z])(start|end|from|until)",
    re.IGNORECASE,
)
_KINDS = ("Point", "MultiPoint", "LineString", "MultiLineString")
# Distance of the corners on an edge that is straight in a projection, in its units (usually
# metres), and their maximum number.
_STEP, _MOST_STEPS = 1000.0, 500

# Names of properties for the class of an airspace, which formats of airspace define.
_CLASS = re.compile(r"(air ?space|icao)?[_ ]?class", re.IGNORECASE)
# Words for areas to stay in, as a value of any property, or as the name of one that is true.
_STAY_IN = re.compile(
    r"(inclusi(on|ve)|include|(keep|stay)[-_ ]?in(side)?)([-_ ]?(zone|fence|area|geofence))?",
    re.IGNORECASE,
)
_NAMES = ("name", "title", "description")
_TRUE = (True, 1, "1", "true", "True", "TRUE", "yes", "Yes", "YES")
# Limits of height in a text for people.
_HEIGHT_IN_TEXT = re.compile(
    r"\d\s{0,3}(?:m|ft|feet|met(?:er|re)s?)?\s{0,3}(?:AGL|AMSL|MSL|ASL|ASFC)\b"
    r"|\bFL\s{0,3}\d{2,3}\b"
    r"|\b(?:upper|lower)\s{1,3}(?:limit|altitude)s?\b[^\d]{0,40}\d"
    r"|\b(?:ceiling|floor)\s{0,3}[:=]?\s{0,3}\d",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Placing:
    """The meaning of the coordinates of a file.

    Parameters
    ----------
    is_local : bool
        Metres in the frame of a terrain.
    system : str, optional
        Reference system that is not WGS84; None for WGS84 and for local metres.
    """

    is_local: bool = False
    system: str | None = None

    def ring(self, points: Any) -> tuple[Position, ...]:
        """Return the corners of a ring in degrees, without the closing one.

        Raises
        ------
        InputError
            If one is not a position.
        """
        pairs = _pairs(points)
        if len(pairs) > 1 and pairs[0] == pairs[-1]:
            pairs = pairs[:-1]
        if self.is_local:
            return pairs
        if self.system is not None:
            pairs = _converted(pairs, self.system)
        check_degrees(pairs, _remedy(pairs))
        return pairs


def _remedy(pairs: tuple[Position, ...]) -> str:
    """Return the remedy for positions that are no degrees."""
    largest = max((abs(value) for pair in pairs for value in pair), default=0.0)
    if largest >= _SCALED:
        return "it looks like degrees times 10,000,000: divide them, or save in EPSG:4326."
    if largest >= _PROJECTED:
        return "it looks like projected metres: name the system in crs, or save in EPSG:4326."
    return 'for local metres add the member "crs_local": true.'


def areas(geometry: Any, placing: Placing, *, is_circle: bool) -> tuple[list[Rings], list[str]]:
    """Return the rings of a geometry, and the kinds of its parts that are not areas.

    Parameters
    ----------
    geometry : object
        A geometry of GeoJSON; the geometries of a collection count one by one.
    placing : Placing
        The meaning of its coordinates.
    is_circle : bool
        Points, also of a MultiPoint, are centres of circles.

    Raises
    ------
    InputError
        If a geometry or a position is bad.
    """
    found: list[Rings] = []
    others: list[str] = []
    waiting = [geometry]
    while waiting:
        part = waiting.pop()
        if not isinstance(part, dict):
            raise InputError("its geometry is not a GeoJSON object.")
        kind, coordinates = part.get("type"), part.get("coordinates")
        if kind == "GeometryCollection":
            members = part.get("geometries")
            if not isinstance(members, list):
                raise InputError('a GeometryCollection must have a list of "geometries".')
            waiting += reversed(members)
        elif kind == "Point" and is_circle:
            found.append((placing.ring([coordinates]),))
        elif kind == "MultiPoint" and is_circle:
            if not isinstance(coordinates, list):
                raise InputError("the coordinates of a MultiPoint must be a list.")
            found += [(placing.ring([each]),) for each in coordinates]
        elif kind in ("Polygon", "MultiPolygon"):
            found += _polygons(kind, coordinates, placing)
        elif kind in _KINDS:
            others.append(_closed(kind, coordinates))
        else:
            raise InputError(
                "a geometry must be a Polygon, a MultiPolygon, a GeometryCollection or a Point "
                f'with "radius_m", not {kind!r}.'
            )
    return found, others


def _polygons(kind: str, coordinates: Any, placing: Placing) -> Iterable[Rings]:
    polygons = [coordinates] if kind == "Polygon" else coordinates
    if not isinstance(polygons, list):
        raise InputError(f"the coordinates of a {kind} must be a list.")
    for rings in polygons:
        if not isinstance(rings, list) or not rings:
            raise InputError(f"a {kind} must have at least one ring.")
        yield tuple(placing.ring(ring) for ring in rings)


def _closed(kind: str, coordinates: Any) -> str:
    """Return the kind of a point or a line, and whether it closes."""
    lines = {"LineString": [coordinates], "MultiLineString": coordinates}.get(kind)
    return f"closed {kind}" if isinstance(lines, list) and _closes(lines) else kind


def _closes(lines: list[Any]) -> bool:
    """Return whether a line ends where it begins, or lines form rings together."""
    drawn = [line for line in lines if isinstance(line, list) and len(line) > 1]
    if any(len(line) > 3 and line[0] == line[-1] for line in drawn):
        return True
    ends = Counter(json.dumps(line[side]) for line in drawn for side in (0, -1))
    return len(drawn) > 2 and all(count % 2 == 0 for count in ends.values())


def _pairs(points: Any) -> tuple[Position, ...]:
    """Return positions of the file, whose heights are ignored."""
    if not isinstance(points, list) or not all(
        isinstance(point, list) and len(point) >= 2 and all(map(is_number, point[:2]))
        for point in points
    ):
        raise InputError("a position must be a list of two finite numbers.")
    return tuple((float(point[0]), float(point[1])) for point in points)


def check_degrees(pairs: Iterable[Position], remedy: str = "give degrees.") -> None:
    """Check that positions are longitudes and latitudes in degrees.

    Raises
    ------
    InputError
        If one is not; the sentence ends with the ``remedy``.
    """
    for longitude, latitude in pairs:
        if not (abs(longitude) <= _MOST_LONGITUDE and abs(latitude) <= 90):
            is_swapped = abs(longitude) <= 90 < abs(latitude) <= 180
            swapped = "latitude comes second; " if is_swapped else ""
            raise InputError(
                f"({longitude:g}, {latitude:g}) is no WGS84 longitude and latitude; "
                f"{swapped}{remedy}"
            )


def named_system(document: Mapping[str, Any]) -> str | None:
    """Return the reference system that an old GeoJSON names, None for WGS84 and its equivalents.

    Raises
    ------
    InputError
        If it names an unknown one.
    """
    if document.get("crs") is None:
        return None
    name = json.dumps(document["crs"])
    code = _SYSTEM.search(name)
    if "CRS84" in name:
        return None
    if code is None:
        raise InputError(
            f"its reference system {name[:80]} is unknown; convert it to WGS84 longitude and "
            "latitude."
        )
    # Loads rasterio.
    from pathgene.host.terrain.geodesy import is_like_wgs84, known_crs

    system = f"{code.group(1).upper()}:{code.group(2)}"
    if known_crs(system).is_geographic and is_like_wgs84(system):
        return None
    return system


def _converted(pairs: tuple[Position, ...], system: str) -> tuple[Position, ...]:
    """Return positions of a reference system in degrees; edges straight there get more corners.

    Raises
    ------
    InputError
        If the system is projected, and the positions look like degrees.
    """
    from pathgene.host.terrain.geodesy import WGS84, known_crs, transform

    corners = np.array(pairs).reshape(-1, 2)
    if len(corners) and not known_crs(system).is_geographic:
        if (np.abs(corners) <= _DEGREES).all():
            x, y = corners[0].tolist()
            raise InputError(
                f"({x:g}, {y:g}) looks like longitude and latitude, but crs names the projected "
                f"system {system}; remove crs if they are degrees."
            )
        corners = _divided(corners) if len(corners) > 1 else corners
    lon, lat = transform(system, WGS84, corners[:, 0], corners[:, 1])
    return tuple(zip(lon.tolist(), lat.tolist(), strict=True))


def _divided(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a ring whose long edges are divided into steps, (n, 2)."""
    ahead = np.roll(corners, -1, axis=0)
    steps = np.clip(np.ceil(np.hypot(*(ahead - corners).T) / _STEP), 1, _MOST_STEPS).astype(int)
    edge = np.repeat(np.arange(len(corners)), steps)
    shares = (np.arange(len(edge)) - np.repeat(np.cumsum(steps) - steps, steps)) / steps[edge]
    divided: NDArray[np.float64] = corners[edge] + shares[:, None] * (ahead - corners)[edge]
    return divided


def unread(properties: Mapping[str, Any], known: Iterable[str]) -> tuple[str, ...]:
    """Return the names of properties that may limit an area and are not ``known``."""
    names = set(known)
    return tuple(
        key
        for key, value in properties.items()
        if key not in names and value not in (None, "", [], {}) and _LIMITING.search(key)
    )


def unread_texts(properties: Mapping[str, Any], description: Any) -> tuple[Remark, ...]:
    """Return notes on a class, and on limits of height in a description, which are not read."""
    remarks = [
        Remark(Grade.NOTE, f"its {key} {value!r:.40} is not read, and it forbids flight")
        for key, value in properties.items()
        if _CLASS.fullmatch(key) and isinstance(value, str | int) and value != ""
    ]
    if isinstance(description, str) and _HEIGHT_IN_TEXT.search(description):
        text = "its description names limits of height and is not read"
        remarks.append(Remark(Grade.NOTE, text))
    return tuple(remarks)


def require_outside(properties: Mapping[str, Any]) -> None:
    """Check that no property asks to stay in an area, which a zone would forbid.

    Raises
    ------
    InputError
        If one does.
    """
    for key, value in properties.items():
        is_value = isinstance(value, str) and _STAY_IN.fullmatch(value.strip()) is not None
        is_named = _STAY_IN.fullmatch(key) is not None and value in _TRUE
        if (is_value and key.lower() not in _NAMES) or is_named:
            raise InputError(
                f"its {key} {value!r:.40} asks to stay inside, but a zone forbids its inside; give "
                "it as a fence of a .plan, or remove the property."
            )
