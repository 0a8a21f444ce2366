"""Times of zones after a departure, compared with the definition moment by moment."""

import math
import random
from datetime import UTC, datetime, time, timedelta, timezone

import pytest

from pathgene.host.formats.features import Period, SunEvent
from pathgene.host.formats.times import moment
from pathgene.host.problem.active_times import LONGEST_S, intervals


HERE = ((10.0, 60.0), (10.1, 60.0), (10.1, 60.1))
DAY = timedelta(days=1)
FIRST, LAST = datetime.min.replace(tzinfo=UTC), datetime.max.replace(tzinfo=UTC)
FILES, MANY = 40, 400


def is_active(period, moment):
    """Return whether a period includes a moment, by its definition, day by day."""
    if (period.start and moment < period.start) or (period.end and moment >= period.end):
        return False
    moment = moment.astimezone(UTC)
    for back in (0, 1):
        day = moment.date() - back * DAY
        if period.days and day.weekday() not in period.days:
            continue
        midnight = datetime.combine(day, time(), UTC)
        first = midnight if period.first is None else datetime.combine(day, period.first, UTC)
        last = midnight + DAY if period.last is None else datetime.combine(day, period.last, UTC)
        if last <= first:
            last += DAY
        if first <= moment < last:
            return True
    return False


def draw(rng, departure):
    """Return a random period without the sun."""
    hours = [timedelta(hours=rng.uniform(-100, 100)) for _ in range(2)]
    start, end = sorted(departure + each for each in hours)
    bounds = [time(rng.randrange(24), rng.choice((0, 15, 30))) for _ in range(2)]
    return Period(
        start if rng.random() < 0.5 else None,
        end if rng.random() < 0.5 else None,
        frozenset(day for day in range(7) if rng.random() < 0.5),
        bounds[0] if rng.random() < 0.7 else None,
        bounds[1] if rng.random() < 0.7 else None,
    )


def check(seed):
    rng = random.Random(seed)
    zone = timezone(timedelta(hours=rng.choice((-9, 0, 5.5, 12))))
    departure = datetime(2026, 3, 1, tzinfo=zone) + timedelta(minutes=rng.randrange(500_000))
    periods = [draw(rng, departure) for _ in range(rng.randint(1, 3))]
    found = intervals(periods, departure, HERE)
    for minute in range(0, int(LONGEST_S / 60), 13):
        seconds = 60.0 * minute + 0.5
        wanted = any(is_active(each, departure + timedelta(seconds=seconds)) for each in periods)
        own = any((a or 0.0) <= seconds < (math.inf if b is None else b) for a, b in found)
        assert own == wanted, (seed, seconds, periods, found)


@pytest.mark.parametrize("seed", range(FILES))
def test_intervals_are_the_periods(seed):
    check(seed)


@pytest.mark.long
def test_many_intervals_are_the_periods():
    for seed in range(FILES, MANY):
        check(seed)


def altitude_deg(moment, lon, lat):
    """Return the altitude of the sun, within 0.1 degree; after Meeus, low accuracy."""
    days = (moment - datetime(2000, 1, 1, 12, tzinfo=UTC)).total_seconds() / 86400
    mean = math.radians(357.529 + 0.98560028 * days)
    along = math.radians(
        280.459 + 0.98564736 * days + 1.915 * math.sin(mean) + 0.020 * math.sin(2 * mean)
    )
    tilt = math.radians(23.439)
    ascension = math.atan2(math.cos(tilt) * math.sin(along), math.cos(along))
    declination = math.asin(math.sin(tilt) * math.sin(along))
    turned = math.radians((18.697374558 + 24.06570982441908 * days) * 15 + lon) - ascension
    here = math.radians(lat)
    return math.degrees(
        math.asin(
            math.sin(here) * math.sin(declination)
            + math.cos(here) * math.cos(declination) * math.cos(turned)
        )
    )


@pytest.mark.parametrize(
    ("lon", "lat", "month"), [(10, 50, 6), (10, 65, 1), (178, -17, 3), (-179, 40, 9), (-75, 0, 12)]
)
@pytest.mark.parametrize(
    ("first", "last", "is_day", "height"),
    [
        (SunEvent.SUNRISE, SunEvent.SUNSET, True, -0.83),
        (SunEvent.SUNSET, SunEvent.SUNRISE, False, -0.83),
        (SunEvent.MORNING_TWILIGHT, SunEvent.EVENING_TWILIGHT, True, -6.0),
        (SunEvent.EVENING_TWILIGHT, SunEvent.MORNING_TWILIGHT, False, -6.0),
    ],
)
def test_day_and_night_are_those_of_the_sun(lon, lat, month, first, last, is_day, height):
    departure = datetime(2026, month, 10, 3, tzinfo=UTC)
    corners = ((float(lon), float(lat)),) * 3
    found = intervals([Period(first=first, last=last)], departure, corners)
    wrong = 0
    for minute in range(0, int(LONGEST_S / 60), 5):
        seconds = 60.0 * minute
        own = any((a or 0.0) <= seconds < (math.inf if b is None else b) for a, b in found)
        wanted = (altitude_deg(departure + timedelta(seconds=seconds), lon, lat) > height) == is_day
        # The zone may be active some minutes longer, never shorter.
        assert own or not wanted, (seconds, found)
        wrong += own != wanted
    assert wrong <= 6 * 3 * 2 / 2


@pytest.mark.parametrize(("hour", "is_active"), [(17, False), (19, True), (21, True), (23, True)])
def test_the_morning_in_the_east_is_the_evening_before_in_utc(hour, is_active):
    """A flight of an hour in New Zealand, where the sun rises at 19 h UTC and sets at 5 h."""
    departure = datetime(2026, 5, 4, hour, 15, tzinfo=UTC)
    day = Period(first=SunEvent.SUNRISE, last=SunEvent.SUNSET)
    assert bool(intervals([day], departure, ((174.0, -41.0),) * 3, 3600.0)) == is_active


def test_without_a_sunrise_a_day_is_a_day_of_the_zone():
    """Monday in Chukotka begins on Sunday at noon, UTC."""
    monday = Period(days=frozenset({0}), first=SunEvent.SUNRISE, last=SunEvent.SUNSET)
    sunday = datetime(2026, 6, 21, 13, tzinfo=UTC)
    assert intervals([monday], sunday, ((179.0, 75.0),) * 3, 3600.0) == [(None, None)]


def test_without_a_sunset_a_zone_of_the_day_is_always_active():
    departure = datetime(2026, 6, 20, 3, tzinfo=UTC)
    north = ((20.0, 75.0),) * 3
    day = Period(first=SunEvent.SUNRISE, last=SunEvent.SUNSET)
    assert intervals([day], departure, north) == [(None, None)]


def test_a_period_that_is_over_is_never_active():
    departure = datetime(2026, 6, 20, 3, tzinfo=UTC)
    past = Period(end=departure - timedelta(seconds=1))
    assert intervals([past], departure, HERE) == []


@pytest.mark.parametrize(
    ("text", "bound"),
    [
        ("0001-01-01T00:00:00+05:00", FIRST),
        ("9999-12-31T23:59:59.9999999-05:00", LAST),
        ("9999-12-31T24:00:00Z", LAST),
    ],
)
def test_a_moment_beyond_the_calendar_is_no_bound(text, bound):
    found = moment(text)
    assert found == bound
    period = Period(*((found, None) if bound is FIRST else (None, found)))
    assert intervals([period], datetime(2026, 6, 20, 3, tzinfo=UTC), HERE) == [(None, None)]
