"""The planner on the chip, on its compiled model: F by time, with and without a clearance."""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from statistics import mean

from bench.chip_runs import CHIP, Outcome, Task, run_all, share, terrains, through_terrains
from bench.report import Options, Report
from bench.scenarios import SYNTHETIC, missing, problem
from host.errors import InputError
from host.evaluation import Evaluator
from host.planners import PLANNERS, make
from host.planners import base as planners
from host.planners.ga_chip import run_options
from host.problem.rules import Rules


__all__ = ["CLEARANCES", "OTHERS", "TIMES_MS", "run"]

#: Milliseconds of chip time.
TIMES_MS = (1, 2, 5, 10, 20, 50, 100)
#: As paper, then clearances in metres.
CLEARANCES = (None, 30.0, 100.0)
#: Planners beside it, and their options.
OTHERS = {
    "ga-fpga": ("ga-fpga", {}),
    "ga-pc": ("ga-pc", {}),
    "fpa-2opt": ("fpa-2opt", {}),
    "astar": ("astar", {}),
    "ga-pc from astar": ("ga-pc", {"init": "astar"}),
    "ga-chip, whole": ("ga-chip", {}),
}
_MOST_SEEDS = 10

_Plan = tuple[str, str, float | None, int]


def run(options: Options) -> Report:
    """Measure the tables whose clearance has ``only`` in its name, all by default."""
    wanted = [each for each in CLEARANCES if options.only in _rules(each)]
    if not wanted:
        raise InputError(
            f"No table has {options.only!r} in its name; there are "
            f"{', '.join(map(_rules, CLEARANCES))}."
        )
    seeds = min(options.seeds, _MOST_SEEDS)
    first, *further = (_table(clearance_m, seeds) for clearance_m in wanted)
    return dataclasses.replace(first, further=[*further, _speed(seeds)])


def _rules(clearance_m: float | None) -> str:
    return "as paper" if clearance_m is None else f"clearance {clearance_m:g} m"


def _table(clearance_m: float | None, seeds: int) -> Report:
    """Return F by chip time, then that of the other planners with their seconds."""
    report = Report(
        f"Mean F, {_rules(clearance_m)}, {seeds} seeds",
        ("planner", *terrains(), "mean", "feasible", "chip ms", "CPU seconds"),
        notes=[
            "A row of the chip is one run of its model, unpolished, at 100 MHz with 8 lanes; its",
            "CPU seconds are those of the model. Whole: the planner ga-chip, with polish, further",
            "seeds where none of a run's paths is feasible, and the map's upload. F is the mean of",
            "the feasible paths; CPU seconds of a plan are of all threads, without compiling.",
            *missing(),
        ],
    )
    for chip_ms in TIMES_MS:
        tasks = [
            Task(
                terrain,
                clearance_m,
                run_options(CHIP, seed=seed, chip_ms=chip_ms, generations=(1 << 32) - 1),
            )
            for terrain in terrains()
            for seed in range(seeds)
        ]
        outcomes = run_all(tasks)
        report.rows.append(_row(f"chip, {chip_ms} ms", outcomes, seeds))
        print(f"chip: {_rules(clearance_m)}, {chip_ms} ms done", file=sys.stderr, flush=True)
    with ProcessPoolExecutor(initializer=_compile) as pool:
        for title in OTHERS:
            plans = [
                (title, terrain, clearance_m, seed)
                for terrain in terrains()
                for seed in range(seeds)
            ]
            report.rows.append(_row(title, list(pool.map(_plan, plans)), seeds))
            print(f"chip: {_rules(clearance_m)}, {title} done", file=sys.stderr, flush=True)
    return report


def _row(title: str, outcomes: Sequence[Outcome], seeds: int) -> tuple[object, ...]:
    by_terrain = [outcomes[at : at + seeds] for at in range(0, len(outcomes), seeds)]
    means, all_means = through_terrains(by_terrain)
    cycles = mean(outcome.cycles for outcome in outcomes)
    return (
        title,
        *means,
        all_means,
        share(outcomes),
        f"{1000 * cycles / CHIP.clock_hz:.2f}" if cycles else "-",
        mean(outcome.seconds for outcome in outcomes),
    )


def _compile() -> None:
    for title in OTHERS:
        _plan((title, SYNTHETIC[0], None, 0), generations=2)


def _plan(task: _Plan, generations: int | None = None) -> Outcome:
    title, terrain, clearance_m, seed = task
    name, own = OTHERS[title]
    rules = None if clearance_m is None else Rules(clearance_m=clearance_m)
    evaluator = Evaluator(dataclasses.replace(problem(terrain), rules=rules), threads=1)
    options = planners.Options(seed=seed, generations=generations or PLANNERS[name].generations)
    # Processor time, not wall time: other load of the machine adds little to it.
    began = time.process_time()
    result = make(name, **own).plan(evaluator, options)
    return Outcome(
        result.evaluation.fitness,
        result.evaluation.feasible,
        result.generations,
        (result.hardware or {}).get("cycles", {}).get("total", 0),
        time.process_time() - began,
    )


def _speed(seeds: int) -> Report:
    """Return the generations that the compiled model runs in a second, and their cycles."""
    report = Report(
        "Speed of the compiled model: runs of 50 ms as paper",
        ("terrain", "generations", "cycles per generation", "generations per second of a core"),
    )
    for terrain in terrains():
        tasks = [
            Task(terrain, None, run_options(CHIP, seed=seed, chip_ms=50, generations=1 << 31))
            for seed in range(seeds)
        ]
        outcomes = run_all(tasks)
        generations = sum(outcome.generations for outcome in outcomes)
        report.rows.append(
            (
                terrain,
                round(generations / len(outcomes)),
                round(sum(outcome.cycles for outcome in outcomes) / generations),
                round(generations / sum(outcome.seconds for outcome in outcomes)),
            )
        )
    return report
