"""Plans with collisions counted by the board, compared with collisions sampled by the host."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import nullcontext
from operator import itemgetter
from statistics import mean
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.campaign import measure
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import missing, names, problem
from pathgene.host.device.boards import open_board
from pathgene.host.evaluation import Evaluator
from pathgene.host.machine import available_cores
from pathgene.host.planners import make
from pathgene.host.planners.allaire.counting import CAUSES, refutation
from pathgene.host.planners.base import Options, Planner
from pathgene.host.problem.problem import Problem


_GENERATIONS = 300
#: Terrains of additional plans on the simulated board.
_SIMULATED = 2

Outcome = dict[str, Any]


def run(options: BenchOptions) -> Report:
    """Run both variants on every available scenario, with the same seeds."""
    report = Report(
        f"Collisions counted on the board, paper mode: {options.seeds} seeds, "
        f"{_GENERATIONS} generations",
        (
            "terrain",
            "host: feasible",
            "host: mean F",
            "board: feasible",
            "board: mean F",
            "counted feasible",
            "not: turn arcs",
            "not: between cells",
            "not: between samples",
            "reported, not feasible",
            "host samples saved",
            "cells counted",
        ),
    )
    runs: dict[str, Any] = {}
    cases = [(name, "model:") for name in names()]
    cases += [(name, "sim:") for name in names()[:_SIMULATED]]
    # A process plans several seeds on one board.
    workers = min(available_cores(), options.seeds)
    tasks = [
        (name, board if way == "board" else "model:", way, range(first, options.seeds, workers))
        for name, board in cases
        for way in ("host", "board")
        for first in range(workers)
    ]
    planned = iter(
        measure("onboard", tasks, _plans, name=lambda task: f"{task[0]}, {task[2]}, {task[1]}")
    )
    for name, board in cases:
        ways: dict[str, list[Outcome]] = {}
        for way in ("host", "board"):
            outcomes = [outcome for _ in range(workers) for outcome in next(planned)]
            ways[way] = sorted(outcomes, key=itemgetter("seed"))
        counted = [outcome["hardware"]["feasibility"] for outcome in ways["board"]]
        report.rows.append(
            (
                f"{name}, on {board}",
                *(_found(ways["host"])),
                *(_found(ways["board"])),
                sum(outcome["claimed"] for outcome in ways["board"]),
                *(sum(outcome["refuted"][cause] for outcome in ways["board"]) for cause in CAUSES),
                sum(
                    outcome["fitness"] > 1 and not outcome["feasible"] for outcome in ways["board"]
                ),
                mean(own["host_samples_saved"] for own in counted),
                mean(own["cells"] for own in counted),
            )
        )
        runs[f"{name} {board}"] = ways
    report.notes = [
        "Scenarios and F as in BENCH=quality. Board: --feasibility board, so the chip counts the",
        "colliding cells of the straight path and its mutations reject points in the ground; every",
        "path that becomes the best is evaluated in full. Counted feasible: different paths of all",
        "runs, each evaluated here by the strict rule of pathgene check. Not feasible: as only",
        "the turn arcs collide, because the straight path does between the cells that the line",
        "visits, or only between the samples at ds. Reported: the result of a run. Saved, counted:",
        "mean of a run. Host: on model:, whichever board the row names.",
        *missing(),
    ]
    report.data = {"runs": runs}
    return report


def _plans(name: str, board: str, way: str, seeds: Sequence[int]) -> list[Outcome]:
    """Plan with each of ``seeds`` on one board, which keeps its map between plans."""
    evaluator = _Recording(problem(name), threads=1)
    with open_board(board) as chip:
        planner = make(
            "ga-fpga", board=board, feasibility=way, open_board=lambda _: nullcontext(chip)
        )
        return [_plan(planner, evaluator, seed) for seed in seeds]


class _Recording(Evaluator):
    """Records the paths that the counts call feasible."""

    def __init__(self, problem: Problem, threads: int) -> None:
        super().__init__(problem, threads=threads)
        self.claimed: dict[bytes, NDArray[np.float64]] = {}

    def fitness_counted(
        self,
        paths: NDArray[np.float64],
        lengths: NDArray[np.integer[Any]],
        counted_m: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """See :meth:`~pathgene.host.evaluation.Evaluator.fitness_counted`."""
        fitness = super().fitness_counted(paths, lengths, counted_m)
        for path, length in zip(paths[fitness > 1], lengths[fitness > 1], strict=True):
            self.claimed[path[:length].tobytes()] = path[:length].copy()
        return fitness


def _plan(planner: Planner, evaluator: _Recording, seed: int) -> Outcome:
    evaluator.claimed.clear()
    result = planner.plan(evaluator, Options(seed=seed, generations=_GENERATIONS))
    refuted = Counter(refutation(evaluator, path) for path in evaluator.claimed.values())
    return {
        "seed": seed,
        "feasible": result.evaluation.feasible,
        "fitness": result.evaluation.fitness,
        "seconds": result.seconds,
        "hardware": result.hardware,
        "claimed": len(evaluator.claimed),
        "refuted": {cause: refuted[cause] for cause in CAUSES},
    }


def _found(outcomes: list[Outcome]) -> tuple[str, float]:
    feasible = sum(outcome["feasible"] for outcome in outcomes)
    return f"{feasible}/{len(outcomes)}", mean(outcome["fitness"] for outcome in outcomes)
