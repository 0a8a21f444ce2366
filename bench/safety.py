"""Cost of safety: every planner in paper mode and with three clearances, over nine terrains.

A row is a terrain, a planner and a set of rules. Results are kept in ``docs/safety.json``
(:class:`bench.store.Store`); ``docs/results.md`` shows them.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median
from typing import Any

from bench import pages
from bench.campaign import measure
from bench.own_paths import own_path
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import SYNTHETIC, missing, names, problem
from bench.store import Store
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners.base import Options
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules


_DOCS = Path(__file__).resolve().parents[1] / "docs"
#: Where the results of all runs are kept.
STORE = _DOCS / "safety.json"
#: Maximum number of seeds of each planner.
MOST_SEEDS = 5
#: The clearance of each set of rules, metres; None in paper mode.
CLEARANCES = (None, 0.0, 30.0, 100.0)

_SOURCES = (
    "bench/scenarios.py",
    "hdl/config.py",
    "host/device",
    "host/evaluation",
    "host/planners",
    "host/problem",
    "host/terrain",
    "sim/model",
)

Outcome = dict[str, Any]


@dataclass(frozen=True)
class Row:
    """A planner on a terrain under a set of rules."""

    terrain: str
    planner: str
    #: Required clearance in metres, with the remaining rules at their defaults; None in paper mode.
    clearance_m: float | None

    @property
    def rules(self) -> str:
        """Name of the set of rules: a column of the table."""
        return "paper mode" if self.clearance_m is None else f"clearance {self.clearance_m:g} m"

    @property
    def name(self) -> str:
        """Name that ``--only`` is compared with."""
        return f"{self.plan} {self.rules}"

    @property
    def plan(self) -> str:
        """Terrain and planner: a line of the table."""
        return f"{self.terrain} {self.planner}"

    def problem(self) -> Problem:
        """Return the problem to plan, without its rasters."""
        rules = None if self.clearance_m is None else Rules(clearance_m=self.clearance_m)
        return dataclasses.replace(problem(self.terrain), rules=rules)


def rows(only: str = "") -> list[Row]:
    """Return the rows with ``only`` in their names, of all available maps."""
    every = [
        Row(terrain, planner, clearance_m)
        for terrain in (*names(), *SYNTHETIC)
        for planner in PLANNERS
        for clearance_m in CLEARANCES
    ]
    return [row for row in every if only in row.name]


def run(options: BenchOptions) -> Report:
    """Measure the rows without stored results; write the tables of all rows to the page.

    Raises
    ------
    InputError
        If no row has the name of ``--only``.
    """
    wanted = rows(options.only)
    if not wanted:
        raise InputError(
            f"No row has {options.only!r} in its name; one is 'canyon astar clearance 30 m'."
        )
    kept = Store(STORE, *_SOURCES)
    _measure_missing(kept, wanted, min(options.seeds, MOST_SEEDS))
    pages.keep("safety", _report(_runs(kept, rows())))
    return _report(_runs(kept, wanted))


def _runs(kept: Store, wanted: Sequence[Row]) -> dict[Row, list[Outcome]]:
    """Return the outcomes of the stored rows."""
    found = {row: kept.get(row.plan, row.rules) for row in wanted}
    return {row: result["outcomes"] for row, result in found.items() if result is not None}


def _measure_missing(kept: Store, wanted: Sequence[Row], seeds: int) -> None:
    """Measure and store the rows that lack results of a seed, one per core."""
    runs = _runs(kept, wanted)
    lacking = [row for row in wanted if len(runs.get(row, ())) < seeds]
    print(f"safety: {len(lacking)} of {len(wanted)} rows to measure", file=sys.stderr, flush=True)

    def keep(task: tuple[Row, int], outcomes: list[Outcome]) -> None:
        row, _ = task
        kept.keep(row.plan, row.rules, {"outcomes": outcomes})

    measure(
        "safety",
        [(row, seeds) for row in lacking],
        _plans,
        name=lambda task: task[0].name,
        keep=keep,
    )


def _plans(row: Row, seeds: int) -> list[Outcome]:
    """Plan with every seed, after a few generations that compile or load the code."""
    _plan(row, Options(generations=2))
    generations = PLANNERS[row.planner].generations
    return [_plan(row, Options(seed=seed, generations=generations)) for seed in range(seeds)]


def _plan(row: Row, options: Options) -> Outcome:
    task = row.problem()
    # Processor time instead of wall time, because load on the machine hardly affects it.
    began = time.process_time()
    result = make(row.planner, **own_path(row.planner)).plan(Evaluator(task, threads=1), options)
    return {
        "fitness": round(result.evaluation.fitness, 6),
        "feasible": result.evaluation.feasible,
        "cpu_seconds": round(time.process_time() - began, 3),
    }


def _report(runs: dict[Row, list[Outcome]]) -> Report:
    rules = {row.clearance_m: row.rules for row in runs}
    cells = {
        (row.terrain, row.planner, row.clearance_m): _fitness(outcomes)
        for row, outcomes in runs.items()
    }
    return Report(
        "Mean F",
        ("terrain", "planner", *rules.values()),
        [
            (terrain, planner, *(cells.get((terrain, planner, key), "") for key in rules))
            for terrain, planner in dict.fromkeys((row.terrain, row.planner) for row in runs)
        ],
        [
            "Mean F of the feasible paths. A share in brackets says how many seeds found one, "
            "where some did not; none: no seed found one.",
            *missing(),
        ],
        {"runs": {row.name: outcomes for row, outcomes in runs.items()}},
        further=[_seconds_table(runs)],
    )


def _fitness(outcomes: Sequence[Outcome]) -> str:
    """Return a row's cell in the table of F."""
    feasible = [outcome["fitness"] for outcome in outcomes if outcome["feasible"]]
    if not feasible:
        return "none"
    share = "" if len(feasible) == len(outcomes) else f" ({len(feasible)}/{len(outcomes)})"
    return f"{mean(feasible):.4f}{share}"


