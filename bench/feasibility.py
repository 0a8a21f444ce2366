"""Cycles of the collision checker's builds by the simulated gateware, and by the paper.

The paper does not publish its map and waypoints. The testing trajectory has the properties that the
paper states (*allaire two-tier*, section 4): segments of 55 and 100 cells, which span the first
2,500 m of the map, then a segment past a mountain. Every cell of it is clear in the detailed map;
the sixth cell on the coarse map is not.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bench.report import Options, Report
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.host.device.chip_map import padded_map
from pathgene.host.terrain.synthetic import large_canyon
from pathgene.sim.harness import VerilatedChecker
from pathgene.sim.model.checker import Point, TerrainModel, paper_cycles, segment_cells
from pathgene.sim.model.checker_cycles import batch_cycles


#: Seed of :func:`pathgene.host.terrain.synthetic.large_canyon`.
CANYON_SEED = 0

#: Aircraft, two waypoints and goal in cells and altitude steps. A random search found this path
#: with the paper's cell counts; every verdict has a margin of at least 20 steps.
TESTING_TRAJECTORY = ((390, 328, 115), (336, 297, 158), (237, 254, 172), (167, 161, 343))


def canyon_map() -> NDArray[np.uint16]:
    """Return the canyon's (500, 500) uint16 altitudes [y, x] in metres, one cell per node.

    Altitudes are rounded up. The paper scales its canyon from 80 km to 8 km, with cells of 16 m,
    and keeps its height of 3,500 m.
    """
    return np.ceil(large_canyon(CANYON_SEED).elevation).astype(np.uint16)


#: Every build, with its cells per cycle.
_BUILDS = (
    (CheckerBuild.TWO_TIER, 1),
    *((CheckerBuild.PARALLEL, lanes) for lanes in (1, 2, 4, 8, 16)),
)
# Table 2 and section 5.1.3 of allaire two-tier, in cycles of 8 ns.
_PAPER_CYCLES, _PAPER_CLOCK_S, _PAPER_CELLS_PER_US = 171, 8e-9, 100.0
_PAPER_SEGMENTS = 55, 100, 6
_PAPER_CELLS = sum(_PAPER_SEGMENTS)
_PATHS = 400
_SEED = 2011

Path = Sequence[Point]


def run(options: Options) -> Report:
    """Check the testing trajectory, then queues of paths over open ground and the canyon."""
    report = Report(
        "Collision checker on the simulated gateware",
        (
            "build",
            "lanes",
            "testing trajectory, cycles",
            "predicted",
            "microseconds",
            "reads",
            "cells per cycle, open ground",
            "cycles per path, canyon",
        ),
    )
    report.rows.append(
        (
            "paper",
            1,
            _PAPER_CYCLES,
            paper_cycles(_PAPER_CELLS, segments=3),
            _PAPER_CYCLES * _PAPER_CLOCK_S * 1e6,
            _PAPER_CELLS,
            _PAPER_CELLS_PER_US * 1e6 * _PAPER_CLOCK_S,
            "-",
        )
    )
    canyon = padded_map(canyon_map(), Config())
    rng = np.random.default_rng(_SEED)
    mixed = [_mixed(rng) for _ in range(_PATHS)]
    flights = [_flight(rng, canyon) for _ in range(_PATHS)]
    free: dict[str, int] = {}
    for build, lanes in _BUILDS:
        config = Config(checker=build, lanes=lanes)
        terrain = TerrainModel(config)
        terrain.write(0, 0, canyon)
        [(predicted, _)] = batch_cycles(config, terrain, [TESTING_TRAJECTORY])
        with VerilatedChecker(config) as checker:
            checker.write(canyon)
            if build is CheckerBuild.TWO_TIER:
                report.notes.append(_table_2([_cycles(checker, number) for number in (1, 2, 3)]))
            trajectory = checker.check([TESTING_TRAJECTORY]).verdicts[0]
            over_canyon = checker.check(flights).verdicts
            sustained = _over_level_ground(checker, mixed)
        free[build] = sum(not verdict["collision"] for verdict in over_canyon)
        report.rows.append(
            (
                build.value,
                lanes,
                trajectory["cycles"],
                predicted,
                trajectory["cycles"] / config.clock_hz * 1e6,
                trajectory["reads"],
                sustained,
                sum(verdict["cycles"] for verdict in over_canyon) / _PATHS,
            )
        )
    cells_of = [segment_cells(*ends) for ends in itertools.pairwise(TESTING_TRAJECTORY)]
    report.notes += [
        f"Testing trajectory: segments of {', '.join(map(str, cells_of))} cells. The two-tier "
        "build stops at the sixth coarse cell of the third, as the paper's does; the parallel "
        "build finds it free. Predicted: cycles of the software models; "
        "microseconds at 125 MHz for the paper and at 100 MHz for the rest.",
        f"Open ground: a queue of {_PATHS} paths of 1 to 17 segments, each of 1 to 101 cells, "
        "all free.",
        f"Canyon: a queue of {_PATHS} paths of 2 to 16 waypoints from 500 to 2500 m above the "
        f"ground, free: {', '.join(f'{count} {build}' for build, count in free.items())}.",
    ]
    return report


def _cycles(checker: VerilatedChecker, segments: int) -> int:
    """Return the cycles of the first segments of the testing trajectory."""
    cycles: int = checker.check([TESTING_TRAJECTORY[: segments + 1]]).verdicts[0]["cycles"]
    return cycles


def _table_2(parts: Sequence[int]) -> str:
    """Return a note comparing the steps in the paper's table 2 with the two-tier build's cycles."""
    first, second, third = _PAPER_SEGMENTS
    paper = [
        paper_cycles(sum(_PAPER_SEGMENTS[:segments]), segments=segments) for segments in (1, 2, 3)
    ]
    return (
        f"Table 2, cycles: 4 to capture the path, {first} for the first segment, 3 to change, "
        f"{second} for the second, 3 to change, {third} for the third: {_listed(paper)} after each "
        f"segment. The two-tier build: {_listed(parts)}."
    )


def _listed(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers))


def cells_per_cycle(config: Config) -> float:
    """Return the sustained rate of a build over open ground, as in the table."""
    rng = np.random.default_rng(_SEED)
    with VerilatedChecker(config) as checker:
        return _over_level_ground(checker, [_mixed(rng) for _ in range(_PATHS)])


def _over_level_ground(checker: VerilatedChecker, paths: Sequence[Path]) -> float:
    edge = Config().map_size
    checker.write(np.zeros((edge, edge), np.uint16))
    verdicts = checker.check(paths).verdicts
    cells = sum(verdict["cells"] for verdict in verdicts)
    return cells / sum(verdict["cycles"] for verdict in verdicts)


def _mixed(rng: np.random.Generator) -> Path:
    """Return a path of short and long segments in every direction, above ground of altitude 0."""
    edge = Config().map_size - 1
    steps = rng.integers(-100, 101, (rng.integers(2, 19), 2))
    steps[0] = rng.integers(0, edge + 1, 2)
    across = np.cumsum(steps, axis=0)
    # Mirrored at the edges of the map.
    across = edge - np.abs(across % (2 * edge) - edge)
    return [(int(x), int(y), int(rng.integers(1, 4095))) for x, y in across]


def _flight(rng: np.random.Generator, heights: NDArray[np.uint16]) -> Path:
    """Return a path across the canyon to the north-east, over the ground at its points."""
    waypoints = int(rng.integers(2, 17))
    along = np.sort(rng.uniform(30, 470, waypoints + 2))
    across = np.stack([along, along], axis=1) + rng.integers(-40, 41, (waypoints + 2, 2))
    points = across.clip(0, 499).astype(int)
    return [
        (int(x), int(y), min(4094, int(heights[y, x]) + int(rng.integers(500, 2500))))
        for x, y in points
    ]
