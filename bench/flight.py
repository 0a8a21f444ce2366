"""Flights of planned paths: every planner, map, weather and aircraft, by the rules and as paper.

A row of the table is a map, an aircraft and a weather; all distinct feasible paths of all planners
and seeds are flown, none is chosen. Results are kept by row and planner in :data:`FOLDER`, so that
an interrupted run goes on where it was; a change of the sources they follow from discards them.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import SYNTHETIC, missing, names, problem
from bench.sources import digest
from host.cores import available_cores
from host.errors import InputError, JobError
from host.evaluation import Evaluator
from host.flight.fly import fly
from host.planners import PLANNERS, make
from host.planners.base import Options
from host.problem import Problem, aircraft
from host.report.files import write_json
from host.report.summary import finite


__all__ = ["FOLDER", "MOST_SEEDS", "PLANNED", "Row", "rows", "run"]

#: Where the results of each row are kept.
FOLDER = Path("build/bench/flights")
#: Seeds of each planner at most: the number of the claim.
MOST_SEEDS = 10
#: The planners by their names in the results, with their options.
PLANNED: dict[str, tuple[str, dict[str, Any]]] = {
    "ga-fpga": ("ga-fpga", {}),
    "ga-pc from astar": ("ga-pc", {"init": "astar"}),
    "fpa-2opt": ("fpa-2opt", {}),
    "astar": ("astar", {}),
}
#: Planners that draw nothing: their paths are the same with every seed.
_DRAWLESS = ("astar",)
AIRCRAFT = ("silver-fox", "c172p")
WEATHERS = ("calm", "along", "across")
WIND_M_S = 8.0

_SOURCES = ("host/evaluation", "host/flight", "host/planners", "host/problem")
# Commands may exceed a limit by this share; rounding apart.
_EXCESS = 0.05 + 1e-6

Outcome = dict[str, Any]


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Parameters
    ----------
    terrain : str
        Name of the map.
    aircraft : str
        Planned for and flown.
    weather : str
        Planned for and flown: calm air, or 8 m/s along the line from start to goal or across it,
        with light turbulence.
    as_paper : bool
        Planned by the evaluation of the papers.
    """

    terrain: str
    aircraft: str
    weather: str
    as_paper: bool

    @property
    def name(self) -> str:
        """Name in the table, which ``--only`` is compared with."""
        mode = "as paper" if self.as_paper else "safe"
        return f"{self.terrain} {self.aircraft} {self.weather} {mode}"

    @property
    def file(self) -> Path:
        """Where the results are kept."""
        return FOLDER / f"{self.name.replace(' ', '_')}.json"

    def problem(self) -> Problem:
        """Return the problem to plan.

        Raises
        ------
        InputError
            If start or goal are no place for this aircraft.
        """
        scenario = problem(self.terrain)
        (x0, y0, _), (x1, y1, _) = scenario.start, scenario.goal
        way = math.hypot(x1 - x0, y1 - y0)
        east, north = WIND_M_S * (x1 - x0) / way, WIND_M_S * (y1 - y0) / way
        winds = {"calm": (0.0, 0.0), "along": (east, north), "across": (-north, east)}
        return Problem(
            scenario.terrain,
            scenario.start,
            scenario.goal,
            aircraft.load(self.aircraft),
            scenario.zones,
            winds[self.weather],
            scenario.ds_m,
            as_paper=self.as_paper,
        )


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
    """Plan and fly all rows that are not kept already; return the table of all.

    Raises
    ------
    InputError
        If no row has the name of ``--only``.
    """
    wanted = rows(options.only)
    if not wanted:
        raise InputError(
            f"No row has {options.only!r} in its name; one is 'canyon silver-fox calm safe'."
        )
    seeds = min(options.seeds, MOST_SEEDS)
    FOLDER.mkdir(parents=True, exist_ok=True)
    tasks = [(row, planner) for row in wanted for planner in PLANNED if _lacks(row, planner, seeds)]
    print(
        f"flight: {sum(_seeds(planner, seeds) for _, planner in tasks)} runs of planners to fly",
        file=sys.stderr,
        flush=True,
    )
    started = time.monotonic()
    with ProcessPoolExecutor(available_cores()) as pool:
        jobs = {pool.submit(_measure, *task, seeds): task for task in tasks}
        for done, job in enumerate(as_completed(jobs), 1):
            row, planner = jobs[job]
            _keep(row, planner, job.result())
            minutes = (time.monotonic() - started) / 60
            print(
                f"flight: {row.name}, {planner} ({done} of {len(jobs)}, {minutes:.1f} min)",
                file=sys.stderr,
                flush=True,
            )
    return _report(wanted, seeds)


