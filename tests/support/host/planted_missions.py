"""Missions with one planted fault, and the same missions without it, above made-up ground.

The ground, the places and the files are made here, by numpy, PROJ and JSON: nothing is taken from
the code that judges them. A fault is planted by construction: a hill under a leg, a wall beside it,
a leg too steep, a fence across it.
"""

import json
from dataclasses import dataclass

import numpy as np
import pyproj


CRS = "EPSG:32632"
ORIGIN = 500_000.0, 5_200_000.0
NODES, CELL_M = 201, 30.0
GROUND_M, HEIGHT_M = 300.0, 420.0
# Figures of the default aircraft and of the default rules.
RADIUS_M, CLIMB, CLEARANCE_M = 150.0, np.tan(np.radians(10.0)), 30.0

WAYPOINT, LOITER_TURNS, RETURN, JUMP = 16, 18, 20, 177
AMSL, HOME = 0, 3

_TO_DEGREES = pyproj.Transformer.from_crs(CRS, "EPSG:4326", always_xy=True)


@dataclass
class Planted:
    """A mission as the texts of files, its ground, and the fault.

    Parameters
    ----------
    heights : ndarray
        Heights of the nodes, row 0 the southernmost.
    plan : str
        The mission as a ``.plan``.
    waypoints : str or None
        The mission as ``QGC WPL 110``; None for a mission that it cannot hold.
    limits : set of str
        Limits that the fault may break; empty without a fault.
    items : set of int
        Numbers of the items of the leg or point with the fault; None stands for home.
    """

    heights: np.ndarray
    plan: str
    waypoints: str | None
    limits: set
    items: set


class _Land:
    """A plain with small waves, hills and walls."""

    def __init__(self, rng):
        axis = np.arange(NODES) * CELL_M
        self.x, self.y = np.meshgrid(axis, axis)
        phase = rng.uniform(0, 6, 2)
        self.heights = GROUND_M + 4 * np.sin(self.x / 700 + phase[0]) * np.cos(
            self.y / 900 + phase[1]
        )

    def hill(self, x, y, top_m, reach_m):
        """Raise a hill with a flat top of a third of its reach."""
        away = np.hypot(self.x - x, self.y - y) / reach_m
        share = np.clip((1 - away) / (2 / 3), 0, 1)
        self.heights = np.maximum(self.heights, GROUND_M + (top_m - GROUND_M) * share)

    def wall(self, start, stop, beside_m, top_m):
        """Raise a wall along the middle of a leg, from a distance to its left."""
        (ax, ay), (bx, by) = start, stop
        run = np.hypot(bx - ax, by - ay)
        east, north = (bx - ax) / run, (by - ay) / run
        along = (self.x - ax) * east + (self.y - ay) * north
        aside = (self.y - ay) * east - (self.x - ax) * north
        inside = (abs(along - run / 2) < run / 5) & (aside >= beside_m) & (aside < beside_m + 90)
        self.heights = np.where(inside, top_m, self.heights)


def plant(kind, seed, *, faulty):
    """Return a mission of a kind, with its fault or without it."""
    rng = np.random.default_rng([seed, sorted(KINDS).index(kind)])
    return KINDS[kind](rng, faulty)


def _line(rng, legs=5):
    """Return points of a mission from west to east, with gentle turns."""
    x = 500 + np.arange(legs + 1) * 1000.0
    y = rng.uniform(1500, 4500) + rng.uniform(-250, 250, legs + 1)
    return np.column_stack((x, y, HEIGHT_M + rng.uniform(-8, 8, legs + 1)))


def _ridge(rng, faulty):
    land, points = _Land(rng), _line(rng)
    leg = int(rng.integers(0, len(points) - 1))
    share = rng.uniform(0.4, 0.6)
    x, y, z = points[leg] + share * (points[leg + 1] - points[leg])
    above = rng.uniform(-CLEARANCE_M + 5, 60) if faulty else rng.uniform(-90, -CLEARANCE_M - 6)
    land.hill(x, y, z + above, rng.uniform(150, 250))
    return _made(land, _items(points), {"clearance"}, {leg + 1, leg + 2}, faulty)


def _steep(rng, faulty):
    land, points = _Land(rng), _line(rng)
    leg = int(rng.integers(0, len(points) - 1))
    run = np.hypot(*(points[leg + 1] - points[leg])[:2])
    points[:, 2] = HEIGHT_M
    points[leg + 1 :, 2] += run * CLIMB * (rng.uniform(1.15, 2.0) if faulty else 0.85)
    return _made(land, _items(points), {"climb"}, {leg + 1, leg + 2}, faulty)


