"""ED-318 of EUROCAE: zones for UAS as GeoJSON with layers of height and circles around points."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats import classes
from pathgene.host.formats.areas import MOST_NAME, Placing, Rings, areas
from pathgene.host.formats.collection import (
    Member,
    check_order,
    members,
    properties_of,
    read_members,
    sized,
)
from pathgene.host.formats.content import Content
from pathgene.host.formats.ed318_rules import (
    TYPES,
    VARIANTS,
    collection_departures,
    feature_departures,
    geometry_departures,
    property_departures,
)
from pathgene.host.formats.features import Bad, Feature, LeftOut, Limit, Period, Read, Reference
from pathgene.host.formats.limits import limit
from pathgene.host.formats.times import applicability, doubts_on_times, moment
from pathgene.host.numeric import is_number
from pathgene.host.remarks import Grade, Remark


__all__ = ["features", "recognises"]

CLASSES = tuple(map(classes.of_word, TYPES))
_OWN = ("limitedApplicability", "zoneAuthority", "regulationExemption")


def recognises(content: Content) -> bool:
    """Return whether a Feature has a layer, an extent or a property of ED-318."""
    return any(
        isinstance(member, dict)
        and member.get("type") == "Feature"
        and (
            _is_layered(member.get("geometry"))
            or any(name in properties_of(member) for name in _OWN)
        )
        for member in members(content.json)
    )


def _is_layered(geometry: Any) -> bool:
    if not isinstance(geometry, dict):
        return False
    parts = geometry.get("geometries")
    return any(name in geometry for name in ("layer", "extent")) or (
        isinstance(parts, list) and any(map(_is_layered, parts))
    )


def features(content: Content) -> Iterator[Read]:
    """Yield the parts of the zones; a zone may be a collection of geometries with a layer each."""
    document = content.json
    try:
        departures = collection_departures(document)
    except InputError as error:
        yield Bad("the collection", str(error))
        departures = []
    metadata = document.get("metadata") if isinstance(document, dict) else None
    metadata = metadata if isinstance(metadata, dict) else {}
    geoid, valid = _geoid(metadata), _valid(metadata)

    def read(member: Member) -> Iterator[Read]:
        for each in _zone(member, departures, geoid):
            yield replace(each, valid=valid) if isinstance(each, Feature) else each

    yield from read_members(document, read)


def _valid(metadata: Mapping[str, Any]) -> Period | None:
    """Return the time in which a collection is valid, if it states one; wrong ones are refused."""
    try:
        start, end = (
            None if metadata.get(name) is None else moment(metadata[name])
            for name in ("validFrom", "validTo")
        )
    except InputError:
        return None
    return Period(start, end) if start or end else None


def _geoid(metadata: Mapping[str, Any]) -> str:
    """Return the geoid that a collection names, if it names one."""
    geoid = metadata.get("otherGeoid")
    return " ".join(geoid.split())[:MOST_NAME] if isinstance(geoid, str) else ""


def _zone(member: Member, common: Sequence[str], geoid: str) -> Iterator[Read]:
    category, periods, departures = _facts(member)
    if member.geometry is None:
        yield LeftOut(member.label, "it has no geometry")
        return
    forbids = classes.forbids(category)
    parts = [(*part, *_rings(part[0])) for part in _parts(member.geometry, departures)]
    departures = list(dict.fromkeys((*common, *departures)))
    for _, layer, found, radius_m, others in parts:
        unread: list[str] = []
        lower, upper = _limit(layer, "lower", unread), _limit(layer, "upper", unread)
        check_order(lower, upper)
        for kind in others:
            yield LeftOut(member.label, f"a {kind} without an extent is not an area", forbids)
        for rings in found:
            yield Feature(
                member.number,
                member.name,
                rings,
                radius_m,
                lower,
                upper,
                periods,
                category,
                forbids=forbids,
                unread=tuple(unread),
                remarks=(
                    *_remarks(departures, geoid, (lower, upper)),
                    *doubts_on_times(member.properties.get("limitedApplicability")),
                ),
            )


def _remarks(
    departures: Sequence[str], geoid: str, limits: Iterable[Limit | None]
) -> Iterator[Remark]:
    if departures:
        text = f"it departs from ED-318, and is read: {'; '.join(departures)}"
        yield Remark(Grade.NOTE, text)
    if geoid and any(limit and limit.reference is Reference.AMSL for limit in limits):
        yield Remark(
            Grade.WARNING,
            f"its heights above the geoid {geoid} count as heights above mean sea level",
        )


def _facts(member: Member) -> tuple[str, tuple[Period, ...], list[str]]:
    """Return class and periods of a zone, and its departures from the schema."""
    departures = feature_departures(member.whole)
    if not member.properties:
        return "", (), [*departures, "it has no properties"]
    stated = member.properties.get("type")
    category = classes.of_word(str(stated))
    if category not in CLASSES:
        raise InputError(f"its type must be one of {', '.join(TYPES)}, not {stated!r}.")
    variant = member.properties.get("variant", VARIANTS[0])
    if variant not in VARIANTS:
        raise InputError(f"its variant must be COMMON or CUSTOMIZED, not {variant!r}.")
    periods = applicability(member.properties.get("limitedApplicability"))
    return category, periods, departures + property_departures(member.properties)


def _parts(geometry: Any, departures: list[str]) -> Iterator[tuple[dict[str, Any], Any]]:
    """Yield single geometries with their layers; a collection's layer is its parts' default."""
    if not isinstance(geometry, dict):
        raise InputError("its geometry is not a GeoJSON object.")
    if geometry.get("type") != "GeometryCollection":
        yield geometry, geometry.get("layer")
        departures += geometry_departures(geometry)
        return
    parts = geometry.get("geometries")
    if not isinstance(parts, list):
        raise InputError('a GeometryCollection must have a list of "geometries".')
    for part in parts:
        if isinstance(part, dict) and part.get("type") == "GeometryCollection":
            raise InputError("a GeometryCollection must not contain another one.")
        for each, layer in _parts(part, departures):
            yield each, layer if "layer" in each else geometry.get("layer")
    departures += geometry_departures(geometry)


def _rings(geometry: Mapping[str, Any]) -> tuple[list[Rings], float | None, list[str]]:
    """Return the rings, the radius and the kinds that are not areas of a single geometry."""
    extent = geometry.get("extent")
    if extent is None:
        found, others = areas(_not_empty(geometry), Placing(), is_circle=False)
        if any(len(set(ring)) < 3 for rings in found for ring in rings):
            raise InputError("a ring must have three corners or more.")
        return found, None, others
    if geometry.get("type") != "Point" or not isinstance(extent, dict):
        raise InputError("an extent must be an object of a Point.")
    if extent.get("subType") != "Circle":
        raise InputError(f"the subType of an extent must be Circle, not {extent.get('subType')!r}.")
    found, others = areas(geometry, Placing(), is_circle=True)
    return found, sized(extent.get("radius")), others


def _not_empty(geometry: Mapping[str, Any]) -> dict[str, Any]:
    """Return a geometry without polygons that have no ring, which the schema allows."""
    kind, coordinates = geometry.get("type"), geometry.get("coordinates")
    if kind == "Polygon" and coordinates == []:
        return {"type": "MultiPolygon", "coordinates": []}
    if kind == "MultiPolygon" and isinstance(coordinates, list):
        return {"type": kind, "coordinates": [each for each in coordinates if each != []]}
    return dict(geometry)


def _limit(layer: Any, side: str, unread: list[str]) -> Limit | None:
    """Return a limit; one without a reference is none, and added to the unread ones."""
    if layer is None:
        return None
    unit = str(layer.get("uom", "m"))
    if unit.lower() not in ("m", "ft"):
        raise InputError(f"the uom of a layer must be m or ft, not {unit!r}.")
    value, reference = layer.get(side), layer.get(f"{side}Reference")
    if reference is not None and str(reference).upper() not in ("AGL", "AMSL", "WGS84"):
        raise InputError(
            f"the {side}Reference of a layer must be AGL, AMSL or WGS84, not {reference!r}."
        )
    if value is None:
        return None
    if reference is None and is_number(value):
        unread.append(f"{side} without {side}Reference")
        return None
    return limit(value, unit, reference or "AMSL")
