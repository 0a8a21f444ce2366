"""Cycles of a generation of the planner core, and of its units, by cycles of a point."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from statistics import mean

from bench.chip_runs import CHIP, Outcome, Task, run_all, terrains, through_terrains
from bench.report import Options, Report
from bench.scenarios import missing
from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import UNITS
from pathgene.hdl.protocol.runs import RunOptions


_CYCLES_OF_A_MS = CHIP.clock_hz // 1000
#: The run whose cycles are counted, and the runs whose F is reported, in milliseconds.
_COUNTED_MS, _TIMES_MS = 50, (6.8, 10)
#: Generations after which F is the same whatever the cycles of a point.
_GENERATIONS, _UNLIMITED = 1000, 1 << 31
_MOST_SEEDS = 10


def run(options: Options) -> Report:
    """Run chips with one and with two cycles of a point over all terrains, in paper mode."""
    seeds = min(options.seeds, _MOST_SEEDS)
    report = Report(
        f"Cycles of a generation by cycles of a point: {seeds} seeds, 8 lanes at 100 MHz",
        (
            "waypoints, up to",
            "cycles of a point",
            "cycles per generation",
            *UNITS,
            f"F after {_GENERATIONS:,} generations",
            *(f"F in {ms} ms" for ms in _TIMES_MS),
        ),
        notes=[
            f"Means over the terrains, in paper mode. Cycles: one run of {_COUNTED_MS} ms with its "
            "first populations; the units overlap. F: the best strictly feasible path, unpolished.",
            *missing(),
        ],
    )
    for waypoints, cycles in product((CHIP.max_waypoints, 18), (2, 1)):
        config = CHIP.replace(max_waypoints=waypoints, point_cycles=cycles)
        counted = _outcomes(config, RunOptions(cycles=_COUNTED_MS * _CYCLES_OF_A_MS), seeds)
        per_generation = mean(_per_generation(some, "") for some in counted)
        units = [mean(_per_generation(some, unit) for some in counted) for unit in UNITS]
        ends = [
            RunOptions(cycles=_UNLIMITED, generations=_GENERATIONS),
            *(RunOptions(cycles=round(ms * _CYCLES_OF_A_MS)) for ms in _TIMES_MS),
        ]
        fitness = [through_terrains(_outcomes(config, end, seeds))[1] for end in ends]
        report.rows.append(
            (waypoints, cycles, round(per_generation), *(round(each) for each in units), *fitness)
        )
    return report


def _outcomes(config: Config, end: RunOptions, seeds: int) -> list[list[Outcome]]:
    """Return the outcomes of a run with each seed, by terrain."""
    names = terrains()
    tasks = [
        Task(name, None, (replace(end, seed=seed),), config)
        for name in names
        for seed in range(seeds)
    ]
    found = run_all(tasks)
    return [found[at * seeds : (at + 1) * seeds] for at in range(len(names))]


def _per_generation(some: list[Outcome], unit: str) -> float:
    """Return cycles of a generation: of a unit, or all."""
    cycles = sum(each.units[unit] if unit else each.cycles for each in some)
    return cycles / sum(each.generations for each in some)
