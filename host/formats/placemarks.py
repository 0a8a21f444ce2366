"""Placemarks of KML: their polygons, closed paths and circles, with the intended heights.

A prism drawn with lid, bottom and walls is one area between two heights.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

from pathgene.host.errors import InputError
from pathgene.host.formats.areas import (
    MOST_NAME,
    Rings,
    check_degrees,
    require_outside,
    unread,
    unread_texts,
)
from pathgene.host.formats.features import (
    Bad,
    Edges,
    Feature,
    LeftOut,
    Limit,
    Position,
    Read,
    Reference,
    label,
)
from pathgene.host.formats.limits import own_limits, stated_limits
from pathgene.host.numeric import parse


__all__ = ["TIMES", "every", "placemark", "places_of", "tag_of", "text_of"]

# Extended data of a zone with numeric values.
_NUMBERS = ("radius_m", "t0", "t1")
_LIMITS = ("lower", "upper")
_READ = (*_NUMBERS, *_LIMITS, "pathgene", "name", "centre")
_REFERENCES = {"absolute": Reference.AMSL, "relativeToGround": Reference.AGL}
# Heights in these modes do not count.
_CLAMPED = ("", "clampToGround", "clampToSeaFloor")
#: Parts that limit the display of a placemark, or of all placemarks of a folder.
TIMES = ("TimeSpan", "TimeStamp", "Region")
# Area of a wall as seen from above, square degrees: a tenth of a millimetre by some kilometres.
_WALL_AREA = 1e-10


@dataclass(frozen=True)
class _Drawn:
    """A polygon or a closed path as drawn.

    Parameters
    ----------
    rings : tuple of rings
        Corners in degrees.
    heights : tuple of float
        Heights of the corners of the outer ring.
    mode : str
        ``altitudeMode``.
    extrudes : bool
        It is drawn down to the ground.
    """

    rings: Rings
    heights: tuple[float, ...]
    mode: str
    extrudes: bool

    @property
    def is_wall(self) -> bool:
        """True for a polygon that has no area as seen from above."""
        ring = self.rings[0]
        x0, y0 = ring[0]
        moved = [(x - x0, y - y0) for x, y in ring]
        ahead = (*moved[1:], moved[0])
        double = sum(xa * yb - xb * ya for (xa, ya), (xb, yb) in zip(moved, ahead, strict=True))
        return len(set(ring)) < 3 or (abs(double) < _WALL_AREA and len(set(self.heights)) > 1)

    @property
    def corners(self) -> frozenset[Position]:
        """The corners of the outer ring as seen from above, rounded."""
        return frozenset((round(x, 7), round(y, 7)) for x, y in self.rings[0])

    @property
    def footprint(self) -> frozenset[frozenset[Position]]:
        """The corners as seen from above, rounded: equal for the lid and bottom of a prism."""
        return frozenset(
            frozenset((round(x, 7), round(y, 7)) for x, y in ring) for ring in self.rings
        )


def placemark(
    number: int, element: ET.Element, *, kind: str = "placemark", around: Iterable[str] = ()
) -> Iterator[Read]:
    """Yield the areas of a placemark.

    An area is a polygon with its holes, a closed path, a ring, or a point or polygon with the
    extended data ``radius_m`` (and ``centre``, longitude and latitude, for a polygon). Limits and
    times are the extended data ``lower``, ``upper``, ``t0`` and ``t1``, ``none`` for no limit.
    Without them, polygons with walls are one area from their lowest to their highest altitude, and
    a polygon that is extruded to the ground has an upper limit: its highest altitude, above mean
    sea level or above the ground as its ``altitudeMode`` says. Every other polygon has no limit.
    Extended data of other programs, such as ``upperLimit``, prevail over altitudes.

    Parameters
    ----------
    number : int
        Place in the document, from 1.
    element : Element
        The placemark.
    kind : str
        Word for a placemark in sentences.
    around : iterable of str
        Names of the parts of its folders that limit its display.
    """
    data = _extended(element)
    is_ours = data.get("pathgene") == "zone"
    name = data.get("name", "") if is_ours else text_of(element, "name")
    name = " ".join(name.split())[:MOST_NAME]
    tag = label(kind, number, name)
    try:
        if not is_ours:
            require_outside(data)
        numbers = {key: _number(key, data.get(key, "none")) for key in _NUMBERS}
        limits = own_limits(data)
        circle = _circle(element, data) if numbers["radius_m"] is not None else None
        drawn = [] if circle else _drawn(element)
        areas = [] if is_ours else list(_joined(drawn))
    except InputError as error:
        yield Bad(tag, str(error))
        return
    stated = stated_limits(data)
    has_own = bool({*_LIMITS} & set(data))
    limiting = (*around, *(each for each in TIMES if any(True for _ in every(element, each))))
    common: dict[str, Any] = {
        "kind": kind,
        "edges": Edges.FRAME if is_ours else Edges.DEGREES,
        "t0_s": numbers["t0"],
        "t1_s": numbers["t1"],
        "unread": (
            *unread(data, (*_READ, *stated.read, *limits.read)),
            *dict.fromkeys(limiting),
        ),
        "remarks": ()
        if is_ours
        else (
            *(limits if has_own else stated).remarks,
            *unread_texts(data, text_of(element, "description")),
        ),
    }
    own = limits.lower, limits.upper
    if circle:
        radius_m = numbers["radius_m"]
        yield Feature(number, name, ((circle,),), radius_m, *own, **common)
        return
    if is_ours and drawn:
        # Its other polygons are bottom and walls.
        yield Feature(number, name, drawn[0].rings, None, *own, **common)
        return
    yield from _others(element, tag, data, bool(drawn))
    for rings, heights in areas:
        if has_own:
            heights = _Heights(*own)
        elif stated.read:
            heights = _Heights(stated.lower, stated.upper)
        modes = tuple(f"altitudeMode {mode}" for mode in heights.unread)
        facts = common | {"unread": (*common["unread"], *modes)}
        yield Feature(number, name, rings, None, heights.lower, heights.upper, **facts)


def _others(
    element: ET.Element, tag: str, data: dict[str, str], has_areas: bool
) -> Iterator[LeftOut | Bad]:
    """Yield the parts of a placemark that are not areas; a point with a radius is bad."""
    points = [each for each in element.iter() if tag_of(each) == "Point"]
    lines = [each for each in every(element, "LineString") if not _is_closed(each)]
    sized = next((key for key in data if "radius" in key.lower()), None)
    if points and sized is not None:
        yield Bad(tag, f'the radius of a circle is the extended data "radius_m", not {sized!r}.')
    elif points and not has_areas:
        yield LeftOut(tag, "a Point is not an area")
    if lines:
        yield LeftOut(tag, "an open path is not an area")
    kinds = {tag_of(each) for each in element.iter()}
    # A MultiTrack consists of tracks.
    others = [kind for kind in ("Model", "MultiTrack", "Track") if kind in kinds]
    for kind in others[:-1] if others[-2:] == ["MultiTrack", "Track"] else others:
        yield LeftOut(tag, f"a {kind} is not an area")
    if not (points or lines or has_areas or others):
        yield LeftOut(tag, "it has no geometry")


def _drawn(element: ET.Element) -> list[_Drawn]:
    """Return polygons, and the rings and closed paths outside them, in the order of the file."""
    found = []
    waiting = list(reversed(element))
    while waiting:
        part = waiting.pop()
        kind = tag_of(part)
        if kind == "Polygon":
            found.append(_polygon(part))
        elif kind == "LinearRing" or (kind == "LineString" and _is_closed(part)):
            ring, heights = _ring(text_of(part, "coordinates"))
            found.append(_of(part, (ring,), heights))
        else:
            waiting += reversed(part)
    return found


def _polygon(element: ET.Element) -> _Drawn:
    sides: dict[str, list[ET.Element]] = {"outerBoundaryIs": [], "innerBoundaryIs": []}
    waiting = [(element, "")]
    while waiting:
        part, side = waiting.pop()
        tag = tag_of(part)
        if tag == "LinearRing" and side:
            sides[side].append(part)
        inside = tag if tag in sides else side
        waiting += ((child, inside) for child in reversed(part))
    outer, holes = ([_ring(text_of(ring, "coordinates")) for ring in own] for own in sides.values())
    if not outer:
        raise InputError("a polygon must have an outer boundary.")
    if len(outer) > 1:
        raise InputError(f"a polygon must have one outer boundary, not {len(outer)}.")
    return _of(element, tuple(ring for ring, _ in (*outer, *holes)), outer[0][1])


def _of(element: ET.Element, rings: Rings, heights: tuple[float, ...]) -> _Drawn:
    extrudes = text_of(element, "extrude") in ("1", "true")
    return _Drawn(rings, heights, text_of(element, "altitudeMode"), extrudes)


def _joined(drawn: list[_Drawn]) -> Iterator[tuple[Rings, _Heights]]:
    """Yield areas with their limits; lid, bottom and walls are one area."""
    walls = [each for each in drawn if each.is_wall]
    flat: dict[frozenset[frozenset[Position]], list[_Drawn]] = {}
    for each in drawn:
        if not each.is_wall:
            flat.setdefault(each.footprint, []).append(each)
    # Without a polygon, each ring without an area must be a wall.
    left = {n for n, wall in enumerate(walls) if not flat or len(set(wall.heights)) > 1}
    at: dict[Position, list[int]] = {}
    for number, wall in enumerate(walls):
        for corner in wall.corners:
            at.setdefault(corner, []).append(number)
    for footprint, layers in flat.items():
        left.difference_update(*(at.get(corner, ()) for ring in footprint for corner in ring))
        own = sorted({number for corner in layers[0].corners for number in at.get(corner, ())})
        yield layers[0].rings, _heights(layers, [walls[number] for number in own])
    alone = [walls[number] for number in sorted(left)]
    if alone:
        ring = _around(alone)
        prism = [_Drawn((ring,), each.heights, each.mode, False) for each in alone]
        yield (ring,), _heights(prism, [])


class _Heights(NamedTuple):
    """Limits of an area, and the modes of its altitudes that are not read."""

    lower: Limit | None = None
    upper: Limit | None = None
    unread: tuple[str, ...] = ()


def _heights(layers: list[_Drawn], walls: list[_Drawn]) -> _Heights:
    """Return the limits of layers over one footprint, with the walls between them."""
    parts = [*layers, *walls]
    modes = tuple(dict.fromkeys(each.mode for each in parts))
    reference = _REFERENCES.get(modes[0]) if len(modes) == 1 else None
    if reference is None:
        are_clamped = all(each.mode in _CLAMPED or not any(each.heights) for each in parts)
        return _Heights(unread=() if are_clamped else tuple(filter(None, modes)))
    low = min(min(each.heights) for each in parts)
    high = max(max(each.heights) for each in parts)
    if any(each.extrudes for each in layers):
        return _Heights(None, Limit(high, reference) if high > 0 else None)
    if len(parts) > 1 and low < high:
        return _Heights(Limit(low, reference), Limit(high, reference))
    return _Heights()


def _around(walls: list[_Drawn]) -> tuple[Position, ...]:
    """Return the ring along the feet of walls.

    Raises
    ------
    InputError
        If they do not follow each other around an area.
    """
    sides = [tuple(dict.fromkeys(wall.rings[0])) for wall in walls]
    # Sides by their corners, the first one last.
    at: dict[Position, list[int]] = {}
    for number in range(len(sides) - 1, -1, -1):
        for corner in sides[number]:
            at.setdefault(corner, []).append(number)
    ring, left = [*sides[0]], set(range(1, len(sides)))
    while left:
        here = at[ring[-1]]
        while here and here[-1] not in left:
            here.pop()
        if not here:
            break
        following = sides[here[-1]]
        left.remove(here.pop())
        ring += [corner for corner in following if corner != ring[-1]]
    if left or ring[0] != ring[-1] or len(ring) < 4:
        raise InputError("its walls do not close around an area; draw a polygon.")
    return tuple(ring[:-1])


def _circle(element: ET.Element, data: dict[str, str]) -> Position:
    """Return the centre of a circle."""
    centre = data.get("centre") or "".join(
        text_of(point, "coordinates") for point in every(element, "Point")
    )
    return _positions(centre)[0][0]


def _is_closed(element: ET.Element) -> bool:
    """Return whether a path ends where it begins, around an area."""
    places = places_of(text_of(element, "coordinates"))
    ends = [place.split(",")[:2] for place in (places[:1] + places[-1:])]
    return len(places) > 3 and ends[0] == ends[1]


def _ring(text: str) -> tuple[tuple[Position, ...], tuple[float, ...]]:
    """Return the corners of a ring without the closing one, and its heights."""
    pairs, heights = _positions(text)
    if len(pairs) > 1 and pairs[0] == pairs[-1]:
        return pairs[:-1], heights
    return pairs, heights


def _positions(text: str) -> tuple[tuple[Position, ...], tuple[float, ...]]:
    """Return positions ``lon,lat[,alt]`` in degrees and heights, 0 if not given."""
    try:
        points = [tuple(map(parse, position.split(","))) for position in places_of(text)]
    except ValueError:
        points = []
    if not points or not all(len(point) in (2, 3) for point in points):
        raise InputError(f"{text[:60]!r} are no positions longitude,latitude,altitude.")
    pairs = tuple((point[0], point[1]) for point in points)
    check_degrees(pairs)
    return pairs, tuple(point[2] if len(point) == 3 else 0.0 for point in points)


def places_of(text: str) -> list[str]:
    """Return positions as texts, without the blanks around their commas."""
    return ",".join(part.strip() for part in text.split(",")).split()


def _extended(element: ET.Element) -> dict[str, str]:
    """Return the extended data of a placemark, typed or not, by name."""
    data = {item.get("name", ""): text_of(item, "value") for item in every(element, "Data")}
    typed = {item.get("name", ""): item.text or "" for item in every(element, "SimpleData")}
    return {name: text.strip() for name, text in (data | typed).items()}


def _number(key: str, text: str) -> float | None:
    if text in ("", "none"):
        return None
    try:
        return parse(text)
    except ValueError:
        raise InputError(
            f"the extended data {key} must be a number or none, not {text!r}."
        ) from None


def tag_of(element: ET.Element) -> str:
    """Return the name of an element without its namespace: versions of KML differ there."""
    return element.tag.rpartition("}")[2]


def every(parent: ET.Element, tag: str) -> Iterable[ET.Element]:
    """Return the elements with a name inside an element, at any depth."""
    return (element for element in parent.iter() if tag_of(element) == tag)


def text_of(parent: ET.Element, tag: str) -> str:
    """Return the text of the first child with this name, or an empty string."""
    found = next((child for child in parent if tag_of(child) == tag), None)
    return "" if found is None else (found.text or "").strip()
