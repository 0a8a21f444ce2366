"""Verdicts, counts, cycles and reads of every build of the collision checker."""

from __future__ import annotations

import functools
import random
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.sim.harness import VerilatedChecker
from pathgene.sim.model.checker import TerrainModel
from pathgene.sim.model.checker_cycles import batch_cycles
from pathgene.sim.model.checker_kernels import check_paths
from tools.recording.random_inputs import Point, below, ground, point


__all__ = ["PATHS", "record_paths", "record_verilated"]

#: Random paths per build.
PATHS = 1000
_VERILATED_PATHS = 200
#: One of this many points stays near its predecessor.
_NEAR = 3

_BUILDS = {
    "two-tier": Config(checker=CheckerBuild.TWO_TIER, lanes=1),
    "parallel, 1 lane": Config(lanes=1),
    "parallel, 8 lanes": Config(lanes=8),
    "parallel, 16 lanes": Config(lanes=16),
}


def record_paths(paths: int = PATHS) -> dict[str, list[Any]]:
    """Return the verdicts of the software model on random paths, by build and mode.

    A row per path: collision flag; segment, x and y of the first collision; whether it is in the
    coarse map; cells up to it; colliding cells by segment; cycles; reads.
    """
    return {
        f"{name}, {mode}": _modelled(config, paths, mode == "counting")
        for name, config in _BUILDS.items()
        for mode in ("first hit", "counting")
    }


def record_verilated(paths: int = _VERILATED_PATHS) -> dict[str, list[Any]]:
    """Return the same rows for fewer paths, from the exported Verilog under Verilator."""
    rows = {}
    for name, config in _BUILDS.items():
        with VerilatedChecker(config) as chip:
            chip.write(_heights(config))
            for mode in ("first hit", "counting"):
                batch = chip.check(_paths(config, paths), count=mode == "counting")
                rows[f"{name}, {mode}"] = [
                    [
                        *(verdict[field] for field in ("collision", "segment", "x", "y")),
                        verdict.get("coarse", 0),
                        verdict["cells"],
                        [[entry[name] for name in ("segment", "terrain", "nofly")]
                         for entry in entries],
                        verdict["cycles"],
                        verdict["reads"],
                    ]
                    for verdict, entries in zip(batch.verdicts, batch.entries, strict=True)
                ]  # fmt: skip
    return rows


def _modelled(config: Config, paths: int, counting: bool) -> list[Any]:
    terrain = TerrainModel(config)
    terrain.write(0, 0, _heights(config))
    queue = _paths(config, paths)
    verdicts = check_paths(config, terrain, queue, counting)
    spent = batch_cycles(config, terrain, queue, counting)
    return [
        [
            int(verdict.collision),
            *(verdict.segment, verdict.x, verdict.y, int(verdict.coarse), verdict.cells),
            [list(entry) for entry in verdict.entries],
            *cycles_and_reads,
        ]
        for verdict, cycles_and_reads in zip(verdicts, spent, strict=True)
    ]


@functools.cache
def _heights(config: Config) -> NDArray[np.int64]:
    return ground(config, seed=2, peaks=2e-4, blocked=1e-4)


def _paths(config: Config, paths: int) -> list[list[Point]]:
    """Draw paths of every number of points: long, short and empty segments."""
    rng = random.Random(3)
    drawn = []
    for _ in range(paths):
        path = [point(rng, config)]
        for _ in range(1 + below(rng, config.max_waypoints + 1)):
            path.append(point(rng, config, path[-1] if below(rng, _NEAR) == 0 else None))
        drawn.append(path)
    return drawn
