"""Quality of the paths: every planner on every scenario, both initial populations, many seeds."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import mean, stdev
from typing import Any

from scipy.stats import ttest_rel

from bench.campaign import measure
from bench.own_paths import own_path
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import SYNTHETIC, missing, names, problem
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners.base import Options


#: The planner that every planner is compared with.
_YARDSTICK = "astar"

Outcome = dict[str, Any]


@dataclass(frozen=True)
class Variant:
    """A planner with its options, and its ``name`` in the table."""

    name: str
    planner: str
    options: dict[str, Any]


def _variants() -> list[Variant]:
    """Return every planner, with both initial populations if it can, and the paper's ga-fpga."""
    variants = []
    for name, entry in PLANNERS.items():
        inits = ({"init": "random"}, {"init": "astar"}) if "init" in entry.options else ({},)
        for options in inits:
            title = f"{name} from astar" if options.get("init") == "astar" else name
            variants.append(Variant(title, name, {**own_path(name), **options}))
        if "initial_draws" in entry.options:
            variants.append(Variant(f"{name} as the paper", name, {"initial_draws": 1}))
    return variants


#: The rows of the table.
VARIANTS = tuple(_variants())


def run(options: BenchOptions) -> Report:
    """Run every variant on every available scenario."""
    report = Report(
        f"Quality: {options.seeds} seeds, each planner's own number of generations, paper mode",
        (
            "terrain",
            "planner",
            "feasible",
            "mean F",
            "deviation",
            "best F",
            "gain over astar",
            "paired p",
            "evaluations",
            "CPU seconds",
        ),
    )
    if not any(options.only in variant.name for variant in VARIANTS):
        raise InputError(
            f"No planner of the benchmark has {options.only!r} in its name; there are "
            f"{', '.join(variant.name for variant in VARIANTS)}."
        )
    variants = [
        variant
        for variant in VARIANTS
        if variant.name == _YARDSTICK or options.only in variant.name
    ]
    tasks = [
        (name, variant, seed)
        for name in (*names(), *SYNTHETIC)
        for variant in variants
        for seed in range(options.seeds)
    ]
    outcomes = measure(
        "quality",
        tasks,
        _plan,
        name=lambda task: task[0],
        prepare=_compile,
        prepare_arguments=(variants,),
    )
    runs: dict[str, dict[str, list[Outcome]]] = {}
    for (name, variant, _), outcome in zip(tasks, outcomes, strict=True):
        runs.setdefault(name, {}).setdefault(variant.name, []).append(outcome)
    for name, of_terrain in runs.items():
        yardstick = [outcome["fitness"] for outcome in of_terrain[_YARDSTICK]]
        report.rows += [(name, title, *_row(some, yardstick)) for title, some in of_terrain.items()]
    report.notes = [
        "Scenario: start and goal at 8 % and 92 % of both axes, 100 m above ground; two no-fly",
        "circles of 6 % of the straight line at 35 % and 65 % of it; voids filled. F of the path",
        "reported, infeasible ones included; feasible by the strict rule. Gain: mean difference to",
        "astar; p of a paired t-test over the seeds. From astar: --init astar. As the paper:",
        "--initial-draws 1, all else alike. CPU seconds of a run, all threads together, compiling",
        "not counted; evaluations are whole paths.",
        *missing(),
    ]
    report.data = {"runs": runs}
    report.further = [_means(runs), _gains(runs)]
    return report


def _compile(variants: Sequence[Variant]) -> None:
    """Compile all code, or load it from the cache, before anything is timed."""
    evaluator = Evaluator(problem(SYNTHETIC[0]), threads=1)
    for variant in variants:
        make(variant.planner, **variant.options).plan(evaluator, Options(generations=2))


def _plan(name: str, variant: Variant, seed: int) -> Outcome:
    planner = make(variant.planner, **variant.options)
    generations = PLANNERS[variant.planner].generations
    evaluator = Evaluator(problem(name), threads=1)
    # Processor time instead of wall time, because load on the machine hardly affects it.
    start = time.process_time()
    result = planner.plan(evaluator, Options(seed=seed, generations=generations))
    seconds = time.process_time() - start
    feasible = (generation for generation, best, _ in result.history if best > 1)
    return {
        "seed": seed,
        "fitness": result.evaluation.fitness,
        "feasible": result.evaluation.feasible,
        "first_feasible": next(feasible, None),
        "evaluations": result.evaluations,
        "cpu_seconds": seconds,
    }


def _row(outcomes: list[Outcome], yardstick: list[float]) -> tuple[object, ...]:
    """Return a planner's row for a terrain; ``yardstick`` has astar's F for the same seeds."""
    fitness = [outcome["fitness"] for outcome in outcomes]
    gains = [value - other for value, other in zip(fitness, yardstick, strict=True)]
    # Without spread, no test applies.
    spread = len(gains) > 1 and stdev(gains) > 0
    p_value = float(ttest_rel(fitness, yardstick).pvalue) if spread else "-"
    return (
        f"{sum(outcome['feasible'] for outcome in outcomes)}/{len(outcomes)}",
        f"{mean(fitness):.4f}",
        stdev(fitness) if len(fitness) > 1 else 0.0,
        f"{max(fitness):.4f}",
        f"{mean(gains):+.4f}",
        p_value,
        mean(outcome["evaluations"] for outcome in outcomes),
        mean(outcome["cpu_seconds"] for outcome in outcomes),
    )


def _means(runs: Mapping[str, Mapping[str, list[Outcome]]]) -> Report:
    """Return the mean F of each planner by terrain; ``runs`` are indexed by terrain and planner."""
    report = Report("Mean F of each planner", ("planner", *runs, "CPU seconds"))
    for title in next(iter(runs.values())):
        cells, seconds = [], []
        for by_planner in runs.values():
            outcomes = by_planner[title]
            feasible = sum(outcome["feasible"] for outcome in outcomes)
            share = "" if feasible == len(outcomes) else f" ({feasible}/{len(outcomes)})"
            cells.append(f"{mean(outcome['fitness'] for outcome in outcomes):.4f}{share}")
            seconds.append(mean(outcome["cpu_seconds"] for outcome in outcomes))
        report.rows.append((title, *cells, f"{min(seconds):.1f} to {max(seconds):.1f}"))
    return report


def _gains(runs: Mapping[str, Mapping[str, list[Outcome]]]) -> Report:
    """Return the gain of each planner that starts from the yardstick's path, by terrain."""
    report = Report(f"Gain over {_YARDSTICK}", ("planner", *runs))
    for title in next(iter(runs.values())):
        if not title.endswith(f"from {_YARDSTICK}"):
            continue
        cells = []
        for by_planner in runs.values():
            yardstick = [outcome["fitness"] for outcome in by_planner[_YARDSTICK]]
            *_, gain, p_value, _, _ = _row(by_planner[title], yardstick)
            doubt = f" (p={p_value:.2g})" if isinstance(p_value, float) and p_value >= 0.01 else ""
            cells.append(f"{gain}{doubt}")
        report.rows.append((title, *cells))
    return report
