"""The flight of a planned path: fly it, judge it, write its files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.files.output import json_bytes
from pathgene.host.files.replacement import replace_files
from pathgene.host.flight.autopilots import IDEAL, autopilot_named
from pathgene.host.flight.flight import Flight, fly_track
from pathgene.host.flight.judge import judge
from pathgene.host.flight.mission import fly_mission
from pathgene.host.flight.models import model_for, model_named
from pathgene.host.flight.report import FlightReport
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.hand_over import USUAL, HandOver
from pathgene.host.planners.base import Stop
from pathgene.host.problem.problem import Problem
from pathgene.host.report.run_files import FLIGHT


__all__ = ["draw", "fly", "save", "write"]


def fly(
    problem: Problem,
    path: ArrayLike,
    aircraft: str | None = None,
    *,
    wind: tuple[float, float] | None = None,
    gusts: str = "none",
    seed: int = 0,
    guidance: str = IDEAL,
    wanted: HandOver = USUAL,
    stop: Stop | None = None,
) -> FlightReport:
    """Fly a path of ``problem`` in JSBSim and judge the flight.

    Parameters
    ----------
    problem : Problem
        The problem that the path was planned for.
    path : array_like
        Waypoints, (n, 3) metres, start and goal included.
    aircraft : str, optional
        The aircraft that flies, ``"silver-fox"``, ``"c172p"`` or ``"j3cub"``; by default the
        aircraft that the path was planned for. Another aircraft flies with its own speed and
        limits.
    wind : (float, float), optional
        Velocity of the air, m/s towards true east and true north; by default the planned wind.
    gusts : str
        Dryden turbulence: none, light, moderate or severe.
    seed : int
        Seed of the turbulence: the same seed gives the same flight.
    guidance : str
        ``"ideal"`` follows the planned track itself. ``"ardupilot"`` and ``"px4"`` fly the exported
        mission item by item and its end, by the laws of that autopilot.
    wanted : HandOver
        The user's choices about the exported mission, such as its end.
    stop : Stop, optional
        Ends the flight early: the part that was flown is judged and counts as not kept.

    Raises
    ------
    InputError
        If the aircraft has no flight model, the wind is not below its airspeed, there is no such
        guidance, an exported mission has no place on Earth, or JSBSim, of the extra ``fly``, or
        pymavlink, of the extra ``mavlink``, is missing.
    JobError
        If the aircraft is lost before the start of the path, or the mission is not exported,
        because its end has no room or it climbs too late, or the autopilot refuses it.
    KeyboardInterrupt
        If ``stop`` ends the flight before the start of the path.
    """
    autopilot = None if guidance == IDEAL else autopilot_named(guidance)
    model = model_for(problem.aircraft) if aircraft is None else model_named(aircraft)
    figures = model.figures()
    if figures.name == problem.aircraft.name:
        figures = problem.aircraft
    path = np.array(path, dtype=np.float64)
    wind = problem.wind if wind is None else wind
    airspeed = figures.cruise_speed_m_s
    slowest = airspeed - math.hypot(*wind)
    if not slowest > 0:
        raise InputError(
            f"A wind of {math.hypot(*wind):g} m/s is not below the airspeed of {figures.name}, "
            f"{airspeed:g} m/s; reduce it."
        )
    evaluator = Evaluator(problem, threads=1)
    track = evaluator.track(path)
    if not any(piece.run_m > 0 for piece in track.pieces):
        raise InputError("The path is vertical, so no aircraft flies it.")
    # An export that is refused is refused before anything flies.
    plan = (
        None
        if autopilot is None
        else flight_plan(problem, track, feasible=evaluator.evaluate(path).feasible, wanted=wanted)
    )
    flight = Flight(
        track.pieces,
        problem.terrain,
        figures,
        model,
        wind=problem.in_frame(wind),
        gusts=gusts,
        seed=seed,
    )
    notes: list[str] = []
    if autopilot is None or plan is None:
        flown = fly_track(flight, airspeed, slowest, stop)
    else:
        flown, notes = fly_mission(flight, plan, autopilot, problem, (model, figures), stop)
    return FlightReport(
        problem=problem,
        path=path,
        track=track,
        flown=flown,
        verdict=judge(problem, track, flown, figures),
        model=model,
        aircraft=figures,
        wind=wind,
        gusts=gusts,
        seed=seed,
        guidance=guidance,
        title="" if autopilot is None else autopilot.title,
        items=0 if plan is None else len(plan.items),
        notes=notes,
    )


def save(report: FlightReport, directory: Path) -> list[Path]:
    """Write ``flight.json`` and ``flight.png`` into ``directory``; return their paths."""
    return [write(report, directory), *draw(report, directory)]


def write(report: FlightReport, directory: Path) -> Path:
    """Write ``flight.json``, and remove misleading pictures of an earlier flight."""
    replace_files(directory, {FLIGHT[0]: json_bytes(report.to_dict())}, gone=FLIGHT)
    return directory / FLIGHT[0]


def draw(report: FlightReport, directory: Path) -> list[Path]:
    """Write ``flight.png``; return its path in a list."""
    # Loads matplotlib, which flying does not need.
    from pathgene.host.flight import picture
    from pathgene.host.report import style

    written = directory / FLIGHT[1]
    style.save(picture.draw(report), written)
    return [written]
