"""Problems that are solvable by construction: a safe path first, then ground and zones around it.

Each of the ten families draws a path and builds obstacles that leave room for it alone, or for
little more. A problem counts only if the strict rule accepts the planted path; otherwise the next
draw of the same seed follows. Lengths are in cells of the terrain unless a name says metres.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.planners.grid.altitudes import lowest_altitudes
from pathgene.host.planners.grid.grid_search import Prices
from pathgene.host.problem.aircraft import load
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon, Zone
from pathgene.host.terrain import Terrain


__all__ = ["CLAIMED", "FAMILIES", "TUNING", "Planted", "planted"]

Floats = NDArray[np.float64]

#: Seeds for tuning, and seeds for claims: nobody looks at a claimed problem while tuning.
TUNING, CLAIMED = range(100), range(50_000, 50_100)

_RELIEF_M = 60.0
# Height of walls of ground over the floor, and of the ceiling, which keeps paths between them.
_WALL_M, _CEILING_M = 900.0, 450.0
_END_M = 60.0
_MOST_DRAWS = 40


@dataclass(frozen=True)
class Planted:
    """A problem and its planted path, (n, 3) float64 metres with both ends."""

    problem: Problem
    path: Floats


class _Scene:
    """Ground, zones and the places of the planted path, all in cells, before they are metres."""

    def __init__(
        self,
        rng: np.random.Generator,
        across: int,
        up: int,
        cell_m: float,
        places: Sequence[Sequence[float]] | Floats,
    ) -> None:
        self.cell_m = cell_m
        #: Makes each zone, given a function that turns points, (n, 2) metres.
        self.zones: list[Callable[[Callable[[Floats], Floats]], Zone]] = []
        self.places = np.array(places, dtype=np.float64)
        relief = gaussian_filter(rng.standard_normal((up, across)), 8.0)
        self.ground = _RELIEF_M * (relief - relief.min()) / np.ptp(relief)
        self.ceiling = False
        #: Altitudes of the planted path, metres; None for the lowest ones.
        self.altitudes: Floats | None = None
        # A wall that leaves the map has no passage beside it.
        self.wide, self.high = across - 1, up - 1

    def box(self, x0: float, y0: float, x1: float, y1: float) -> None:
        """Add a rectangular zone."""
        ring = np.array(((x0, y0), (x1, y0), (x1, y1), (x0, y1))) * self.cell_m
        self.zones.append(lambda moved: Polygon(tuple(map(tuple, moved(ring).tolist()))))

    def disc(self, x: float, y: float, radius: float) -> None:
        """Add a circular zone."""
        middle = np.array([(x, y)]) * self.cell_m

        def made(moved: Callable[[Floats], Floats]) -> Zone:
            (at_x, at_y), *_ = moved(middle).tolist()
            return Circle(at_x, at_y, radius * self.cell_m)

        self.zones.append(made)

    def away(self, places: Floats, radius: float = 150.0) -> Floats:
        """Return the distance of each node to the smoothed track through ``places``, in cells."""
        track = self.track(places, radius)
        open_nodes = np.ones(self.ground.shape, dtype=bool)
        column, row = np.rint(track).astype(int).T
        open_nodes[np.clip(row, 0, self.high), np.clip(column, 0, self.wide)] = False
        away: Floats = distance_transform_edt(open_nodes)
        return away

    def track(self, places: Floats, radius_m: float = 150.0) -> Floats:
        """Return points of the smoothed track, less than half a cell apart."""
        path = np.column_stack((places * self.cell_m, np.zeros(len(places))))
        points = []
        for piece in smooth(path, radius_m).pieces:
            count = max(2, math.ceil(3 * piece.run_m / self.cell_m))
            points.append(piece.points(np.linspace(0, 1, count))[:, :2])
        track: Floats = np.concatenate(points) / self.cell_m
        return track

    def carve(self, width: float, *decoys: Floats) -> None:
        """Raise all ground farther than ``width`` from the planted path and the decoys."""
        away = np.minimum.reduce([self.away(self.places), *map(self.away, decoys)])
        self.ground = np.where(away > width, _WALL_M + self.ground, self.ground)
        self.ceiling = True


_Build = Callable[[np.random.Generator], _Scene]


def _maze(rng: np.random.Generator) -> _Scene:
    """Return 3 to 8 walls of zones, with gaps at alternating ends."""
    return _walls(rng, int(rng.integers(3, 9)), 100, rng.uniform(10, 16), rng.uniform(6, 12))


def _thin(rng: np.random.Generator) -> _Scene:
    """Return a map 16 to 28 cells wide, with walls from alternating sides."""
    up = int(rng.integers(16, 29))
    return _walls(rng, int(rng.integers(2, 6)), up, rng.uniform(30, 45), rng.uniform(5, 7.5))


def _walls(rng: np.random.Generator, count: int, up: int, lane: float, gap: float) -> _Scene:
    across = math.ceil((count + 1) * lane) + 1
    upper = bool(rng.integers(2))
    places = [(0.5 * lane, up * rng.uniform(0.4, 0.6))]
    boxes = []
    for wall in range(count):
        x, thick = (wall + 1) * lane, rng.uniform(0.5, 2.0)
        y = up - 1 - 0.5 * gap if upper else 0.5 * gap
        edges = (-1.0, up - 1 - gap) if upper else (gap, float(up))
        boxes.append((x - thick, edges[0], x + thick, edges[1]))
        places += [(x - 0.35 * lane, y), (x + 0.35 * lane, y)]
        upper = not upper
    places.append(((count + 0.5) * lane, up * rng.uniform(0.4, 0.6)))
    scene = _Scene(rng, across, up, 60.0, places)
    for box in boxes:
        scene.box(*box)
    return scene


def _gap(rng: np.random.Generator) -> _Scene:
    """Return a wall with a gap of 1.5 to 8 cells: of zones, or of ground from 3.5 cells on."""
    gap, middle = rng.uniform(1.5, 8.0), rng.uniform(20, 80)
    places = [(12, rng.uniform(15, 85)), (38, middle), (62, middle), (88, rng.uniform(15, 85))]
    scene = _Scene(rng, 100, 100, rng.uniform(70, 100), places)
    low, high = middle - gap / 2, middle + gap / 2
    if gap > 3.5 and rng.integers(2):
        rows = np.arange(100)
        scene.ground[(rows < low) | (rows > high), 48:53] += _WALL_M
        scene.ceiling = True
    else:
        scene.box(48, -1, 52, low)
        scene.box(48, high, 52, 100)
    return scene


def _pit(rng: np.random.Generator) -> _Scene:
    """Return a start in a pit: half with a slot, half without, so that a climb must circle."""
    slot, middle = bool(rng.integers(2)), rng.uniform(30, 50, 2)
    angle = rng.uniform(0, 2 * math.pi)
    ahead = np.array((math.cos(angle), math.sin(angle)))
    goal = middle + 48 * np.array((math.cos(angle + 2.4), math.sin(angle + 2.4)))
    goal = np.clip(goal, 8, 91)
    if slot:
        out = middle + 22 * ahead
        places = [middle, middle + 12 * ahead, out + 6 * ahead, goal]
        scene = _Scene(rng, 100, 100, 60.0, np.clip(places, 4, 95))
        away = scene.away(scene.places[:3])
        rows, columns = np.indices(scene.ground.shape)
        beyond = np.hypot(columns - middle[0], rows - middle[1])
        ring = (beyond > 8) & (beyond < 20) & (away > rng.uniform(2.5, 4.5))
        scene.ground[ring] += _WALL_M
        scene.ceiling = True
        return scene
    turns, side = int(rng.integers(2, 4)), 8
    depth = rng.uniform(150, 300) * turns / 2
    angles = angle + np.arange(turns * side + 1) * 2 * math.pi / side
    circle = middle + 6.0 * np.column_stack((np.cos(angles), np.sin(angles)))
    leave = angles[-1] + 0.5 * math.pi
    out = circle[-1] + 24 * np.array((math.cos(leave), math.sin(leave)))
    scene = _Scene(rng, 100, 100, 60.0, np.clip([*circle, out, goal], 4, 95))
    rows, columns = np.indices(scene.ground.shape)
    scene.ground[np.hypot(columns - middle[0], rows - middle[1]) > 10] += depth
    return scene


def _spiral(rng: np.random.Generator) -> _Scene:
    """Return a square spiral of zones with the goal at its centre."""
    lane, sides = rng.uniform(9, 13), int(rng.integers(5, 9))
    # Arms of the spiral, from the centre outwards.
    way, at = np.array((1.0, 0.0)), np.zeros(2)
    corners = [at]
    for side in range(sides):
        at = at + way * lane * (side // 2 + 1)
        corners.append(at)
        way = np.array((-way[1], way[0]))
    arms = np.array(corners)
    arms[-1] += (arms[-1] - arms[-2]) / np.hypot(*(arms[-1] - arms[-2])) * lane
    low, high = arms.min(axis=0) - 1.6 * lane, arms.max(axis=0) + 1.6 * lane
    size = np.ceil(high - low).astype(int) + 1
    places = (arms - low)[::-1]
    scene = _Scene(rng, int(size[0]), int(size[1]), 60.0, places)
    # Walls lie half a lane beside the arms: the outline of the lane, but for its mouth.
    half, thick = 0.5 * lane, 0.6
    inner = places[::-1]
    for side in range(sides):
        one, other = inner[side], inner[side + 1]
        ahead = (other - one) / np.hypot(*(other - one))
        right = np.array((ahead[1], -ahead[0]))
        begin = one - ahead * half
        end = other + ahead * (half if side < sides - 1 else 0.0)
        ends = np.array((begin + right * half, end + right * half))
        (x0, y0), (x1, y1) = ends.min(axis=0) - thick, ends.max(axis=0) + thick
        scene.box(x0, y0, x1, y1)
    # The dead end at the goal.
    x, y = inner[0] - np.array((half, 0.0))
    scene.box(x - thick, y - half, x + thick, y + half)
    return scene


def _comb(rng: np.random.Generator) -> _Scene:
    """Return bays between teeth of zones; start and goal lie deep in two of them."""
    bays, lane = int(rng.integers(4, 8)), rng.uniform(8, 12)
    across, up = math.ceil(bays * lane) + 1, 80
    one, other = sorted(rng.choice(bays, 2, replace=False).tolist())
    spine = 70.0
    columns = [(bay + 0.5) * lane for bay in (one, other)]
    places = [
        (columns[0], rng.uniform(6, 30)),
        (columns[0], spine),
        (columns[1], spine),
        (columns[1], rng.uniform(6, 30)),
    ]
    scene = _Scene(rng, across, up, 60.0, places)
    for tooth in range(1, bays):
        thick = rng.uniform(0.4, 1.5)
        scene.box(tooth * lane - thick, -1, tooth * lane + thick, rng.uniform(55, 62))
    return scene


def _wander(rng: np.random.Generator, size: float, steps: int, long: float) -> Floats:
    """Return a path that wanders from the west to the east."""
    heading = rng.uniform(-0.5, 0.5)
    at = np.array((8.0, rng.uniform(0.3, 0.7) * size))
    places = [at]
    for _ in range(steps):
        heading = np.clip(heading + rng.uniform(-1.1, 1.1), -1.3, 1.3)
        if not 12 < at[1] + long * math.sin(heading) < size - 12:
            heading = -heading
        at = at + long * np.array((math.cos(heading), math.sin(heading)))
        places.append(at)
    return np.array(places)


def _islands(rng: np.random.Generator) -> _Scene:
    """Return large zones and peaks on both sides of a path."""
    places = _wander(rng, 100, int(rng.integers(5, 8)), 15.0)
    scene = _Scene(rng, max(100, math.ceil(places[:, 0].max()) + 8), 100, 60.0, places)
    _strew(rng, scene, 35, 4.0, 14.0)
    peaks = rng.random((100, scene.wide + 1))
    hills = gaussian_filter(peaks, 4.0)
    away = scene.away(places)
    tops = (hills > np.quantile(hills, 0.7)) & (away > 3.5)
    scene.ground[tops] += _WALL_M
    scene.ceiling = True
    return scene


def _strew(
    rng: np.random.Generator, scene: _Scene, count: int, least: float, greatest: float
) -> None:
    """Add circles that keep 0.9 to 2 cells from the planted track."""
    track = scene.track(scene.places)
    while count:
        at = rng.uniform((0, 0), (scene.wide, scene.high))
        room = float(np.hypot(*(track - at).T).min()) - rng.uniform(0.9, 2.0)
        if room > least:
            scene.disc(at[0], at[1], min(room, rng.uniform(least, greatest)))
            count -= 1


def _circles_100(rng: np.random.Generator) -> _Scene:
    """Return 100 circles beside a path."""
    places = _wander(rng, 100, int(rng.integers(5, 8)), 15.0)
    scene = _Scene(rng, max(100, math.ceil(places[:, 0].max()) + 8), 100, 60.0, places)
    _strew(rng, scene, 100, 2.0, 9.0)
    return scene


def _circles_1000(rng: np.random.Generator) -> _Scene:
    """Return 1,000 circles beside a path."""
    places = _wander(rng, 200, int(rng.integers(8, 12)), 20.0)
    scene = _Scene(rng, max(200, math.ceil(places[:, 0].max()) + 8), 200, 60.0, places)
    _strew(rng, scene, 1_000, 0.5, 6.0)
    return scene


def _canyon(rng: np.random.Generator) -> _Scene:
    """Return a winding canyon with dead ends in a plateau above the ceiling."""
    places = _wander(rng, 120, int(rng.integers(6, 10)), 14.0)
    scene = _Scene(rng, math.ceil(places[:, 0].max()) + 12, 120, 60.0, places)
    decoys = []
    for place in places[1:-1:2]:
        angle = rng.uniform(0, 2 * math.pi)
        end = place + 25 * np.array((math.cos(angle), math.sin(angle)))
        decoys.append(np.array((place, np.clip(end, 2, scene.high - 2))))
    scene.carve(rng.uniform(2.2, 4.5), *decoys)
    return scene


#: The families by name.
FAMILIES: dict[str, _Build] = {
    "maze": _maze,
    "gap": _gap,
    "pit": _pit,
    "spiral": _spiral,
    "comb": _comb,
    "islands": _islands,
    "circles-100": _circles_100,
    "circles-1000": _circles_1000,
    "thin": _thin,
    "canyon": _canyon,
}


def planted(family: str, seed: int) -> Planted:
    """Return a problem of a family, whose planted path the strict rule accepts.

    Raises
    ------
    RuntimeError
        If the strict rule accepts none of 40 draws.
    """
    number = list(FAMILIES).index(family)
    for draw in range(_MOST_DRAWS):
        rng = np.random.default_rng((seed, number, draw))
        found = _proved(FAMILIES[family](rng), rng)
        if found is not None:
            return found
    raise RuntimeError(f"No path of {_MOST_DRAWS} draws of {family}, seed {seed}, is safe.")


def _proved(scene: _Scene, rng: np.random.Generator) -> Planted | None:
    """Return the problem in metres, its axes swapped and mirrored at random; None if unsafe."""
    swap, *mirror = (rng.integers(2, size=3) == 1).tolist()
    ground, places, zones = _turned(scene, swap, mirror)
    terrain = Terrain("planted", ground, scene.cell_m, scene.cell_m)
    if (places < 0).any() or (places > (terrain.width_m, terrain.height_m)).any():
        return None
    ends = [(x, y, float(terrain.ground(x, y)) + _END_M) for x, y in places[[0, -1]].tolist()]
    rules = Rules(ceiling_m=_CEILING_M if scene.ceiling else None)
    try:
        problem = Problem(terrain, ends[0], ends[1], load("silver-fox"), zones=zones, rules=rules)
    except InputError:  # An end in a zone.
        return None
    path = lowest_altitudes(problem, Prices(problem), places)
    if path is None or not Evaluator(problem, threads=1).evaluate(path).feasible:
        return None
    return Planted(problem, path)


def _turned(scene: _Scene, swap: bool, mirror: Sequence[bool]) -> tuple[Floats, Floats, list[Zone]]:
    """Return ground, places and zones in metres, with swapped and mirrored axes."""
    ground = scene.ground
    most = np.array((scene.wide, scene.high)) * scene.cell_m
    signs = np.where(mirror, -1.0, 1.0)

    def moved(points: Floats) -> Floats:
        points = np.where(mirror, most, 0.0) + signs * points
        return points[:, ::-1] if swap else points

    ground = ground[:: -1 if mirror[1] else 1, :: -1 if mirror[0] else 1]
    zones = [made(moved) for made in scene.zones]
    return ground.T if swap else ground, moved(scene.places * scene.cell_m), zones
