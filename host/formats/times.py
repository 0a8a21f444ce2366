"""Times of zones in files: moments, days of the week, times of day, the sun."""

from __future__ import annotations

import operator
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, time, timedelta, timezone
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats.features import Period, SunEvent
from pathgene.host.remarks import Grade, Remark


__all__ = ["applicability", "between", "daily", "doubts_on_times", "moment"]

_DAYS = ("MON", "TUE", "WED", "THU", "FRI", "SAT", "SUN")
_DAY = timedelta(days=1)
_FIRST, _LAST = datetime.min.replace(tzinfo=UTC), datetime.max.replace(tzinfo=UTC)
# A Monday in UTC, on which times of day are placed.
_MONDAY = datetime(2024, 1, 1, tzinfo=UTC)
# The time zone of moments that state none.
_ASSUMED = timezone(timedelta(0), "UTC, assumed")


def moment(text: Any) -> datetime:
    """Return the moment of a text in ISO 8601; one without a time zone is UTC.

    Raises
    ------
    InputError
        If the text is not one.
    """
    midnight = str(text).replace("T24:00", "T00:00")
    try:
        # A date alone does not tell which end of the day is meant.
        if "T" not in midnight:
            raise ValueError
        found = datetime.fromisoformat(midnight)
        if found.tzinfo is None:
            found = found.replace(tzinfo=_ASSUMED)
        try:
            found += _DAY if midnight != str(text) else timedelta()
            found.astimezone(UTC)
        except OverflowError:
            # Programs write the first and last moment of their calendar for no bound.
            found = _FIRST if found.year == 1 else _LAST
    except ValueError:
        raise InputError(f"{text!r} is no date and time, such as 2026-05-01T06:00:00Z.") from None
    return found


def between(start: datetime | None, end: datetime | None) -> Period:
    """Return the period between two moments, which may be None for no bound."""
    plain = any(bound is not None and bound.tzinfo is _ASSUMED for bound in (start, end))
    return Period(start, end, has_plain_times=plain)


def daily(
    days: frozenset[int],
    first: str | SunEvent | None,
    last: str | SunEvent | None,
    start: datetime | None = None,
    end: datetime | None = None,
) -> Period:
    """Return the period of a time of day, which may be in any time zone.

    Parameters
    ----------
    days : frozenset of int
        Days of the week on which the period begins, Monday is 0; empty for every day.
    first, last : str or SunEvent, optional
        Bounds; a text is a time in ISO 8601, UTC without a zone. None for the bound of the day.
    start, end : datetime, optional
        Moments between which the period applies.

    Raises
    ------
    InputError
        If a text is not a time of day.
    """
    begin, finish = _on_monday(first), _on_monday(last)
    if isinstance(begin, datetime):
        shift = (begin.astimezone(UTC).date() - _MONDAY.date()).days
        days = frozenset((day + shift) % 7 for day in days)
    first_time = begin.astimezone(UTC).time() if isinstance(begin, datetime) else begin
    last_time = finish.astimezone(UTC).time() if isinstance(finish, datetime) else finish
    if first_time is None and last_time is not None:
        first_time = time(0)
    if last_time is None and first_time is not None:
        last_time = time(0)
    if first_time == last_time:
        if isinstance(first_time, time) and first_time != time(0):
            # From a time to the same time on the next day.
            days |= frozenset((day + 1) % 7 for day in days)
        first_time = last_time = None
    bounds = [each for each in (begin, finish) if isinstance(each, datetime)]
    plain = any(each.tzinfo is _ASSUMED for each in bounds)
    return replace(
        between(start, end),
        days=frozenset() if len(days) == 7 else days,
        first=first_time,
        last=last_time,
        has_plain_times=plain or between(start, end).has_plain_times,
    )


