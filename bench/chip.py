"""The planner core on its compiled model: F by time, with and without a clearance."""

from __future__ import annotations

import dataclasses
import math
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import mean
from typing import Any

from bench.campaign import measure
from bench.chip_runs import (
    BOARD_CHIP,
    BOARD_URL,
    CHIP,
    Outcome,
    Task,
    run_all,
    share,
    terrains,
    through_terrains,
)
from bench.report import Options, Report
from bench.scenarios import SYNTHETIC, UNTUNED, missing, problem
from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import UNITS
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners import base as planners
from pathgene.host.planners.chip.schedule import ChipSchedule
from pathgene.host.problem.rules import Rules


#: Milliseconds of chip time.
TIMES_MS = (1, 2, 5, 10, 20, 50, 100)
_MOST_SEEDS = 10
#: The run whose cycles are reported, milliseconds.
_COUNTED_MS = 50
_YARDSTICK = "astar"
_POLISHED = "ga-chip, 50 ms and polish"
_POLISHED_BOARD = f"{_POLISHED}, sizes of the ulx3s-85f"
#: The time for which the share of feasible runs is reported, and the factor by which it has more
#: seeds.
_SHARED_MS, _MORE_SEEDS = 10, 10


@dataclass(frozen=True)
class Other:
    """A planner compared with the chip, its options, and its maximum number of seeds."""

    planner: str
    seeds: int = _MOST_SEEDS
    options: Mapping[str, Any] = dataclasses.field(default_factory=dict)


#: Planners compared with the chip; the slow ones have fewer seeds, and astar draws nothing.
OTHERS = {
    _POLISHED: Other("ga-chip", options={"chip_ms": 50, "polish": "chip"}),
    _POLISHED_BOARD: Other(
        "ga-chip", options={"chip_ms": 50, "polish": "chip", "board": BOARD_URL}
    ),
    "ga-fpga": Other("ga-fpga", seeds=3),
    "ga-pc": Other("ga-pc", seeds=3),
    "fpa-2opt": Other("fpa-2opt", seeds=1),
    _YARDSTICK: Other("astar", seeds=1),
    "ga-pc from astar": Other("ga-pc", seeds=3, options={"init": "astar"}),
}


@dataclass(frozen=True)
class Table:
    """A table: terrains, a clearance in metres (None in paper mode), and a chip."""

    clearance_m: float | None = None
    untuned: bool = False
    config: Config = CHIP

    def terrains(self) -> list[str]:
        """Return the names of the table's terrains."""
        return list(UNTUNED) if self.untuned else terrains()

    def others(self) -> dict[str, Other]:
        """Return the planners to compare: the polished chip and the yardstick, or all."""
        if self.config != CHIP:
            wanted = [_POLISHED_BOARD, _YARDSTICK]
        elif self.untuned:
            wanted = [_POLISHED, _YARDSTICK]
        else:
            wanted = [title for title in OTHERS if title != _POLISHED_BOARD]
        return {title: OTHERS[title] for title in wanted if title in OTHERS}


#: Every table of F.
TABLES = {
    "paper mode": Table(),
    "clearance 30 m": Table(30.0),
    "clearance 100 m": Table(100.0),
    "untuned ground": Table(untuned=True),
    "sizes of the ulx3s-85f": Table(config=BOARD_CHIP),
}

_Plan = tuple[str, str, float | None, int]
#: Outcomes of each row, for each terrain in the order of the seeds.
_Measured = dict[str, list[list[Outcome]]]


def run(options: Options) -> Report:
    """Measure the tables with ``only`` in their names, all by default."""
    wanted = {name: table for name, table in TABLES.items() if options.only in name}
    if not wanted:
        raise InputError(
            f"No table has {options.only!r} in its name; there are {', '.join(TABLES)}."
        )
    seeds = min(options.seeds, _MOST_SEEDS)
    reports: list[Report] = []
    for name, table in wanted.items():
        measured = _measured(name, table, seeds)
        reports.append(_fitness(name, table, measured, seeds))
        if table == Table():
            reports += [_cycles(measured), _race(measured), _shares(_MORE_SEEDS * seeds)]
    return dataclasses.replace(reports[0], further=reports[1:])


