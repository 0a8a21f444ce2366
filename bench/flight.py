"""Flights of planned paths: every planner, map, weather and aircraft, with both sets of rules.

A row of a table is a map, an aircraft and a weather; all distinct feasible paths of all planners
and seeds are flown, without selection. Results are kept by row and planner in ``docs/flights.json``
(:class:`bench.store.Store`); ``docs/flight.md`` shows them.
"""

from __future__ import annotations

import hashlib
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import mean
from typing import Any

from bench import guided_flights, pages
from bench.campaign import measure
from bench.flight_rows import AIRCRAFT, WEATHERS, Row, gusts_of
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import SYNTHETIC, missing, names
from bench.store import Store
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.flight.fly import fly
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners.base import Options
from pathgene.host.problem.problem import Problem


_DOCS = Path(__file__).resolve().parents[1] / "docs"
#: Where the results of all flights are kept.
STORE = _DOCS / "flights.json"
#: Maximum seeds of each planner: the number in the claim.
MOST_SEEDS = 10
#: The planners, by their names in the results, with their options.
PLANNED: dict[str, tuple[str, dict[str, Any]]] = {
    "ga-fpga": ("ga-fpga", {}),
    "ga-pc from astar": ("ga-pc", {"init": "astar"}),
    "fpa-2opt": ("fpa-2opt", {}),
    "astar": ("astar", {}),
}
#: Planners that draw nothing: their paths are the same with every seed.
_DRAWLESS = ("astar",)

# All sources of the flight except its picture and report.
_FLIGHT = (
    "aircraft",
    "autopilot.py",
    "flight.py",
    "fly.py",
    "ground.py",
    "guidance.py",
    "judge.py",
    "models.py",
    "route.py",
    "simulator.py",
)
_SOURCES = (
    "bench/scenarios.py",
    "hdl/config.py",
    "host/device",
    "host/evaluation",
    *(f"host/flight/{name}" for name in _FLIGHT),
    "host/planners",
    "host/problem",
    "host/terrain",
    "sim/model",
)
# Commands may exceed a limit by this share, plus rounding.
_EXCESS = 0.05 + 1e-4
# The figures of flights: the key in the verdict, and the function that selects the worst.
_FIGURES: dict[str, tuple[str, Callable[[list[float]], float]]] = {
    "cross-track rms, m": ("cross_track_rms_m", max),
    "max, m": ("cross_track_max_m", max),
    "height error max, m": ("height_error_max_m", max),
    "clearance planned, m": ("clearance_planned_m", min),
    "flown, m": ("clearance_flown_m", min),
    "least share": ("clearance_share", min),
    "largest excess": ("excess", max),
}
# Digits after the point; every other figure has 1.
_DIGITS = {"least share": 2, "largest excess": 2}
_COLUMNS = (
    "map, aircraft, weather",
    "found",
    "flown",
    "kept",
    *list(_FIGURES)[:-1],
    "zones entered",
    "largest excess",
)
# Maximum number of sentences about breaks that are kept per planner.
_MOST_BREAKS = 3

Outcome = dict[str, Any]


def rows(only: str = "") -> list[Row]:
    """Return the rows with ``only`` in their names, of all available maps."""
    every = [
        Row(terrain, plane, weather, as_paper)
        for as_paper in (False, True)
        for plane in AIRCRAFT
        for terrain in (*names(), *SYNTHETIC)
        for weather in WEATHERS
    ]
    return [row for row in every if only in row.name]


def run(options: BenchOptions) -> Report:
    """Plan and fly all rows without stored results; write the tables of all rows to the page.

    If only rows by guidance are wanted, the tables of the other rows stay.

    Raises
    ------
    InputError
        If no row has the name of ``--only``.
    """
    wanted, guided = rows(options.only), guided_flights.rows(options.only)
    if not wanted and not guided:
        raise InputError(
            f"No row has {options.only!r} in its name; one is 'canyon silver-fox calm safe'."
        )
    by_guidance = Store(STORE, *guided_flights.SOURCES)
    guided_flights.measure_missing(by_guidance, guided)
    table = guided_flights.report(by_guidance, guided_flights.rows())
    if not wanted:
        pages.keep_table("flight", table)
        return guided_flights.report(by_guidance, guided)
    kept = Store(STORE, *_SOURCES)
    _measure_missing(kept, wanted, min(options.seeds, MOST_SEEDS))
    every = _report(kept, rows())
    every.further = [*every.further, table]
    every.data |= table.data
    pages.keep("flight", every)
    return _report(kept, wanted)


def _measure_missing(kept: Store, wanted: list[Row], seeds: int) -> None:
    """Measure the missing results, one planner of a row per core."""
    tasks = [
        (row, planner)
        for row in wanted
        for planner in PLANNED
        if (kept.get(row.name, planner) or {"runs": 0})["runs"] < _seeds(planner, seeds)
    ]
    print(
        f"flight: {sum(_seeds(planner, seeds) for _, planner in tasks)} runs of planners to fly",
        file=sys.stderr,
        flush=True,
    )

    def keep(task: tuple[Row, str, int], outcomes: list[Outcome]) -> None:
        row, planner, _ = task
        kept.keep(row.name, planner, _worst(outcomes))

    measure(
        "flight",
        [(*task, seeds) for task in tasks],
        _measure,
        name=lambda task: f"{task[0].name}, {task[1]}",
        keep=keep,
    )


