"""Planned missions, uploaded to the simulated autopilot and flown by it.

The mission is the exported one: it travels over MAVLink by ``host/mission/autopilot``, and the
autopilot flies the items that it has accepted, with ArduPlane's laws. The verdict is on the flight:
half of the required clearance, also on the circle at the end, no zone, no full circle on the way,
and no more than 25 m beside the legs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.autopilot import Flown, from_legs
from bench.flight import AIRCRAFT, WEATHERS, WIND_M_S, Row
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import missing, names
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.flight.flight import limits_of
from pathgene.host.flight.ground import demanded_m, known_surface_m
from pathgene.host.flight.judge import SHARE
from pathgene.host.formats.flight_plan import WAYPOINT
from pathgene.host.formats.places import degrees
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.mavlink_link import Link
from pathgene.host.mission.autopilot.upload import upload
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import surface_below
from pathgene.sim.autopilot.airframe import Airframe
from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.connection import Connection
from pathgene.sim.autopilot.items import MISSION, Item
from pathgene.sim.autopilot.parameters import ARDUPLANE, Parameters
from pathgene.sim.autopilot.pilot import Kind, Mode
from pathgene.sim.autopilot.wind import Wind


__all__ = ["Outcome", "fly_export", "run", "with_places"]

#: Maximum distance beside the legs.
BESIDE_M = 25.0
# Seconds of the final circle that are flown.
_CIRCLE_S = 120.0
# A turn by this angle within this time, before the end, is a full circle.
_FULL_RAD, _FULL_S = math.radians(330), 40.0
_GUSTS_M_S = 1.0

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Outcome:
    """The flight of an exported mission.

    Parameters
    ----------
    refusal : str
        The sentence of a refused upload, or empty.
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


def airframe_of(aircraft: Aircraft) -> Airframe:
    """Return the simulated airframe of a planner's aircraft."""
    return Airframe.of(
        weight_n=aircraft.weight_N,
        wing_area_m2=aircraft.wing_area_m2,
        span_m=aircraft.wing_span_m,
        drag_zero=aircraft.zero_lift_drag_coefficient,
        lift_max=aircraft.lift_coefficient_max or 1.4,
        power_w=aircraft.engine_power_W or 30 * aircraft.weight_N,
        cruise_m_s=aircraft.cruise_speed_m_s,
    )


def parameters_of(aircraft: Aircraft) -> Parameters:
    """Return ArduPlane's defaults with the speeds of an aircraft, and its rates up and down.

    The rates are a margin above the aircraft's limits, as :func:`limits_of` returns them.
    """
    most = limits_of(aircraft)
    lift = aircraft.lift_coefficient_max or 1.4
    stall = math.sqrt(2 * aircraft.weight_N / (1.225 * aircraft.wing_area_m2 * lift))
    speed = aircraft.cruise_speed_m_s
    return Parameters(
        ARDUPLANE,
        {
            "AIRSPEED_CRUISE": speed,
            "AIRSPEED_MIN": min(1.2 * stall, 0.9 * speed),
            "AIRSPEED_MAX": 1.4 * speed,
            "TECS_CLMB_MAX": most.climb_m_s,
            "TECS_SINK_MAX": most.descent_m_s,
            "THR_MAX": 100.0,
        },
    )


def _wind(terrain: Terrain, wind: tuple[float, float], at: Sequence[float], seed: int) -> Wind:
    """Return the wind of a problem, turned from the terrain's axes to east and north."""
    if not any(wind):
        return Wind()
    x, y = at[0], at[1]
    lat, lon = np.array(degrees(terrain, np.array([x, x]), np.array([y, y + 1000.0]))).T
    north = lat[1] - lat[0]
    east = (lon[1] - lon[0]) * math.cos(math.radians(lat[0]))
    turn = math.atan2(east, north)
    sine, cosine = math.sin(turn), math.cos(turn)
    return Wind(
        wind[0] * cosine + wind[1] * sine,
        wind[1] * cosine - wind[0] * sine,
        gusts_m_s=_GUSTS_M_S,
        seed=seed,
    )


