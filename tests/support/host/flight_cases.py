"""Random problems and paths under the rules of safe flight, most of them near a limit."""

import dataclasses
import math

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.terrain import Terrain
from tests.support.host.flight_oracle import examine, surface
from tests.support.host.random_flights import near_a_limit, random_zones


MOST_NODES = 32
_FOX = aircraft.load("silver-fox")


def random_terrain(rng):
    """Return land of 4 to 32 nodes per side: noise, slopes, cliffs, steps, valleys; some voids."""
    rows, columns = rng.integers(4, MOST_NODES + 1, 2)
    dx = round(10 ** rng.uniform(math.log10(5), 2), 2)
    dy = dx if rng.random() < 0.7 else round(10 ** rng.uniform(math.log10(5), 2), 2)
    east, north = np.meshgrid(np.arange(columns), np.arange(rows))
    rough = 10 ** rng.uniform(-1, 1.8)
    kind = rng.integers(6)
    if kind == 0:
        land = rng.uniform(0, rough, (rows, columns))
    elif kind == 1:
        land = east * rng.uniform(-0.5, 0.5) * dx + north * rng.uniform(-0.5, 0.5) * dy
    elif kind == 2:
        land = np.where(east * rng.uniform(-1, 1) + north > rows * rng.uniform(0, 1), rough, 0.0)
    elif kind == 3:
        land = rough * (np.sin(east * rng.uniform(0.1, 1)) + np.cos(north * rng.uniform(0.1, 1)))
    elif kind == 4:
        land = rough * np.abs(east - columns * rng.random()) ** rng.uniform(0.5, 1.5)
    else:
        land = np.zeros((rows, columns))
        land[rng.integers(rows, size=3), rng.integers(columns, size=3)] = rough
    land = land - land.min() + 10
    if rng.random() < 0.3:
        land = np.round(land)
    if rng.random() < 0.08:
        land[rng.integers(rows), rng.integers(columns)] = np.nan
    return Terrain(name="random", elevation=land, dx_m=dx, dy_m=dy, crs=None, origin=(0.0, 0.0))


def _random_rules(rng, cell_m):
    return Rules(
        clearance_m=float(rng.choice([0, 5, 30, rng.uniform(0, 60)])),
        corridor_m=float(rng.choice([0, 25, cell_m, rng.uniform(0, 40)])),
        zone_margin_m=float(rng.choice([0, 25, rng.uniform(0, 40)])),
        reserve=float(rng.choice([0, 0.1])),
    )


def _random_aircraft(rng):
    return dataclasses.replace(
        _FOX,
        turn_radius_m=float(10 ** rng.uniform(0.7, 1.8)),
        lift_coefficient_max=None if rng.random() < 0.9 else 3.0,
        engine_power_W=None if rng.random() < 0.5 else 1850.0,
        max_climb_deg=float(rng.uniform(5, 60)),
        max_descent_deg=float(rng.uniform(5, 60)),
    )


def _random_path(rng, terrain):
    """Return a path of 2 to 6 points, some at nodes or halfway between them."""
    count = 2 + int(4 * rng.random() ** 2)
    size = terrain.width_m, terrain.height_m
    path = np.zeros((count, 3))
    path[:, :2] = rng.uniform((0, 0), size, (count, 2))
    snap = rng.random()
    if snap < 0.3:
        half = np.array((terrain.dx_m, terrain.dy_m)) / (1 if snap < 0.15 else 2)
        path[:, :2] = np.clip(np.round(path[:, :2] / half) * half, 0, size)
    elif rng.random() < 0.8:
        # A gentle path, whose turns fit.
        along = np.linspace(0, 1, count)[:, None]
        path[:, :2] = path[0, :2] + along * (path[-1, :2] - path[0, :2])
        path[1:-1, :2] += rng.normal(0, 0.05 * min(size), (count - 2, 2))
        path[:, :2] = np.clip(path[:, :2], 0, size)
    ground = surface(terrain, path[:, 0], path[:, 1])
    ground = np.where(np.isfinite(ground), ground, 10.0)
    kind = rng.integers(3)
    path[:, 2] = (
        ground.max() if kind == 0 else ground + rng.uniform(0, 60, count) if kind == 1 else ground
    )
    path[:, 2] += rng.uniform(0, 60)
    return path


