"""The sun's rise, set and civil twilight by the low-precision formulas of the Astronomical Almanac.

They are good to a minute below the polar circles.
"""

import math
from datetime import UTC, datetime, timedelta


_J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)
_NOON = timedelta(hours=12)
#: Height of the sun in degrees, and the side of noon.
_EVENTS = {"SR": (-0.833, -1), "SS": (-0.833, 1), "BMCT": (-6.0, -1), "EECT": (-6.0, 1)}


def moment(day, lon, lat, event):
    """Return the moment of an event next to the noon of a date at a longitude, UTC."""
    height, side = _EVENTS[event]
    noon = datetime(day.year, day.month, day.day, tzinfo=UTC) + _NOON - timedelta(hours=lon / 15)
    found = noon
    for _ in range(4):
        declination, lead_deg = _place(found)
        cosine = (
            math.sin(math.radians(height)) - math.sin(math.radians(lat)) * math.sin(declination)
        ) / (math.cos(math.radians(lat)) * math.cos(declination))
        angle = math.degrees(math.acos(cosine))
        found = noon + timedelta(hours=(side * angle - lead_deg) / 15)
    return found


def _place(when):
    """Return the sun's declination, radians, and its lead over the mean sun, degrees."""
    n = (when - _J2000) / timedelta(days=1)
    mean = 280.460 + 0.9856474 * n
    anomaly = math.radians(357.528 + 0.9856003 * n)
    along = math.radians(mean + 1.915 * math.sin(anomaly) + 0.020 * math.sin(2 * anomaly))
    tilt = math.radians(23.439 - 4e-7 * n)
    declination = math.asin(math.sin(tilt) * math.sin(along))
    ascension = math.degrees(math.atan2(math.cos(tilt) * math.sin(along), math.cos(along)))
    return declination, (mean - ascension + 180) % 360 - 180
