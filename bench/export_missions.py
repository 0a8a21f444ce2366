"""The missions of the campaign of exports: maps, aircraft, weather and planners.

Every planner plans on every one of the nine maps for each aircraft, and on generated ground that
nothing was tuned for. The weather turns from mission to mission.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from bench.flight_rows import WEATHERS, WIND_M_S, Row
from bench.own_paths import own_path
from bench.scenarios import SYNTHETIC, names
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners.base import Options, Result
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.origin import at_origin


__all__ = ["AIRCRAFT", "GENERATED", "Mission", "missions"]

AIRCRAFT = ("silver-fox", "c172p", "j3cub")
#: Generated ground: hills, with random starts and goals.
GENERATED = tuple(f"hills-{seed}" for seed in range(201, 213))

# Generations, fewer than by default; a planner that is not named takes its own number.
_GENERATIONS = {"ga-chip": 2000, "ga-fpga": 100, "ga-pc": 100, "fpa": 100, "fpa-2opt": 100}
_GENERATIONS |= {"astar": 1, "ga-dp": 30, "ga-auv": 30}
# Planners whose first population is the grid search's, since they have few generations.
_BEGIN: dict[str, dict[str, Any]] = {
    name: {"init": "astar"} for name in ("ga-pc", "fpa", "fpa-2opt")
}
# South-west corner of ground that has no place of its own, latitude and longitude.
_PLACE = (46.0, 8.0)
# Nodes and cell of the hills, and the height of start and goal above them.
_NODES, _CELL_M, _HEIGHT_M = 400, 30.0, 60.0
_SLOPE = 2.4
_LEAST_HIGH_M, _MOST_HIGH_M = 300.0, 1800.0
_SHARE = 0.4


@dataclass(frozen=True)
class Mission:
    """A mission to plan, export and fly."""

    terrain: str
    aircraft: str
    weather: str
    planner: str

    @property
    def name(self) -> str:
        """Name in the store, without the planner."""
        return f"{self.terrain} {self.aircraft} {self.weather}"

    @property
    def number(self) -> int:
        """A number from the names, by which missions are mixed."""
        return zlib.crc32(f"{self.name} {self.planner}".encode())

    @property
    def seed(self) -> int:
        """Seed of the turbulence, different for each mission."""
        return self.number % 1000

    def problem(self) -> Problem:
        """Return the problem to plan.

        Raises
        ------
        InputError
            If start or goal are impossible for this aircraft.
        """
        if self.terrain in GENERATED:
            return _over_hills(self)
        made = Row(self.terrain, self.aircraft, self.weather, False).problem()
        if self.terrain in SYNTHETIC:
            made = replace(made, terrain=at_origin(made.terrain, *_PLACE))
        return made

    def plan(self, problem: Problem) -> Result:
        """Plan with few generations, on the processor."""
        planner = make(self.planner, **own_path(self.planner), **_BEGIN.get(self.planner, {}))
        options = Options(seed=0, generations=_GENERATIONS[self.planner])
        return planner.plan(Evaluator(problem, threads=1), options)


def missions() -> list[Mission]:
    """Return all missions on the available maps, mixed, so that any part is a fair sample."""
    made = []
    for number, terrain in enumerate((*names(), *SYNTHETIC, *GENERATED)):
        for place, plane in enumerate(AIRCRAFT):
            for turn, planner in enumerate(PLANNERS):
                weather = WEATHERS[
                    (number + number // 3 + place + turn + turn // 3) % len(WEATHERS)
                ]
                if terrain in GENERATED and (number + turn) % len(AIRCRAFT) != place:
                    continue
                made.append(Mission(terrain, plane, weather, planner))
    return sorted(made, key=lambda mission: mission.number)


@cache
def _hills(name: str) -> Terrain:
    """Return hills of random heights at all scales, 12 km wide, with a place on Earth."""
    rng = np.random.default_rng(int(name.rpartition("-")[2]))
    noise = np.fft.rfft2(rng.normal(size=(_NODES, _NODES)))
    rows, columns = np.fft.fftfreq(_NODES)[:, None], np.fft.rfftfreq(_NODES)[None]
    frequency = np.hypot(rows, columns)
    frequency[0, 0] = np.inf
    land = np.fft.irfft2(noise * frequency**-_SLOPE, s=(_NODES, _NODES))
    land = (land - land.min()) / np.ptp(land) * rng.uniform(_LEAST_HIGH_M, _MOST_HIGH_M)
    return at_origin(Terrain(name, land, _CELL_M, _CELL_M), *_PLACE)


def _over_hills(mission: Mission) -> Problem:
    """Return a problem from a random start to a random goal."""
    terrain = _hills(mission.terrain)
    rng = np.random.default_rng(zlib.crc32(mission.terrain.encode()))
    size = np.array([terrain.width_m, terrain.height_m])
    while True:
        (x0, y0), (x1, y1) = rng.uniform(0.1, 0.9, (2, 2)) * size
        way = math.hypot(x1 - x0, y1 - y0)
        if way > _SHARE * terrain.width_m:
            break
    along = (WIND_M_S * (x1 - x0) / way, WIND_M_S * (y1 - y0) / way)
    winds = {"calm": (0.0, 0.0), "along": along, "across": (-along[1], along[0])}
    start, goal = (
        (float(x), float(y), float(terrain.ground(x, y)) + _HEIGHT_M)
        for x, y in ((x0, y0), (x1, y1))
    )
    plane = aircraft.load(mission.aircraft)
    return Problem(terrain, start, goal, plane, wind=winds[mission.weather])