def random_case(rng):
    """Return a problem and a path, usually within a metre of its worst limit.

    The paths of about a third of the problems keep all limits.
    """
    while True:
        terrain = random_terrain(rng)
        cell_m = min(terrain.dx_m, terrain.dy_m)
        options = {
            "aircraft": _random_aircraft(rng),
            "rules": _random_rules(rng, cell_m),
            "zones": (),
        }
        if rng.random() < 0.5:
            angle, strength = rng.uniform(0, 2 * math.pi), rng.uniform(0, 15)
            options["wind"] = strength * math.cos(angle), strength * math.sin(angle)
        path = _random_path(rng, terrain)
        zones = random_zones(rng, terrain.width_m, terrain.height_m, 3)
        if rng.random() < 0.25:
            for end in ("start", "goal"):
                if rng.random() < 0.6:
                    options[f"{end}_heading_deg"] = float(rng.uniform(0, 360))
        if rng.random() < 0.5:
            options["zones"] = zones
        try:
            return _near(rng, terrain, path, options)
        except InputError:
            # An end off the map, in the ground or in a zone, or a route without cost: try the next
            # case.
            continue


def _near(rng, terrain, path, options):
    """Return the case moved to a limit chosen by chance."""
    rules, plane = options["rules"], options["aircraft"]
    lifted = path + np.array((0, 0, 2000.0))

    def problem(path, **changes):
        return Problem(terrain, path[0], path[-1], **{**options, **changes})

    def findings(path, **changes):
        return examine(problem(path, **changes), path)

    kind = rng.integers(8)
    aim = rng.uniform(-1, 1)
    if kind <= 3:
        # Moving a path up or down changes its excess by the same amount, except for the ramps at
        # its ends.
        free = {"zones": ()}
        bottom = 2000.0
        for _ in range(3):
            ground = np.nanmin(terrain.elevation)
            if (lifted[[0, -1], 2] < ground).any():
                break
            excess = _height_excess(problem(lifted, **free), lifted)
            if not math.isfinite(excess):
                break
            bottom = excess
            lifted = lifted + np.array((0, 0, excess - aim))
        if math.isfinite(bottom) and bottom < 1999:
            path = lifted
    elif kind == 4 and options["zones"]:
        zone = options["zones"][rng.integers(len(options["zones"]))]
        path = path + np.array((0, 0, 200.0 * rng.integers(2)))
        radius = problem(path, zones=()).limits.turn_radius_m
        if math.isfinite(radius):
            path = near_a_limit(rng, path, zone, rules.zone_margin_m, radius)
    elif kind == 5:
        path = path + np.array((0, 0, 100.0))
        heights = path[:, 2].max() + aim
        options["rules"] = dataclasses.replace(rules, ceiling_m=float(heights))
    elif kind == 6:
        path = path + np.array((0, 0, 100.0))
        # The excess over a certainly broken ceiling gives the height.
        found = findings(path, rules=dataclasses.replace(rules, ceiling_agl_m=61.0), zones=())
        height = found.metres["ceiling-agl"] + 61.0 + aim
        if height > rules.clearance_m:
            options["rules"] = dataclasses.replace(rules, ceiling_agl_m=float(height))
    else:
        path = path + np.array((0, 0, 100.0))
        found = findings(path, zones=())
        limit = rng.choice(["climb", "descent", "fuel", "power"])
        factor = 1 + rng.uniform(-0.02, 0.02)
        options["aircraft"] = _limited(plane, limit, found, factor)
    return problem(path), path


def _height_excess(problem, path):
    """Return how much a path is too low, even far below the limit."""
    found = examine(problem, path)
    excess = found.metres["clearance"]
    if excess > -1.5:
        return excess
    top = np.nanmax(problem.terrain.elevation)
    return float(top + problem.rules.clearance_m - path[:, 2].min())