def _measured(name: str, table: Table, seeds: int) -> _Measured:
    """Execute all runs and plans of a table."""
    measured: _Measured = {}
    rows = {_title(chip_ms): (chip_ms, False) for chip_ms in TIMES_MS}
    if _COUNTED_MS in TIMES_MS:
        rows[f"{_title(_COUNTED_MS)}, one run"] = _COUNTED_MS, True
    for title, (chip_ms, is_whole) in rows.items():
        tasks = [
            Task(terrain, table.clearance_m, _runs(seed, chip_ms, is_whole=is_whole), table.config)
            for terrain in table.terrains()
            for seed in range(seeds)
        ]
        measured[title] = _by_terrain(run_all(tasks), seeds)
        print(f"chip: {name}, {title} done", file=sys.stderr, flush=True)
    own = {title: min(seeds, other.seeds) for title, other in table.others().items()}
    plans = [
        (title, terrain, table.clearance_m, seed)
        for title in own
        for terrain in table.terrains()
        for seed in range(own[title])
    ]
    outcomes = measure(
        "chip",
        [(plan,) for plan in plans],
        _plan,
        name=lambda task: f"{name}, {task[0][0]}",
        prepare=_compile,
    )
    for title, count in own.items():
        of_title = [
            outcome for plan, outcome in zip(plans, outcomes, strict=True) if plan[0] == title
        ]
        measured[title] = _by_terrain(of_title, count)
    return measured


