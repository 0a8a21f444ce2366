"""Check of a mission of any ground station: its flight, its faults, and their remedies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.formats.mission_items import AMSL, ARDUPILOT, PX4, MissionFile, line_file
from pathgene.host.formats.places import check_place
from pathgene.host.mission.foreign.commands import Frame
from pathgene.host.mission.foreign.course import Chain, Point
from pathgene.host.mission.foreign.faults import Fault
from pathgene.host.mission.foreign.flight import Aims, Flight, flight_of
from pathgene.host.mission.foreign.home import MOST_M, Surroundings
from pathgene.host.mission.foreign.judge import FlightProblem, Judge
from pathgene.host.mission.foreign.remedies import Remedy, remedy
from pathgene.host.mission.foreign.words import change_of, counted, fault_line, where
from pathgene.host.remarks import Grade, Reading, Remark
from pathgene.host.terrain import Terrain
from pathgene.host.version import version


__all__ = ["RETURN_M", "MissionCheck", "check_mission", "check_path", "checked_by", "judge_of"]

#: Heights of returns above home, as the autopilots ship them: RTL_ALTITUDE and RTL_RETURN_ALT.
RETURN_M = {ARDUPILOT: 100.0, PX4: 60.0}

_FRAMES = {
    Frame.AMSL: "above mean sea level",
    Frame.HOME: "above home",
    Frame.GROUND: "above the ground, straight between the items",
}
# Remedies are searched for this number of faults.
_MOST_REMEDIES = 100


@dataclass(frozen=True, eq=False)
class MissionCheck:
    """The verdict on a mission.

    Parameters
    ----------
    mission : MissionFile
        The mission as the file states it.
    flight : Flight
        The mission as it is flown.
    judge : Judge
        Its judge.
    reading : Reading
        Facts that were read or assumed.
    faults : list of Fault
        Its faults, in flying order; empty if the mission is feasible.
    """

    mission: MissionFile
    flight: Flight
    judge: Judge
    reading: Reading
    faults: list[Fault]

    @property
    def feasible(self) -> bool:
        """True if no limit is broken."""
        return not self.faults

    @cached_property
    def remedies(self) -> list[Remedy | None]:
        """The remedy of each fault, where one was found."""
        found = [
            remedy(self.judge, self.flight.chains, fault, self.faults)
            for fault in self.faults[:_MOST_REMEDIES]
        ]
        return [*found, *[None] * (len(self.faults) - len(found))]

    @cached_property
    def _lowest(self) -> tuple[float, int, int] | None:
        return self.judge.lowest(self.flight.chains)

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Names and texts of the main figures."""
        legs = sum(len(chain.points) - 1 for chain in self.flight.chains)
        lowest = self._lowest
        text = "none: no leg is judged in the air"
        if lowest is not None:
            height, chain, leg = lowest
            at = where(self.flight.chains[chain], leg, is_leg=True)
            shown = "unknown over a void" if math.isnan(height) else f"{height:.1f} m"
            text = f"{shown}, {at}"
        return [
            ("feasible", "yes" if self.feasible else "no"),
            ("faults", str(len(self.faults))),
            ("items", f"{len(self.mission.items)}, {counted(legs, 'leg')} flown"),
            ("length", f"{self._length_m:.1f} m"),
            ("minimum clearance", text),
        ]

    @property
    def lines(self) -> Iterator[str]:
        """A line for each fault, with its number."""
        for number, table in enumerate(self.tables, start=1):
            yield f"{number}. {table['sentence']}"

    @property
    def tables(self) -> list[dict[str, Any]]:
        """A table for each fault, as in the report."""
        return [
            {"number": number, **self._table(fault, found)}
            for number, (fault, found) in enumerate(
                zip(self.faults, self.remedies, strict=True), start=1
            )
        ]

    @property
    def report(self) -> dict[str, Any]:
        """The output of ``pathgene check --json``: plain JSON values, every number finite."""
        problem = self.judge.problem
        lowest = self._lowest
        least = None if lowest is None or math.isnan(lowest[0]) else lowest[0]
        assert problem.rules is not None
        return {
            "pathgene": version(),
            "feasible": self.feasible,
            "faults": self.tables,
            "minimum_clearance_m": least,
            "length_m": self._length_m,
            "legs": [
                where(chain, leg, is_leg=True)
                for chain in self.flight.chains
                for leg in range(len(chain.points) - 1)
            ],
            "read": {"mission": self.reading.to_dict()},
            "terrain": problem.terrain.describe(),
            "uav": problem.aircraft.to_dict(),
            "wind": list(problem.wind),
            "rules": problem.rules.to_dict(),
        }

    @property
    def _length_m(self) -> float:
        return sum(
            float(self.judge.track(chain.points).length_m)
            for chain in self.flight.chains
            if len(chain.points) > 1
        )

    def _table(self, fault: Fault, found: Remedy | None) -> dict[str, Any]:
        """Return a fault as in the report."""
        chains, problem = self.flight.chains, self.judge.problem
        points = chains[fault.chain].points
        own = points[fault.leg : fault.leg + (2 if fault.is_leg else 1)]
        numbers = [
            point.handle[1] if point.handle and point.handle[0] == "item" else None for point in own
        ]
        x, y, z = fault.place
        place: dict[str, Any] = {"x_m": x, "y_m": y}
        if problem.terrain.crs is not None:
            lat, lon = problem.terrain.to_geographic(x, y)
            place = {"lat": float(lat), "lon": float(lon)}
        return {
            "limit": fault.limit,
            "where": where(chains[fault.chain], fault.leg, is_leg=fault.is_leg),
            "items": numbers,
            **place,
            "altitude_m": z,
            "from_m": fault.span_m[0] if fault.is_leg else None,
            "to_m": fault.span_m[1] if fault.is_leg else None,
            "allowed_m": fault.allowed,
            "value_m": fault.value,
            "broken_by_m": fault.metres,
            "sentence": fault_line(chains, fault, found, problem),
            "change": None if found is None else change_of(chains, found, problem),
        }


