"""openAIP: airspaces as GeoJSON or as the JSON of its service, with numbers for types and units."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from datetime import time
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats import classes
from pathgene.host.formats.areas import Placing, areas
from pathgene.host.formats.collection import (
    Member,
    check_order,
    members,
    properties_of,
    read_members,
)
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Feature, LeftOut, Limit, Period, Read, SunEvent
from pathgene.host.formats.limits import limit, limit_text
from pathgene.host.formats.times import between, daily, moment
from pathgene.host.remarks import Grade, Remark


__all__ = ["features", "recognises"]

# The numbers of openAIP.
_UNITS = {0: "M", 1: "FT", 6: "FL"}
_REFERENCES = {0: "AGL", 1: "AMSL", 2: "STD"}
# openAIP's OpenAir reader writes the second pair.
_LIMITS = (("lowerLimit", "upperLimit"), ("lowerCeiling", "upperCeiling"))
# Activations that have no fixed time: the airspace counts as always active.
_AT_ANY_TIME = {"byNotam": "by NOTAM", "onDemand": "on demand", "onRequest": "on request"}
_UTC = "its hours of operation count as UTC, as openAIP defines them"
# Activities by their numbers.
_ACTIVITIES = (
    "",
    "parachuting",
    "aerobatics",
    "aeroclub and aerial work",
    "ultralight flight",
    "hang gliding and paragliding",
)


def recognises(content: Content) -> bool:
    """Return whether a member has a limit that is an object with unit and reference."""
    return any(
        isinstance(value, dict) and ("referenceDatum" in value or value.get("unlimited") is True)
        for member in members(content.json)
        for pair in _LIMITS
        for value in map(properties_of(member).get, pair)
    )


def features(content: Content) -> Iterator[Read]:
    """Yield the airspaces."""
    return read_members(content.json, _airspace)


def _airspace(member: Member) -> Iterator[Read]:
    if member.geometry is None:
        yield LeftOut(member.label, "it has no geometry")
        return
    facts = member.properties
    category, airspace_class = _type_and_class(facts)
    forbids = classes.forbids(category, airspace_class=airspace_class)
    names = next((pair for pair in _LIMITS if any(name in facts for name in pair)), _LIMITS[0])
    unread: list[str] = []
    limits = list(_limits(facts, names, unread))
    periods = _periods(facts, unread)
    has_hours = any(isinstance(each, time) for p in periods for each in (p.first, p.last))
    unknown = classes.unknown((category, airspace_class))
    hours = (Remark(Grade.NOTE, _UTC),) if has_hours else ()
    remarks = (*_remarks(facts, forbids=forbids), *hours, *unknown)
    found, others = areas(member.geometry, Placing(), is_circle=False)
    if any(len(set(ring)) < 3 for rings in found for ring in rings):
        raise InputError("a ring must have three corners or more.")
    for kind in others:
        yield LeftOut(member.label, f"a {kind} is not an area", forbids)
    for rings, (lower, upper) in itertools.product(found, limits):
        yield Feature(
            member.number,
            member.name,
            rings,
            None,
            lower,
            upper,
            periods,
            category,
            forbids=forbids,
            airspace_class=airspace_class,
            unread=tuple(unread),
            remarks=remarks,
        )


def _remarks(facts: Mapping[str, Any], *, forbids: bool) -> Iterator[Remark]:
    """Yield remarks on activations without a time, and on activities that nothing forbids."""
    ways = [text for name, text in _AT_ANY_TIME.items() if facts.get(name) is True]
    if ways:
        text = f"it is activated {' or '.join(ways)} and counts as always active"
        yield Remark(Grade.NOTE, text)
    activity = facts.get("activity")
    if activity is not None:
        if activity not in range(len(_ACTIVITIES)) or isinstance(activity, bool):
            most = len(_ACTIVITIES) - 1
            raise InputError(f"{activity!r:.40} is no activity of openAIP, which has 0 to {most}.")
        if activity and not forbids:
            why = f"its activity is {_ACTIVITIES[activity]}, and its class does not forbid flight"
            yield Remark(Grade.WARNING, why)


def _type_and_class(facts: Mapping[str, Any]) -> tuple[str, str]:
    """Return the type, from its number or word, and the ICAO class, from its number or letter."""
    kind, icao = facts.get("type"), facts.get("icaoClass", facts.get("class"))
    # An airspace that is no Feature has its own type there.
    type_name = "OTHER" if kind == "Feature" else _name(kind, classes.of_openaip)
    return classes.type_and_class(type_name, _name(icao, classes.of_icao))


def _name(stated: Any, of_number: Callable[[Any], str]) -> str:
    if stated is None:
        return "OTHER"
    if isinstance(stated, str):
        return classes.of_word(stated)
    return of_number(stated)


def _limits(
    facts: Mapping[str, Any], names: tuple[str, str], unread: list[str]
) -> Iterator[tuple[Limit | None, Limit | None]]:
    """Yield pairs of limits: one, or several that together cover all stated limits.

    ``lowerLimitMin`` and ``upperLimitMax`` state a second height, such as FL 65 or 1,000 ft above
    the ground, whichever is higher.
    """
    lower, upper = (_limit(facts, name, unread) for name in names)
    lowest, highest = (
        _limit(facts, other, unread) if facts.get(other) is not None else stated
        for other, stated in (("lowerLimitMin", lower), ("upperLimitMax", upper))
    )
    pairs = ((lower, upper), (lowest, upper), (lower, highest), (lowest, highest))
    for pair in dict.fromkeys(pairs):
        check_order(*pair)
        yield pair


def _limit(facts: Mapping[str, Any], name: str, unread: list[str]) -> Limit | None:
    value = facts.get(name)
    if isinstance(value, str):
        try:
            return limit_text(value)
        except ValueError:
            unread.append(name)
            return None
    if value is None:
        return None
    if not isinstance(value, dict):
        raise InputError(f"{name} must be an object with value, unit and referenceDatum.")
    if value.get("unlimited") is True:
        return None
    unit, reference = value.get("unit"), value.get("referenceDatum")
    unit = _UNITS.get(unit, unit) if isinstance(unit, int) else unit
    reference = _REFERENCES.get(reference, reference) if isinstance(reference, int) else reference
    if (unit, reference) in (("FL", "AGL"), ("FL", "GND")):
        # A pressure is no height above the ground, so the limit is unknown.
        unread.append(f"{name} FL {value.get('value')} {reference}")
        return None
    return limit(value.get("value"), unit, reference)


def _periods(facts: Mapping[str, Any], unread: list[str]) -> tuple[Period, ...]:
    """Return the times of activity, UTC; none for an airspace that may be active at any time."""
    activations = [_is_true(facts, name) for name in _AT_ANY_TIME]
    if any(activations):
        return ()
    start, end = (
        moment(facts[name]) if facts.get(name) else None for name in ("activeFrom", "activeUntil")
    )
    if start and end and end < start:
        raise InputError("its activeUntil lies before its activeFrom.")
    hours = facts.get("hoursOfOperation") or {}
    if not isinstance(hours, dict):
        raise InputError(f"its hoursOfOperation must be an object, not {hours!r:.40}.")
    listed = hours.get("operatingHours")
    if not listed:
        return (between(start, end),) if start or end else ()
    if not isinstance(listed, list) or not all(isinstance(each, dict) for each in listed):
        raise InputError("its operatingHours must be a list of objects.")
    if "local" in str(hours.get("remarks", "")).lower():
        unread.append("hoursOfOperation")
        return ()
    activations = [_is_true(each, "byNotam") for each in listed]
    if any(activations):
        return ()
    periods: dict[Any, Period] = {}
    for each in listed:
        day = each.get("dayOfWeek")
        if isinstance(day, bool) or not isinstance(day, int) or not 0 <= day <= 6:
            raise InputError(f"a dayOfWeek must be 0 to 6, not {day!r}.")
        period = daily(frozenset({day}), *_bounds(each), start, end)
        same = (period.first, period.last)
        days = periods[same].days if same in periods else frozenset()
        periods[same] = Period(start, end, days | period.days, *same)
    joined = [
        Period(start, end, frozenset() if len(each.days) == 7 else each.days, each.first, each.last)
        for each in periods.values()
    ]
    return () if Period() in joined else tuple(joined)


def _bounds(each: Mapping[str, Any]) -> tuple[str | SunEvent | None, str | SunEvent | None]:
    first = SunEvent.SUNRISE if _is_true(each, "sunrise") else each.get("startTime")
    last = SunEvent.SUNSET if _is_true(each, "sunset") else each.get("endTime")
    for name, value in (("startTime", first), ("endTime", last)):
        if value is not None and not isinstance(value, str):
            raise InputError(f"its {name} must be a text, not {value!r:.40}.")
    return first, last


def _is_true(facts: Mapping[str, Any], name: str) -> bool:
    value = facts.get(name)
    if not isinstance(value, bool | None):
        raise InputError(f"{name} must be true or false, not {value!r:.40}.")
    return value is True
