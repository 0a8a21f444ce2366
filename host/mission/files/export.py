"""Files of a planned path for ground stations and viewers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from host.errors import InputError
from host.evaluation import Evaluator
from host.files.output import replacing, write_json, writing_into
from host.mission.files.flight_plan import check_place, flight_plan
from host.problem.problem import Problem
from host.report.geojson import path_document
from host.terrain import Terrain


__all__ = ["FORMATS", "check_formats", "export", "parse_formats"]

#: File that each format is written to.
FORMATS = {
    "plan": "path.plan",
    "waypoints": "path.waypoints",
    "kml": "path.kml",
    "geojson": "path.geojson",
}

# GeoJSON has local metres as well.
_WITHOUT_PLACE = ("geojson",)


def parse_formats(text: str) -> tuple[str, ...]:
    """Return the formats of a list like ``plan,kml``, each once.

    Raises
    ------
    InputError
        If the list is empty or names an unknown format.
    """
    formats = tuple(dict.fromkeys(name.strip() for name in text.split(",")))
    for name in formats:
        if name not in FORMATS:
            raise InputError(
                f"There is no file format {name!r}; give some of {', '.join(FORMATS)} (--write)."
            )
    return formats


def check_formats(formats: Sequence[str], terrain: Terrain) -> None:
    """Refuse formats that a terrain has no positions for; call it before the work for the path.

    Raises
    ------
    InputError
        If the terrain has no place on Earth and a format needs one.
    """
    if set(formats) - set(_WITHOUT_PLACE):
        check_place(terrain)


def export(
    problem: Problem,
    path: NDArray[np.float64],
    formats: Sequence[str],
    directory: Path,
    note: Callable[[str], None],
    *,
    feasible: bool | None = None,
) -> list[Path]:
    """Write a path in some of :data:`FORMATS`.

    Parameters
    ----------
    problem : Problem
        The problem.
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    formats : sequence of str
        Keys of :data:`FORMATS`.
    directory : Path
        An existing folder.
    note : callable
        Receives a sentence about each thing that a file cannot say.
    feasible : bool, optional
        The verdict on the path, which ``path.plan`` states.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the terrain has no place on Earth and a format needs one, or the directory cannot be
        written to.
    """
    from host.mission.files.kml_file import kml_text
    from host.mission.files.plan_file import plan_document
    from host.mission.files.waypoints_file import waypoints_text

    check_formats(formats, problem.terrain)
    is_flown = not {"plan", "waypoints"}.isdisjoint(formats)
    plan = flight_plan(problem, path, feasible=feasible) if is_flown else None
    for sentence in plan.notes if plan else ():
        note(sentence)
    written = []
    with writing_into(directory):
        for name in formats:
            file = directory / FORMATS[name]
            if name == "plan" and plan:
                write_json(file, plan_document(plan))
            elif name == "waypoints" and plan:
                _write_text(file, waypoints_text(plan))
            elif name == "kml":
                _write_text(file, kml_text(problem, path, problem.terrain.name))
            else:
                write_json(file, _geojson(problem, path))
            written.append(file)
    return written


def _geojson(problem: Problem, path: NDArray[np.float64]) -> dict[str, object]:
    terrain = problem.terrain
    return path_document(
        path,
        Evaluator(problem).track(path),
        terrain,
        step_m=min(terrain.dx_m, terrain.dy_m),
        zones=problem.zones,
        way=problem.way,
    )


def _write_text(file: Path, text: str) -> None:
    with replacing(file) as binary:
        binary.write(text.encode())