def _tight(rng, faulty):
    land, points = _Land(rng), _line(rng)
    at = int(rng.integers(1, len(points) - 2))
    here = points[at]
    side = rng.choice((-1, 1))
    # A corner of a right angle, and another one after a leg shorter than two radii.
    short = rng.uniform(0.4, 1.7) * RADIUS_M if faulty else rng.uniform(2.4, 3.0) * RADIUS_M
    points[at - 1 : at + 1, 1] = here[1]
    corner = here + np.array((0, side * short, 0))
    points[at + 1 :, 1] = corner[1]
    points = np.insert(points, at + 1, corner, axis=0)
    return _made(land, _items(points), {"turn"}, {at + 1, at + 2}, faulty)


def _circle(rng, faulty):
    land, points = _Land(rng), _line(rng)
    at = int(rng.integers(1, len(points) - 1))
    points[:, 1] = points[0, 1]
    radius = rng.uniform(RADIUS_M, 260)
    x, y, z = points[at]
    side = rng.choice((-1, 1))
    away = radius if faulty else radius + 180
    land.hill(x, y + side * away, z + rng.uniform(0, 60), 105)
    items = _items(points)
    items[at] |= {"command": LOITER_TURNS, "params": [2, 0, radius, 0]}
    return _made(land, items, {"clearance"}, {at + 1}, faulty)


def _home(rng, faulty):
    """One item has a height above home; the fault is a home in a pit."""
    land, points = _Land(rng), _line(rng)
    at = int(rng.integers(1, len(points) - 1))
    items = _items(points)
    items[at] |= {"frame": HOME, "alt": 120.0}
    home = (*points[0, :2], None)
    if faulty:
        pit = 5400.0, 5400.0 if points[0, 1] < 3000 else 600.0
        depth = rng.uniform(105, 150)
        land.heights -= depth * np.clip(2 - np.hypot(land.x - pit[0], land.y - pit[1]) / 200, 0, 1)
        home = (*pit, None)
    return _made(land, items, {"clearance"}, {at, at + 1, at + 2}, faulty, home=home)


def _fence(rng, faulty):
    land, points = _Land(rng), _line(rng)
    leg = int(rng.integers(0, len(points) - 1))
    a, b = points[leg, :2], points[leg + 1, :2]
    middle = a + rng.uniform(0.4, 0.6) * (b - a)
    left = np.array((a[1] - b[1], b[0] - a[0])) / np.hypot(*(b - a))
    radius = rng.uniform(60, 200)
    # Its rim reaches into the margin of 25 m, or stays out of it.
    middle = middle + left * rng.choice((-1, 1)) * (
        rng.uniform(0, radius + 15) if faulty else radius + rng.uniform(30, 90)
    )
    circles, polygons = [], []
    if rng.random() < 0.5:
        circles = [(middle, radius, False)]
    else:
        angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        ring = middle + radius * np.column_stack((np.cos(angles), np.sin(angles)))
        polygons = [(ring, False)]
    low, high = points[:, :2].min(axis=0) - 400, points[:, :2].max(axis=0) + 400
    polygons.append((np.array([low, (high[0], low[1]), high, (low[0], high[1])]), True))
    return _made(
        land, _items(points), {"zone"}, {leg + 1, leg + 2}, faulty, fences=(circles, polygons)
    )


_U = np.array([(800, 1200), (800, 2800), (1600, 4400), (3600, 4400), (4400, 2800)], float)


def _u_shape(rng):
    corners = _U + rng.uniform(-60, 60, 2)
    return np.column_stack((corners, np.full(len(corners), HEIGHT_M)))


def _return(rng, faulty):
    land, points = _Land(rng), _u_shape(rng)
    middle = (points[0] + points[-1]) / 2
    # The return is 100 m above home.
    top = GROUND_M + 100 + (rng.uniform(0, 80) if faulty else -CLEARANCE_M - rng.uniform(16, 50))
    land.hill(*middle[:2], top, rng.uniform(150, 300))
    items = [*_items(points), _item(RETURN, None)]
    home = (*points[0, :2], None)
    return _made(land, items, {"clearance"}, {len(points), None}, faulty, home=home)


def _jump(rng, faulty):
    land, points = _Land(rng), _u_shape(rng)
    middle = (points[1] + points[-1]) / 2
    top = HEIGHT_M + (rng.uniform(-20, 80) if faulty else rng.uniform(-90, -CLEARANCE_M - 6))
    land.hill(*middle[:2], top, rng.uniform(150, 300))
    last = points[-1] + np.array((0, -1700, 0))
    repeats = int(rng.integers(1, 6))
    items = [*_items(points), _item(JUMP, None, [2, repeats, 0, 0]), *_items([last])]
    return _made(land, items, {"clearance"}, {len(points), 2}, faulty)


