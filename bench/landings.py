"""Landings of exported missions in calm air and in wind, on level ground, by both autopilots.

The simulated autopilots fly the exported landing in gusts. The verdict is on the true track: where
it touches down, how high it passes the place, and the share of the clearance that it keeps on the
glide.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.campaign import measure
from bench.export_missions import AIRCRAFT
from bench.flight_rows import WIND_M_S
from bench.report import Report
from bench.store import Result, Store
from pathgene.host.evaluation import Evaluator
from pathgene.host.flight.ground import demanded_m
from pathgene.host.formats.flight_plan import FlightPlan
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.hand_over import HandOver
from pathgene.host.mission.ending import Ending
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.origin import at_origin
from pathgene.sim.autopilot.items import MISSION, Command
from pathgene.sim.autopilot.pilot import Kind, Mode
from pathgene.sim.autopilot_flight import GUSTS_M_S, give_mission, launched


__all__ = ["WINDS", "Landed", "Landing", "exported", "fly_landing", "landings", "table"]

#: Wind of a landing to the north, m/s east and north.
WINDS = {
    "calm": (0.0, 0.0),
    "head": (0.0, -WIND_M_S),
    "cross": (WIND_M_S, 0.0),
    "tail": (0.0, WIND_M_S),
}
# Flights of a landing, each with its own gusts.
_SEEDS = range(4)
# Side of the ground and of its cells, start and goal, touch-down and its heading.
_SIDE_M, _CELL_M = 24_000.0, 100.0
_START, _GOAL = (7500.0, 6500.0, 200.0), (9000.0, 8000.0, 200.0)
_LAND = (12_000.0, 16_000.0, 0.0)
# South-west corner of the ground, latitude and longitude.
_PLACE = (46.0, 8.0)
# Share of the height above the touch-down that is required as clearance, as docs/files.md says.
_SHARE_OF_HEIGHT = 0.5
# Below this height of the glide ArduPlane may flare, and no clearance is required.
_FLARE_M = 6.0
# A flight that lasts longer is lost.
_MOST_S = 3000.0
_COLUMNS = ("aircraft, wind", "autopilot", "glide, degrees", "first, m", "median, m", "last, m")
_MORE = ("beside, m", "over the place, m", "least share")


@dataclass(frozen=True)
class Landing:
    """A landing to fly: names of the aircraft, the wind and the autopilot."""

    aircraft: str
    wind: str
    autopilot: str

    @property
    def name(self) -> str:
        """Name in the store, without the autopilot."""
        return f"landing {self.aircraft} {self.wind}"

    def problem(self) -> Problem:
        """Return the problem whose path the landing follows."""
        cells = round(_SIDE_M / _CELL_M) + 1
        level = Terrain("level", np.zeros((cells, cells)), _CELL_M, _CELL_M)
        plane = aircraft.load(self.aircraft)
        ground = at_origin(level, *_PLACE)
        return Problem(ground, _START, _GOAL, plane, wind=WINDS[self.wind])


@dataclass(frozen=True)
class Landed:
    """A flown landing.

    Parameters
    ----------
    glide_deg : float
        Slope of the exported glide.
    along_m, across_m : float
        Touch-down beyond the place and beside the centreline.
    over_m : float
        Height at which the aircraft passes the place, 0 if it touches down before.
    share : float
        Minimum share of the required clearance on the glide.
    """

    glide_deg: float
    along_m: float
    across_m: float
    over_m: float
    share: float


def landings() -> list[Landing]:
    """Return all landings."""
    return [
        Landing(plane, wind, kind.name) for plane in AIRCRAFT for wind in WINDS for kind in Kind
    ]


def exported(landing: Landing) -> tuple[Problem, FlightPlan]:
    """Return a problem and its flight plan with the landing."""
    problem = landing.problem()
    track = Evaluator(problem, threads=1).track(np.array([problem.start, problem.goal]))
    wanted = HandOver(ending=Ending("land", _LAND))
    return problem, flight_plan(problem, track, feasible=True, wanted=wanted)


def fly_landing(problem: Problem, plan: FlightPlan, kind: Kind, seed: int) -> Landed:
    """Upload a landing and fly it.

    Parameters
    ----------
    seed : int
        Seed of the gusts.
    """
    autopilot = launched(problem, plan, seed, kind, gusts_m_s=GUSTS_M_S)
    give_mission(autopilot, plan)
    autopilot.fly_mission()
    pilot, rows = autopilot.pilot, []
    while pilot.mode is not Mode.LANDED and pilot.time_s < _MOST_S:
        pilot.tick()
        if pilot.sequencer.command == Command.LAND:
            rows.append((*pilot.vehicle.place, pilot.vehicle.altitude_m))
    plane = autopilot.earth.plane
    *_, before, point = (item for item in autopilot.lists.items[MISSION] if item.navigates)
    begin, end = (np.array(plane.local(item.lat, item.lon)) for item in (before, point))
    length = math.dist(begin, end)
    east, north = (end - begin) / length
    flown = np.array(rows)
    offset = flown[:, :2] - end
    along = offset @ (east, north)
    across = offset @ (north, -east)
    height = flown[:, 2] - point.z
    slope = (before.z - point.z) / length
    line = -along * slope
    required = np.minimum(_SHARE_OF_HEIGHT * line, demanded_m(problem, *np.array([_LAND[:2]]).T))
    judged = line > _FLARE_M
    at_place = height[along >= 0]
    return Landed(
        math.degrees(math.atan(slope)),
        float(along[-1]),
        float(across[-1]),
        float(at_place[0]) if at_place.size else 0.0,
        float(np.min(height[judged] / required[judged])),
    )


def table(store: Store, only: str) -> Report:
    """Fly the landings without stored results whose names contain a text; return their table."""
    wanted = [each for each in landings() if only in f"{each.name} {each.autopilot}"]
    measure(
        "landings",
        [(each,) for each in wanted if store.get(each.name, each.autopilot) is None],
        _measure,
        name=lambda task: f"{task[0].name} {task[0].autopilot}",
        keep=lambda task, result: store.keep(task[0].name, task[0].autopilot, result),
    )
    rows: list[Sequence[Any]] = [
        _row(each, result)
        for each in wanted
        if (result := store.get(each.name, each.autopilot)) is not None
    ]
    note = (
        f"Landings on level ground in gusts of {GUSTS_M_S:.0f} m/s and wind of {WIND_M_S:.0f} m/s, "
        f"{len(_SEEDS)} flights a row. First, median and last touch-down are metres after the "
        "place, a minus before it. The share is of the clearance that is required on the glide."
    )
    return Report("Landings in wind", (*_COLUMNS, *_MORE), rows, [note])


def _measure(landing: Landing) -> Result:
    problem, plan = exported(landing)
    flown = [fly_landing(problem, plan, Kind[landing.autopilot], seed) for seed in _SEEDS]
    along = [each.along_m for each in flown]
    return {
        "glide_deg": flown[0].glide_deg,
        "first_m": min(along),
        "median_m": float(np.median(along)),
        "last_m": max(along),
        "beside_m": max(abs(each.across_m) for each in flown),
        "over_m": max(each.over_m for each in flown),
        "share": min(each.share for each in flown),
    }


def _row(landing: Landing, result: Result) -> Sequence[Any]:
    return (
        f"{landing.aircraft}, {landing.wind}",
        "ArduPlane" if landing.autopilot == Kind.ARDUPLANE.name else "PX4",
        round(result["glide_deg"], 1),
        *(round(result[key]) for key in ("first_m", "median_m", "last_m")),
        *(round(result[key], 1) for key in ("beside_m", "over_m")),
        round(result["share"], 2),
    )
