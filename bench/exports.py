"""Planned missions, uploaded to the simulated autopilot and flown by it.

The mission is the exported one: it travels over MAVLink by ``host/mission/autopilot``, and the
autopilot flies the items that it has accepted, with ArduPlane's laws. The verdict is on the flight:
half of the required clearance, also on the circle at the end, no zone, no full circle on the way,
and no more than 25 m beside the legs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench import landings
from bench.autopilot import from_legs
from bench.campaign import measure
from bench.export_missions import AIRCRAFT, GENERATED, Mission, missions
from bench.flight_rows import WEATHERS, WIND_M_S
from bench.following import follow
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import missing
from bench.store import Result, Store
from pathgene.host.errors import JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.flight.ground import demanded_m, is_off_map, known_surface_m
from pathgene.host.flight.judge import SHARE
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.planners import PLANNERS
from pathgene.host.problem.problem import Problem
from pathgene.sim.autopilot.autopilot import Autopilot
from pathgene.sim.autopilot.flown import Flown
from pathgene.sim.autopilot.items import MISSION, Item
from pathgene.sim.autopilot_flight import GUSTS_M_S, fly_items, give_mission, launched


__all__ = ["Outcome", "fly_export", "run", "with_places"]

#: Where the results of missions are kept, so that an interrupted campaign continues.
STORE = Path(__file__).resolve().parents[1] / "build" / "bench" / "export_missions.json"
_SOURCES = (
    "bench/export_missions.py",
    "bench/exports.py",
    "bench/following.py",
    "bench/landings.py",
    "hdl/config.py",
    "host/device",
    "host/evaluation",
    "host/mission/autopilot",
    "host/planners",
    "host/problem",
    "host/terrain",
    "sim/autopilot",
    "sim/autopilot_flight.py",
    "sim/model",
)
#: Maximum distance beside the legs.
BESIDE_M = 25.0
_COLUMNS = (
    *("missions", "at once", "higher start", "higher goal", "other goal", "refused", "kept"),
    *("least share", "at the end", "beside the legs, m"),
)
# A turn by this angle within this time, before the end, is a full circle.
_FULL_RAD, _FULL_S = math.radians(330), 40.0

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Outcome:
    """The flight of an exported mission.

    Parameters
    ----------
    refusal : str
        The sentence of a refused export or upload, or empty.
    arrived : bool
        The last item was reached.
    share, end_share : float
        Minimum share of the required clearance that the flight keeps, on the way and at its end.
    beside_m : float
        Maximum distance from the legs.
    circles : int
        Full circles on the way.
    zones : int
        Zones entered.
    """

    refusal: str = ""
    arrived: bool = False
    share: float = math.nan
    end_share: float = math.nan
    beside_m: float = math.nan
    circles: int = 0
    zones: int = 0

    @property
    def kept(self) -> bool:
        """The mission was accepted, and its flight kept everything."""
        is_high = min(self.share, self.end_share) >= SHARE
        is_straight = self.beside_m <= BESIDE_M and not self.circles
        return self.arrived and is_high and is_straight and not self.zones


def fly_export(problem: Problem, path: Floats, seed: int = 0) -> Outcome:
    """Export a path, upload it and fly it.

    Parameters
    ----------
    seed : int
        Seed of the turbulence.
    """
    try:
        return _flown(problem, path, seed)
    except JobError as error:
        return Outcome(refusal=str(error))


def _flown(problem: Problem, path: Floats, seed: int) -> Outcome:
    """Return the outcome of a mission; raise the error of a refused export or upload."""
    track = Evaluator(problem, threads=1).track(path)
    plan = flight_plan(problem, track, feasible=True)
    autopilot = launched(problem, plan, seed)
    give_mission(autopilot, plan)
    flown, arrived = fly_items(autopilot)
    return _judged(problem, autopilot, flown, arrived)


def _judged(problem: Problem, autopilot: Autopilot, flown: Flown, arrived: bool) -> Outcome:
    """Return the verdict on a flight."""
    terrain, plane = problem.terrain, autopilot.earth.plane
    lat, lon = np.array([plane.degrees((east, north)) for east, north in flown.place.tolist()]).T
    x, y = terrain.to_local(lat, lon)
    clearance = flown.altitude_m - known_surface_m(terrain, x, y)
    demanded = demanded_m(problem, x, y)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(demanded > 0, clearance / demanded, np.where(clearance > 0, 9.0, -1.0))
    # Beyond the edge of the map, the ground is unknown.
    shares[is_off_map(terrain, x, y)] = -1.0
    flown, items = with_places(flown, autopilot.lists.items[MISSION])
    waypoints = np.array([(*plane.local(item.lat, item.lon), item.z) for item in items])
    last = len(items) - 1
    on_way = (flown.index > 1) & (flown.index < last)
    beside, _, _ = from_legs(flown, waypoints)
    velocity = np.gradient(flown.place, flown.time_s, axis=0)
    heading = np.unwrap(np.arctan2(velocity[:, 0], velocity[:, 1]))[on_way]
    zones = sum(
        bool(zone.footprint.contains(x, y).any())
        for zone in problem.zones
        if not zone.limits.keys() - {"name"}
    )
    return Outcome(
        "",
        arrived,
        float(np.nanmin(shares[on_way], initial=9.0)),
        float(np.nanmin(shares[flown.index == last], initial=9.0)),
        float(beside[on_way].max(initial=0.0)),
        _circles(heading),
        zones,
    )


def with_places(flown: Flown, items: Sequence[Item]) -> tuple[Flown, list[Item]]:
    """Return a flight and its items without those that fly nowhere, such as changes of speed."""
    has = [item.navigates for item in items]
    numbers = np.cumsum(has) - 1
    flies = [item for item, navigates in zip(items, has, strict=True) if navigates]
    return replace(flown, index=numbers[flown.index]), flies


def _circles(heading_rad: Floats) -> int:
    """Return the number of full circles in headings that are a tick apart."""
    span = round(_FULL_S * 10)
    count, place = 0, 0
    while place + 1 < len(heading_rad):
        turned = np.abs(heading_rad[place : place + span] - heading_rad[place])
        full = np.flatnonzero(turned >= _FULL_RAD)
        if len(full):
            count += 1
            place += int(full[0])
        else:
            place += 10
    return count


def run(options: BenchOptions) -> Report:
    """Plan, upload and fly all missions without stored results; return the tables of all."""
    STORE.parent.mkdir(parents=True, exist_ok=True)
    store = Store(STORE, *_SOURCES)
    wanted = [each for each in missions() if options.only in f"{each.name} {each.planner}"]
    measure(
        "exports",
        [(each,) for each in wanted if store.get(each.name, each.planner) is None],
        _measure,
        name=lambda task: f"{task[0].name} {task[0].planner}",
        keep=lambda task, result: store.keep(task[0].name, task[0].planner, result),
    )
    report = _report([(each, store.get(each.name, each.planner) or {}) for each in wanted])
    report.further = [*report.further, landings.table(store, options.only)]
    return report


def _measure(mission: Mission) -> Result:
    """Return the outcome of a mission; without one, its path was not found."""

    def plan(task: Problem) -> tuple[bool, Floats]:
        found = mission.plan(task)
        return found.evaluation.feasible, found.path

    done = follow(mission.problem, plan, lambda task, path: _flown(task, path, mission.seed))
    if done.result is None and not done.refusal:
        return {"found": False, **({"note": done.note} if done.note else {})}
    outcome = done.result or Outcome(refusal=done.refusal)
    return {"found": True, "followed": done.followed, **_figures(outcome)}


def _figures(outcome: Outcome) -> Result:
    """Return an outcome as it is stored."""
    return {
        "kept": outcome.kept,
        **{
            name: round(value, 3) if isinstance(value, float) else value
            for name, value in asdict(outcome).items()
            if not (isinstance(value, float) and math.isnan(value))
        },
    }


def _report(results: list[tuple[Mission, Result]]) -> Report:
    """Return a table by aircraft and weather, one by planner, and the missions not kept."""
    measured = [(mission, result) for mission, result in results if result]
    flown = [(mission, result) for mission, result in measured if result["found"]]
    report = Report(
        "Exported missions by aircraft and weather",
        ["aircraft, weather", *_COLUMNS],
        [
            (f"{aircraft}, {weather}", *_cells(part))
            for aircraft in AIRCRAFT
            for weather in WEATHERS
            if (part := [r for m, r in flown if (m.aircraft, m.weather) == (aircraft, weather)])
        ],
    )
    by_planner = Report(
        "Exported missions by planner",
        ["planner", *_COLUMNS],
        [
            (planner, *_cells(part))
            for planner in PLANNERS
            if (part := [r for m, r in flown if m.planner == planner])
        ],
    )
    by_ground = Report(
        "Exported missions by ground",
        ["ground", *_COLUMNS],
        [
            (name, *_cells(part))
            for name, is_generated in (("the nine maps", False), ("generated hills", True))
            if (part := [r for m, r in flown if (m.terrain in GENERATED) == is_generated])
        ],
    )
    lost = Report(
        "Missions that are not kept",
        ["mission", "reason"],
        [(f"{m.name} {m.planner}", _reason(r)) for m, r in flown if not r["kept"]],
    )
    kept = sum(result["kept"] for _, result in flown)
    report.notes = [
        f"{kept} of {len(flown)} missions kept; {len(measured) - len(flown)} further ones have no "
        "path. The aircraft flies with the defaults of ArduPlane 4.6, its own speeds and its "
        "rates of climb and descent plus 5 %, in calm air or in wind of "
        f"{WIND_M_S:.0f} m/s with gusts of {GUSTS_M_S:.0f} m/s.",
        *missing(),
    ]
    if len(measured) < len(results):
        report.notes.append(f"Missions not measured yet: {len(results) - len(measured)}.")
    report.further = [by_planner, by_ground, *([lost] if lost.rows else [])]
    return report


def _cells(part: list[Result]) -> list[Any]:
    """Return the numbers of some missions, and the worst figures of their flights."""
    flown = [result for result in part if not result["refusal"]]

    def worst(key: str, choose: Callable[[list[float]], float], digits: int) -> object:
        values = [result[key] for result in flown if key in result]
        return round(choose(values), digits) if values else "-"

    return [
        len(part),
        sum(not result["followed"] for result in flown),
        sum(any(text.startswith("start") for text in result["followed"]) for result in flown),
        sum("goal higher" in result["followed"] for result in flown),
        sum("goal elsewhere" in result["followed"] for result in flown),
        len(part) - len(flown),
        sum(result["kept"] for result in part),
        worst("share", min, 2),
        worst("end_share", min, 2),
        worst("beside_m", max, 1),
    ]


def _reason(result: Result) -> str:
    """Return why a mission is not kept."""
    if result["refusal"]:
        return "refused: " + str(result["refusal"]).partition("; ")[0].rstrip(".")
    reasons = {
        "does not arrive": not result["arrived"],
        f"keeps {result['share']:.2f} on the way": result["share"] < SHARE,
        f"keeps {result['end_share']:.2f} at the end": result["end_share"] < SHARE,
        f"{result['beside_m']:.0f} m beside its legs": result["beside_m"] > BESIDE_M,
        f"{result['circles']} full circles": bool(result["circles"]),
        f"enters {result['zones']} zones": bool(result["zones"]),
    }
    return ", ".join(text for text, holds in reasons.items() if holds)
