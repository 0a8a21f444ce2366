"""How good the paths are: ga-fpga on the software model and ga-pc, over terrains and seeds."""

from __future__ import annotations

import sys
from math import ceil
from statistics import mean

from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import names, problem
from host.evaluation import Evaluator
from host.planners import make
from host.planners.base import Options, Result


__all__ = ["TARGETS", "run"]

#: Mean best fitness of a trial with the paper's operators in floating point, 300 generations.
TARGETS = {
    "himalaya": 1.49,
    "tujunga": 1.485,
    "cdem": 1.48,
    "st-helens": 1.46,
    "alps": 1.44,
    "jervis": 1.31,
}
_GENERATIONS = 300


def run(options: BenchOptions) -> Report:
    """Run both planners on every scenario that is there, with as many evaluations each."""
    report = Report(
        f"Quality: {options.seeds} seeds, {_GENERATIONS} generations, population 32",
        (
            "terrain",
            "ga-fpga feasible",
            "ga-fpga mean F",
            "as the paper: feasible",
            "as the paper: mean F",
            "trial's mean F",
            "ga-pc feasible",
            "ga-pc mean F",
            "feasible by generation (median)",
        ),
    )
    runs: dict[str, dict[str, list[dict[str, float]]]] = {}
    for name in names():
        evaluator = Evaluator(problem(name))
        seeds = range(options.seeds)
        fpga = [_plan("ga-fpga", evaluator, seed, _GENERATIONS) for seed in seeds]
        plain = [
            _plan("ga-fpga", evaluator, seed, _GENERATIONS, initial_draws=1) for seed in seeds
        ]
        # The host evaluates the first population and then the children of every generation.
        budget = fpga[0].evaluations
        pc = [_plan_budget("ga-pc", evaluator, seed, budget) for seed in seeds]
        first = sorted(_first_feasible(result) for result in fpga)
        report.rows.append(
            (
                name,
                f"{sum(result.evaluation.feasible for result in fpga)}/{len(fpga)}",
                mean(result.evaluation.fitness for result in fpga),
                f"{sum(result.evaluation.feasible for result in plain)}/{len(plain)}",
                mean(result.evaluation.fitness for result in plain),
                TARGETS.get(name, "-"),
                f"{sum(result.evaluation.feasible for result in pc)}/{len(pc)}",
                mean(result.evaluation.fitness for result in pc),
                first[len(first) // 2],
            )
        )
        runs[name] = {
            planner: [
                {
                    "seed": seed,
                    "fitness": result.evaluation.fitness,
                    "feasible": result.evaluation.feasible,
                    "first_feasible": _first_feasible(result),
                    "evaluations": result.evaluations,
                }
                for seed, result in enumerate(results)
            ]
            for planner, results in (("ga-fpga", fpga), ("as the paper", plain), ("ga-pc", pc))
        }
        print(f"quality: {name} done", file=sys.stderr, flush=True)
    report.notes = [
        "Scenario: start and goal at 8 % and 92 % of both axes, 100 m above ground; two no-fly",
        "circles of 6 % of the straight line at 35 % and 65 % of it; voids filled. F of the path",
        "reported, infeasible ones included; feasible by the strict rule. ga-pc has as many",
        "evaluations as ga-fpga, or up to a generation more. As the paper: ga-fpga",
        "with --initial-draws 1, all else alike.",
    ]
    report.data = {"runs": runs}
    return report


def _plan(
    planner: str, evaluator: Evaluator, seed: int, generations: int, **own: int
) -> Result:
    return make(planner, **own).plan(evaluator, Options(seed=seed, generations=generations))


def _plan_budget(planner: str, evaluator: Evaluator, seed: int, evaluations: int) -> Result:
    """Run ``planner`` until it has used ``evaluations``, to the next whole generation."""
    few = _plan(planner, evaluator, seed, 2)
    per_generation = (few.evaluations - 32) / 2
    return _plan(planner, evaluator, seed, max(1, ceil((evaluations - 32) / per_generation)))


def _first_feasible(result: Result) -> int:
    for generation, best, _ in result.history:
        if best > 1:
            return int(generation)
    return int(result.history[-1][0]) + 1