def _report(kept: Store, wanted: list[Row]) -> Report:
    """Return the tables of rows under the rules and in paper mode, with stored results."""
    tables = []
    for as_paper in (False, True):
        table = Report("Paper mode" if as_paper else "By the rules", _COLUMNS)
        flown = safe = lacking = 0
        for row in (row for row in wanted if row.as_paper == as_paper):
            parts = [part for planner in PLANNED if (part := kept.get(row.name, planner))]
            lacking += len(PLANNED) - len(parts)
            if parts:
                table.rows.append((row.name.rsplit(" ", 2 if as_paper else 1)[0], *_cells(parts)))
                table.data[row.name] = parts
                flown += sum(part["flown"] for part in parts)
                safe += sum(part["kept"] for part in parts)
        table.notes = [f"{flown:,} flights, {safe:,} of them kept."]
        if lacking:
            table.notes.append(f"Planners of a row not measured yet: {lacking}.")
        if not as_paper:
            table.failed = any(
                part["kept"] < part["flown"] or part["largest excess"] > _EXCESS
                for parts in table.data.values()
                for part in parts
                if part["flown"]
            )
        tables.append(table)
    by_rules, as_paper_too = tables
    by_rules.data = {"flights": {**by_rules.data, **as_paper_too.data}}
    by_rules.further = [as_paper_too]
    by_rules.notes += missing()
    return by_rules


def _worst(outcomes: list[Outcome]) -> Outcome:
    """Return the numbers of runs, paths and flights of a planner, and its worst figures."""
    feasible = [outcome for outcome in outcomes if outcome["feasible"]]
    flights = list({outcome["path"]: outcome for outcome in feasible}.values())
    told = [flight for flight in flights if "clearance_flown_m" in flight]
    worst: Outcome = {
        "runs": len(outcomes),
        "found": len(feasible),
        "flown": len(flights),
        "kept": sum(flight["kept"] for flight in flights),
        "zones entered": sum(bool(flight["zones_entered"]) for flight in told),
        "seconds": round(mean(outcome.get("plan_seconds", 0.0) for outcome in outcomes), 2),
        "breaks": sorted({text for flight in flights for text in flight["breaks"]})[:_MOST_BREAKS],
    }
    for column, (key, choose) in _FIGURES.items():
        values = [flight[key] for flight in told if math.isfinite(flight[key])]
        worst[column] = round(choose(values), 4) if values else None
    return worst


def _cells(parts: list[Outcome]) -> tuple[object, ...]:
    """Return the cells of a row from the results of its planners."""

    def total(key: str) -> int:
        return sum(part[key] for part in parts)

    def worst(column: str) -> object:
        _, choose = _FIGURES[column]
        values = [part[column] for part in parts if part[column] is not None]
        return f"{choose(values):.{_DIGITS.get(column, 1)}f}" if values else "-"

    figures = {column: worst(column) for column in _FIGURES}
    return (
        f"{total('found')}/{total('runs')}",
        total("flown"),
        total("kept"),
        *(figures.get(column, total("zones entered")) for column in _COLUMNS[4:]),
    )


def _measure(row: Row, planner: str, seeds: int) -> list[Outcome]:
    """Plan with every seed and fly the distinct paths."""
    try:
        task = row.problem()
        evaluator = Evaluator(task, threads=1)
    except InputError as error:
        return [
            {"planner": planner, "seed": seed, "feasible": False, "path": "", "note": str(error)}
            for seed in range(_seeds(planner, seeds))
        ]
    outcomes: dict[str, Outcome] = {}
    measured = []
    for seed in range(_seeds(planner, seeds)):
        outcome = dict(_plan_and_fly(row, task, evaluator, planner, seed, outcomes))
        measured.append(outcome | {"seed": seed})
    return measured


def _plan_and_fly(
    row: Row,
    task: Problem,
    evaluator: Evaluator,
    planner: str,
    seed: int,
    flown: dict[str, Outcome],
) -> Outcome:
    name, own = PLANNED[planner]
    started = time.process_time()
    result = make(name, **own).plan(
        evaluator, Options(seed=seed, generations=PLANNERS[name].generations)
    )
    outcome: Outcome = {
        "planner": planner,
        "feasible": result.evaluation.feasible,
        "fitness": result.evaluation.fitness,
        "path": hashlib.sha256(result.path.tobytes()).hexdigest()[:16],
        "plan_seconds": time.process_time() - started,
    }
    if not result.evaluation.feasible:
        return outcome
    if outcome["path"] in flown:
        return flown[outcome["path"]]
    try:
        flight = fly(task, result.path, gusts=gusts_of(row.weather), seed=seed)
    except JobError as error:
        outcome |= {"kept": False, "excess": 0.0, "breaks": [str(error)]}
    else:
        outcome |= flight.verdict.to_dict() | {"excess": flight.verdict.excess}
    flown[outcome["path"]] = outcome
    return outcome


def _seeds(planner: str, seeds: int) -> int:
    return 1 if planner in _DRAWLESS else seeds
