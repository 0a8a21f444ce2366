"""A judge of paths among the zones of a scene, which shares no code with the readers.

Shapes are Shapely's in a plane of PROJ, heights come from the scene's own grid, times from plain
arithmetic. For each zone the judge says whether a path is surely inside and whether it may be: the
documents allow a zone to be larger than its file says, by tiles over steep ground, by unknown
pressures and geoids, and by minutes around sunrise, but never smaller.
"""

from datetime import UTC, datetime, timedelta, timezone
from functools import cached_property

import numpy as np
import pyproj
import shapely
from scipy.ndimage import maximum_filter, minimum_filter

from tests.support.host import sun
from tests.support.host.zone_scenes import CELL, NODES, shift_m, transformer


#: Documented tolerance of edges, metres, and our own of a millimetre.
EDGE_M, OWN_M = 0.5, 0.001
STEP_M = 2.0
_EARTH = pyproj.Geod(ellps="WGS84")
#: Metres by which a zone may be larger, besides tiles: samples, polygons around circles.
_LARGER_M = 1.5
#: Pressures, heights of the geoid, and uncertainty of the scene's own geoid.
_PRESSURES_HPA = (950.0, 1050.0)
_GEOID_M = (-107.0, 86.0)
_GEOID_ERROR_M = 15.0
#: Tiles of a zone and of a file, and the ground that counts as level.
_TILES, _ALL_TILES, _LEVEL_M = 128, 512, 10.0
#: Seconds of doubt about a moment, and about an event of the sun: surely and perhaps. In wind, the
#: product takes the slope over the ground for the slope through the air, and times an arc by its
#: eighths.
_MOMENT_S, _SHARE_IN_WIND, _ARC_S, _SUN_S, _SUN_MARGIN_S = 0.5, 0.015, 6.0, 120.0, 480.0


