"""Problems on generated ground that no choice of the planners was tuned on.

Four kinds: fractal ground, canyons and river valleys (:mod:`pathgene.host.terrain.synthetic`), each
with two circles on the straight line, and gentle ground with islands of zones.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bench.scenarios import valley
from pathgene.host.errors import InputError
from pathgene.host.evaluation.reference import problem_utopia
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon, Zone
from pathgene.host.terrain import Terrain, synthetic


__all__ = ["CLAIMED", "KINDS", "TUNING", "generated"]

Floats = NDArray[np.float64]

KINDS = ("fractal", "canyon", "river", "islands")
#: Seeds for looking at while tuning, and seeds for claims, which nobody looks at while tuning.
TUNING, CLAIMED = range(1_000, 1_025), range(20_271_130, 20_271_155)

_AIRCRAFT = "silver-fox"
_SIDE_M = 30.0
_HEIGHT_M, _VALLEY_HEIGHT_M = 100.0, 60.0
_ENDS = 0.08, 0.92
# Two circles on the straight line: their places and their radius, as shares of it.
_PLACES, _RADIUS = (0.35, 0.65), 0.06
# Islands of zones: their number, their radius in metres, and the free ground around the ends.
_ISLANDS, _ISLAND_M, _FREE_M = (15, 40), (300.0, 1_200.0), 800.0
_MOST_DRAWS = 20


def generated(kind: str, seed: int, clearance_m: float | None = None) -> Problem:
    """Return a problem of a kind.

    Parameters
    ----------
    clearance_m : float, optional
        Clearance under the rules of safe flight; None for the evaluation of the papers.

    Raises
    ------
    RuntimeError
        If none of 20 draws has its ends outside zones and ground, and a straight line with a cost.
    """
    for draw in range(_MOST_DRAWS):
        rng = np.random.default_rng((seed, KINDS.index(kind), draw))
        terrain, ends, zones = _scene(kind, seed, rng)
        rules = None if clearance_m is None else Rules(clearance_m=clearance_m)
        try:
            problem = Problem(terrain, *ends, _AIRCRAFT, zones=zones, rules=rules)
            # Costs are relative to the straight line, which may be too steep a glide.
            problem_utopia(problem)
            return problem
        except InputError:
            continue
    raise RuntimeError(f"None of {_MOST_DRAWS} draws of {kind}, seed {seed}, is a problem.")


def _scene(
    kind: str, seed: int, rng: np.random.Generator
) -> tuple[Terrain, tuple[Point, Point], list[Zone]]:
    if kind in ("canyon", "river"):
        terrain = (synthetic.canyon if kind == "canyon" else synthetic.river)(seed=seed)
        south, north = (share * terrain.height_m for share in _ENDS)
        places = [(valley(terrain, y), y) for y in (south, north)]
        ends = _above(terrain, places, _VALLEY_HEIGHT_M)
        return terrain, ends, _on_the_line(places)
    across, up = (int(nodes) for nodes in rng.integers(250, 500, 2))
    relief_m = rng.uniform(800, 2_000) if kind == "fractal" else rng.uniform(50, 300)
    ground = _fractal(rng, up, across, slope=rng.uniform(1.8, 2.4)) * relief_m
    terrain = Terrain(kind, ground, _SIDE_M, _SIDE_M)
    near, far = _ENDS
    rows = (near, far) if rng.integers(2) else (far, near)
    places = [
        (share * terrain.width_m, row * terrain.height_m)
        for share, row in zip(_ENDS, rows, strict=True)
    ]
    ends = _above(terrain, places, _HEIGHT_M)
    if kind == "fractal":
        return terrain, ends, _on_the_line(places)
    return terrain, ends, _islands(rng, terrain, places)


def _above(
    terrain: Terrain, places: list[tuple[float, float]], height_m: float
) -> tuple[Point, Point]:
    start, goal = ((x, y, float(terrain.ground(x, y)) + height_m) for x, y in places)
    return start, goal


def _fractal(rng: np.random.Generator, rows: int, columns: int, slope: float) -> Floats:
    """Return ground from 0 to 1 whose amplitude falls as frequency ** -slope, (rows, columns).

    It is drawn on a larger grid and cut, so that opposite edges do not match.
    """
    shape = 2 * rows, 2 * columns
    frequency = np.hypot(
        *np.meshgrid(np.fft.fftfreq(shape[0]), np.fft.rfftfreq(shape[1]), indexing="ij")
    )
    frequency[0, 0] = math.inf
    spectrum = np.fft.rfft2(rng.standard_normal(shape)) * frequency**-slope
    land: Floats = np.fft.irfft2(spectrum, s=shape)[:rows, :columns]
    scaled: Floats = (land - land.min()) / np.ptp(land)
    return scaled


def _on_the_line(places: list[tuple[float, float]]) -> list[Zone]:
    """Return two circles on the line between the ends."""
    (x0, y0), (x1, y1) = places
    radius_m = _RADIUS * math.dist(*places)
    return [Circle(x0 + share * (x1 - x0), y0 + share * (y1 - y0), radius_m) for share in _PLACES]


def _islands(
    rng: np.random.Generator, terrain: Terrain, places: list[tuple[float, float]]
) -> list[Zone]:
    """Return circles and quadrangles that may overlap, none near an end."""
    zones: list[Zone] = []
    for _ in range(int(rng.integers(*_ISLANDS))):
        at = rng.uniform((0, 0), (terrain.width_m, terrain.height_m))
        radius_m = float(rng.uniform(*_ISLAND_M))
        if min(math.dist(at, place) for place in places) < radius_m + _FREE_M:
            continue
        if rng.integers(2):
            zones.append(Circle(float(at[0]), float(at[1]), radius_m))
            continue
        angles = np.sort(rng.uniform(0, 2 * math.pi, 4))
        ring = at + radius_m * np.column_stack((np.cos(angles), np.sin(angles)))
        zones.append(Polygon(tuple(map(tuple, ring.tolist()))))
    return zones
