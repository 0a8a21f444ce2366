"""Files of a planned path for ground stations, viewers and browsers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.files.output import json_bytes, writing_into
from pathgene.host.files.replacement import replace_files
from pathgene.host.mission.files.flight_plan import check_place, flight_plan
from pathgene.host.problem.problem import Problem
from pathgene.host.report.geojson import path_document
from pathgene.host.report.read import Run
from pathgene.host.report.run_files import digests
from pathgene.host.report.summary import finite
from pathgene.host.terrain import Terrain


__all__ = ["FORMATS", "check_formats", "export", "exported", "parse_formats"]

#: File that each format is written to.
FORMATS = {
    "plan": "path.plan",
    "waypoints": "path.waypoints",
    "kml": "path.kml",
    "geojson": "path.geojson",
    "html": "path.html",
}

# They have local metres as well.
_WITHOUT_PLACE = ("geojson", "html")


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


def exported(
    problem: Problem,
    path: NDArray[np.float64],
    formats: Sequence[str],
    note: Callable[[str], None],
    *,
    feasible: bool | None = None,
    page: Callable[[], str] | None = None,
) -> dict[str, bytes]:
    """Return a path in some of :data:`FORMATS`: the contents of files by their names.

    Parameters
    ----------
    problem : Problem
        The problem.
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    formats : sequence of str
        Keys of :data:`FORMATS`.
    note : callable
        Receives a sentence about each thing that a file cannot say.
    feasible : bool, optional
        The verdict on the path, which ``path.plan`` states.
    page : callable, optional
        Makes ``path.html``; ``html`` among the formats needs it.

    Raises
    ------
    InputError
        If the terrain has no place on Earth and a format needs one.
    """
    from pathgene.host.mission.files.kml_file import kml_text
    from pathgene.host.mission.files.plan_file import plan_document
    from pathgene.host.mission.files.waypoints_file import waypoints_text

    check_formats(formats, problem.terrain)
    is_flown = not {"plan", "waypoints"}.isdisjoint(formats)
    plan = flight_plan(problem, path, feasible=feasible) if is_flown else None
    for sentence in plan.notes if plan else ():
        note(sentence)
    contents = {}
    for name in formats:
        if name == "plan" and plan:
            content = json_bytes(plan_document(plan))
        elif name == "waypoints" and plan:
            content = waypoints_text(plan).encode()
        elif name == "html" and page:
            content = page().encode()
        elif name == "kml":
            content = kml_text(problem, path, problem.terrain.name).encode()
        elif name == "geojson":
            content = json_bytes(_geojson(problem, path))
        else:
            raise ValueError(f"The format {name!r} needs the function that makes it")
        contents[FORMATS[name]] = content
    return contents


def export(
    run: Run,
    formats: Sequence[str],
    directory: Path,
    note: Callable[[str], None],
    *,
    page: Callable[[], str] | None = None,
) -> list[Path]:
    """Write the path of a finished run in some of :data:`FORMATS`, all files or none.

    In the folder of the run, its summary states the new digests.

    Parameters
    ----------
    run : Run
        The run.
    formats : sequence of str
        Keys of :data:`FORMATS`.
    directory : Path
        An existing folder.
    note : callable
        Receives a sentence about each thing that a file cannot say.
    page : callable, optional
        As for :func:`exported`.

    Returns
    -------
    list of Path
        The files written, without the summary.

    Raises
    ------
    InputError
        If the terrain has no place on Earth and a format needs one, or the directory cannot be
        written to.
    """
    contents = exported(run.problem, run.path, formats, note, feasible=run.feasible, page=page)
    written = [directory / name for name in contents]
    with writing_into(directory):
        stated = run.summary.get("files")
        if stated is not None and directory.samefile(run.file.parent):
            whole = {**run.summary, "files": {**stated, **digests(contents)}}
            contents[run.file.name] = json_bytes(finite(whole))
        replace_files(directory, contents)
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