def fly_export(problem: Problem, path: Floats, seed: int = 0) -> Outcome:
    """Export a path, upload it and fly it.

    Parameters
    ----------
    seed : int
        Seed of the turbulence.
    """
    terrain = problem.terrain
    track = Evaluator(problem, threads=1).track(path)
    plan = flight_plan(problem, track, feasible=True)
    first, second, *_ = (item for item in plan.items if item.command == WAYPOINT)
    start = Start(plan.home, height_m=first.alt_m - plan.home[2], armed=False)

    def ground(lat: float, lon: float) -> float:
        x, y = terrain.to_local(np.array([lat]), np.array([lon]))
        return float(surface_below(terrain, x, y, void_m=math.nan)[0])

    east = (second.lon - first.lon) * math.cos(math.radians(first.lat))
    heading = math.degrees(math.atan2(east, second.lat - first.lat))
    autopilot = Autopilot(
        Kind.ARDUPLANE,
        Start(start.home, (0.0, 0.0), start.height_m, heading, armed=False),
        parameters=parameters_of(problem.aircraft),
        airframe=airframe_of(problem.aircraft),
        wind=_wind(terrain, problem.wind, problem.start, seed),
        ground=ground,
    )
    connection = Connection(autopilot)
    link = Link(connection, clock=connection.clock)
    link.find(5.0)
    try:
        upload(plan, link)
    except JobError as error:
        return Outcome(refusal=str(error))
    flown, arrived = _flown(autopilot)
    return _judged(problem, autopilot, flown, arrived)


def _flown(autopilot: Autopilot) -> tuple[Flown, bool]:
    """Fly the mission that the autopilot holds, and a while of its end."""
    pilot = autopilot.pilot
    vehicle = pilot.vehicle
    pilot.fly_mission()
    last = len(autopilot.lists.items[MISSION]) - 1
    rows = []
    end_s = math.inf
    most_s = 5000.0
    while pilot.time_s < min(end_s, most_s):
        pilot.tick()
        is_last = pilot.mode is not Mode.AUTO or pilot.sequencer.index == last
        if is_last and end_s == math.inf:
            end_s = pilot.time_s + _CIRCLE_S
        number = last if is_last else pilot.sequencer.index
        bank = math.degrees(vehicle.roll_rad)
        rows.append((pilot.time_s, *vehicle.place, vehicle.altitude_m, bank, number))
    table = np.array(rows)
    index = table[:, 5].astype(np.int64)
    return Flown(table[:, 0], table[:, 1:3], table[:, 3], table[:, 4], index), end_s < math.inf


def _judged(problem: Problem, autopilot: Autopilot, flown: Flown, arrived: bool) -> Outcome:
    """Return the verdict on a flight."""
    terrain, plane = problem.terrain, autopilot.earth.plane
    lat, lon = np.array([plane.degrees((east, north)) for east, north in flown.place.tolist()]).T
    x, y = terrain.to_local(lat, lon)
    clearance = flown.altitude_m - known_surface_m(terrain, x, y)
    demanded = demanded_m(problem, x, y)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(demanded > 0, clearance / demanded, np.where(clearance > 0, 9.0, -1.0))
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
    """Plan with `astar` on every map with a place, upload and fly."""
    report = Report(
        "Planned missions, uploaded to the simulated ArduPlane and flown by it",
        [
            *("map, aircraft, weather", "accepted", "kept", "least share", "at the end"),
            *("beside the legs, m", "full circles", "zones entered"),
        ],
    )
    total = kept = 0
    for name in names():
        for aircraft in AIRCRAFT:
            for weather in WEATHERS:
                row = Row(name, aircraft, weather, False)
                if options.only not in row.name:
                    continue
                outcome = _measure(row)
                if outcome is None:
                    continue
                total += 1
                kept += outcome.kept
                report.rows.append(_cells(row, outcome))
    report.notes += [
        f"{kept} of {total} missions kept. The aircraft flies with the defaults of ArduPlane 4.6, "
        "its own speeds and its rates of climb and descent plus 5 %; the planner `astar` by the "
        f"rules; wind of {WIND_M_S:.0f} m/s with gusts of {_GUSTS_M_S:.0f} m/s.",
        *missing(),
    ]
    return report


def _measure(row: Row) -> Outcome | None:
    """Return the outcome of a row, or None if it has no path."""
    try:
        task = row.problem()
        found = make("astar").plan(Evaluator(task, threads=1), Options(seed=0, generations=1))
    except InputError:
        return None
    return fly_export(task, found.path) if found.evaluation.feasible else None


def _cells(row: Row, outcome: Outcome) -> list[Any]:
    return [
        row.name.removesuffix(" safe"),
        outcome.refusal or "yes",
        "yes" if outcome.kept else "no",
        round(outcome.share, 2),
        round(outcome.end_share, 2),
        round(outcome.beside_m, 1),
        outcome.circles,
        outcome.zones,
    ]
