"""Geozones of INAV as GeoJSON: exclusion and inclusion areas."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats.areas import Placing, areas
from pathgene.host.formats.collection import (
    Member,
    check_order,
    members,
    properties_of,
    read_members,
    sized,
)
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Feature, LeftOut, Limit, Read, Reference
from pathgene.host.numeric import is_number


__all__ = ["features", "recognises"]

_TYPES = ("exclusive", "inclusive")
_HEIGHTS = ("MinAlt", "MaxAlt")


def recognises(content: Content) -> bool:
    """Return whether a member has type, height or radius of a geozone."""
    return any(
        str(properties.get("Type")).lower() in _TYPES
        and any(name in properties for name in (*_HEIGHTS, "IsAMSL", "Radius"))
        for properties in map(properties_of, members(content.json))
    )


def features(content: Content) -> Iterator[Read]:
    """Yield the geozones."""
    return read_members(content.json, _geozone)


def _geozone(member: Member) -> Iterator[Read]:
    facts = member.properties
    kind = str(facts.get("Type")).lower()
    if kind not in _TYPES:
        raise InputError(f"its Type must be Exclusive or Inclusive, not {facts.get('Type')!r}.")
    keeps_in = kind == "inclusive"
    if member.geometry is None:
        yield LeftOut(member.label, "it has no geometry")
        return
    found, others = areas(member.geometry, Placing(), is_circle="Radius" in facts)
    for other in others:
        yield LeftOut(member.label, f"a {other} without Radius is not an area", True)
    heights = [_height(facts.get(name), name) for name in _HEIGHTS]
    is_amsl = str(facts.get("IsAMSL")).lower() in ("true", "1")
    # Heights above home, whose place is not in the file, and the floor and ceiling of an inclusion
    # fence are not read.
    is_read = is_amsl and not keeps_in
    lower, upper = heights if is_read else (None, None)
    check_order(lower, upper)
    for rings in found:
        yield Feature(
            member.number,
            member.name,
            rings,
            sized(facts["Radius"]) if len(rings[0]) == 1 else None,
            lower,
            upper,
            keeps_in=keeps_in,
            unread=()
            if is_read
            else tuple(name for name, height in zip(_HEIGHTS, heights, strict=True) if height),
        )


def _height(value: Any, name: str) -> Limit | None:
    """Return an altitude; 0 means no limit."""
    if value is None or value == 0:
        return None
    if not is_number(value):
        raise InputError(f"{name} must be a number, not {value!r}.")
    return Limit(float(value), Reference.AMSL)