class Judge:
    """Judges paths of a scene.

    Parameters
    ----------
    scene : Scene
        The zones.
    unit_m : float
        Metres of the paths for a unit of the site's reference system.
    speed_m_s : float
        Speed through the air.
    """

    def __init__(self, scene, unit_m, speed_m_s):
        self.scene, self._unit_m, self._speed_m_s = scene, unit_m, speed_m_s
        site = scene.site
        plane = f"+proj=tmerc +lat_0={site.lat} +lon_0={site.lon} +ellps=WGS84 +units=m"
        self._to_plane = transformer(4326, plane)
        self._from_site = transformer(site.crs, plane)
        self._shapes = [self._shape(area) for area in scene.areas]
        followed = sum(self._follows(area) for area in scene.areas if area.forbids)
        self._tiles = min(_ALL_TILES // max(followed, 1), _TILES)

    def judge(self, x, y, z):
        """Return the names of zones that a track is surely in, and of those that it may be in.

        ``x``, ``y`` and ``z`` are arrays of samples, metres from the site's first node.
        """
        flight = _Flight(self, np.asarray(x), np.asarray(y), np.asarray(z))
        surely, perhaps = set(), set()
        for area, shape in zip(self.scene.areas, self._shapes, strict=True):
            if area.forbids and not shape.is_empty:
                sure, may = self._inside(area, shape, flight)
                surely |= {area.name} if sure else set()
                perhaps |= {area.name} if may else set()
            elif area.forbids and area.keeps_in:
                surely.add(area.name)
                perhaps.add(area.name)
        return surely, perhaps

    # --- Shapes ----------------------------------------------------------------------------------

    def _shape(self, area):
        """Return the area in the plane, cut to some kilometres around the map."""
        site = self.scene.site
        if area.circle:
            lon, lat, radius_m = area.circle
            bearings = np.arange(0.0, 360.0, 1.0)
            return self._planar(shapely.Polygon(_arc(lon, lat, radius_m, bearings)))
        if area.sector:
            lon, lat, radius_m, first, last = area.sector
            bearings = np.linspace(first, last, 1 + 2 * int(last - first))
            arc = _arc(lon, lat, radius_m, bearings)
            return self._planar(shapely.Polygon([*arc, (lon, lat)]))
        rings = [np.array(ring) for ring in area.rings]
        polygon = shapely.Polygon(rings[0], rings[1:])
        wide = 0.15 / np.cos(np.radians(site.lat))
        around = shapely.box(site.lon - wide, site.lat - 0.15, site.lon + wide, site.lat + 0.15)
        return self._planar(shapely.segmentize(polygon & around, 0.001))

    def _planar(self, polygon):
        """Return a polygon of degrees in the plane."""

        def moved(degrees):
            return np.column_stack(self._to_plane.transform(*degrees.T))

        found = shapely.transform(polygon, moved)
        shapely.prepare(found)
        return found

    def places(self, x, y):
        """Return points of a path in the site's units, and in the plane."""
        own = np.column_stack((x, y)) / self._unit_m
        plane = self._from_site.transform(*(own + self.scene.site.south_west).T)
        return own, np.column_stack(plane)

    # --- Inside ----------------------------------------------------------------------------------

    def _inside(self, area, shape, flight):
        margin_m = self.scene.margin_m
        reach = margin_m + _LARGER_M + 3e-4 * np.sqrt(shape.area)
        near = np.arange(len(flight.plane))
        if not area.keeps_in:
            west, south, east, north = shape.bounds
            x, y = flight.plane.T
            near = np.flatnonzero(
                (x > west - reach) & (x < east + reach) & (y > south - reach) & (y < north + reach)
            )
        if not len(near):
            return False, False
        points = shapely.points(flight.plane[near])
        away = shapely.distance(shape, points)
        within = np.flatnonzero(away == 0)
        away[within] = -shapely.distance(shape.boundary, points[within])
        if area.keeps_in:
            away = -away
        sure, may = away <= margin_m - EDGE_M - OWN_M, away <= reach
        near, sure, points = near[may], sure[may], points[may]
        if not len(near):
            return False, False
        z = flight.z[near]
        surely, perhaps = self._heights(area, shape, flight, near, points)
        sure &= (z > surely[0] - margin_m + EDGE_M) & (z < surely[1] + margin_m - EDGE_M)
        may = (z > perhaps[0] - margin_m - 1) & (z < perhaps[1] + margin_m + 1)
        surely, perhaps = self.active(area, flight.times[near])
        return bool((sure & surely).any()), bool((may & perhaps).any())

    def _follows(self, area):
        return any(each and each.surface == "AGL" for each in (area.lower, area.upper))

    def _heights(self, area, shape, flight, near, points):
        """Return lower and upper limits, surely and perhaps."""
        ground = lowest = highest = 0.0
        if self._follows(area):
            # Limits count from the ground under the zone, not under the margin.
            lines = shapely.shortest_line(shape, points)
            feet = shapely.get_coordinates(shapely.get_point(lines, 0))
            east, north = self._from_site.transform(*feet.T, direction="INVERSE")
            own = np.column_stack((east, north)) - self.scene.site.south_west
            ground = self.scene.site.ground(own)
            west, south, east, north = shape.bounds
            size = np.sqrt(min(east - west, 6000) * min(north - south, 6000) / self._tiles)
            nodes = int(np.ceil(2 * size / CELL + 1.5))
            column, row = np.clip(np.round(own / CELL), 0, NODES - 1).astype(int).T
            low, high = self._windows(nodes)
            lowest, highest = low[row, column] - _LEVEL_M, high[row, column] + _LEVEL_M
        surely, perhaps = [], []
        for limit, sign, extreme in ((area.lower, -1, lowest), (area.upper, 1, highest)):
            if limit is None or (sign < 0 and limit.surface == "AGL" and limit.value <= 0):
                surely.append(sign * np.inf)
                perhaps.append(sign * np.inf)
                continue
            sure, may = self._altitudes(limit, sign, ground, extreme)
            surely.append(sure)
            perhaps.append(may)
        return surely, perhaps

    def _windows(self, nodes):
        size = 2 * nodes + 1
        heights = self.scene.site.heights
        return minimum_filter(heights, size, mode="nearest"), maximum_filter(
            heights, size, mode="nearest"
        )

    def _altitudes(self, limit, sign, ground, extreme):
        """Return the altitude of a limit: so that the zone is surely, or perhaps, as large."""
        metres, site = limit.metres, self.scene.site
        if limit.surface == "AGL":
            return metres + ground, metres + extreme
        if limit.surface == "WGS84":
            own = metres - site.geoid_m - sign * _GEOID_ERROR_M
            return own, metres - (_GEOID_M[0] if sign > 0 else _GEOID_M[1])
        if limit.surface == "STD":
            pressure = self.scene.qnh_hpa or _PRESSURES_HPA[sign > 0]
            own = metres + shift_m(pressure)
            return own - sign * 2.0, own + sign * 2.0
        return metres, metres

    # --- Times -----------------------------------------------------------------------------------

    def active(self, area, times):
        """Return whether a zone is active at seconds after the start: surely, perhaps."""
        surely, perhaps = np.ones(len(times), dtype=bool), np.ones(len(times), dtype=bool)
        doubts = self._doubts(times)
        for bound, sign in zip(area.seconds, (1, -1), strict=True):
            if bound is not None:
                after = sign * (times - bound)
                surely &= after >= doubts[0]
                perhaps &= after >= -doubts[1]
        if area.hours and self.scene.departure is not None:
            found = [self._period(area, hours, times) for hours in area.hours]
            surely &= np.any([sure for sure, _ in found], axis=0)
            perhaps &= np.any([may for _, may in found], axis=0)
        return surely, perhaps

    def pauses(self, area, seconds):
        """Return whether a zone is surely not active at a time in the first seconds."""
        return not self.active(area, np.linspace(0.0, seconds, 1000))[1].all()

    def _doubts(self, times):
        """Return the seconds by which a zone is surely and perhaps active less or longer."""
        if not any(self.scene.wind):
            return _MOMENT_S, _MOMENT_S
        sure = _MOMENT_S + _SHARE_IN_WIND * times
        return sure, sure + _ARC_S

    def _period(self, area, hours, times):
        surely, perhaps = np.zeros(len(times), dtype=bool), np.zeros(len(times), dtype=bool)
        doubts = self._doubts(times)
        for first, last, (inner, outer) in self._spans(area, hours):
            surely |= (times >= first + doubts[0] + inner) & (times <= last - doubts[0] - inner)
            perhaps |= (times >= first - doubts[1] - outer) & (times <= last + doubts[1] + outer)
        for bound, sign in ((hours.start, 1), (hours.end, -1)):
            if bound is not None:
                after = sign * (times - self._seconds(bound))
                surely &= after >= doubts[0]
                perhaps &= after >= -doubts[1]
        return surely, perhaps

    def _seconds(self, moment):
        return (moment - self.scene.departure).total_seconds()

    def _spans(self, area, hours):
        """Yield first and last second of the days around the flight, with doubts."""
        if hours.first is None:
            yield -np.inf, np.inf, (0.0, 0.0)
            return
        zone = timezone(timedelta(hours=hours.offset_h))
        today = self.scene.departure.astimezone(zone).date()
        for shift in range(-3, 4):
            day = today + timedelta(days=shift)
            if hours.days and day.weekday() not in hours.days:
                continue
            first, last = (self._bound(day, each, zone) for each in (hours.first, hours.last))
            if last <= first:
                last = self._bound(day + timedelta(days=1), hours.last, zone)
            is_sun = ":" not in hours.first
            doubts = (_SUN_S, _SUN_MARGIN_S + self._wide_s(area)) if is_sun else (0.0, 0.0)
            yield self._seconds(first), self._seconds(last), doubts

    def _wide_s(self, area):
        """Return the seconds from sunrise at the map to sunrise at the ends of a wide zone."""
        corners = [lon for ring in area.rings for lon, _ in ring]
        return 300.0 * max((abs(lon - self.scene.site.lon) for lon in corners), default=0.0)

    def _bound(self, day, text, zone):
        if ":" not in text:
            return sun.moment(day, self.scene.site.lon, self.scene.site.lat, text)
        hour, minute = map(int, text.split(":"))
        midnight = datetime(day.year, day.month, day.day, tzinfo=zone)
        return (midnight + timedelta(hours=hour, minutes=minute)).astimezone(UTC)


class _Flight:
    """Samples of a track in the plane, with altitudes and seconds after the start."""

    def __init__(self, judge, x, y, z):
        _, self.plane = judge.places(x, y)
        self.z = z
        self._wind, self._speed_m_s = judge.scene.wind, judge._speed_m_s

    @cached_property
    def times(self):
        steps = np.diff(np.column_stack((self.plane, self.z)), axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        nothing = np.zeros((2, len(steps)))
        east, north = np.divide(steps[:, :2].T, lengths, where=lengths > 0, out=nothing)
        along = east * self._wind[0] + north * self._wind[1]
        square = self._speed_m_s**2 - np.dot(self._wind, self._wind)
        over_ground = along + np.sqrt(along**2 + square)
        return np.concatenate(([0.0], np.cumsum(lengths / over_ground)))


def _arc(lon, lat, radius_m, bearings):
    """Return points at bearings around a centre, their longitudes next to the centre's."""
    count = len(bearings)
    east, north, _ = _EARTH.fwd(
        np.full(count, lon), np.full(count, lat), bearings, np.full(count, radius_m)
    )
    return list(zip(lon + (east - lon + 180) % 360 - 180, north, strict=True))