def _survey(rng, faulty):
    """Four transects, the first item being a waypoint; the fault is a summit below one of them."""
    land = _Land(rng)
    x, y = rng.uniform(900, 1200), rng.uniform(1500, 1800)
    corners = []
    for transect in range(4):
        ends = [(x + 450 * transect, y), (x + 450 * transect, y + 1800)]
        corners += ends if transect % 2 == 0 else ends[::-1]
    points = np.column_stack((corners, np.full(8, HEIGHT_M)))
    transect = int(rng.integers(0, 4))
    middle = (points[2 * transect] + points[2 * transect + 1]) / 2
    above = rng.uniform(-20, 60) if faulty else rng.uniform(-80, -CLEARANCE_M - 6)
    land.hill(*middle[:2], HEIGHT_M + above, 200)
    approach = np.array([[x, y - 900, HEIGHT_M]])
    items = _items(np.vstack((approach, points)))
    first = 2 + 2 * transect
    return _made(land, items, {"clearance"}, {first, first + 1}, faulty, survey=slice(1, None))


def _corridor(rng, faulty):
    land, points = _Land(rng), _line(rng)
    leg = int(rng.integers(0, len(points) - 1))
    beside = rng.uniform(5, 24) if faulty else rng.uniform(60, 120)
    land.wall(points[leg, :2], points[leg + 1, :2], beside, HEIGHT_M + rng.uniform(20, 90))
    return _made(land, _items(points), {"clearance"}, {leg + 1, leg + 2}, faulty)


KINDS = {
    "ridge": _ridge,
    "climb": _steep,
    "turn": _tight,
    "loiter": _circle,
    "home": _home,
    "fence": _fence,
    "return": _return,
    "jump": _jump,
    "survey": _survey,
    "corridor": _corridor,
}


def _item(command, place, params=(0, 0, 0, 0), frame=AMSL):
    x, y, z = (None, None, 0.0) if place is None else map(float, place)
    return {"command": command, "x": x, "y": y, "alt": z, "params": list(params), "frame": frame}


def _items(points):
    return [_item(WAYPOINT, point) for point in points]


def degrees(x, y):
    """Return latitude and longitude of a place, by PROJ."""
    lon, lat = _TO_DEGREES.transform(ORIGIN[0] + x, ORIGIN[1] + y)
    return lat, lon


def _made(land, items, limits, numbers, faulty, *, home=None, fences=((), ()), survey=None):
    simple = [_simple(number, item) for number, item in enumerate(items, start=1)]
    listed = simple
    if survey is not None:
        inner = {"Items": simple[survey], "Refly90Degrees": False}
        listed = [
            *simple[: survey.start],
            {
                "type": "ComplexItem",
                "complexItemType": "survey",
                "version": 5,
                "TransectStyleComplexItem": inner,
            },
        ]
    place = None
    if home is not None:
        lat, lon = degrees(*home[:2])
        place = [lat, lon, home[2]]
    circles, polygons = fences
    document = {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "firmwareType": 3,
            "vehicleType": 1,
            "cruiseSpeed": 20,
            "hoverSpeed": 5,
            "globalPlanAltitudeMode": 0,
            "plannedHomePosition": place,
            "items": listed,
        },
        "geoFence": {
            "version": 2,
            "circles": [
                {
                    "version": 1,
                    "inclusion": inside,
                    "circle": {"center": list(degrees(*centre)), "radius": radius},
                }
                for centre, radius, inside in circles
            ],
            "polygons": [
                {
                    "version": 1,
                    "inclusion": inside,
                    "polygon": [list(degrees(*corner)) for corner in ring],
                }
                for ring, inside in polygons
            ],
        },
        "rallyPoints": {"version": 2, "points": []},
    }
    rows = None
    if survey is None and not (circles or polygons) and (home is None or home[2] is not None):
        rows = _rows(items)
    return Planted(
        land.heights,
        json.dumps(document),
        rows,
        limits if faulty else set(),
        numbers if faulty else set(),
    )


def _simple(number, item):
    lat, lon = (0, 0) if item["x"] is None else degrees(item["x"], item["y"])
    return {
        "type": "SimpleItem",
        "doJumpId": number,
        "command": item["command"],
        "frame": item["frame"],
        "params": [*item["params"], lat, lon, item["alt"]],
        "autoContinue": True,
    }


def _rows(items):
    lines = ["QGC WPL 110", "0\t1\t0\t16\t0\t0\t0\t0\t0\t0\t0\t1"]
    for number, item in enumerate(items, start=1):
        lat, lon = (0, 0) if item["x"] is None else degrees(item["x"], item["y"])
        words = [number, 0, item["frame"], item["command"], *item["params"], lat, lon, item["alt"]]
        lines.append("\t".join(map(repr, map(_plain, words))) + "\t1")
    return "\n".join(lines) + "\n"


def _plain(value):
    return value if isinstance(value, int) else float(value)