def _runs(seed: int, chip_ms: int, *, is_whole: bool = False) -> tuple[RunOptions, ...]:
    """Return the runs of a plan whose first run finds a path, or a single run for all the time."""
    schedule = ChipSchedule(config=CHIP, seed=seed, generations=(1 << 32) - 1, chip_ms=chip_ms)
    first = schedule.first()[0]
    if is_whole:
        return (dataclasses.replace(first, cycles=chip_ms * CHIP.clock_hz // 1000),)
    return first, *schedule.further()


def _title(chip_ms: int) -> str:
    return f"chip, {chip_ms} ms"


def _by_terrain(outcomes: Sequence[Outcome], seeds: int) -> list[list[Outcome]]:
    return [list(outcomes[at : at + seeds]) for at in range(0, len(outcomes), seeds)]


def _fitness(name: str, table: Table, measured: _Measured, seeds: int) -> Report:
    """Return F by chip time, then F and seconds of the planners compared with it."""
    fewer = [
        f"{title} {other.seeds}" for title, other in table.others().items() if other.seeds < seeds
    ]
    report = Report(
        f"Mean F, {name}, {seeds} seeds",
        (
            "planner",
            *table.terrains(),
            "mean",
            "feasible",
            "chip ms",
            "CPU seconds",
            "host's share",
        ),
        notes=[
            "Rows of the chip: runs of its model at 100 MHz with 8 lanes, unpolished; CPU seconds "
            "of the model. Up to 20 ms there is one run. Longer plans are four runs, each from "
            "the population of the previous one, as the planner makes them. Rows of ga-chip: the "
            "whole planner, with further seeds where no path of a run is feasible, and with the "
            "upload of the map. F: mean of the feasible paths; mean: of the maps with such a "
            "path. CPU seconds: all threads, without compiling. Host's share: share of the "
            "seconds of a plan in which the host does not wait for a board.",
            *([f"Seeds: {', '.join(fewer)}."] if fewer else []),
            *missing(),
        ],
    )
    for title, by_terrain in measured.items():
        means, all_means = through_terrains(by_terrain)
        every = [outcome for some in by_terrain for outcome in some]
        cycles = mean(outcome.cycles for outcome in every)
        host = mean(outcome.host_share for outcome in every)
        report.rows.append(
            (
                title,
                *means,
                all_means,
                share(every),
                f"{1000 * cycles / CHIP.clock_hz:.2f}" if cycles else "-",
                mean(outcome.seconds for outcome in every),
                "-" if math.isnan(host) else f"{100 * host:.0f} %",
            )
        )
    return report


def _compile() -> None:
    for title in OTHERS:
        _plan((title, SYNTHETIC[0], None, 0), generations=2)


def _plan(task: _Plan, generations: int | None = None) -> Outcome:
    title, terrain, clearance_m, seed = task
    name, own = OTHERS[title].planner, OTHERS[title].options
    rules = None if clearance_m is None else Rules(clearance_m=clearance_m)
    evaluator = Evaluator(dataclasses.replace(problem(terrain), rules=rules), threads=1)
    options = planners.Options(seed=seed, generations=generations or PLANNERS[name].generations)
    # Processor time instead of wall time, because load on the machine hardly affects it.
    began = time.process_time()
    result = make(name, **own).plan(evaluator, options)
    return Outcome(
        result.evaluation.fitness,
        result.evaluation.feasible,
        result.generations,
        (result.hardware or {}).get("cycles", {}).get("total", 0),
        time.process_time() - began,
        host_share=1 - result.seconds.get("link", 0.0) / result.seconds["total"],
    )


def _cycles(measured: _Measured) -> Report:
    """Return the generations per second of the compiled model, and their cycles."""
    chip_ms = _COUNTED_MS if _COUNTED_MS in TIMES_MS else TIMES_MS[-1]
    report = Report(
        f"Cycles of a generation, and speed of the compiled model: paper mode, {chip_ms} ms",
        (
            "terrain",
            "generations",
            "cycles per generation",
            *UNITS,
            "wait",
            "generations per second of a core",
        ),
        notes=[
            "Cycles of all first populations are shared out to the generations. The units overlap;",
            "wait: cycles in which nothing is walked and no wavefront spreads.",
        ],
    )
    for terrain, outcomes in zip(terrains(), measured[_title(chip_ms)], strict=True):
        generations = sum(outcome.generations for outcome in outcomes)
        cycles = sum(outcome.cycles for outcome in outcomes)
        units = {unit: sum(outcome.units[unit] for outcome in outcomes) for unit in UNITS}
        units["wait"] = cycles - units["walk"] - units["wavefront"]
        report.rows.append(
            (
                terrain,
                round(generations / len(outcomes)),
                round(cycles / generations),
                *(round(spent / generations) for spent in units.values()),
                round(generations / sum(outcome.seconds for outcome in outcomes)),
            )
        )
    return report


def _race(measured: _Measured) -> Report:
    """Return the seconds of the model until its mean F reaches the yardstick's."""
    report = Report(
        "Seconds of a processor core until astar's F: the compiled model, and astar itself",
        ("terrain", "astar's F", "astar, seconds", "chip's F", "chip ms", "model, seconds"),
        notes=["The shortest of the runs above whose mean F is that of astar or more."],
    )
    if _YARDSTICK not in measured:
        return report
    slower = measured[_YARDSTICK]
    for at, terrain in enumerate([*terrains(), "mean"]):
        places = range(len(slower)) if terrain == "mean" else (at,)
        own = _mean_of(slower, places)
        found: tuple[object, ...] = ("-", "-", "-")
        for chip_ms in TIMES_MS:
            fitness, seconds = _mean_of(measured[_title(chip_ms)], places)
            if fitness >= own[0]:
                found = f"{fitness:.4f}", chip_ms, seconds
                break
        report.rows.append((terrain, f"{own[0]:.4f}", own[1], *found))
    return report


def _shares(seeds: int) -> Report:
    """Return how many short runs find a feasible path, with more seeds."""
    report = Report(
        f"Runs of {_SHARED_MS} ms with a feasible path, paper mode, {seeds} seeds",
        (*terrains(), "all"),
    )
    tasks = [
        Task(terrain, None, _runs(seed, _SHARED_MS))
        for terrain in terrains()
        for seed in range(seeds)
    ]
    by_terrain = _by_terrain(run_all(tasks), seeds)
    every = [outcome for some in by_terrain for outcome in some]
    found = sum(outcome.feasible for outcome in every)
    report.rows.append(
        (*map(share, by_terrain), f"{share(every)} ({100 * found / len(every):.1f} %)")
    )
    return report


def _mean_of(by_terrain: Sequence[Sequence[Outcome]], places: Sequence[int]) -> tuple[float, float]:
    """Return the means over terrains of the mean F of feasible paths and of the seconds."""
    fitness = [
        mean([each.fitness for each in by_terrain[at] if each.feasible] or [0.0]) for at in places
    ]
    return mean(fitness), mean(each.seconds for at in places for each in by_terrain[at])
