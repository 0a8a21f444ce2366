"""Random scenes of zones in terms of no file format: places, heights, times and classes.

:mod:`tests.support.host.zone_writers` writes a scene as a file, and
:mod:`tests.support.host.zone_judge` judges paths among its zones. Neither knows the readers.
"""

import math
import random
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta, timezone
from functools import cache, cached_property

import numpy as np
import rasterio
from affine import Affine
from pyproj import Transformer

from tests.support.host import sun
from tests.support.host.zone_abilities import ABILITIES


NODES, CELL = 41, 100.0
FOOT_M = 0.3048
#: Reference systems with a place, its longitude, latitude and height of the geoid.
PLACES = (
    ("EPSG:32632", 9.6, 45.1, 45.0),
    ("EPSG:32633", 13.2, 60.0, 36.0),
    ("EPSG:32760", 179.996, -16.6, 56.0),
    ("EPSG:32635", 25.3, 69.4, 24.0),
    ("EPSG:32718", -75.2, -12.0, 30.0),
    ("EPSG:3035", 9.8, 51.6, 45.0),
)
#: The planners by the last digit of a seed.
PLANNERS = (
    "astar", "fpa-2opt", "ga-pc", "astar", "ga-dp",
    "ga-fpga", "astar", "ga-chip", "astar", "ga-auv",
)  # fmt: skip


@cache
def transformer(source, target):
    """Return PROJ's transformer of longitude first, made once: that takes a while."""
    return Transformer.from_crs(source, target, always_xy=True)


@dataclass(frozen=True, eq=False)
class Site:
    """A map: heights at the nodes of a reference system, row 0 the southernmost."""

    crs: str
    lon: float
    lat: float
    geoid_m: float
    heights: np.ndarray

    @cached_property
    def south_west(self):
        """The first node in the reference system."""
        to = transformer(4326, self.crs)
        east, north = to.transform(self.lon, self.lat)
        half = CELL * (NODES - 1) / 2
        return round(east) - half, round(north) - half

    def degrees(self, points):
        """Return points (n, 2) from the first node, in units of the system, in degrees."""
        to = transformer(self.crs, 4326)
        lon, lat = to.transform(*(np.asarray(points) + self.south_west).T)
        turned = (np.asarray(lon) - self.lon + 180) % 360 - 180
        return np.column_stack((self.lon + turned, lat))

    def ground(self, points):
        """Return bilinear heights under points (n, 2) from the first node."""
        across = np.clip(np.asarray(points) / CELL, 0, NODES - 1 - 1e-9)
        column, row = np.floor(across).astype(int).T
        east, north = (across - np.floor(across)).T
        h = self.heights
        low = (1 - east) * h[row, column] + east * h[row, column + 1]
        high = (1 - east) * h[row + 1, column] + east * h[row + 1, column + 1]
        return (1 - north) * low + north * high

    def write(self, file):
        """Write a GeoTIFF."""
        west, south = self.south_west
        place = Affine(CELL, 0, west - CELL / 2, 0, -CELL, south + CELL * (NODES - 0.5))
        with rasterio.open(
            file, "w", driver="GTiff", width=NODES, height=NODES, count=1, dtype="float64",
            crs=self.crs, transform=place,
        ) as raster:  # fmt: skip
            raster.write(self.heights[::-1], 1)


@dataclass(frozen=True)
class Height:
    """A limit: a value in ``m``, ``ft`` or ``FL`` over AMSL, AGL, WGS84 or STD."""

    value: float
    unit: str
    surface: str

    @property
    def metres(self):
        return self.value * {"m": 1.0, "ft": FOOT_M, "FL": 100 * FOOT_M}[self.unit]


@dataclass(frozen=True)
class Hours:
    """A time of activity: moments, days of the week, and bounds of a day at an offset from UTC.

    A bound is ``HH:MM`` or an event of the sun: SR, SS, BMCT or EECT.
    """

    start: datetime | None = None
    end: datetime | None = None
    days: tuple[int, ...] = ()
    first: str | None = None
    last: str | None = None
    offset_h: int = 0


@dataclass(frozen=True)
class Area:
    """A zone.

    ``rings`` are in degrees without a closing corner, longitudes continue beyond 180;
    ``circle`` is longitude, latitude, radius in metres; ``sector`` adds two bearings, clockwise.
    """

    name: str
    rings: tuple = ()
    circle: tuple | None = None
    sector: tuple | None = None
    lower: Height | None = None
    upper: Height | None = None
    hours: tuple[Hours, ...] = ()
    seconds: tuple = (None, None)
    word: str = ""
    category: str = ""
    forbids: bool = True
    keeps_in: bool = False

    @property
    def is_timed(self):
        return bool(self.hours) or self.seconds != (None, None)


