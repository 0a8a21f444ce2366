"""Geozones of INAV as GeoJSON: exclusion and inclusion areas.

Heights are in metres above sea level or above home. The file does not name the home, so heights
above it are not read: an area to keep out of then reaches from the ground to the sky.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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
from pathgene.host.remarks import Grade, Remark


__all__ = ["features", "recognises"]

_TYPES = ("exclusive", "inclusive")
_HEIGHTS = ("MinAlt", "MaxAlt")
# Names of the member that tells heights above sea level from heights above home.
_AMSL = ("IsAMSL", "isSealevelRef", "isSeaLevelRef")
_TRUE, _FALSE = ("true", "1", "1.0"), ("false", "0", "0.0", "none", "")
# Remarks on heights above home, by whether the area is to stay in.
_ABOVE_HOME = {
    False: Remark(
        Grade.WARNING,
        "its heights are above home, which the file does not name, so it reaches from the ground "
        "to the sky",
    ),
    True: Remark(
        Grade.WARNING,
        "its heights are above home, which the file does not name, so the path stays in its area "
        "at any height",
    ),
}


def recognises(content: Content) -> bool:
    """Return whether a member has type, height or radius of a geozone."""
    return any(
        str(properties.get("Type")).lower() in _TYPES
        and any(name in properties for name in (*_HEIGHTS, *_AMSL, "Radius"))
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
    lower, upper = (_height(facts.get(name), name) for name in _HEIGHTS)
    check_order(lower, upper)
    if keeps_in and lower is not None and lower == upper:
        raise InputError("its MinAlt is its MaxAlt, so nothing may be flown in it.")
    remarks: tuple[Remark, ...] = ()
    if not _is_amsl(facts) and (lower or upper):
        remarks = (_ABOVE_HOME[keeps_in],)
        lower = upper = None
    for rings in found:
        radius_m = sized(facts["Radius"]) if len(rings[0]) == 1 else None
        for is_outside, low, high in _parts(lower, upper, keeps_in=keeps_in):
            yield Feature(
                member.number,
                member.name,
                rings,
                radius_m,
                low,
                high,
                keeps_in=is_outside,
                remarks=remarks,
            )


def _parts(
    lower: Limit | None, upper: Limit | None, *, keeps_in: bool
) -> Iterator[tuple[bool, Limit | None, Limit | None]]:
    """Yield the parts that forbid: all outside the area, or the area, between two limits.

    A geozone to stay in forbids everything outside it, and in its area all heights below its lower
    and above its upper limit.
    """
    if not keeps_in:
        yield False, lower, upper
        return
    yield True, None, None
    if lower is not None:
        yield False, None, lower
    if upper is not None:
        yield False, upper, None


def _is_amsl(facts: Mapping[str, Any]) -> bool:
    """Return whether heights are above sea level; without a statement they are above home.

    Raises
    ------
    InputError
        If the statement is neither true nor false.
    """
    name = next((name for name in _AMSL if name in facts), _AMSL[0])
    stated = str(facts.get(name, "false")).lower()
    if stated not in (*_TRUE, *_FALSE):
        raise InputError(f"{name} must be true or false, not {facts[name]!r}.")
    return stated in _TRUE


def _height(value: Any, name: str) -> Limit | None:
    """Return an altitude; 0 means no limit."""
    if value is None or value == 0:
        return None
    if not is_number(value):
        raise InputError(f"{name} must be a number, not {value!r}.")
    return Limit(float(value), Reference.AMSL)
