"""Evaluations per second of one core, on the paths that planners meet."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import EMBEDDED, problem
from host.evaluation import Evaluator
from host.planners import make
from host.planners.base import Options


__all__ = ["run"]

_RANDOM_PATHS, _RANDOM_WAYPOINTS = 32, 8


def run(options: BenchOptions) -> Report:
    """Evaluate final populations of many seeds and random paths, each once, on one thread."""
    scenario = problem(EMBEDDED)
    evaluator = Evaluator(scenario, threads=1)
    paths = [
        path
        for seed in range(options.seeds)
        for _, path in make("ga-fpga").plan(evaluator, Options(seed=seed)).archive[:32]
    ]
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
        "Evaluation",
        ("terrain", "paths", "ds m", "evaluations per second and core"),
        [(terrain.name, len(paths), float(scenario.ds_m), len(paths) / seconds)],
        [
            "The best 32 paths of each seed of ga-fpga and 32 random ones of 8 waypoints, each",
            "once; processor time of one thread, no caching, no early rejection.",
        ],
    )