def check_mission(
    mission: MissionFile, problem: FlightProblem, return_m: float | None = None
) -> MissionCheck:
    """Judge a mission.

    Parameters
    ----------
    problem : FlightProblem
        Terrain, aircraft, zones, wind and rules; its ends do not count.
    return_m : float, optional
        Height above home of a return to launch; by default the autopilot's own.

    Raises
    ------
    InputError
        If an item cannot be judged, the terrain has no place on Earth or holds no part of the
        mission, or the aircraft stalls in every turn.
    """
    return checked_by(judge_of(problem), mission, return_m)


def judge_of(problem: FlightProblem) -> Judge:
    """Return the judge of missions for a problem.

    Raises
    ------
    InputError
        If the terrain has no place on Earth, or the aircraft stalls in every turn.
    """
    check_place(problem.terrain)
    judge = Judge(problem)
    if not math.isfinite(judge.radius_m):
        raise InputError(
            f"{problem.aircraft.name} stalls in every turn at its cruise speed of "
            f"{problem.aircraft.cruise_speed_m_s:g} m/s; choose another UAV."
        )
    return judge


def checked_by(judge: Judge, mission: MissionFile, return_m: float | None = None) -> MissionCheck:
    """Judge a mission by a judge that stands; see :func:`check_mission`."""
    problem = judge.problem
    if return_m is not None and not 0 <= return_m <= MOST_M:
        raise InputError(
            f"the height of a return must be from 0 to {MOST_M:,.0f} m above home, not "
            f"{return_m:g} (--return-height)."
        )
    around = Surroundings(mission, problem.terrain)
    aims = Aims(
        judge.radius_m,
        problem.aircraft.cruise_speed_m_s,
        math.tan(max(problem.limits.climb_rad, 0.0)),
        RETURN_M[mission.autopilot or ARDUPILOT] if return_m is None else return_m,
    )
    flight = flight_of(mission, around, aims)
    _check_on_map(flight, problem.terrain)
    reading = _reading(mission, flight, around, return_m)
    faults = _once(flight, judge.faults(flight.chains))
    return MissionCheck(mission, flight, judge, reading, faults)