def _limited(plane, limit, found, factor):
    """Return the aircraft with a limit close to the findings."""
    if limit in ("climb", "descent"):
        degrees = getattr(plane, f"max_{limit}_deg")
        sine = math.sin(math.radians(degrees)) * (1 + found.shares[limit]) * factor
        if 0.01 < sine < 0.95:
            return dataclasses.replace(plane, **{f"max_{limit}_deg": math.degrees(math.asin(sine))})
    elif limit in found.shares and found.shares[limit] > -0.99:
        name = "engine_power_W" if limit == "power" else "fuel_weight_N"
        most = getattr(plane, name) * (1 + found.shares[limit]) * factor
        return dataclasses.replace(plane, **{name: most})
    return plane


def _at_south_edge(rng, width_m, corridor_m, radius_m):
    """Return points of a path along the south edge of a map, or away from it.

    Its corridor ends within a few metres of the edge, on the map or beyond it.
    """
    aim = float(rng.choice([0.0, rng.uniform(-0.01, 0.01), rng.uniform(-4, 8)]))
    rim = corridor_m + aim
    middle = rng.uniform(0.2, 0.8) * width_m
    far = rng.uniform(0.5, 3) * (corridor_m + 4 * radius_m)
    kind = rng.integers(5)
    if kind == 0:  # Along the edge, not always parallel to it.
        tilt = 0.0 if rng.random() < 0.5 else rng.uniform(-0.05, 0.05) * width_m
        return [(rng.uniform(0, 0.3) * width_m, rim), (rng.uniform(0.7, 1) * width_m, rim + tilt)]
    if kind == 1:  # Around the south-west corner.
        other = corridor_m + rng.uniform(-2, 6)
        return [(rim, far), (rim, other), (far, other)]
    if kind == 2:  # Towards the edge and back: the arc is nearest in its middle.
        angle = rng.uniform(0.2, 1.3)
        reach = radius_m * (1 / math.cos(angle) - 1)
        run = far * np.array((math.cos(angle), math.sin(angle)))
        return [
            (middle - run[0], rim - reach + run[1]),
            (middle, rim - reach),
            (middle + run[0], rim - reach + run[1]),
        ]
    # From an end that is nearer than the corridor, and perhaps in the corner.
    away = rng.uniform(0, 1) * corridor_m
    heading = math.acos(min(max(away - aim, 0.0) / max(corridor_m, 1e-9), 1.0))
    heading = 0.5 * math.pi - heading if rng.random() < 0.8 else rng.uniform(0.3, 2.8)
    begin = np.array((middle if kind == 3 else rng.uniform(0, 2) * corridor_m, away))
    return [begin, begin + far * np.array((math.cos(heading), math.sin(heading)))]


def random_edge_case(rng):
    """Return a problem and a path near an edge or a corner of the map, mostly far above ground."""
    while True:
        terrain = random_terrain(rng)
        rules = _random_rules(rng, min(terrain.dx_m, terrain.dy_m))
        plane = dataclasses.replace(
            _FOX, turn_radius_m=float(10 ** rng.uniform(0.5, 1.8)), lift_coefficient_max=None
        )
        turned, flipped_x, flipped_y = rng.random(3) < 0.5
        size = np.array((terrain.width_m, terrain.height_m))
        points = np.array(
            _at_south_edge(rng, size[int(turned)], rules.corridor_m, plane.turn_radius_m)
        )
        points = points[:, ::-1] if turned else points
        points = np.where((flipped_x, flipped_y), size - points, points)
        if rng.random() < 0.5:
            points = points[::-1]
        height = np.nanmax(terrain.elevation) + rng.choice([rules.clearance_m + 0.5, 150.0])
        path = np.column_stack((points, np.full(len(points), height)))
        options = {"rules": rules, "aircraft": plane}
        if rng.random() < 0.2:
            way = path[1] - path[0]
            heading = math.degrees(math.atan2(way[0], way[1])) + rng.uniform(-60, 60)
            options["start_heading_deg"] = heading % 360
        try:
            return Problem(terrain, path[0], path[-1], **options), path
        except InputError:
            continue
