"""Random problems without a path, each with its intended reason."""

from dataclasses import dataclass, replace

import numpy as np

from pathgene.host.problem.aircraft import load
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain


CELL_M = 50.0
NODES = 80
WIDTH_M = (NODES - 1) * CELL_M
FOX = load("silver-fox")


def lane(west, east):
    """Return two zones that leave a lane of 300 m around y = 2000: too narrow to turn back."""
    return tuple(
        Polygon(((west, low), (east, low), (east, high), (west, high)), name=name)
        for low, high, name in ((1000, 1850, "south"), (2150, 3000, "north"))
    )


@dataclass(frozen=True)
class Closed:
    """A problem without a path, and the reason that must be given."""

    problem: Problem
    code: str
    proven: bool = True
    zones: frozenset[str] = frozenset()
    limit: str | None = None
    end: str | None = None


def hills(rng, height_m=60.0):
    """Return gentle random hills around 200 m."""
    y, x = np.mgrid[:NODES, :NODES] / NODES
    a, b, c, d = rng.uniform(0, 2 * np.pi, 4)
    waves = np.sin(6 * x + a) * np.cos(5 * y + b) + 0.5 * np.sin(9 * x + 4 * y + c)
    return 200 + 0.5 * height_m * waves + 2 * np.sin(25 * y + d)


def terrain(elevation):
    return Terrain("random", elevation, CELL_M, CELL_M)


def ends(rng, ground, *, height_m=120.0):
    """Return a start in the west and a goal in the east, above the ground."""
    points = []
    for low, high in ((0.06, 0.25), (0.75, 0.94)):
        x, y = rng.uniform(low, high) * WIDTH_M, rng.uniform(0.1, 0.9) * WIDTH_M
        points.append((x, y, float(ground.ground(x, y)) + height_m))
    return points


