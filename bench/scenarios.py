"""Terrains, zones, starts and goals of the benchmarks, fixed before any measurement."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from pathgene.host.errors import InputError
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain, load, synthetic


#: The real terrain that comes with the packages.
EMBEDDED = "jacksboro"
#: The kinds of synthetic land of *roberge*, 25 km2 at 10 m, with seed 0.
SYNTHETIC = ("canyon", "river")
#: The same kinds with different seeds, which were not used for tuning.
HELD_OUT = tuple(f"{kind}-{seed}" for kind in SYNTHETIC for seed in (101, 102, 103, 104))
#: The subset on which the benchmark ``chip`` plans.
UNTUNED = tuple(name for name in HELD_OUT if name.endswith(("101", "102")))
#: The kind of land on which *allaire-2008* measures, 80 x 80 km, with seed 0.
LARGE = "large-canyon"
#: Elevation tiles next to the repository, if available.
TILES = {
    "himalaya": "himalaya_gorge_np.tif",
    "tujunga": "big_tujunga_canyon_ca.tif",
    "cdem": "cdem_indian_river_bc.tif",
    "st-helens": "st_helens_wa.tif",
    "alps": "alps_jungfrau_voids_ch.tif",
    "jervis": "jervis_inlet_fjord_bc.tif",
}
#: Replacements of the four maps of *roberge*: its two synthetic kinds, and two real ones.
TABLE_4 = (*SYNTHETIC, EMBEDDED, "himalaya")
_FOLDER = Path(__file__).resolve().parents[2] / "shared" / "terrain"

# Start and goal on both axes, the zones on the line between them, and their radius, all as shares.
_ENDS = 0.08, 0.92
_ZONES = 0.35, 0.65
_RADIUS = 0.06
_HEIGHT_M = 100.0
_VALLEY_HEIGHT_M = 60.0


def names() -> list[str]:
    """Return the available real terrains: the embedded one and the tiles."""
    return names_of([EMBEDDED, *TILES])


def names_of(wanted: Sequence[str]) -> list[str]:
    """Return the available terrains of ``wanted``; only tiles may be missing."""
    return [name for name in wanted if name not in TILES or (_FOLDER / TILES[name]).exists()]


def missing(wanted: Sequence[str] = (EMBEDDED, *TILES)) -> list[str]:
    """Return a note on the missing terrains of ``wanted``, if any."""
    left_out = [name for name in wanted if name not in names_of(wanted)]
    return [f"Not next to the repository, so left out: {', '.join(left_out)}."] if left_out else []


def source_of(name: str) -> str:
    """Return the value of ``--terrain``: an embedded name or a file."""
    return str(_FOLDER / TILES[name]) if name in TILES else name


@cache
def _terrain(name: str) -> Terrain:
    if name in HELD_OUT:
        kind, _, seed = name.partition("-")
        land: Terrain = getattr(synthetic, kind)(seed=int(seed))
        return land
    source = source_of(name)
    if source == name:
        return load(name)
    if not Path(source).exists():
        raise InputError(f"The elevation tile {TILES[name]} is not next to the repository.")
    return load(source, fill_voids=True)


@cache
def problem(name: str) -> Problem:
    """Return a scenario for paper mode, with two no-fly circles on the line from start to goal.

    On a real terrain, the ends are in opposite corners, 100 m above ground; on a synthetic terrain,
    they are in the south and north, 60 m above the lowest ground of the valley and below the ground
    between them.
    """
    terrain = _terrain(name)
    (x0, x1), (y0, y1) = (
        tuple(share * size for share in _ENDS) for size in (terrain.width_m, terrain.height_m)
    )
    height_m = _HEIGHT_M
    if name in (*SYNTHETIC, *HELD_OUT):
        (x0, x1), height_m = (valley(terrain, y) for y in (y0, y1)), _VALLEY_HEIGHT_M
    radius = _RADIUS * math.hypot(x1 - x0, y1 - y0)
    zones = tuple(
        Circle(x0 + share * (x1 - x0), y0 + share * (y1 - y0), radius) for share in _ZONES
    )
    start = (x0, y0, float(terrain.ground(x0, y0)) + height_m)
    goal = (x1, y1, float(terrain.ground(x1, y1)) + height_m)
    return Problem(terrain, start, goal, aircraft.load("silver-fox"), zones=zones, as_paper=True)


@cache
def problem_at_one_cell(name: str) -> Problem:
    """Return :func:`problem` with a sampling step of one cell, for the benchmarks of *roberge*."""
    scenario = problem(name)
    return dataclasses.replace(scenario, ds_m=min(scenario.terrain.dx_m, scenario.terrain.dy_m))


def valley(terrain: Terrain, y: float) -> float:
    """Return x of the lowest land at ``y``, metres."""
    return float(terrain.elevation[round(y / terrain.dy_m)].argmin() * terrain.dx_m)
