"""The members of an ED-318 zone: a wrong value is refused, a departure in the paperwork is named.

A missing or unknown member, a text that is too long or too short, a time without a time zone, and
the spelling of ED-269 change neither area nor heights, so such a zone is read.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats.times import moment
from pathgene.host.numeric import is_number


__all__ = [
    "TYPES",
    "VARIANTS",
    "collection_departures",
    "feature_departures",
    "geometry_departures",
    "property_departures",
]

TYPES = ("USPACE", "PROHIBITED", "REQ_AUTHORIZATION", "CONDITIONAL", "NO_RESTRICTION")
VARIANTS = ("COMMON", "CUSTOMIZED")
_REASONS = (
    "AIR_TRAFFIC",
    "SENSITIVE",
    "PRIVACY",
    "POPULATION",
    "NATURE",
    "NOISE",
    "EMERGENCY",
    "DAR",
    "OTHER",
)
_MOMENT = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)")
_CLOCK = re.compile(r"\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)")
# Nested lists of positions in the coordinates of each kind of geometry.
_DEPTHS = {
    "Point": 0,
    "MultiPoint": 1,
    "LineString": 1,
    "MultiLineString": 2,
    "Polygon": 2,
    "MultiPolygon": 3,
}
# Fewest positions of a line, and of a ring.
_FEWEST = {"LineString": 2, "MultiLineString": 2, "Polygon": 4, "MultiPolygon": 4}

#: A check of a value at a place of the file, which yields departures and refuses wrong values.
_Check = Callable[[str, Any], Iterator[str]]


def property_departures(properties: Mapping[str, Any]) -> list[str]:
    """Return the departures of a zone's properties from the schema that leave its area clear.

    Raises
    ------
    InputError
        If a value is wrong.
    """
    return list(_ZONE("its properties", properties))


def collection_departures(document: Any) -> list[str]:
    """Return the departures of a document besides its features.

    Raises
    ------
    InputError
        If a value is wrong.
    """
    if not isinstance(document, dict) or document.get("type") != "FeatureCollection":
        return ["the document is no FeatureCollection"]
    return list(_COLLECTION("the collection", document))


def geometry_departures(geometry: Mapping[str, Any]) -> list[str]:
    """Return the departures of a geometry, whose positions must be numbers, and enough of them.

    Raises
    ------
    InputError
        If they are not as the kind requires.
    """
    kind = str(geometry.get("type"))
    if kind in _DEPTHS:
        _check_positions(kind, geometry.get("coordinates"), _DEPTHS[kind])
    return list(_GEOMETRY("its geometry", geometry))


def feature_departures(feature: Mapping[str, Any]) -> list[str]:
    """Return the departures of the members of a Feature besides properties and geometry.

    Raises
    ------
    InputError
        If a value is wrong.
    """
    return list(_FEATURE("it", feature))


def _check_positions(kind: str, value: Any, depth: int) -> None:
    if not isinstance(value, list):
        raise InputError(f"the coordinates of a {kind} must be a list, not {value!r:.40}.")
    if depth == 0:
        if len(value) < 2 or not all(map(is_number, value)):
            raise InputError("a position must be a list of two finite numbers.")
        return
    if depth == 1 and len(value) < _FEWEST.get(kind, 0):
        word = "ring" if "Polygon" in kind else "line"
        raise InputError(f"a {word} must have {_FEWEST[kind]} positions or more, not {len(value)}.")
    for each in value:
        _check_positions(kind, each, depth - 1)


def _text(least: int = 0, most: int = 10_000_000) -> _Check:
    def check(where: str, value: Any) -> Iterator[str]:
        if not isinstance(value, str):
            raise InputError(f"{where} must be a text, not {value!r:.40}.")
        if len(value) > most or len(value) < least:
            bound = f"at most {most}" if len(value) > most else f"at least {least}"
            yield f"{where} has {len(value)} characters, not {bound}"

    return check


def _word(*words: str) -> _Check:
    def check(where: str, value: Any) -> Iterator[str]:
        if value not in words:
            raise InputError(f"{where} must be one of {', '.join(words)}, not {value!r:.40}.")
        return iter(())

    return check


def _kind(name: str, *kinds: type) -> _Check:
    def check(where: str, value: Any) -> Iterator[str]:
        if not isinstance(value, kinds) or isinstance(value, bool):
            raise InputError(f"{where} must be {name}, not {value!r:.40}.")
        return iter(())

    return check


def _list(check_member: _Check, least: int = 0, most: int = 10_000_000) -> _Check:
    def check(where: str, value: Any) -> Iterator[str]:
        if not isinstance(value, list):
            raise InputError(f"{where} must be a list, not {value!r:.40}.")
        if len(value) > most or len(value) < least:
            yield f"{where} has {len(value)} members"
        for each in value:
            yield from check_member(where, each)

    return check


def _members(
    members: Mapping[str, _Check], required: Sequence[str] = (), *, is_open: bool = True
) -> _Check:
    def check(where: str, value: Any) -> Iterator[str]:
        if not isinstance(value, dict):
            raise InputError(f"{where} must be an object, not {value!r:.40}.")
        has = "have" if where.endswith("properties") else "has"
        missing = [name for name in required if name not in value]
        if missing:
            yield f"{where} {has} no {', '.join(missing)}"
        for name, each in value.items():
            if name in members and each is None:
                yield f"its {name} is null"
            elif name in members:
                yield from members[name](f"its {name}", each)
            elif not is_open:
                yield f"{where} {has} an unknown member {name:.40}"

    return check


def _moment(where: str, value: Any) -> Iterator[str]:
    if not isinstance(value, str):
        raise InputError(f"{where} must be a date and time, not {value!r:.40}.")
    moment(value)
    if not _MOMENT.fullmatch(value):
        yield f"{where}, {value!r:.40}, is no full date and time with a time zone"


def _clock(where: str, value: Any) -> Iterator[str]:
    if not isinstance(value, str):
        raise InputError(f"{where} must be a time of day, not {value!r:.40}.")
    if not _CLOCK.fullmatch(value):
        yield f"{where}, {value!r:.40}, is no full time of day with a time zone"


def _box(where: str, value: Any) -> Iterator[str]:
    if not isinstance(value, list) or len(value) < 4 or not all(map(is_number, value)):
        raise InputError(f"{where} must be a list of four numbers or more, not {value!r:.40}.")
    return iter(())


def _spelled(*words: str) -> _Check:
    """Return the check of a word that the reader refuses unless it knows the spelling."""

    def check(where: str, value: Any) -> Iterator[str]:
        if value not in words:
            yield f"{where}, {value!r:.40}, has another spelling"

    return check


def _whole(where: str, value: Any) -> Iterator[str]:
    if not is_number(value) or not float(value).is_integer():
        raise InputError(f"{where} must be a whole number, not {value!r:.40}.")
    return iter(())


def _number(where: str, value: Any) -> Iterator[str]:
    if not is_number(value):
        raise InputError(f"{where} must be a number, not {value!r:.40}.")
    return iter(())


_SHORT = _list(_members({"text": _text(most=200), "lang": _text(most=5)}, ("lang",)))
_EVENT = _spelled("BMCT", "SR", "SS", "EECT")
_REFERENCE = _spelled("AGL", "AMSL", "WGS84")
_LAYER = _members(
    {
        "upper": _number,
        "upperReference": _REFERENCE,
        "lower": _number,
        "lowerReference": _REFERENCE,
        "uom": _spelled("m", "ft"),
    }
)
_DAILY = _members(
    {
        "day": _list(_spelled("MON", "TUE", "WED", "THU", "FRI", "SAT", "SUN", "ANY")),
        "startTime": _clock,
        "startEvent": _EVENT,
        "endTime": _clock,
        "endEvent": _EVENT,
    },
    ("day",),
    is_open=False,
)
_PERIOD = _members(
    {"startDateTime": _moment, "endDateTime": _moment, "schedule": _list(_DAILY)}, is_open=False
)
_AUTHORITY = _members(
    {
        "name": _SHORT,
        "service": _SHORT,
        "contactName": _SHORT,
        "siteURL": _text(),
        "email": _text(),
        "phone": _text(most=200),
        "purpose": _word("AUTHORIZATION", "NOTIFICATION", "INFORMATION"),
        "intervalBefore": _text(),
    },
    ("purpose",),
)
_ZONE = _members(
    {
        "identifier": _text(most=7),
        "country": _text(3, 3),
        "name": _SHORT,
        "type": _spelled(*TYPES),
        "variant": _word(*VARIANTS),
        "restrictionConditions": _text(),
        "region": _whole,
        "reason": _list(_word(*_REASONS), most=9),
        "otherReasonInfo": _SHORT,
        "regulationExemption": _word("YES", "NO"),
        "message": _SHORT,
        "zoneAuthority": _list(_AUTHORITY, least=1),
        "limitedApplicability": _list(_PERIOD),
        "dataSource": _members(
            {
                "creationDate": _text(),
                "updateDateTime": _text(),
                "originator": _members({"text": _text(most=200), "lang": _text(most=5)}, ("lang",)),
            }
        ),
        "extendedProperties": _members({}),
    },
    ("identifier", "country", "type", "variant", "zoneAuthority"),
    is_open=False,
)
_GEOMETRY = _members({"layer": _LAYER, "bbox": _box})
_FEATURE = _members({"id": _kind("a number or a text", int, float, str), "bbox": _box})
_COLLECTION = _members(
    {
        "name": _text(most=200),
        "bbox": _box,
        "metadata": _members(
            {
                "validFrom": _moment,
                "validTo": _moment,
                "issued": _moment,
                "provider": _SHORT,
                "description": _SHORT,
                "otherGeoid": _text(),
                "technicalLimitations": _SHORT,
            }
        ),
    }
)