def _on_monday(text: str | SunEvent | None) -> datetime | SunEvent | None:
    if text is None or isinstance(text, SunEvent):
        return text
    try:
        if text.startswith("24:00"):
            return _MONDAY + _DAY
        of_day = time.fromisoformat(text)
    except ValueError:
        raise InputError(f"{text!r} is no time of day, such as 06:00:00Z.") from None
    return datetime.combine(_MONDAY.date(), of_day, of_day.tzinfo or _ASSUMED)


def applicability(value: Any) -> tuple[Period, ...]:
    """Return the periods of ED-269's ``applicability`` or ED-318's ``limitedApplicability``.

    Raises
    ------
    InputError
        If a period is bad.
    """
    found: list[Period] = []
    for part in value if isinstance(value, list) else [value]:
        if part is None:
            continue
        if not isinstance(part, dict):
            raise InputError(f"a period of its applicability must be an object, not {part!r}.")
        periods = list(_periods(part))
        if Period() in periods:
            return ()
        found += periods
    return tuple(found)


def doubts_on_times(value: Any) -> tuple[Remark, ...]:
    """Return notes on an applicability, without faults, whose parts contradict themselves."""
    parts = [part for part in (value if isinstance(value, list) else [value]) if part is not None]
    dated = [any(map(part.get, ("startDateTime", "endDateTime", "schedule"))) for part in parts]
    permanent = list(map(_is_permanent, parts))
    texts = []
    if any(map(operator.and_, permanent, dated)):
        texts.append(
            "it is permanent, so its dates and schedule are not read, and it is always active"
        )
    if any(
        not is_permanent and not has for is_permanent, has in zip(permanent, dated, strict=True)
    ):
        texts.append(
            "a period of its applicability has neither dates nor a schedule, so it counts as "
            "always active"
        )
    return tuple(Remark(Grade.NOTE, text) for text in texts)


def _is_permanent(part: dict[str, Any]) -> bool:
    """Return whether a period is permanent.

    Raises
    ------
    InputError
        If it says neither that it is nor that it is not.
    """
    stated = part.get("permanent")
    word = "NO" if stated is None else str(stated).strip().upper()
    if word in ("YES", "TRUE", "Y"):
        return True
    if word in ("NO", "FALSE", "N", ""):
        return False
    raise InputError(f"permanent must be YES or NO, not {stated!r}.")


def _periods(part: dict[str, Any]) -> Iterator[Period]:
    if _is_permanent(part):
        yield Period()
        return
    start, end = (
        moment(part[name]) if part.get(name) else None for name in ("startDateTime", "endDateTime")
    )
    if start and end and end < start:
        raise InputError(f"its period ends on {end.isoformat()}, before its start.")
    schedule = part.get("schedule")
    if not schedule:
        yield between(start, end)
        return
    for each in schedule if isinstance(schedule, list) else [schedule]:
        if not isinstance(each, dict):
            raise InputError(f"a daily period must be an object, not {each!r}.")
        bounds = (_bound(each, "start"), _bound(each, "end"))
        yield daily(_weekdays(each.get("day")), *bounds, start, end)


def _weekdays(value: Any) -> frozenset[int]:
    names = value if isinstance(value, list) else [value]
    upper = [str(name).upper() for name in names]
    if value is None or "ANY" in upper:
        return frozenset()
    for name in upper:
        if name not in _DAYS:
            raise InputError(f"{name!r} is no day of the week; it must be MON to SUN or ANY.")
    return frozenset(map(_DAYS.index, upper))


def _bound(part: dict[str, Any], side: str) -> str | SunEvent | None:
    event, clock = part.get(f"{side}Event"), part.get(f"{side}Time")
    if event is None:
        return None if clock is None else str(clock)
    if clock is not None:
        raise InputError(f"a daily period has both {side}Time and {side}Event; give one.")
    try:
        return SunEvent(str(event).upper())
    except ValueError:
        raise InputError(f"{event!r} is no event of the sun: BMCT, SR, SS or EECT.") from None