@dataclass(frozen=True)
class Scene:
    """A file of zones over a map, with the choices of a flight."""

    seed: int
    kind: str
    site: Site
    areas: tuple[Area, ...]
    start: tuple[float, float]
    goal: tuple[float, float]
    departure: datetime | None = None
    qnh_hpa: float | None = None
    margin_m: float = 25.0
    wind: tuple[float, float] = (0.0, 0.0)
    forbid: str | None = None
    swapped: str = ""
    planner: str = field(default="astar")

    @property
    def ability(self):
        return ABILITIES[self.kind]

    def having(self, areas):
        return replace(self, areas=tuple(areas))


def scene(seed):
    """Return the scene of a seed; the seeds take turns in formats and planners."""
    rng = random.Random(f"scene {seed}")
    kind = list(ABILITIES)[seed % len(ABILITIES)]
    ability = ABILITIES[kind]
    site = _site(rng)
    qnh_hpa = rng.choice((None, None, 985.0, 1013.25, 1030.0))
    event = rng.choice(("SR", "SS", "BMCT", "EECT"))
    departure = _departure(rng, site, event)
    ends = [tuple(rng.uniform(*box) for _ in "xy") for box in ((200, 900), (3100, 3800))]
    rng.shuffle(ends)
    forbid = rng.choice((None, None, None, "all", "default,E", "PROHIBITED,RESTRICTED,default"))
    drawing = _Drawing(rng, site, ability, departure, qnh_hpa, event, forbid)
    count = rng.randint(2, 6) if ability.many else 1
    areas = tuple(drawing.area(f"Z{number}") for number in range(count))
    is_known = ability.hours and rng.random() < 0.85
    found = Scene(
        seed, kind, site, areas, *ends, departure if is_known else None, qnh_hpa,
        rng.choice((25.0, 25.0, 25.0, 0.0, 10.0, 60.0)),
        rng.choice(((0.0, 0.0), (0.0, 0.0), (6.0, -3.0), (-4.0, 5.0))),
        forbid if ability.classes else None,
        planner=PLANNERS[seed % len(PLANNERS)],
    )  # fmt: skip
    if ability.many and rng.random() < 0.05:
        found = replace(found, swapped=rng.choice([area.name for area in areas]))
    return found


def _site(rng):
    crs, lon, lat, geoid_m = rng.choice(PLACES)
    x, y = np.meshgrid(np.arange(NODES) * CELL, np.arange(NODES) * CELL)
    east, north = rng.uniform(-0.02, 0.02), rng.uniform(-0.02, 0.02)
    waves = [rng.uniform(0, 2 * math.pi) for _ in range(2)]
    relief = rng.choice((5.0, 25.0, 50.0))
    heights = 320.0 + east * (x - 2000) + north * (y - 2000) + relief * (
        np.sin(x / 620 + waves[0]) + np.cos(y / 540 + waves[1])
    )  # fmt: skip
    return Site(crs, lon, lat, geoid_m, heights)


def _departure(rng, site, event):
    """Return a moment: next to midnight or an event of the sun, or any."""
    day = datetime(2026, rng.randint(1, 12), rng.randint(1, 28), tzinfo=UTC)
    kind = rng.choice(("any", "midnight", "sun", "sun"))
    if kind == "midnight":
        moment = day - timedelta(seconds=rng.uniform(20, 180))
    elif kind == "sun" and abs(site.lat) < 65:
        moment = sun.moment(day, site.lon, site.lat, event)
        moment += timedelta(minutes=rng.uniform(-13, 12))
    else:
        moment = day + timedelta(seconds=rng.uniform(0, 86_400))
    zone = timezone(timedelta(hours=rng.choice((0, 0, 2, -5, 11))))
    return moment.replace(microsecond=0).astimezone(zone)


