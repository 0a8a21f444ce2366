"""The planner core compared with ``astar`` on generated ground that was not used for tuning."""

from __future__ import annotations

import dataclasses
from statistics import mean
from typing import Any

from bench.campaign import measure
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import HELD_OUT, SYNTHETIC, problem
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners.base import Options
from pathgene.host.problem.rules import Rules


_MOST_SEEDS = 5
_YARDSTICK = "astar"
#: Columns of the tables: planners with their options.
VARIANTS: dict[str, tuple[str, dict[str, Any]]] = {
    _YARDSTICK: ("astar", {}),
    "ga-chip unpolished, 10 ms": ("ga-chip", {"chip_ms": 10, "polish": "off"}),
    "ga-chip polished, 10 ms": ("ga-chip", {"chip_ms": 10, "polish": "on"}),
    "ga-chip unpolished, 50 ms": ("ga-chip", {"chip_ms": 50, "polish": "off"}),
    "ga-chip polished, 50 ms": ("ga-chip", {"chip_ms": 50, "polish": "on"}),
}
#: Titles of the tables by the clearance; None stands for paper mode.
_TABLES = {"paper mode": None, "with a clearance of 30 m": 30.0}

#: Problem, clearance, variant and seed of a plan.
_Task = tuple[str, float | None, str, int]


def run(options: BenchOptions) -> Report:
    """Plan every problem by every variant, in paper mode and with a clearance."""
    seeds = min(options.seeds, _MOST_SEEDS)
    reports = []
    tasks = [
        (name, clearance_m, variant, seed)
        for clearance_m in _TABLES.values()
        for name in HELD_OUT
        for variant in VARIANTS
        for seed in range(1 if variant == _YARDSTICK else seeds)
    ]
    fitness = measure(
        "held-out",
        [(task,) for task in tasks],
        _fitness,
        name=lambda task: f"{task[0][0]}, clearance {task[0][1]}",
        prepare=_compile,
    )
    found = dict(zip(tasks, fitness, strict=True))
    for title, clearance_m in _TABLES.items():
        reports.append(_table(title, clearance_m, found, seeds))
    return dataclasses.replace(reports[0], further=reports[1:])


def _compile() -> None:
    for variant in VARIANTS:
        _fitness((SYNTHETIC[0], None, variant, 0), generations=2)


def _fitness(task: _Task, generations: int | None = None) -> float | None:
    """Return F of a plan's path; None if it has no feasible path."""
    name, clearance_m, variant, seed = task
    planner, own = VARIANTS[variant]
    rules = None if clearance_m is None else Rules(clearance_m=clearance_m)
    evaluator = Evaluator(dataclasses.replace(problem(name), rules=rules), threads=1)
    options = Options(seed=seed, generations=generations or PLANNERS[planner].generations)
    evaluation = make(planner, **own).plan(evaluator, options).evaluation
    return evaluation.fitness if evaluation.feasible else None


def _table(
    title: str, clearance_m: float | None, found: dict[_Task, float | None], seeds: int
) -> Report:
    report = Report(
        f"Mean F on held-out ground, {title}, {seeds} seeds",
        ("problem", *VARIANTS),
        notes=[
            "Generated ground, whose seeds were not used for any choice. Plans on the chip's "
            "model, whose time is the modelled cycles at 100 MHz. Mean F of the feasible paths; a "
            "share in brackets says how many seeds found one, where some did not. Unpolished: the "
            "chip's best path as it is; polished: moved by the host."
        ],
    )
    means: dict[str, list[float]] = {variant: [] for variant in VARIANTS}
    for name in HELD_OUT:
        cells = []
        for variant in VARIANTS:
            values = [
                value
                for (problem_name, clearance, planned, _), value in found.items()
                if (problem_name, clearance, planned) == (name, clearance_m, variant)
            ]
            feasible = [value for value in values if value is not None]
            means[variant].append(mean(feasible) if feasible else 0.0)
            share = "" if len(feasible) == len(values) else f" ({len(feasible)}/{len(values)})"
            cells.append(f"{means[variant][-1]:.4f}{share}" if feasible else "none")
        report.rows.append((name, *cells))
    better = [
        sum(own > other for own, other in zip(values, means[_YARDSTICK], strict=True))
        for values in means.values()
    ]
    report.rows.append(
        ("better than astar", "-", *(f"{count} of {len(HELD_OUT)}" for count in better[1:]))
    )
    return report