def _seconds_table(runs: dict[Row, list[Outcome]]) -> Report:
    rules = {row.clearance_m: row.rules for row in runs}
    safe = [key for key in rules if key is not None]
    table = Report(
        "CPU seconds of a plan",
        ("planner", *rules.values(), *(f"{rules[key]}, relative to paper mode" for key in safe)),
        notes=[
            "The least and the greatest mean of a terrain, with the problem's rasters, without "
            "compiling; plans that find no path count. Relative to paper mode: the median of the "
            "ratios of the terrains."
        ],
    )
    for planner in dict.fromkeys(row.planner for row in runs):
        by_rules = {key: _seconds(runs, planner, key) for key in rules}
        table.rows.append(
            (
                planner,
                *(_range(by_rules[key].values()) for key in rules),
                *(_times(by_rules[key], by_rules.get(None, {})) for key in safe),
            )
        )
    return table


def _seconds(
    runs: dict[Row, list[Outcome]], planner: str, clearance_m: float | None
) -> dict[str, float]:
    """Return the mean CPU seconds of a planner under a set of rules by terrain."""
    return {
        row.terrain: mean(outcome["cpu_seconds"] for outcome in outcomes)
        for row, outcomes in runs.items()
        if (row.planner, row.clearance_m) == (planner, clearance_m)
    }


def _range(seconds: Collection[float]) -> str:
    return f"{min(seconds):.2f} to {max(seconds):.2f}" if seconds else ""


def _times(seconds: dict[str, float], as_paper: dict[str, float]) -> str:
    """Return the median ratio over the common terrains."""
    ratios = [seconds[terrain] / as_paper[terrain] for terrain in seconds if terrain in as_paper]
    return f"{median(ratios):.2f}" if ratios else ""