def check_path(problem: FlightProblem, path: NDArray[np.float64]) -> MissionCheck:
    """Judge the waypoints of a path, (n, 3) metres, as points of a mission."""
    points = tuple(
        Point(x, y, z, f"point {number}", ("item", number))
        for number, (x, y, z) in enumerate(path.tolist(), start=1)
    )
    judge = Judge(problem)
    flight = Flight((Chain(points),), (), (), False)
    mission = line_file("a path", [], AMSL)
    faults = _once(flight, judge.faults(flight.chains))
    return MissionCheck(mission, flight, judge, Reading(), faults)


def _once(flight: Flight, faults: list[Fault]) -> list[Fault]:
    """Return the worst fault of each leg and limit, where jumps repeat a leg."""
    worst: dict[tuple[str, str], Fault] = {}
    for fault in faults:
        key = where(flight.chains[fault.chain], fault.leg, is_leg=fault.is_leg), fault.limit
        if key not in worst or fault.metres > worst[key].metres:
            worst[key] = fault
    return list(worst.values())


def _check_on_map(flight: Flight, terrain: Terrain) -> None:
    """Refuse a mission none of whose points lies on the map."""
    points = [point for chain in flight.chains for point in chain.points]
    if any(
        0 <= each.x_m <= terrain.width_m and 0 <= each.y_m <= terrain.height_m for each in points
    ):
        return
    first = points[0]
    lat, lon = terrain.to_geographic(first.x_m, first.y_m)
    raise InputError(
        f"the mission lies outside the map: {first.name} is at {lat:.6f}, {lon:.6f}; give the "
        "terrain of its place."
    )


def _reading(
    mission: MissionFile, flight: Flight, around: Surroundings, return_m: float | None
) -> Reading:
    """Return the facts of a mission and the assumptions on it."""
    home, terrain = around.home, around.terrain
    facts: dict[str, Any] = {
        "kind": mission.kind,
        "items": len(mission.items),
        "heights": [_FRAMES[frame] for frame in Frame if frame in around.used],
        "home": None,
        "ignored": list(flight.ignored),
        "rally_points": len(mission.rally),
    }
    if home is not None:
        lat, lon = terrain.to_geographic(home.x_m, home.y_m)
        facts["home"] = {"lat": float(lat), "lon": float(lon), "altitude_m": home.z_m}
    more = []
    if flight.returns and return_m is None:
        autopilot = mission.autopilot or ARDUPILOT
        text = (
            f"the height of the return, {RETURN_M[autopilot]:g} m above home, is the default of "
            f"{autopilot}; --return-height states another one."
        )
        more.append(Remark(Grade.WARNING, text))
    for name, numbers in _transects(mission).items():
        text = f"{name} is flown by its stored transects, items {numbers[0]} to {numbers[-1]}."
        more.append(Remark(Grade.NOTE, text))
    first = flight.chains[0].points[0]
    if mission.home is not None and not first.is_ground and first.name != "home":
        text = f"the way from home to {first.name} is not judged, because there is no take-off."
        more.append(Remark(Grade.NOTE, text))
    return Reading(facts, (*mission.remarks, *around.remarks, *flight.remarks, *more))


def _transects(mission: MissionFile) -> dict[str, list[int]]:
    """Return the numbers of the items of each survey and corridor."""
    found: dict[str, list[int]] = {}
    for item in mission.items:
        if item.within:
            found.setdefault(item.within, []).append(item.number)
    return found
