"""Missions in files, flown by a simulated autopilot and judged by the ground that was planted.

The file is read by JSON alone, and the ground and the zones are judged by numpy and PROJ: nothing
here is taken from the code that checks and mends missions.
"""

import json
import math
from dataclasses import dataclass

import numpy as np
import pyproj

from pathgene.host.problem.aircraft import Aircraft
from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.items import DEGREES, MISSION, RALLY, Item
from pathgene.sim.autopilot.pilot import Kind
from pathgene.sim.autopilot_flight import (
    airframe_of,
    fly_items,
    parameters_of,
    px4_parameters_of,
)
from tests.support.host.planted_missions import CELL_M, CRS, ORIGIN, RETURN, WAYPOINT


_TO_CRS = pyproj.Transformer.from_crs("EPSG:4326", CRS, always_xy=True)
_WITHOUT_PLACE = {RETURN, 177, 178}


@dataclass
class Flight:
    """A flight of a mission.

    Parameters
    ----------
    arrived : bool
        The last item was reached.
    clearance_m : float
        Minimum height above the ground.
    zone_m : float
        Minimum distance outside the exclusion fences and inside the inclusion fences; infinite
        without fences.
    """

    arrived: bool
    clearance_m: float
    zone_m: float


def local(lat, lon):
    """Return places in metres of the planted ground."""
    east, north = _TO_CRS.transform(lon, lat)
    return np.asarray(east) - ORIGIN[0], np.asarray(north) - ORIGIN[1]


def ground_of(heights, x, y):
    """Return the heights between the nodes; NaN beyond the edge."""
    rows, columns = heights.shape
    across, up = np.asarray(x) / CELL_M, np.asarray(y) / CELL_M
    off = (across < 0) | (up < 0) | (across > columns - 1) | (up > rows - 1)
    i = np.clip(across.astype(int), 0, columns - 2)
    j = np.clip(up.astype(int), 0, rows - 2)
    east, north = across - i, up - j
    south = heights[j, i] * (1 - east) + heights[j, i + 1] * east
    beyond = heights[j + 1, i] * (1 - east) + heights[j + 1, i + 1] * east
    return np.where(off, np.nan, south * (1 - north) + beyond * north)


def items_of(document):
    """Return the items of a plan as the autopilot gets them, without home."""
    found = []
    for table in document["mission"]["items"]:
        for own in table.get("TransectStyleComplexItem", {"Items": [table]})["Items"]:
            *params, lat, lon, z = own["params"]
            params = tuple(math.nan if each is None else float(each) for each in params)
            place = round((lat or 0) * DEGREES), round((lon or 0) * DEGREES)
            found.append(Item(own["command"], own["frame"], params, *place, float(z or 0)))
    return found


def _parameters(kind, aircraft):
    """Return the parameters of an autopilot for missions that return 100 m above home."""
    if kind is Kind.ARDUPLANE:
        return parameters_of(aircraft)
    parameters = px4_parameters_of(aircraft)
    # These missions have neither a take-off nor a landing.
    parameters.update({"RTL_RETURN_ALT": 100.0, "MIS_TKO_LAND_REQ": 0.0})
    return parameters


def fly(text, heights, kind=Kind.ARDUPLANE):
    """Fly the mission of a plan from its first item by an autopilot."""
    document = json.loads(text)
    items = items_of(document)
    placed = [item for item in items if item.command not in _WITHOUT_PLACE]
    stated = document["mission"].get("plannedHomePosition")
    lat, lon = stated[:2] if stated else (placed[0].lat, placed[0].lon)
    home_m = float(ground_of(heights, *local(lat, lon)))
    east, north = (b - a for a, b in zip(*(local(p.lat, p.lon) for p in placed[:2]), strict=True))
    aircraft = Aircraft.load("silver-fox")
    first = placed[0]
    above_m = {0: -home_m, 3: 0.0, 10: 0.0}[first.frame]
    ground_m = float(ground_of(heights, *local(first.lat, first.lon)))
    above_m += ground_m - home_m if first.frame == 10 else 0.0
    away = np.subtract(local(first.lat, first.lon), local(lat, lon))
    autopilot = Autopilot(
        kind,
        Start(
            (lat, lon, home_m),
            (float(away[0]), float(away[1])),
            first.z + above_m,
            math.degrees(math.atan2(east, north)),
            armed=False,
        ),
        parameters=_parameters(kind, aircraft),
        airframe=airframe_of(aircraft),
        ground=lambda lat, lon: float(ground_of(heights, *local(lat, lon))),
    )
    home = Item(16, 0, (0.0,) * 4, round(lat * DEGREES), round(lon * DEGREES), home_m)
    autopilot.lists.items[MISSION] = [home, *items] if kind is Kind.ARDUPLANE else items
    autopilot.lists.items[RALLY] = []
    flown, arrived = fly_items(autopilot)
    plane = autopilot.earth.plane
    lats, lons = np.array([plane.degrees((x, y)) for x, y in flown.place.tolist()]).T
    x, y = local(lats, lons)
    altitude = flown.altitude_m
    if items[-1].command == WAYPOINT:
        # After the last item, an ArduPlane returns and a PX4 circles: no part of the mission.
        to_x, to_y = local(items[-1].lat, items[-1].lon)
        last = len(autopilot.lists.items[MISSION]) - 1
        away = np.where(flown.index == last, np.hypot(to_x - x, to_y - y), np.inf)
        flies = slice(0, int(np.argmin(away)) + 1)
        x, y, altitude = x[flies], y[flies], altitude[flies]
    clearance = altitude - ground_of(heights, x, y)
    return Flight(
        arrived,
        float(np.nan_to_num(clearance, nan=-1.0).min()),
        _room_m(document["geoFence"], x, y),
    )


def _room_m(fences, x, y):
    """Return the minimum distance of places from the forbidden sides of fences."""
    least = math.inf
    for circle in fences["circles"]:
        cx, cy = local(*circle["circle"]["center"])
        away = np.hypot(x - cx, y - cy) - circle["circle"]["radius"]
        least = min(least, float((-away if circle["inclusion"] else away).min()))
    for polygon in fences["polygons"]:
        corners = np.column_stack(local(*np.array(polygon["polygon"]).T))
        away = _outside_m(corners, x, y)
        least = min(least, float((-away if polygon["inclusion"] else away).min()))
    return least


def _outside_m(corners, x, y):
    """Return distances from a ring, negative inside."""
    inside = np.zeros(len(x), bool)
    nearest = np.full(len(x), np.inf)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        crosses = (ay > y) != (by > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= crosses & (x < ax + (y - ay) / (by - ay) * (bx - ax))
        share = np.clip(
            ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2), 0, 1
        )
        nearest = np.minimum(
            nearest, np.hypot(x - ax - share * (bx - ax), y - ay - share * (by - ay))
        )
    return np.where(inside, -nearest, nearest)
