"""Other projects' optimizers and planners on the same problem, compared with ``fpa-2opt``."""

from __future__ import annotations

import importlib.util
import math
import sys
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib import metadata
from statistics import mean
from typing import NamedTuple

import numpy as np

from bench.peers.optimizers import (
    OPTIMIZERS,
    PLANNERS,
    POPULATION,
    BudgetSpentError,
    Objective,
    Optimizer,
    solve,
)
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import problem_at_one_cell
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.base import Options


MAP = "canyon"
WAYPOINTS = 6
_ITERATIONS = 500
_MOST_SEEDS = 5


@dataclass(frozen=True)
class _Outcome:
    """The result of one run.

    ``early`` is the fitness after the seconds that ``fpa-2opt`` takes; ``late`` is the fitness of a
    run with as many evaluations as ``fpa-2opt`` has candidates, whether or not these were evaluated
    in full.
    """

    fitness: float
    feasible: bool
    evaluations: int
    seconds: float
    early: float
    late: float = math.nan


class _Rates(NamedTuple):
    """Candidates per second of ``fpa-2opt``, with early rejection and with full evaluation."""

    judged: float
    full: float


def run(options: BenchOptions, *, iterations: int = _ITERATIONS) -> Report:
    """Run every installed peer with as many evaluations, or seconds, as ``fpa-2opt`` takes."""
    report = Report(
        f"Peers on {MAP}, {WAYPOINTS} free waypoints, ds one cell, paper mode",
        (
            "planner",
            "hands over",
            "full evaluations",
            "seconds",
            "full evaluations/s",
            "fpa-2opt's all in full, times as many",
            "fpa-2opt's judged, times as many",
            "feasible",
            "mean F",
            "mean F in fpa-2opt's seconds",
            "mean F of as many as fpa-2opt judges",
        ),
    )
    seeds = range(min(options.seeds, _MOST_SEEDS))
    evaluator = Evaluator(problem_at_one_cell(MAP))
    _ours(evaluator, 0, 40)  # Compiles.
    ours = [_ours(evaluator, seed, iterations) for seed in seeds]
    evaluations = round(mean(outcome.evaluations for outcome in ours))
    seconds = mean(outcome.seconds for outcome in ours)
    # The speed of full evaluations, too, because an aborted candidate takes time but does not
    # count.
    full = [_ours(evaluator, seed, iterations, give_up=False) for seed in seeds]
    judged = round(mean(outcome.evaluations for outcome in full))
    # The same candidates are evaluated with and without early rejection.
    rates = _Rates(
        judged=mean(
            whole.evaluations / outcome.seconds for outcome, whole in zip(ours, full, strict=True)
        ),
        full=mean(whole.evaluations / whole.seconds for whole in full),
    )
    _add(report, "fpa-2opt", "batches", ours, rates)
    _add(report, "fpa-2opt, all in full", "batches", full, rates)
    missing = set()
    for name, optimizer in OPTIMIZERS.items():
        if importlib.util.find_spec(optimizer.package) is None:
            missing.add(optimizer.package)
            continue
        outcomes = [
            replace(
                _optimized(optimizer, evaluator, seed, evaluations, seconds),
                late=_optimized(optimizer, evaluator, seed, judged, seconds).fitness,
            )
            for seed in seeds
        ]
        hands_over = "batches" if optimizer.batches else "path by path"
        _add(report, f"{name} {metadata.version(optimizer.package)}", hands_over, outcomes, rates)
    for name in PLANNERS:
        if importlib.util.find_spec("ompl") is None:
            missing.add("ompl")
            continue
        outcomes = [_sampled(name, evaluator, seed, seconds) for seed in seeds]
        _add(report, f"OMPL {name} {metadata.version('ompl')}", "points", outcomes, rates)
    report.notes = [
        f"Means of {len(seeds)} seeds. fpa-2opt: table 3 of roberge, all cores. The optimizers",
        f"have {POPULATION} solutions, as many full evaluations as fpa-2opt (whose candidates cut",
        "short are not counted), and our evaluation on all cores where they hand over batches.",
        "All in full: the same run without cutting short; the peers' rates are compared with its,",
        "and with all candidates that fpa-2opt judges, whether in full or cut short. The last",
        "column is of a run of as many full evaluations as those.",
        "OMPL's planners get as many seconds: they know the airspace, but minimize length.",
    ]
    if missing:
        report.notes.append(
            f"Not installed, so left out: {', '.join(sorted(missing))} (pip install '.[peers]')."
        )
    return report


def _ours(evaluator: Evaluator, seed: int, iterations: int, *, give_up: bool = True) -> _Outcome:
    planner = make("fpa-2opt", waypoints=WAYPOINTS, give_up=give_up)
    options = Options(seed=seed, generations=iterations, population=POPULATION)
    result = planner.plan(evaluator, options)
    found = result.evaluation
    return _Outcome(
        found.fitness,
        found.feasible,
        result.evaluations,
        result.seconds["total"],
        found.fitness,
        found.fitness,
    )


def _optimized(
    optimizer: Optimizer, evaluator: Evaluator, seed: int, evaluations: int, seconds: float
) -> _Outcome:
    objective = Objective(evaluator, WAYPOINTS, evaluations)
    started = time.perf_counter()
    with suppress(BudgetSpentError):
        optimizer.run(objective, seed, evaluations)
    spent = time.perf_counter() - started
    found = evaluator.evaluate(objective.best)
    return _Outcome(
        found.fitness,
        found.feasible,
        objective.evaluations,
        spent,
        objective.fitness_after(seconds),
    )


def _sampled(planner: str, evaluator: Evaluator, seed: int, seconds: float) -> _Outcome:
    started = time.perf_counter()
    path = solve(evaluator, planner, seed, seconds)
    spent = time.perf_counter() - started
    if path is None:
        path = np.array([evaluator.problem.start, evaluator.problem.goal])
    found = evaluator.evaluate(path)
    return _Outcome(found.fitness, found.feasible, 0, spent, found.fitness)


def _add(
    report: Report, name: str, hands_over: str, outcomes: list[_Outcome], ours: _Rates
) -> None:
    count, seconds = (
        mean(getattr(outcome, what) for outcome in outcomes) for what in ("evaluations", "seconds")
    )
    rate = count / seconds
    report.rows.append(
        (
            name,
            hands_over,
            round(count) if count else "-",
            seconds,
            rate if count else "-",
            ours.full / rate if count else "-",
            ours.judged / rate if count else "-",
            f"{sum(outcome.feasible for outcome in outcomes)}/{len(outcomes)}",
            mean(outcome.fitness for outcome in outcomes),
            mean(outcome.early for outcome in outcomes),
            "-" if math.isnan(outcomes[0].late) else mean(outcome.late for outcome in outcomes),
        )
    )
    print(f"peers: {name} done", file=sys.stderr, flush=True)
