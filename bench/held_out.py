"""The planner core compared with ``astar`` on generated ground that was not used for tuning."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator
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
# A plan by the chip alone, and one that may report the route of astar.
_OWN, _WITH_ASTAR = "ga-chip polished, 10 ms", "ga-chip and astar's route, 10 ms"
#: Columns of the tables: planners with their options.
VARIANTS: dict[str, tuple[str, dict[str, Any]]] = {
    _YARDSTICK: ("astar", {}),
    "ga-chip unpolished, 10 ms": ("ga-chip", {"chip_ms": 10, "polish": "off"}),
    _OWN: ("ga-chip", {"chip_ms": 10, "polish": "chip"}),
    "ga-chip unpolished, 50 ms": ("ga-chip", {"chip_ms": 50, "polish": "off"}),
    "ga-chip polished, 50 ms": ("ga-chip", {"chip_ms": 50, "polish": "chip"}),
    _WITH_ASTAR: ("ga-chip", {"chip_ms": 10, "polish": "on"}),
}
#: Titles of the tables by the clearance; None stands for paper mode.
_TABLES = {"paper mode": None, "with a clearance of 30 m": 30.0}

#: Problem, clearance, variant and seed of a plan.
_Task = tuple[str, float | None, str, int]


@dataclasses.dataclass(frozen=True)
class Outcome:
    """F of a plan's path, None if it has no feasible path; whose route it is; processor seconds."""

    fitness: float | None
    route_from: str | None
    seconds: float


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
    outcomes = measure(
        "held-out",
        [(task,) for task in tasks],
        plan,
        name=lambda task: f"{task[0][0]}, clearance {task[0][1]}",
        prepare=_compile,
    )
    found = dict(zip(tasks, outcomes, strict=True))
    for title, clearance_m in _TABLES.items():
        reports.append(_table(title, clearance_m, found, seeds))
    reports.append(_routes(found))
    return dataclasses.replace(reports[0], further=reports[1:])


def _compile() -> None:
    for variant in VARIANTS:
        plan((SYNTHETIC[0], None, variant, 0), generations=2)


def plan(task: _Task, generations: int | None = None) -> Outcome:
    """Return the outcome of a plan."""
    name, clearance_m, variant, seed = task
    planner, own = VARIANTS[variant]
    rules = None if clearance_m is None else Rules(clearance_m=clearance_m)
    evaluator = Evaluator(dataclasses.replace(problem(name), rules=rules), threads=1)
    options = Options(seed=seed, generations=generations or PLANNERS[planner].generations)
    # Processor time instead of wall time, because load on the machine hardly affects it.
    began = time.process_time()
    result = make(planner, **own).plan(evaluator, options)
    return Outcome(
        result.evaluation.fitness if result.evaluation.feasible else None,
        (result.hardware or {}).get("route_from"),
        time.process_time() - began,
    )


def _table(
    title: str, clearance_m: float | None, found: dict[_Task, Outcome], seeds: int
) -> Report:
    report = Report(
        f"Mean F on held-out ground, {title}, {seeds} seeds",
        ("problem", *VARIANTS),
        notes=[
            "Generated ground, whose seeds were not used for any choice. Plans on the chip's "
            "model, whose time is the modelled cycles at 100 MHz. Mean F of the feasible paths; a "
            "share in brackets says how many seeds found one, where some did not. Unpolished: the "
            "chip's best path as it is; polished: moved by the host. In the last column the host "
            "also polishes the route of astar, and the better path counts."
        ],
    )
    means: dict[str, list[float]] = {variant: [] for variant in VARIANTS}
    for name in HELD_OUT:
        cells = []
        for variant in VARIANTS:
            values = [each.fitness for each in _of(found, clearance_m, variant, name)]
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


def _of(
    found: dict[_Task, Outcome], clearance_m: float | None, variant: str, name: str
) -> Iterator[Outcome]:
    """Yield the outcomes of a variant for a problem, in the order of the seeds."""
    for (problem_name, clearance, planned, _), outcome in found.items():
        if (problem_name, clearance, planned) == (name, clearance_m, variant):
            yield outcome


def _routes(found: dict[_Task, Outcome]) -> Report:
    """Return how often the route of astar is the better one, and the seconds it costs."""
    report = Report(
        "The route of astar beside the chip's, 10 ms of chip",
        ("rules", "plans", "route of astar", "below astar", "CPU s without it", "CPU s"),
        notes=[
            "Route of astar: plans whose reported path is its polished route. Below astar: plans "
            "whose F is below F of astar by more than 0.0001. CPU seconds: mean of a plan, "
            "all threads."
        ],
    )
    for title, clearance_m in _TABLES.items():
        own: list[Outcome] = []
        plans: list[Outcome] = []
        lower = 0
        for name in HELD_OUT:
            (yardstick,) = _of(found, clearance_m, _YARDSTICK, name)
            own += _of(found, clearance_m, _OWN, name)
            of_problem = list(_of(found, clearance_m, _WITH_ASTAR, name))
            lower += sum(
                (each.fitness or 0.0) < (yardstick.fitness or 0.0) - 1e-4 for each in of_problem
            )
            plans += of_problem
        report.rows.append(
            (
                title,
                len(plans),
                sum(each.route_from == "astar" for each in plans),
                lower,
                f"{mean(each.seconds for each in own):.2f}",
                f"{mean(each.seconds for each in plans):.2f}",
            )
        )
    return report
