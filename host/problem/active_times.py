"""Times of zones: periods of a file as seconds after the departure, with a safety margin."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from datetime import UTC, datetime, time, timedelta, timezone
from operator import itemgetter
from typing import Any

from pathgene.host.formats.features import Period, Position, SunEvent


__all__ = ["LONGEST_S", "Interval", "described", "intervals"]

#: Seconds after the start of the path; None for no limit.
Interval = tuple[float | None, float | None]

#: Maximum duration of a flight, seconds: three days.
LONGEST_S = 259_200.0
# Sunrise and sunset are known to a minute or two; a zone is active longer by this time.
_SUN_MARGIN = timedelta(minutes=5)
_DAY = timedelta(days=1)
_DAYS = ("Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun")


def intervals(
    periods: Sequence[Period],
    departure: datetime,
    corners: Sequence[Position],
    longest_s: float = LONGEST_S,
) -> list[Interval]:
    """Return when a zone is active during a flight, in seconds after the departure.

    Parameters
    ----------
    periods : sequence of Period
        Not empty.
    departure : datetime
        With a time zone.
    corners : sequence of (longitude, latitude)
        Places of the zone, at which the sun rises and sets.
    longest_s : float
        Maximum duration of the flight, seconds.
    """
    begin = departure.astimezone(UTC)
    end = begin + timedelta(seconds=longest_s)
    found = sorted(
        (max(first, begin), min(last, end))
        for period in periods
        for first, last in _spans(period, begin, end, corners)
        if first < end and last > begin
    )
    joined: list[tuple[datetime, datetime]] = []
    for first, last in found:
        if joined and first <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(joined[-1][1], last))
        else:
            joined.append((first, last))
    return [
        (
            None if first == begin else (first - begin).total_seconds(),
            None if last == end else (last - begin).total_seconds(),
        )
        for first, last in joined
    ]


def _spans(
    period: Period, begin: datetime, end: datetime, corners: Sequence[Position]
) -> Iterator[tuple[datetime, datetime]]:
    """Yield the spans of a period around a time of interest, in UTC."""
    start = begin - _DAY if period.start is None else period.start.astimezone(UTC)
    stop = end + _DAY if period.end is None else period.end.astimezone(UTC)
    if not period.days and period.first is None and period.last is None:
        yield start, stop
        return
    day = begin.date() - timedelta(days=2)
    # East of Greenwich the sun rises on the evening before, in UTC.
    while datetime.combine(day, time(), UTC) < end + _DAY:
        if not period.days or day.weekday() in period.days:
            midnight = datetime.combine(day, time(), UTC)
            first = _moment(period.first, midnight, corners, is_end=False)
            last = _moment(period.last, midnight, corners, is_end=True)
            if last <= first:
                last = _moment(period.last, midnight + _DAY, corners, is_end=True)
            if max(first, start) < min(last, stop):
                yield max(first, start), min(last, stop)
        day += _DAY


def _moment(
    bound: time | SunEvent | None,
    midnight: datetime,
    corners: Sequence[Position],
    *,
    is_end: bool,
) -> datetime:
    """Return the moment of a bound in a day, with a safety margin for an event of the sun."""
    if bound is None:
        return midnight + (_DAY if is_end else timedelta())
    if isinstance(bound, time):
        if bound.tzinfo is None:
            bound = bound.replace(tzinfo=UTC)
        # A bound such as 06:00+02:00 belongs to the same day.
        return datetime.combine(midnight.date(), bound).astimezone(UTC)
    moments = list(_sun(bound, midnight, corners))
    if len(moments) < len(_extremes(corners)):
        # If the sun does not rise or set there, the zone is active all day, in any time zone.
        return midnight + (1.5 * _DAY if is_end else -0.5 * _DAY)
    return max(moments) + _SUN_MARGIN if is_end else min(moments) - _SUN_MARGIN


def _sun(event: SunEvent, midnight: datetime, corners: Sequence[Position]) -> Iterator[datetime]:
    """Yield the moments of an event in a local day, at each outermost place of a zone."""
    from astral import Observer
    from astral.sun import dawn, dusk, sunrise, sunset

    finders: dict[SunEvent, Callable[..., Any]] = {
        SunEvent.MORNING_TWILIGHT: dawn,
        SunEvent.SUNRISE: sunrise,
        SunEvent.SUNSET: sunset,
        SunEvent.EVENING_TWILIGHT: dusk,
    }
    for longitude, latitude in _extremes(corners):
        east = (longitude + 180.0) % 360.0 - 180.0
        zone = timezone(timedelta(hours=round(east / 15.0)))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                moment = finders[event](Observer(latitude, east), midnight.date(), tzinfo=zone)
            except ValueError:
                continue
        yield moment.astimezone(UTC)


def _extremes(corners: Iterable[Position]) -> tuple[Position, ...]:
    """Return the westernmost, easternmost, southernmost and northernmost corner."""
    places = list(corners)
    east, north = itemgetter(0), itemgetter(1)
    return (
        min(places, key=east),
        max(places, key=east),
        min(places, key=north),
        max(places, key=north),
    )


def described(periods: Iterable[Period]) -> str:
    """Return periods in words; empty for always."""
    return "; ".join(filter(None, map(_words, periods)))


def _words(period: Period) -> str:
    parts = [
        "" if period.start is None else f"from {period.start.isoformat()}",
        "" if period.end is None else f"until {period.end.isoformat()}",
        " ".join(_DAYS[day] for day in sorted(period.days)),
    ]
    if period.first is not None or period.last is not None:
        parts.append(f"{_bound(period.first, '00:00')} to {_bound(period.last, '24:00')}")
    return ", ".join(filter(None, parts))


def _bound(bound: time | SunEvent | None, default: str) -> str:
    if bound is None:
        return default
    return str(bound) if isinstance(bound, SunEvent) else bound.isoformat("minutes")
