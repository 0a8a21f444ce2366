"""Evaluations per second on one core, milliseconds of the strict rule, cost of a clearance."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from bench.report import Options as BenchOptions
from bench.report import Report
from bench.rules import clearance_table, strict_table
from bench.scenarios import EMBEDDED, problem
from pathgene.host.device.boards import open_board
from pathgene.host.device.chip import Chip
from pathgene.host.device.waypoints import unpack_waypoints
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.allaire.ga_fpga import FpgaGeneticPlanner
from pathgene.host.planners.base import Options
from pathgene.host.problem.chip_map import ChipMap


__all__ = ["run"]

_RANDOM_PATHS, _RANDOM_WAYPOINTS = 32, 8
# Maximum number of plans without and with a clearance, and of calls of the strict rule, per
# planner.
_MOST_ROUNDS, _REPEATS = 9, 200


def run(options: BenchOptions) -> Report:
    """Measure on one thread: populations in paper mode, single paths by the strict rule, plans."""
    report = _populations(options.seeds)
    clearance = clearance_table(min(options.seeds, _MOST_ROUNDS))
    report.further = [strict_table(_REPEATS), clearance]
    report.data = clearance.data
    return report


def _populations(seeds: int) -> Report:
    """Evaluate final populations of many seeds and random paths, each once."""
    scenario = problem(EMBEDDED)
    evaluator = Evaluator(scenario, threads=1)
    paths = [path for seed in range(seeds) for path in _final_population(evaluator, seed)]
    rng = np.random.default_rng(0)
    terrain = scenario.terrain
    for _ in range(_RANDOM_PATHS):
        inner = rng.random((_RANDOM_WAYPOINTS, 3))
        inner *= terrain.width_m, terrain.height_m, terrain.highest - terrain.lowest
        inner[:, 2] += terrain.lowest
        paths.append(np.concatenate(([scenario.start], inner, [scenario.goal])))
    lengths = np.array([len(path) for path in paths])
    padded: NDArray[np.float64] = np.zeros((len(paths), int(lengths.max()), 3))
    for row, path in zip(padded, paths, strict=True):
        row[: len(path)] = path
    evaluator.fitness(padded[:2], lengths[:2])
    started = time.process_time()
    evaluator.fitness(padded, lengths)
    seconds = time.process_time() - started
    return Report(
        "Evaluation, paper mode",
        ("terrain", "paths", "ds m", "evaluations per second and core"),
        [(terrain.name, len(paths), float(scenario.ds_m), len(paths) / seconds)],
        [
            "Final population of each seed of ga-fpga, and 32 random paths of 8 waypoints, each",
            "once; processor time of one thread, no caching, no early rejection.",
        ],
    )


def _final_population(evaluator: Evaluator, seed: int) -> list[NDArray[np.float64]]:
    chips: list[Chip] = []

    def keep(url: str) -> Chip:
        chips.append(open_board(url))
        return chips[-1]

    scenario = evaluator.problem
    FpgaGeneticPlanner(open_board=keep).plan(evaluator, Options(seed=seed))
    (chip,) = chips
    grid = ChipMap(chip.config, scenario)
    return [
        np.concatenate(
            (
                [scenario.start],
                grid.to_metres(unpack_waypoints(chip.config, path)),
                [scenario.goal],
            )
        )
        for path in chip.paths
    ]
