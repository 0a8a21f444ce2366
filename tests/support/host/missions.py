"""Random missions over hills in both hemispheres."""

from functools import cache

import numpy as np

from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.hand_over import HandOver
from pathgene.host.mission.ending import Ending
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.origin import at_origin


# South-west corners in both hemispheres, one at the edge of its UTM zone.
PLACES = (
    ("EPSG:32632", (300_000.0, 5_200_000.0)),
    ("EPSG:32616", (732_656.4, 4_005_633.1)),
    ("EPSG:32733", (420_000.0, 6_200_000.0)),
    ("EPSG:2056", (2_600_000.0, 1_200_000.0)),
    (46.123456, 7.654321),
    (-33.5, 151.25),
)


# Seeds of the missions that tests have in common: those with room for a circle at the end.
_WITHOUT_ROOM = {2, 3, 11, 12, 19, 25, 29, 30, 32, 34, 35, 36, 38, 44, 53, 54, 58}
# Those with room for a straight return home.
_RETURNS = {41, 55}
SEEDS = tuple(seed for seed in range(60) if seed not in _WITHOUT_ROOM)


def random_zones(rng, width, height):
    """Return up to four zones: circles, polygons, holes, limits of height and time."""
    zones = []
    for number in range(rng.integers(0, 5)):
        limits = {"name": f"area {number}"} if rng.random() < 0.7 else {}
        if rng.random() < 0.4:
            lower = rng.uniform(100, 800)
            limits |= {"lower_m": lower} if rng.random() < 0.5 else {}
            limits |= {"upper_m": lower + rng.uniform(50, 900)} if rng.random() < 0.7 else {}
        if rng.random() < 0.2:
            limits |= {"t0_s": rng.uniform(0, 100), "t1_s": rng.uniform(101, 300)}
        x, y = rng.uniform(0.3 * width, 0.7 * width), rng.uniform(0.3 * height, 0.7 * height)
        radius = rng.uniform(50, 600)
        if rng.random() < 0.5:
            zones.append(Circle(x, y, radius, **limits))
            continue
        angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 9)))
        ring = np.column_stack((x + radius * np.cos(angles), y + radius * np.sin(angles)))
        centre = ring.mean(axis=0)
        holes = (centre + 0.2 * (ring - centre),) if rng.random() < 0.4 else ()
        zones.append(
            Polygon(
                tuple(map(tuple, ring.tolist())),
                tuple(tuple(map(tuple, hole.tolist())) for hole in holes),
                **limits,
            )
        )
    return tuple(zones)


@cache
def make_mission(seed):
    """Return a problem with a place on Earth, and a path of it, feasible or not."""
    rng = np.random.default_rng(seed)
    shape, side = (41, 61), float(rng.uniform(60, 200))
    heights = 300 + 200 * rng.random(shape)
    first, second = PLACES[seed % len(PLACES)]
    if isinstance(first, str):
        terrain = Terrain("hills", heights, side, side, first, second)
    else:
        terrain = at_origin(Terrain("hills", heights, side, side), first, second)
    width, height = terrain.width_m, terrain.height_m
    inner = rng.uniform((0.2 * width, 0.2 * height), (0.8 * width, 0.8 * height), (7, 2))
    middle = inner[: rng.integers(0, 8)]
    path = np.array(
        [
            (0.05 * width, 0.05 * height, rng.uniform(560, 700)),
            *((x, y, rng.uniform(520, 1500)) for x, y in middle),
            (0.95 * width, 0.95 * height, rng.uniform(560, 700)),
        ]
    )
    rules = {} if seed % 3 else {"as_paper": True}
    if seed % 5 == 1:
        rules = {"rules": Rules(corridor_m=4.0)}
    problem = Problem(
        terrain,
        path[0],
        path[-1],
        zones=random_zones(rng, width, height),
        wind=tuple(rng.uniform(-5, 5, 2)),
        **rules,
    )
    return problem, path


def flight_of(problem, path, **options):
    """Return the flight plan of a path."""
    return flight_plan(problem, Evaluator(problem, threads=1).track(path), **options)


@cache
def flight(seed):
    """Return the flight plan of a random mission; some return home, where that has room."""
    problem, path = make_mission(seed)
    rtl = {"wanted": HandOver(ending=Ending("rtl"))} if seed in _RETURNS else {}
    return flight_of(problem, path, **rtl)
