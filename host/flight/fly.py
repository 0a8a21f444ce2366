"""The flight of a planned path: flown, judged, written."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.errors import InputError
from host.evaluation import Evaluator
from host.evaluation.track import SmoothedTrack
from host.flight.flight import PERIOD_S, Flight, Flown, fly_track
from host.flight.judge import Verdict, judge
from host.flight.models import FlightModel, model_for
from host.problem.aircraft import Aircraft
from host.problem.problem import Problem
from host.report.files import write_json
from host.report.summary import finite, version


__all__ = ["FlightReport", "fly"]

# Seconds between two points of the track in the file.
_POINT_S = 1.0
# What the file has of the track; more digits than the model's truth deserves cost space.
_COLUMNS = (
    ("t_s", 2),
    ("x", 2),
    ("y", 2),
    ("z", 2),
    ("along_m", 1),
    ("cross_m", 2),
    ("height_error_m", 2),
    ("airspeed_m_s", 2),
)


@dataclass(frozen=True, eq=False, kw_only=True)
class FlightReport:
    """A flight of a planned path.

    Parameters
    ----------
    problem : Problem
        The problem of the path.
    path : ndarray
        Waypoints, (n, 3) float64 metres.
    track : SmoothedTrack
        The smoothed path.
    flown : Flown
        Samples of the flight.
    verdict : Verdict
        What it kept and broke.
    model : FlightModel
        The aircraft that flew.
    aircraft : Aircraft
        Its figures: those that were planned for, unless another aircraft flew.
    wind : (float, float)
        Where the air moved to, m/s.
    gusts : str
        Turbulence.
    seed : int
        Its seed.
    """

    problem: Problem
    path: NDArray[np.float64]
    track: SmoothedTrack
    flown: Flown
    verdict: Verdict
    model: FlightModel
    aircraft: Aircraft
    wind: tuple[float, float]
    gusts: str
    seed: int

    def to_dict(self) -> dict[str, Any]:
        """The content of ``flight.json``; every number is finite, None stands for the others."""
        every = round(_POINT_S / PERIOD_S)
        table = {
            "pathgene": version(),
            "aircraft": self.model.name,
            "planned_for": self.problem.aircraft.name,
            "as_paper": self.problem.rules is None,
            "wind": list(self.wind),
            "gusts": self.gusts,
            "seed": self.seed,
            **self.verdict.to_dict(),
            "track": {
                name: np.round(getattr(self.flown, name)[::every], digits).tolist()
                for name, digits in _COLUMNS
            },
        }
        plain: dict[str, Any] = finite(table)
        return plain

    def save(self, directory: Path) -> list[Path]:
        """Write ``flight.json`` and ``flight.png`` into ``directory``; return their paths."""
        # Loads matplotlib, which flying does not need.
        from host.flight import picture

        written = [directory / "flight.json", directory / "flight.png"]
        write_json(written[0], self.to_dict())
        picture.write(self, written[1])
        return written


def fly(
    problem: Problem,
    path: NDArray[np.float64],
    model: FlightModel | None = None,
    *,
    wind: tuple[float, float] | None = None,
    gusts: str = "none",
    seed: int = 0,
) -> FlightReport:
    """Fly a path of ``problem`` in JSBSim and judge the flight.

    Parameters
    ----------
    problem : Problem
        The problem that the path was planned for.
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    model : FlightModel, optional
        The aircraft that flies; by default that which was planned for. Another one flies with its
        own speed and limits.
    wind : (float, float), optional
        Where the air moves to, m/s in x and y; by default the wind that was planned for.
    gusts : str
        Dryden turbulence: none, light, moderate or severe.
    seed : int
        Its seed: the same seed gives the same flight.

    Raises
    ------
    InputError
        If the aircraft planned for has no flight model, the wind is not below its airspeed, or
        JSBSim is missing.
    JobError
        If the aircraft is lost before the start of the path.
    """
    planned = model_for(problem.aircraft) if model is None else model
    aircraft = planned.figures()
    if aircraft.name == problem.aircraft.name:
        aircraft = problem.aircraft
    wind = problem.wind if wind is None else wind
    airspeed = aircraft.cruise_speed_m_s
    slowest = airspeed - math.hypot(*wind)
    if not slowest > 0:
        raise InputError(
            f"A wind of {math.hypot(*wind):g} m/s is not below the airspeed of {aircraft.name}, "
            f"{airspeed:g} m/s; reduce it."
        )
    track = Evaluator(problem, threads=1).track(path)
    if not any(piece.run_m > 0 for piece in track.pieces):
        raise InputError("The path is vertical, so no aircraft flies it.")
    flight = Flight(
        track.pieces, problem.terrain, aircraft, planned, wind=wind, gusts=gusts, seed=seed
    )
    flown = fly_track(flight, airspeed, slowest)
    return FlightReport(
        problem=problem,
        path=path,
        track=track,
        flown=flown,
        verdict=judge(problem, track, flown, aircraft),
        model=planned,
        aircraft=aircraft,
        wind=wind,
        gusts=gusts,
        seed=seed,
    )
