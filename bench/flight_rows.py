"""Rows of flights: a map, an aircraft and a weather, with the problem to plan."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bench.scenarios import problem
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem


__all__ = ["AIRCRAFT", "WEATHERS", "WIND_M_S", "Row", "gusts_of", "winds_of"]

AIRCRAFT = ("silver-fox", "c172p")
#: Calm air, or wind along the line from start to goal or across it, with light turbulence.
WEATHERS = ("calm", "along", "across")
WIND_M_S = 8.0


def winds_of(east: float, north: float) -> dict[str, tuple[float, float]]:
    """Return the wind of each weather, m/s, for a way in the direction of a unit vector."""
    east, north = WIND_M_S * east, WIND_M_S * north
    return {"calm": (0.0, 0.0), "along": (east, north), "across": (-north, east)}


def gusts_of(weather: str) -> str:
    """Return the turbulence of a weather, as ``pathgene fly --gusts`` takes it."""
    return "none" if weather == "calm" else "light"


@dataclass(frozen=True)
class Row:
    """A row of the table."""

    terrain: str
    #: The aircraft that is planned for and flown.
    aircraft: str
    #: The weather that is planned for and flown: calm air, or 8 m/s along the line from start to
    #: goal or across it, with light turbulence.
    weather: str
    #: Planned by the evaluation of the papers.
    as_paper: bool

    @property
    def name(self) -> str:
        """Name in the table, which ``--only`` is compared with."""
        mode = "paper mode" if self.as_paper else "safe"
        return f"{self.terrain} {self.aircraft} {self.weather} {mode}"

    def problem(self) -> Problem:
        """Return the problem to plan.

        Raises
        ------
        InputError
            If start or goal are impossible for this aircraft.
        """
        scenario = problem(self.terrain)
        (x0, y0, _), (x1, y1, _) = scenario.start, scenario.goal
        way = math.hypot(x1 - x0, y1 - y0)
        winds = winds_of((x1 - x0) / way, (y1 - y0) / way)
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
