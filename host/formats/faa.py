"""Airspace of the FAA as GeoJSON: classes, special use, and the map of facilities for UAS.

The limits of an airspace are a value, a unit and a code of the reference (``UPPER_VAL``,
``UPPER_UOM``, ``UPPER_CODE``). A cell of the map of facilities has the height above the ground
(``CEILING``) up to which an authorisation is usual: it is one area below that height, which
requires an authorisation, and one above it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats import classes
from pathgene.host.formats.areas import Placing, areas, named_system, unread
from pathgene.host.formats.collection import (
    Member,
    check_order,
    members,
    properties_of,
    read_members,
)
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Feature, LeftOut, Limit, Read, Reference
from pathgene.host.formats.limits import limit
from pathgene.host.numeric import as_number, parse


__all__ = ["features", "recognises"]

_LIMITS = ("UPPER_VAL", "UPPER_UOM", "UPPER_CODE", "LOWER_VAL", "LOWER_UOM", "LOWER_CODE")
_KNOWN = (*_LIMITS, "UPPER_DESC", "LOWER_DESC", "CEILING")
# Members of the cells of the map of facilities, besides the height.
_CELL = ("MAP_EFF", "APT1_FAAID", "APT1_ICAO", "UNIT", "ARPT_COUNT")
# The FAA writes this number, or a smaller one, where there is no value.
_NO_VALUE = -9998.0
_UNLIMITED = ("UNLTD", "UNL", "UNLIMITED")
# The surface area of an airport in class E, where 14 CFR 107.41 requires an authorisation. The
# extensions of surface areas, E3 and E4, require none.
_SURFACE_AREA = "CLASS_E2"
# Letters of special use that are classes of airspace elsewhere.
_TYPES = MappingProxyType(
    {
        "A": "ALERT",
        "D": "DANGER",
        "MOA": "MTA",
        "MODE-C": "TMZ",
        "NSA": "PROTECTED",
        "P": "PROHIBITED",
        "R": "RESTRICTED",
        "W": "WARNING",
    }
)


def recognises(content: Content) -> bool:
    """Return whether a member has limits or a cell of the FAA."""
    return any(
        _is_airspace(properties) or _is_cell(properties)
        for properties in map(properties_of, members(content.json))
    )


def _is_airspace(properties: Mapping[str, Any]) -> bool:
    return any(
        f"{side}_VAL" in properties and f"{side}_CODE" in properties for side in ("UPPER", "LOWER")
    )


def _is_cell(properties: Mapping[str, Any]) -> bool:
    return "CEILING" in properties and any(name in properties for name in _CELL)


def features(content: Content) -> Iterator[Read]:
    """Yield the airspaces and cells.

    Raises
    ------
    InputError
        If the reference system is unknown.
    """
    document = content.json
    placing = Placing(system=named_system(document) if isinstance(document, dict) else None)

    def read(member: Member) -> Iterator[Read]:
        return _areas(member, placing)

    yield from read_members(document, read)


def _areas(member: Member, placing: Placing) -> Iterator[Read]:
    if member.geometry is None:
        yield LeftOut(member.label, "it has no geometry")
        return
    facts = member.properties
    parts = list(_cell(facts) if _is_cell(facts) else _airspace(facts))
    found, others = areas(member.geometry, placing, is_circle=False)
    for kind in others:
        yield LeftOut(member.label, f"a {kind} is not an area", True)
    for rings in found:
        for (category, airspace_class), lower, upper, doubtful in parts:
            yield Feature(
                member.number,
                member.name,
                rings,
                None,
                lower,
                upper,
                category=category,
                forbids=classes.forbids(category, airspace_class=airspace_class),
                unread=(*doubtful, *unread(facts, _KNOWN)),
                airspace_class=airspace_class,
                remarks=classes.unknown((category, airspace_class)),
            )


# Type and class, limits, doubtful properties.
_Part = tuple[tuple[str, str], Limit | None, Limit | None, tuple[str, ...]]


def _cell(facts: Mapping[str, Any]) -> Iterator[_Part]:
    """Yield the parts of a cell of the map of facilities: below its height, and above it."""
    unit = facts.get("UNIT") or "FT"
    height = limit(_value(facts.get("CEILING"), "CEILING"), unit, "AGL")
    if height.height_m > 0:
        yield ("REQ_AUTHORISATION", ""), None, height, ()
    yield ("RESTRICTED", ""), height if height.height_m > 0 else None, None, ()


def _airspace(facts: Mapping[str, Any]) -> Iterator[_Part]:
    doubtful: list[str] = []
    lower, upper = (_limit(facts, side, doubtful) for side in ("LOWER", "UPPER"))
    check_order(lower, upper)
    yield _type_and_class(facts, lower), lower, upper, tuple(doubtful)


def _limit(facts: Mapping[str, Any], side: str, doubtful: list[str]) -> Limit | None:
    """Return a limit; one without a unit or reference is none, and added to the doubtful ones."""
    code = str(facts.get(f"{side}_CODE") or "").strip().upper()
    if code in _UNLIMITED:
        return None
    value = _value(facts.get(f"{side}_VAL"), f"{side}_VAL")
    if code in ("SFC", "GND") and value in (None, 0.0):
        return Limit(0.0, Reference.AGL, "SFC")
    if value is None:
        return None
    try:
        return limit(value, facts.get(f"{side}_UOM"), code)
    except InputError:
        doubtful.append(f"{side}_VAL")
        return None


def _value(stated: Any, name: str) -> float | None:
    """Return a number, which some files state as a text, or None."""
    if stated is None or stated == "":
        return None
    try:
        value = parse(stated) if isinstance(stated, str) else as_number(stated)
    except ValueError:
        raise InputError(f"{name} must be a number, not {stated!r}.") from None
    return None if value <= _NO_VALUE else value


def _type_and_class(facts: Mapping[str, Any], lower: Limit | None) -> tuple[str, str]:
    """Return the type, of special use or of a surface area, and the class of airspace."""
    kind, local, stated = (
        str(facts.get(name) or "").strip().upper() for name in ("TYPE_CODE", "LOCAL_TYPE", "CLASS")
    )
    class_name = stated if len(stated) == 1 and stated in "ABCDEFG" else "OTHER"
    begins_at_ground = lower is None or (lower.reference is Reference.AGL and lower.height_m <= 0)
    if kind in _TYPES:
        type_name = _TYPES[kind]
    elif local == _SURFACE_AREA and begins_at_ground:
        type_name = "REQ_AUTHORISATION"
    else:
        # A single letter is no word of the table of classes: there W is a wave window.
        type_name = classes.of_word(kind) if len(kind) > 1 and kind != "CLASS" else "OTHER"
    return classes.type_and_class(type_name, class_name)