def star(rng, x, y, radius_m, corners=9):
    """Return a ring of corners around a point, as far as 0.7 to 1 times the radius."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, corners) * 0.2 + np.arange(corners) * 2 * np.pi / 9)
    reach = radius_m * rng.uniform(0.7, 1.0, corners)
    return tuple(zip(x + reach * np.cos(angles), y + reach * np.sin(angles), strict=True))


def zone_wall(rng):
    """A strip across the map, often thinner than a cell."""
    ground = terrain(hills(rng))
    start, goal = ends(rng, ground)
    thick = rng.choice([1.0, 30.0, 80.0, 400.0])
    low, high = rng.uniform(0.35, 0.65, 2) * WIDTH_M
    ring = ((low, -50), (low + thick, -50), (high + thick, WIDTH_M + 50), (high, WIDTH_M + 50))
    zone = Polygon(ring, name="border")
    return Closed(
        Problem(ground, start, goal, zones=[zone]), "closed", zones=frozenset({"zone border"})
    )


def zone_chain(rng):
    """Circles across the map, whose margins touch each other, and some more circles."""
    ground = terrain(hills(rng))
    start, goal = ends(rng, ground)
    zones, y = [], -30.0
    x = rng.uniform(0.4, 0.6) * WIDTH_M
    while y < WIDTH_M + 30:
        radius = rng.uniform(60, 250)
        zones.append(Circle(x, y + radius, radius, name=f"c{len(zones)}"))
        y += 2 * radius + rng.uniform(0, 45)
    names = frozenset(f"zone {zone.name}" for zone in zones)
    zones.insert(0, Circle(x + 400, rng.uniform(0, WIDTH_M), 30))
    return Closed(Problem(ground, start, goal, zones=zones), "closed", zones=names)


def zone_ring(rng):
    """A polygon with a hole around one end, or a ring of circles around it."""
    ground = terrain(hills(rng))
    start, goal = ends(rng, ground)
    end = str(rng.choice(["start", "goal"]))
    x, y, _ = start if end == "start" else goal
    if rng.random() < 0.5:
        hole = star(rng, x, y, 320)
        zone = Polygon(star(rng, x, y, 700), (hole,), name="atoll")
        return Closed(
            Problem(ground, start, goal, zones=[zone]),
            "closed",
            zones=frozenset({"zone atoll"}),
            end=end,
        )
    angles = np.arange(12) * np.pi / 6 + rng.uniform(0, 1)
    zones = [Circle(x + 380 * np.cos(a), y + 380 * np.sin(a), 80) for a in angles]
    names = frozenset(f"zone {number}" for number in range(1, 13))
    return Closed(Problem(ground, start, goal, zones=zones), "closed", zones=names, end=end)


def void_wall(rng):
    """A gap in the data across the map, which may be diagonal."""
    heights = hills(rng)
    column = int(rng.integers(28, 50))
    for row in range(NODES):
        heights[row, column] = np.nan
        if rng.random() < 0.5 and 26 < column < 52:
            column += int(rng.choice([-1, 1]))
    ground = terrain(heights)
    start, goal = ends(rng, ground)
    return Closed(Problem(ground, start, goal), "closed")


def void_and_zones(rng):
    """Voids from one edge of the map to a zone, which reaches the opposite edge."""
    heights = hills(rng)
    heights[:40, 40] = np.nan
    ground = terrain(heights)
    start, goal = ends(rng, ground)
    ring = ((1950, 1960), (2050, 1960), (2050, 5000), (1950, 5000))
    zone = Polygon(ring, name="north")
    return Closed(
        Problem(ground, start, goal, zones=[zone]), "closed", zones=frozenset({"zone north"})
    )


def low_ceiling(rng):
    """A ridge across the map that is everywhere higher than the ceiling allows."""
    heights = hills(rng)
    first = int(rng.integers(30, 42))
    lowest = rng.uniform(420, 500)
    heights[:, first : first + 8] = lowest + 150 * rng.random((NODES, 1))
    ground = terrain(heights)
    start, goal = ends(rng, ground)
    top = lowest + rng.uniform(-20, 25)
    if rng.random() < 0.3:
        aircraft = replace(FOX, service_ceiling_m=top)
        return Closed(Problem(ground, start, goal, aircraft), "ceiling", limit="service-ceiling")
    return Closed(
        Problem(ground, start, goal, rules=Rules(ceiling_m=top)), "ceiling", limit="ceiling"
    )


def high_zone(rng):
    """A zone across the map that could be flown over, were it not for the ceiling."""
    ground = terrain(hills(rng))
    start, goal = ends(rng, ground)
    x, upper = rng.uniform(0.4, 0.6) * WIDTH_M, rng.uniform(450, 600)
    ring = ((x, -50), (x + 90, -50), (x + 90, WIDTH_M + 50), (x, WIDTH_M + 50))
    zone = Polygon(ring, name="low", upper_m=upper)
    top = upper + rng.uniform(-40, 20)
    return Closed(
        Problem(ground, start, goal, zones=[zone], rules=Rules(ceiling_m=top)),
        "ceiling",
        zones=frozenset({"zone low"}),
        limit="ceiling",
    )


def pit(rng, radius_m, depth_m):
    """One end in a pit with vertical walls."""
    heights = hills(rng)
    end = str(rng.choice(["start", "goal"]))
    column = int(rng.integers(12, 20)) if end == "start" else int(rng.integers(60, 68))
    row = int(rng.integers(15, 65))
    y, x = np.mgrid[:NODES, :NODES]
    inside = np.hypot(x - column, y - row) * CELL_M <= radius_m
    heights += depth_m
    heights[inside] = 150.0
    ground = terrain(heights)
    start, goal = ends(rng, ground)
    own = (column * CELL_M, row * CELL_M, 150.0 + 80)
    start, goal = (own, goal) if end == "start" else (start, own)
    return Problem(ground, start, goal), end


def narrow_pit(rng):
    """A pit without room to circle: no path leads out."""
    problem, end = pit(rng, 100.0, rng.uniform(700, 1200))
    code = "climb" if end == "start" else "descent"
    return Closed(problem, code, limit=code, end=end)


def wide_pit(rng):
    """A pit in which an aircraft could circle up, which no planner does."""
    problem, end = pit(rng, rng.uniform(250, 420), rng.uniform(900, 1400))
    code = "climb" if end == "start" else "descent"
    return Closed(problem, code, proven=False, limit=code, end=end)


def canyon(rng):
    """A canyon, closed at both ends, with one end of the path in it."""
    heights = hills(rng) + 1500.0
    row, wide = int(rng.integers(25, 55)), int(rng.integers(2, 5))
    heights[row - wide : row + wide + 1, 10:30] = 150.0
    ground = terrain(heights)
    _, goal = ends(rng, ground)
    start = (rng.uniform(700, 1300), row * CELL_M, 250.0)
    proven = (2 * wide + 1) * CELL_M < 2 * FOX.turn_radius_m
    return Closed(Problem(ground, start, goal), "climb", proven, limit="climb", end="start")


def small_tank(rng):
    """A fuel tank too small for the straight line."""
    ground = terrain(hills(rng))
    start, goal = ends(rng, ground)
    line = np.hypot(goal[0] - start[0], goal[1] - start[1])
    wind = (0.0, 0.0) if rng.random() < 0.5 else (-6.0, 0.0)
    # Level flight burns 1.3e-5 N per metre.
    aircraft = replace(FOX, fuel_weight_N=float(line * 1.3e-5 * rng.uniform(0.3, 0.7)))
    return Closed(Problem(ground, start, goal, aircraft, wind=wind), "fuel", limit="fuel")


def weak_engine(rng):
    """An engine that cannot hold level flight, and a goal above the start."""
    ground = terrain(hills(rng))
    start, goal = ends(rng, ground)
    goal = (*goal[:2], max(goal[2], start[2] + 10))
    aircraft = replace(FOX, engine_power_W=float(rng.uniform(20, 120)))
    return Closed(Problem(ground, start, goal, aircraft), "power", limit="power")


def bad_end(rng):
    """One end above the ceiling, or in the margin of a zone."""
    ground = terrain(hills(rng))
    start, goal = ends(rng, ground)
    end = str(rng.choice(["start", "goal"]))
    x, y, z = start if end == "start" else goal
    if rng.random() < 0.5:
        away = rng.uniform(1, 24)
        zone = Circle(x + 100 + away, y, 100, name="airfield")
        return Closed(
            Problem(ground, start, goal, zones=[zone]),
            end,
            zones=frozenset({"zone airfield"}),
            limit="zone-margin",
            end=end,
        )
    lift = z + 300
    start, goal = ((x, y, lift), goal) if end == "start" else (start, (x, y, lift))
    rules = Rules(ceiling_m=lift - rng.uniform(1, 40))
    return Closed(Problem(ground, start, goal, rules=rules), end, limit="ceiling", end=end)


KINDS = (
    zone_wall,
    zone_chain,
    zone_ring,
    void_wall,
    void_and_zones,
    low_ceiling,
    high_zone,
    narrow_pit,
    wide_pit,
    canyon,
    small_tank,
    weak_engine,
    bad_end,
)
