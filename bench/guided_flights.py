"""Flights of exported missions in JSBSim by the laws of ArduPlane and PX4, and by ideal guidance.

They are rows of :mod:`bench.flight`: three maps with a place on Earth, planned with ``astar`` by
the rules, and a valley whose ground is parallel to a path that dives and climbs as steeply as the
aircraft can, for each aircraft and weather. The sentences of a refused export are followed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.campaign import measure
from bench.flight_rows import AIRCRAFT, WEATHERS, WIND_M_S, Row, gusts_of, winds_of
from bench.following import follow
from bench.report import Report
from bench.scenarios import missing, names_of
from bench.store import Result, Store
from pathgene.host.errors import JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.flight.fly import fly
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.origin import at_origin


__all__ = ["GUIDANCES", "SOURCES", "TITLE", "GuidedRow", "measure_missing", "report", "rows"]

Path = NDArray[np.float64]

#: All sources of these flights.
SOURCES = (
    *("bench/flight_rows.py", "bench/following.py", "bench/guided_flights.py"),
    *("bench/scenarios.py", "hdl/config.py", "host/evaluation", "host/flight", "host/formats"),
    *("host/mission/autopilot", "host/planners", "host/problem", "host/terrain"),
    *("sim/autopilot", "sim/autopilot_flight.py"),
)
TITLE = "Exported missions by guidance"
GUIDANCES = ("ideal", "ardupilot", "px4")
#: The name of the valley among the maps.
VALLEY = "valley"

# Maps with room, and of different sizes; all maps take three times as long.
_MAPS = ("jacksboro", "tujunga", "st-helens")
# Figures of a flight: the part of the column after the guidance, the key of the verdict, digits.
_FIGURES = (("least share", "clearance_share", 2), ("beside, m", "cross_track_max_m", 1))
# The valley: height of its rim, its depth, the level way before, in and after it, and the distance
# of the ground below the path, metres.
_RIM_M, _DEEP_M = 900.0, 300.0
_WAYS_M = (3000.0, 300.0, 3000.0)
_ABOVE_M = 35.0
_CELL_M, _WIDE_M = 25.0, 6000.0
# Slopes of the path are below the aircraft's limits by this share, which is rounding.
_BELOW_LIMIT = 1e-6
_PLACE = (46.0, 8.0)


@dataclass(frozen=True)
class GuidedRow:
    """A row of the table; it has the fields of :class:`bench.flight_rows.Row`."""

    terrain: str
    aircraft: str
    weather: str

    @property
    def name(self) -> str:
        """Name in the store, which ``--only`` is compared with."""
        return f"{self.terrain} {self.aircraft} {self.weather} guidance"

    def problem(self) -> Problem:
        """Return the problem to plan."""
        if self.terrain == VALLEY:
            return _valley(self)[0]
        return Row(self.terrain, self.aircraft, self.weather, False).problem()

    def plan(self, problem: Problem) -> tuple[bool, Path]:
        """Return the verdict on the path of ``astar``, or on the path into the valley, and it."""
        evaluator = Evaluator(problem, threads=1)
        if self.terrain != VALLEY:
            found = make("astar").plan(evaluator, Options(seed=0, generations=1))
            return found.evaluation.feasible, found.path
        path = _valley(self)[1]
        path[0], path[-1] = problem.start, problem.goal
        return evaluator.evaluate(path).feasible, path


def rows(only: str = "") -> list[GuidedRow]:
    """Return the rows with ``only`` in their names, of the available maps."""
    every = [
        GuidedRow(name, plane, weather)
        for name in (*names_of(_MAPS), VALLEY)
        for plane in AIRCRAFT
        for weather in WEATHERS
    ]
    return [row for row in every if only in row.name]


def measure_missing(store: Store, wanted: Sequence[GuidedRow]) -> None:
    """Fly the rows that have no result by a guidance in the store."""
    measure(
        "flight",
        [
            (row, guidance)
            for row in wanted
            for guidance in GUIDANCES
            if store.get(row.name, guidance) is None
        ],
        _measure,
        name=lambda task: f"{task[0].name}, {task[1]}",
        keep=lambda task, result: store.keep(task[0].name, task[1], result),
    )


def report(store: Store, wanted: Sequence[GuidedRow]) -> Report:
    """Return the table of rows, with stored results."""
    columns = ["map, aircraft, weather", "after a refusal"]
    for guidance in GUIDANCES:
        columns += [f"{guidance}: kept", *(f"{guidance}: {figure[0]}" for figure in _FIGURES)]
    made = Report(TITLE, columns)
    kept = dict.fromkeys(GUIDANCES, 0)
    breaks: dict[str, Any] = {}
    lacking = 0
    for row in wanted:
        parts = {each: part for each in GUIDANCES if (part := store.get(row.name, each))}
        lacking += len(GUIDANCES) - len(parts)
        if not parts or not any(part["found"] for part in parts.values()):
            continue
        followed = next(iter(parts.values()))["followed"]
        cells: list[Any] = [row.name.removesuffix(" guidance"), ", ".join(followed) or "-"]
        for guidance in GUIDANCES:
            part = parts.get(guidance, {})
            kept[guidance] += part.get("kept", False)
            if part.get("breaks"):
                breaks.setdefault(row.name, {})[guidance] = part["breaks"]
            cells += _cells(part)
        made.rows.append(cells)
    counts = ", ".join(f"{count} with {guidance}" for guidance, count in kept.items())
    made.notes = [
        f"Kept of {len(made.rows)}: {counts}. The wind is {WIND_M_S:.0f} m/s with light turbulence "
        "of JSBSim.",
        *missing(_MAPS),
    ]
    if lacking:
        made.notes.append(f"Flights not measured yet: {lacking}.")
    made.data = {"breaks by guidance": breaks}
    made.failed = any(count < len(made.rows) for count in kept.values())
    return made


def _cells(part: Result) -> list[Any]:
    if not part:
        return ["", *("" for _ in _FIGURES)]
    verdict = part["refused"] or ("yes" if part["kept"] else "no")
    figures = [(part.get(key), digits) for _, key, digits in _FIGURES]
    return [verdict, *("-" if value is None else round(value, digits) for value, digits in figures)]


def _measure(row: GuidedRow, guidance: str) -> Result:
    """Return the figures of a flight; a mission is changed as its refused export says."""

    def flown(task: Problem, path: Path) -> Result:
        # The ideal guidance flies the mission that is exported.
        flight_plan(task, Evaluator(task, threads=1).track(path), feasible=True)
        try:
            made = fly(task, path, gusts=gusts_of(row.weather), guidance=guidance).verdict
        except JobError as error:
            return {"kept": False, "refused": "refused", "breaks": [str(error)]}
        verdict = made.to_dict()
        figures = {key: verdict[key] for _, key, _ in _FIGURES}
        return {"kept": verdict["kept"], "refused": "", "breaks": verdict["breaks"], **figures}

    done = follow(row.problem, row.plan, flown)
    if done.result is None and not done.refusal:
        return {"found": False, "kept": False}
    refused = {"kept": False, "refused": "refused", "breaks": [done.refusal]}
    return {"found": True, "followed": done.followed, **(done.result or refused)}


def _valley(row: GuidedRow) -> tuple[Problem, Path]:
    """Return a valley with a path through it, as steep as the aircraft's limits in this wind."""
    plane = aircraft.load(row.aircraft)
    wind = winds_of(1.0, 0.0)[row.weather]
    level = Terrain(VALLEY, np.zeros((3, 3)), _CELL_M, _CELL_M)
    limits = Problem(level, (0, 0, 100), (25, 0, 100), plane, wind=wind).slope_limits(
        np.array([1.0]), np.array([0.0])
    )
    climb, dive = (float(limit[0]) * (1 - _BELOW_LIMIT) for limit in limits)
    before, floor, after = _WAYS_M
    runs = (before, _DEEP_M / dive, floor, _DEEP_M / climb, after)
    x = np.concatenate(([0.0], np.cumsum(runs))) + 1000.0
    z = np.array([_RIM_M, _RIM_M, _RIM_M - _DEEP_M, _RIM_M - _DEEP_M, _RIM_M, _RIM_M]) + _ABOVE_M
    across = 0.5 * _WIDE_M
    path = np.column_stack((x, np.full(6, across), z))
    columns = math.ceil((x[-1] + 4000.0) / _CELL_M)
    nodes = _CELL_M * np.arange(columns)
    # Around a node the ground has its height, so it is the lowest one that suits the path there.
    sides = [np.interp(nodes + side * _CELL_M, x, z) for side in (-0.5, 0.0, 0.5)]
    ground = np.minimum.reduce(sides) - _ABOVE_M
    land = np.tile(ground, (round(_WIDE_M / _CELL_M) + 1, 1))
    terrain = at_origin(Terrain(VALLEY, land, _CELL_M, _CELL_M), *_PLACE)
    return Problem(terrain, tuple(path[0]), tuple(path[-1]), plane, wind=wind), path
