"""Cost of safety: every planner as paper and with three clearances, over nine terrains."""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from pathlib import Path
from statistics import mean
from typing import Any

from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import SYNTHETIC, missing, names, problem
from host.evaluation import Evaluator
from host.planners import PLANNERS, make
from host.planners.base import Options
from host.problem.problem import Problem
from host.problem.rules import Rules
from host.report.files import write_json


__all__ = ["run"]

_MOST_SEEDS = 5
#: The rules of a row; None is as paper.
_CLEARANCES = (None, 0.0, 30.0, 100.0)
_KEPT = Path("build/bench/safety-runs.json")

Outcome = dict[str, Any]


def run(options: BenchOptions) -> Report:
    """Run every planner on every available scenario under every set of rules.

    Finished rows are kept in ``build/bench/safety-runs.json``, so a stopped run can go on.
    """
    seeds = min(options.seeds, _MOST_SEEDS)
    report = Report(
        f"What safety costs: {seeds} seeds, each planner's own number of generations",
        ("terrain", "planner", "rules", "feasible", "mean F", "CPU seconds", "beside paper"),
    )
    kept: dict[str, list[Outcome]] = json.loads(_KEPT.read_text()) if _KEPT.exists() else {}
    for name in (*names(), *SYNTHETIC):
        for planner in (entry for entry in PLANNERS if options.only in entry):
            seconds_as_paper = 0.0
            for clearance_m in _CLEARANCES:
                rules = "as paper" if clearance_m is None else f"{clearance_m:g} m"
                key = f"{name} {planner} {rules} {seeds}"
                if key not in kept:
                    kept[key] = _plans(name, planner, clearance_m, seeds)
                    _KEPT.parent.mkdir(parents=True, exist_ok=True)
                    write_json(_KEPT, kept)
                seconds = mean(outcome["cpu_seconds"] for outcome in kept[key])
                seconds_as_paper = seconds_as_paper or seconds
                feasible = [run["fitness"] for run in kept[key] if run["feasible"]]
                report.rows.append(
                    (
                        name,
                        planner,
                        rules,
                        f"{len(feasible)}/{seeds}",
                        f"{mean(feasible):.4f}" if feasible else "-",
                        seconds,
                        f"{seconds / seconds_as_paper:.2f}",
                    )
                )
        print(f"safety: {name} done", file=sys.stderr, flush=True)
    report.notes = [
        "Scenarios of BENCH=quality: the ends are 100 m above ground, on synthetic land 60 m.",
        "Rules: the clearance, all others by default. F: the mean of feasible paths alone; without",
        "one, no planner may have a path, as an end may break a limit itself (`pathgene diagnose`",
        "tells). CPU seconds of a plan, its problem's rasters included, compiling not counted.",
        *missing(),
    ]
    report.data = {"runs": kept}
    return report


def _plans(name: str, planner: str, clearance_m: float | None, seeds: int) -> list[Outcome]:
    generations = PLANNERS[planner].generations
    _plan(_problem(name, clearance_m), planner, Options(generations=2))
    return [
        _plan(_problem(name, clearance_m), planner, Options(seed=seed, generations=generations))
        for seed in range(seeds)
    ]


def _problem(name: str, clearance_m: float | None) -> Problem:
    """Return a scenario under rules, its rasters not yet made."""
    scenario = problem(name)
    if clearance_m is None:
        return dataclasses.replace(scenario)
    return dataclasses.replace(scenario, rules=Rules(clearance_m=clearance_m))


def _plan(scenario: Problem, planner: str, options: Options) -> Outcome:
    began = time.process_time()
    result = make(planner).plan(Evaluator(scenario, threads=1), options)
    return {
        "fitness": result.evaluation.fitness,
        "feasible": result.evaluation.feasible,
        "cpu_seconds": time.process_time() - began,
    }