def _report(wanted: list[Row], seeds: int) -> Report:
    report = Report(
        f"Flight: {seeds} seeds, every distinct feasible path flown",
        (
            "row",
            "found",
            "flown",
            "kept",
            "cross-track rms, m",
            "max, m",
            "height error max, m",
            "clearance planned, m",
            "flown, m",
            "least share",
            "zones entered",
            "largest excess",
        ),
    )
    runs = {}
    for row in wanted:
        kept = _kept(row)
        outcomes = [
            outcome
            for planner in PLANNED
            for outcome in kept.get(planner, [])
            if outcome["seed"] < seeds
        ]
        runs[row.name] = outcomes
        report.rows.append((row.name, *_cells(outcomes)))
        if not row.as_paper:
            report.failed |= any(
                not outcome["kept"] or outcome["excess"] > _EXCESS
                for outcome in outcomes
                if "kept" in outcome
            )
    report.notes = [
        f"Scenarios of BENCH=quality. Planners: {', '.join(PLANNED)}.",
        "Found: feasible paths of all runs; flown: those of them that differ. Kept: half of the",
        "demanded clearance, no zone entered, the goal reached. Along, across: 8 m/s from start to",
        "goal, or across, with light turbulence; planned for and flown. Columns after kept are the",
        "worst of all flights, also the rms; clearances the least. Share: of the one demanded.",
        "Excess: of commands over a limit of the aircraft, means of 5 s; 0.05 is allowed. Safe: a",
        "clearance of 30 m and all rules of flight.",
        *missing(),
    ]
    report.data = {"runs": runs}
    return report


def _cells(outcomes: list[Outcome]) -> tuple[object, ...]:
    feasible = [outcome for outcome in outcomes if outcome["feasible"]]
    found = f"{len(feasible)}/{len(outcomes)}"
    flights = list({outcome["path"]: outcome for outcome in feasible}.values())
    if not flights:
        return found, 0, *("-",) * 9
    flown = [flight for flight in flights if "clearance_flown_m" in flight]

    def worst(key: str, choose: Any = max) -> object:
        return choose((flight[key] for flight in flown), default="-")

    shares = [share for flight in flown if (share := flight["clearance_share"]) is not None]
    return (
        found,
        len(flights),
        sum(flight["kept"] for flight in flights),
        worst("cross_track_rms_m"),
        worst("cross_track_max_m"),
        worst("height_error_max_m"),
        worst("clearance_planned_m", min),
        worst("clearance_flown_m", min),
        min(shares, default="-"),
        sum(bool(flight["zones_entered"]) for flight in flown),
        worst("excess"),
    )


def _measure(row: Row, planner: str, seeds: int) -> list[Outcome]:
    """Plan with every seed and fly what differs."""
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
    started = time.process_time()
    gusts = "none" if row.weather == "calm" else "light"
    try:
        flight = fly(task, result.path, gusts=gusts, seed=seed)
    except JobError as error:
        outcome |= {"kept": False, "excess": 0.0, "breaks": [str(error)]}
    else:
        outcome |= finite(flight.verdict.to_dict()) | {"excess": flight.verdict.excess}
    outcome["fly_seconds"] = time.process_time() - started
    flown[outcome["path"]] = outcome
    return outcome


def _seeds(planner: str, seeds: int) -> int:
    return 1 if planner in _DRAWLESS else seeds


def _lacks(row: Row, planner: str, seeds: int) -> bool:
    return len(_kept(row).get(planner, [])) < _seeds(planner, seeds)


def _kept(row: Row) -> dict[str, list[Outcome]]:
    """Return the outcomes of a row by planner, if they follow from the present sources."""
    try:
        content = json.loads(row.file.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    if content.get("sources") != digest(*_SOURCES):
        return {}
    planners: dict[str, list[Outcome]] = content["planners"]
    return planners


def _keep(row: Row, planner: str, outcomes: list[Outcome]) -> None:
    planners = _kept(row) | {planner: outcomes}
    write_json(
        row.file, {"sources": digest(*_SOURCES), **dataclasses.asdict(row), "planners": planners}
    )