@dataclass
class _Drawing:
    """Draws zones that a format can state."""

    rng: random.Random
    site: Site
    ability: object
    departure: datetime
    qnh_hpa: float | None
    event: str
    forbid: str | None

    def area(self, name):
        rng, ability = self.rng, self.ability
        keeps_in = ability.keeps_in and (not ability.keeps_out or rng.random() < 0.3)
        word, category, forbids = rng.choice(ability.classes) if ability.classes else ("", "", True)
        shape = self._shape(keeps_in)
        limits = (None, None)
        if ability.limits and not (keeps_in and not ability.limits_inside):
            limits = self._limits(shape)
        hours, seconds = (), (None, None)
        if ability.hours and rng.random() < 0.55:
            hours = self._hours()
        if ability.seconds and rng.random() < 0.45:
            seconds = self._seconds()
        title = name + rng.choice(("", " Zürich", " Área 51", ' "R", quoted', " & <b>"))
        return Area(
            title, **shape, lower=limits[0], upper=limits[1], hours=hours, seconds=seconds,
            word=word, category=category, forbids=self._forbids(category, forbids),
            keeps_in=keeps_in,
        )  # fmt: skip

    def _forbids(self, category, by_default):
        if self.forbid is None or not category:
            return by_default
        chosen = self.forbid.split(",")
        return "all" in chosen or category in chosen or ("default" in chosen and by_default)

    # --- Shapes ----------------------------------------------------------------------------------

    def _shape(self, keeps_in):
        rng, ability = self.rng, self.ability
        x, y = rng.uniform(500, 3500), rng.uniform(500, 3500)
        size = rng.uniform(150, 900)
        if keeps_in:
            x, y, size = rng.uniform(1500, 2500), rng.uniform(1500, 2500), rng.uniform(2300, 4000)
        lon, lat = self.site.degrees([(x, y)])[0].round(7).tolist()
        kind = rng.random()
        if ability.circles and kind < 0.35:
            return {"circle": (lon, lat, round(size, 1))}
        if ability.sectors and kind < 0.6:
            first = rng.randrange(360)
            return {"sector": (lon, lat, round(size, 1), first, first + rng.randrange(60, 300))}
        if ability.far and kind > 0.93 and not keeps_in:
            return {"rings": (self._wide(x, y),)}
        corners = self._star(x, y, size, rng.randint(4, 9))
        rings = [corners]
        if ability.holes and rng.random() < 0.45:
            # A hole in the middle of a large ring, so that a path fits through.
            corners = self._star(x, y, size * 1.6, 8, spread=0.2)
            middle = np.array((x, y))
            rings = [corners, (np.array(corners) - middle) * rng.uniform(0.4, 0.7) + middle]
        return {"rings": tuple(self._turned(self.site.degrees(ring)) for ring in rings)}

    def _star(self, x, y, size, corners, spread=0.8):
        rng = self.rng
        angles = [2 * math.pi * (k + rng.uniform(0, spread)) / corners for k in range(corners)]
        reach = [size * rng.uniform(1 - spread / 2, 1) for _ in range(corners)]
        return [
            (x + r * math.cos(a), y + r * math.sin(a)) for r, a in zip(reach, angles, strict=True)
        ]

    def _wide(self, x, y):
        """Return a strip of some degrees, whose long edges bend across the map."""
        rng = self.rng
        lon, lat = self.site.degrees([(x, y)])[0]
        wide, high = rng.uniform(0.5, 2.5), rng.uniform(0.001, 0.006)
        tilt = rng.uniform(-0.01, 0.01)
        west, east = lon - wide, lon + wide
        ring = (
            (west, -high - tilt),
            (east, -high + tilt),
            (east, high + tilt),
            (west, high - tilt),
        )
        return self._turned(np.array([(x, lat + y) for x, y in ring]))

    def _turned(self, ring):
        """Return a ring from any corner in either direction."""
        first = self.rng.randrange(len(ring))
        rolled = np.roll(ring, first, axis=0)[:: self.rng.choice((1, -1))]
        return tuple(map(tuple, rolled.round(7).tolist()))

    # --- Heights ---------------------------------------------------------------------------------

    def _limits(self, shape):
        """Return lower and upper limit; each may be None."""
        rng, ability = self.rng, self.ability
        place = shape.get("circle") or shape.get("sector")
        lon, lat = place[:2] if place else np.mean(shape["rings"][0], axis=0)
        to = transformer(4326, self.site.crs)
        x, y = np.array(to.transform(lon, lat)) - self.site.south_west
        ground = float(self.site.ground([(x, y)])[0])
        kind = rng.choice(("none", "high", "low", "band", "sky", "ground"))
        low, high = {
            "none": (None, None),
            "high": (ground + rng.uniform(90, 350), ground + 2000),
            "low": (None, ground + rng.uniform(20, 150)),
            "band": (ground + rng.uniform(60, 150), ground + rng.uniform(300, 600)),
            "sky": (ground + rng.uniform(90, 300), None),
            "ground": (ground, ground + rng.uniform(60, 300)),
        }[kind]
        if "circle" in shape and ability.circle_limits:
            pairs = ability.circle_limits
        else:
            pairs = ability.limits
        one = rng.choice(pairs)
        other = one if ability.one_surface else rng.choice(pairs)
        if ability.one_unit:
            other = rng.choice([pair for pair in pairs if pair[1] == one[1]])
            if ability.one_surface:
                other = one
        if ability.upper_alone and high is None:
            low = None
        return (
            None if low is None else self._height(low, ground, *one),
            None if high is None else self._height(high, ground, *other),
        )

    def _height(self, target_m, ground_m, surface, unit):
        """Return a limit at an altitude, rounded as people do."""
        base_m = {"AMSL": 0.0, "AGL": ground_m, "WGS84": -self.site.geoid_m}
        if surface == "STD":
            base_m["STD"] = shift_m(self.qnh_hpa or 1013.25)
        value = target_m - base_m[surface]
        size = {"m": 1.0, "ft": FOOT_M, "FL": 100 * FOOT_M}[unit]
        rounded = round(value / size, 1 if unit == "m" else 0)
        return Height(float(max(rounded, 0.0)), unit, surface)

    # --- Times -----------------------------------------------------------------------------------

    def _hours(self):
        """Return periods, most of which begin or end during the flight."""
        rng, ability = self.rng, self.ability
        begin = self.departure.astimezone(UTC)
        near, later = begin + timedelta(seconds=rng.uniform(15, 190)), timedelta(hours=3)
        near = near.replace(second=0) if ability.hours == "moments" else near
        near = near.replace(microsecond=0)
        kinds = ["past", "coming", "begins", "ends", "window"]
        if ability.hours in ("schedule", "sun"):
            kinds += ["clock begins", "clock ends", "weekday", "weekday"]
        if ability.hours == "sun" and abs(self.site.lat) < 65:
            kinds += ["sun"] * 4
        kind = rng.choice(kinds)
        if kind == "sun":
            pairs = [("SR", "SS"), ("BMCT", "EECT")]
            pairs += [(last, first) for first, last in pairs] if ability.nights else []
            pairs = [pair for pair in pairs if self.event in pair and set(pair) <= ability.events]
            if pairs:
                first, last = rng.choice(pairs)
                return (Hours(first=first, last=last),)
            kind = "clock begins"
        if kind.startswith("clock") or kind == "weekday":
            return (self._clock(kind, begin),)
        spans = {
            "past": (begin - later, begin - timedelta(minutes=2)),
            "coming": (begin + timedelta(minutes=rng.uniform(12, 3000)), None),
            "begins": (near, begin + later),
            "ends": (begin - later, near),
            "window": (near, near + timedelta(seconds=60)),
        }
        start, end = spans[kind]
        if start is not None:
            start = start.replace(microsecond=0)
        if ability.hours == "moments" and kind != "window":
            start, end = (each and each.replace(second=0) for each in (start, end))
        if ability.both_moments and end is None:
            end = start + timedelta(days=2)
        found = [Hours(start, end)]
        if rng.random() < 0.3 and not ability.one_period:
            # A second period that changes nothing.
            found.append(Hours(begin - timedelta(days=9), begin - timedelta(days=8)))
        rng.shuffle(found)
        return tuple(found)

    def _clock(self, kind, begin):
        """Return a period of a time of day; it may begin on the day before, in its own zone."""
        rng, ability = self.rng, self.ability
        offset_h = rng.choice((0, 0, 2, -7)) if ability.offsets else 0
        local = begin + timedelta(hours=offset_h)
        minute = (local + timedelta(seconds=rng.uniform(30, 190))).replace(second=0)
        bound = f"{minute:%H:%M}"
        if kind == "weekday":
            days = rng.choice(((local.weekday(),), ((local.weekday() + 1) % 7,), (0, 2, 4)))
            if rng.random() < 0.5 and offset_h == 0:
                return Hours(days=tuple(sorted(days)), first="00:00", last="24:00")
            first, last = f"{local - timedelta(hours=2):%H:%M}", bound
            return Hours(days=tuple(sorted(days)), first=first, last=last, offset_h=offset_h)
        if kind == "clock begins":
            return Hours(
                first=bound, last=f"{minute + timedelta(hours=5):%H:%M}", offset_h=offset_h
            )
        return Hours(first=f"{minute - timedelta(hours=5):%H:%M}", last=bound, offset_h=offset_h)

    def _seconds(self):
        rng = self.rng
        t0, t1 = round(rng.uniform(0, 120), 1), round(rng.uniform(125, 300), 1)
        return rng.choice(((t0, None), (None, t1), (t0, t1), (None, t0 + 5.0), (9000.0, None)))


def shift_m(qnh_hpa):
    """Return the altitude of the standard pressure at sea level, by the standard atmosphere."""
    exponent = 287.05287 * 0.0065 / 9.80665
    return 288.15 / 0.0065 * ((qnh_hpa / 1013.25) ** exponent - 1.0)
