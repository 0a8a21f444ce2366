"""Recorder of the tests' goldens: results of the model that no change of the code may affect.

``python -m tools.record`` writes ``tests/golden/golden.json`` again after an intended change. The
file has integers and the terms of fixed paths, and is valid on every machine.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import random
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol.codes import LinkMode
from pathgene.hdl.protocol.paths import pack_paths
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link
from pathgene.host.evaluation import Evaluator
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import load
from pathgene.sim.model.checker import TerrainModel
from pathgene.sim.model.checker_cycles import batch_cycles
from pathgene.sim.model.checker_kernels import check_paths
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.chip import ModelPort


#: Generations per run.
GENERATIONS = 50
#: All paths are checked after every generation whose number is a multiple of this.
_CHECK_EVERY = 5
#: The model replies immediately; the limit only ensures that no frame is repeated on a busy
#: machine.
_TIMEOUT_S = 60.0

_SMALL = Config(
    population=8, children=4, elites=1, survivors=3, perturbs=1, inserts=1, deletes=1,
    max_waypoints=5, map_size=16, coarse_factor=4, altitude_bits=6,
)  # fmt: skip
#: Configurations, with a flag for new waypoints that avoid the ground.
_CHIPS = {
    "default": (Config(), False),
    "with map": (Config(), True),
    "small with map": (_SMALL, True),
}


Point = tuple[int, int, int]


class _TappedPort(ModelPort):
    """A port of the model that keeps a digest of the bytes in each direction.

    It uses SHA-256 instead of CRC-32: a frame ends with its own CRC-32, so a CRC-32 over whole
    frames does not depend on their contents.
    """

    def __init__(self, chip: ChipModel) -> None:
        super().__init__(chip)
        self.sent, self.received = hashlib.sha256(), hashlib.sha256()

    def write(self, data: bytes | bytearray | memoryview) -> int:
        self.sent.update(data)
        return super().write(data)

    def read(self, size: int = 1) -> bytes:
        data = super().read(size)
        self.received.update(data)
        return data


def record_generations(seed: int, chips: Iterable[str] = _CHIPS) -> dict[str, Any]:
    """Return the record of :func:`_generations` by chip and link mode."""
    return {
        f"{name}, {mode.name.lower()}, seed {seed}": _generations(*_CHIPS[name], mode, seed)
        for name in chips
        for mode in LinkMode
    }


def _generations(config: Config, avoid_ground: bool, mode: LinkMode, seed: int) -> dict[str, Any]:
    """Breed on the model over a link, with a random ranking for each generation.

    ``populations`` are the CRC-32 of each generation's population as the chip sends it, which is
    also the host's copy; ``checks`` the CRC-32 of all results of a check of the whole population;
    ``sent`` and ``received`` the SHA-256 of all bytes on the line.
    """
    rng = random.Random(seed)
    port = _TappedPort(ChipModel(config))
    with Chip(Link(port, timeout_s=_TIMEOUT_S)) as chip:
        if avoid_ground:
            # Enough peaks and blocked cells for new waypoints to be redrawn and given up.
            chip.upload_map(_ground(config, seed=4, peaks=0.2, blocked=0.1))
        highest = config.map_size - 1
        limits = (highest, highest, config.blocked_altitude - 1)
        chip.start(seed, limits, avoid_ground=avoid_ground)
        chip.load(_population(rng, config))
        populations, checks = [], []
        for generation in range(1, GENERATIONS + 1):
            chip.step(_shuffled(rng, config.population), mode)
            paths = chip.paths
            if paths != chip.read(0, config.population):
                raise AssertionError(f"The host's copy is wrong in generation {generation}")
            populations.append(zlib.crc32(pack_paths(config, paths)))
            if avoid_ground and generation % _CHECK_EVERY == 0:
                ends = (_waypoint(config, _point(rng, config)) for _ in range(2))
                counting = generation % (2 * _CHECK_EVERY) == 0
                checked = chip.check_population(*ends, counting=counting)
                checks.append(checksum(dataclasses.astuple(checked)))
        counters = chip.counters()
    return {
        "populations": populations,
        "checks": checks,
        "sent": port.sent.hexdigest(),
        "received": port.received.hexdigest(),
        "counters": counters,
    }


#: One of this many points stays near its predecessor.
_NEAR = 3

_BUILDS = {
    "two-tier": Config(checker=CheckerBuild.TWO_TIER, lanes=1),
    "parallel, 1 lane": Config(lanes=1),
    "parallel, 8 lanes": Config(lanes=8),
    "parallel, 16 lanes": Config(lanes=16),
}


def record_paths(paths: int) -> dict[str, list[Any]]:
    """Return the verdicts of the software model on random paths, by build and mode.

    There is a row per path: collision flag; segment, x and y of the first collision; whether it is
    in the coarse map; cells up to it; colliding cells by segment; cycles; reads.
    """
    return {
        f"{name}, {mode}": _modelled(config, paths, mode == "counting")
        for name, config in _BUILDS.items()
        for mode in ("first hit", "counting")
    }


def _modelled(config: Config, paths: int, counting: bool) -> list[Any]:
    terrain = TerrainModel(config)
    terrain.write(0, 0, _ground(config, seed=2, peaks=2e-4, blocked=1e-4))
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


def _paths(config: Config, paths: int) -> list[list[Point]]:
    """Draw paths with every number of points, and with long, short and empty segments."""
    rng = random.Random(3)
    drawn = []
    for _ in range(paths):
        path = [_point(rng, config)]
        for _ in range(1 + _below(rng, config.max_waypoints + 1)):
            path.append(_point(rng, config, path[-1] if _below(rng, _NEAR) == 0 else None))
        drawn.append(path)
    return drawn


def _below(rng: random.Random, limit: int) -> int:
    """Draw an integer of 0..limit - 1."""
    return int(rng.random() * limit)


def _shuffled(rng: random.Random, count: int) -> list[int]:
    """Draw a permutation of 0..count - 1."""
    return sorted(range(count), key=[rng.random() for _ in range(count)].__getitem__)


@functools.cache
def _ground(config: Config, seed: int, *, peaks: float, blocked: float) -> NDArray[np.int64]:
    """Draw a map ``[y, x]`` of altitude steps: low rough ground, peaks and blocked cells.

    ``peaks`` and ``blocked`` are the shares of peaks and blocked cells.
    """
    rng = random.Random(seed)
    top = config.blocked_altitude
    cells = []
    for _ in range(config.map_size**2):
        kind = rng.random()
        if kind < peaks:
            cells.append(top // 2 + _below(rng, top // 2))
        elif kind < peaks + blocked:
            cells.append(top)
        else:
            cells.append(_below(rng, top // 4 + 1))
    return np.array(cells).reshape(config.map_size, config.map_size)


def _point(rng: random.Random, config: Config, near: Point | None = None) -> Point:
    """Draw a point of a path above most of the ground, within two cells of ``near`` if given."""
    edge, top = config.map_size - 1, config.blocked_altitude
    x, y = _below(rng, edge + 1), _below(rng, edge + 1)
    if near is not None:
        x, y = (min(max(at - 2 + _below(rng, 5), 0), edge) for at in near[:2])
    return x, y, top // 4 + _below(rng, top - top // 4)


def _waypoint(config: Config, at: Point) -> int:
    """Pack a point as the chip stores it."""
    bits = config.coordinate_bits
    return at[0] | at[1] << bits | at[2] << 2 * bits


def _population(rng: random.Random, config: Config) -> list[list[int]]:
    """Draw a path of packed waypoints for every slot, of all lengths."""
    least, most = config.MIN_WAYPOINTS, config.max_waypoints
    return [
        [
            _waypoint(config, _point(rng, config))
            for _ in range(least + _below(rng, most - least + 1))
        ]
        for _ in range(config.population)
    ]


def checksum(value: Any) -> int:
    """Return the CRC-32 of plain JSON data."""
    return zlib.crc32(json.dumps(value).encode())


#: The committed record of the tests.
GOLDENS = Path(__file__).resolve().parents[1] / "tests" / "golden" / "golden.json"


def golden_generations() -> dict[str, Any]:
    """Return every tenth population and all counters of some runs."""
    runs = record_generations(1)
    for run in runs.values():
        run["populations"] = run["populations"][9::10]
    return runs


def golden_paths() -> dict[str, Any]:
    """Return the CRC-32 of each build's results on a hundred paths."""
    return {
        title: [checksum(rows[first : first + 100]) for first in range(0, len(rows), 100)]
        for title, rows in record_paths(300).items()
    }


def evaluate(problem: dict[str, Any], path: list[list[float]]) -> dict[str, float]:
    """Return every term of a path in metres over a problem of the tests' record."""
    zones = tuple(Circle(*circle) for circle in problem["circles"])
    ends = tuple(problem["start"]), tuple(problem["goal"])
    plane = aircraft.load("silver-fox")
    task = Problem(load(problem["terrain"]), *ends, plane, zones=zones, as_paper=True)
    terms = Evaluator(task, threads=1).evaluate(np.array(path)).to_dict()
    return {key: float(value) for key, value in terms.items()}


#: Parts that are integers. The fixed paths and their problems stay.
GOLDEN_PARTS: dict[str, Callable[[], Any]] = {
    "generations": golden_generations,
    "paths": golden_paths,
}


def main() -> None:
    """Write the goldens."""
    kept = json.loads(GOLDENS.read_text())
    for fixed in kept["fitness"]:
        fixed["terms"] = evaluate(kept["problems"][fixed["map"]], fixed["path"])
    kept |= {name: make() for name, make in GOLDEN_PARTS.items()}
    GOLDENS.write_text(json.dumps(kept, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main()
