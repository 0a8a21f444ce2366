"""ED-318 of EUROCAE: zones for UAS as GeoJSON with layers of height and circles around points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats import classes
from pathgene.host.formats.areas import Placing, Rings, areas
from pathgene.host.formats.collection import (
    Member,
    check_order,
    members,
    properties_of,
    read_members,
    sized,
)
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Feature, LeftOut, Limit, Read
from pathgene.host.formats.limits import limit
from pathgene.host.formats.times import applicability


__all__ = ["features", "recognises"]

TYPES = ("PROHIBITED", "REQ_AUTHORISATION", "CONDITIONAL", "NO_RESTRICTION", "USPACE")
_VARIANTS = ("COMMON", "CUSTOMIZED")
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
    return read_members(content.json, _zone)


def _zone(member: Member) -> Iterator[Read]:
    stated = member.properties.get("type")
    category = classes.of_word(str(stated))
    if category not in TYPES:
        raise InputError(f"its type must be one of {', '.join(TYPES)}, not {stated!r}.")
    variant = member.properties.get("variant", "COMMON")
    if variant not in _VARIANTS:
        raise InputError(f"its variant must be COMMON or CUSTOMIZED, not {variant!r}.")
    periods = applicability(member.properties.get("limitedApplicability"))
    if member.geometry is None:
        yield LeftOut(member.label, "it has no geometry")
        return
    for geometry, layer in _parts(member.geometry, None):
        lower, upper = _limit(layer, "lower"), _limit(layer, "upper")
        check_order(lower, upper)
        found, radius_m, others = _rings(geometry)
        forbids = classes.forbids(category)
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
            )


def _parts(geometry: Any, layer: Any) -> Iterator[tuple[dict[str, Any], Any]]:
    """Yield single geometries with their layers; a collection's layer is its parts' default."""
    if not isinstance(geometry, dict):
        raise InputError("its geometry is not a GeoJSON object.")
    layer = geometry.get("layer", layer)
    if geometry.get("type") != "GeometryCollection":
        yield geometry, layer
        return
    parts = geometry.get("geometries")
    if not isinstance(parts, list):
        raise InputError('a GeometryCollection must have a list of "geometries".')
    for part in parts:
        if part is not None:
            yield from _parts(part, layer)


def _rings(geometry: Mapping[str, Any]) -> tuple[list[Rings], float | None, list[str]]:
    """Return the rings, the radius and the kinds that are not areas of a single geometry."""
    extent = geometry.get("extent")
    if extent is None:
        found, others = areas(geometry, Placing(), is_circle=False)
        if any(len(set(ring)) < 3 for rings in found for ring in rings):
            raise InputError("a ring must have three corners or more.")
        return found, None, others
    if geometry.get("type") != "Point" or not isinstance(extent, dict):
        raise InputError("an extent must be an object of a Point.")
    if extent.get("subType") != "Circle":
        raise InputError(f"the subType of an extent must be Circle, not {extent.get('subType')!r}.")
    found, others = areas(geometry, Placing(), is_circle=True)
    return found, sized(extent.get("radius")), others


def _limit(layer: Any, side: str) -> Limit | None:
    if layer is None:
        return None
    if not isinstance(layer, dict):
        raise InputError(f"a layer must be an object, not {layer!r}.")
    unit = str(layer.get("uom", "m"))
    if unit.lower() not in ("m", "ft"):
        raise InputError(f"the uom of a layer must be m or ft, not {unit!r}.")
    value, reference = layer.get(side), layer.get(f"{side}Reference")
    if reference is not None and str(reference).upper() not in ("AGL", "AMSL", "WGS84"):
        raise InputError(
            f"the {side}Reference of a layer must be AGL, AMSL or WGS84, not {reference!r}."
        )
    return None if value is None else limit(value, unit, reference)
