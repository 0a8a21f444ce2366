"""The files of a run."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Callable, Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pathgene.host.evaluation import Evaluator
from pathgene.host.files.output import json_bytes, writing_into
from pathgene.host.files.replacement import replace_files
from pathgene.host.formats import geojson
from pathgene.host.planners.base import Result
from pathgene.host.report.reading import warnings_in
from pathgene.host.report.routes import route_from, route_note
from pathgene.host.report.run_files import DATA, FLIGHT, GRID, PATH, PICTURE, SUMMARY, digests
from pathgene.host.report.track import track_of


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pathgene.host.report.handed_over import HandedOver
    from pathgene.host.report.picture import Scene


__all__ = [
    "Drawn",
    "Written",
    "scene",
    "write_diagnosis",
    "write_figure",
    "write_picture",
    "write_report",
    "write_run_picture",
]


class Written(NamedTuple):
    """Result of :func:`write_report`."""

    #: The files written.
    files: list[Path]
    #: Content of ``summary.json``.
    summary: dict[str, Any]


def write_report(
    directory: Path,
    evaluator: Evaluator,
    result: Result,
    summary: Mapping[str, Any],
    warn: Callable[[str], None],
    *,
    picture: bool = True,
    grid: bool = True,
    others: Mapping[str, bytes] | None = None,
    mission: Callable[[], HandedOver | None] = lambda: None,
) -> Written:
    """Write ``summary.json``, ``terrain.npz``, ``path.geojson``, further files and ``path.png``.

    The files of an earlier run are replaced all or none. Files that this run does not have are
    removed too, including the files of a flight of the earlier run. The picture comes last, and an
    error in it only causes a warning.

    Parameters
    ----------
    summary : mapping
        Result of :func:`pathgene.host.report.summary.summarise`. The file also has the member
        ``files``, with the SHA-256 of each other file except the picture.
    warn : callable
        Receives a sentence if there is no picture.
    picture : bool
        Draw ``path.png``; otherwise only remove a misleading picture of an earlier run.
    grid : bool
        Write ``terrain.npz``; otherwise remove the file of an earlier run, which ``check`` would
        mistake for the terrain of this one.
    others : mapping, optional
        Contents of additional files by their names in :data:`pathgene.host.report.run_files.DATA`.
    mission : callable
        Returns the mission that the picture shows, if there is one.

    Raises
    ------
    InputError
        If the directory cannot be written to.
    """
    problem = evaluator.problem
    contents = {GRID: _grid(evaluator)} if grid else {}
    contents |= {
        PATH: geojson.write(track_of(problem, result.path, evaluator.track(result.path))),
        **(others or {}),
    }
    whole = {**summary, "files": digests(contents)}
    contents[SUMMARY] = json_bytes(whole)
    with writing_into(directory):
        replace_files(directory, contents, gone=(*DATA, PICTURE, *FLIGHT))
    written = [directory / name for name in dict.fromkeys((SUMMARY, *contents))]
    if picture:
        written += write_run_picture(directory, evaluator, result, summary, warn, mission)
    return Written(written, whole)


def write_run_picture(
    directory: Path,
    evaluator: Evaluator,
    result: Result,
    summary: Mapping[str, Any],
    warn: Callable[[str], None],
    mission: Callable[[], HandedOver | None] = lambda: None,
) -> list[Path]:
    """Draw ``path.png`` of a run and return the files drawn; see :func:`write_report`."""
    drawing = directory / PICTURE

    def made() -> Scene:
        return scene(evaluator, result, summary, mission())

    return [drawing] if write_picture(drawing, made, warn) else []


def write_picture(file: Path, made: Callable[[], Scene], warn: Callable[[str], None]) -> bool:
    """Draw the picture of a scene; see :func:`write_figure`."""

    def figure() -> Figure:
        from pathgene.host.report.picture import draw

        return draw(made())

    return write_figure(file, figure, warn)


def write_figure(file: Path, made: Callable[[], Figure], warn: Callable[[str], None]) -> bool:
    """Draw a figure and return whether it was drawn; an error only causes a warning.

    Parameters
    ----------
    warn : callable
        Receives a sentence if there is no picture.
    """
    try:
        from pathgene.host.report.style import save

        save(made(), file)
    except Exception as error:
        warn(f"There is no picture this time, drawing it failed: {type(error).__name__}: {error}.")
        return False
    return True


def _grid(evaluator: Evaluator) -> bytes:
    """Return the evaluated grid: elevation (NaN over voids), dx_m, dy_m, nofly and its place."""
    problem = evaluator.problem
    content = BytesIO()
    problem.terrain.save_npz(content, problem.nofly_raster)
    return content.getvalue()


def scene(
    evaluator: Evaluator,
    result: Result,
    summary: Mapping[str, Any],
    mission: HandedOver | None = None,
) -> Scene:
    """Return the content of a run's picture."""
    from pathgene.host.report.picture import Scene

    found = summary.get("reason")
    reason = found if isinstance(found, Mapping) else {}
    title, subtitle = _captions(summary)
    return Scene(
        evaluator,
        result.path,
        result.evaluation,
        result.history,
        title,
        subtitle,
        reason,
        _legs(summary),
        warnings_in(summary),
        mission,
    )


def _legs(summary: Mapping[str, Any]) -> list[tuple[int, float]]:
    """Return the first row of the history, and the fitness, of each leg of a mission."""
    # A leg that was not planned has no rows.
    legs = [leg for leg in summary.get("legs", ()) if leg["planned"]]
    first = itertools.accumulate((leg["generations"] + 1 for leg in legs), initial=0)
    generations = [row[0] for row in summary["history"]] if legs else []
    return [
        (bisect.bisect_left(generations, generation), leg["fitness"])
        for generation, leg in zip(first, legs, strict=False)
    ]


def _captions(summary: Mapping[str, Any]) -> tuple[str, str]:
    """Title and subtitle of the picture."""
    verdict = "feasible" if summary["feasible"] else "not feasible"
    board = f" (board {summary['board']})" if summary["board"] else ""
    by = f"{summary['planner']}{board}"
    if summary.get("fallback"):
        # In a mission, the remaining legs still come from the planner.
        by = f"{by}, {'in part by' if summary.get('legs') else 'path by'} {summary['fallback']}"
    if note := route_note(route_from(summary)):
        by = f"{by}, {note}"
    subtitle = (
        f"{verdict}, fitness {summary['fitness']:.4f}, {summary['length_m'] / 1000:.2f} km, "
        f"mean altitude {summary['mean_altitude_m']:,.0f} m, fuel {summary['fuel_N']:.3f} N "
        f"({summary['uav']['name']}); {summary['generations']} "
        f"generation{'' if summary['generations'] == 1 else 's'}, seed {summary['seed']}"
    )
    return f"{summary['terrain']['name']}, planned by {by}", subtitle


#: The evaluator of the problem or of the reported leg; the search that found no feasible path,
#: whose best path is drawn, or None to draw the straight line; and terrain and leg, the title of
#: the picture.
Drawn = tuple[Evaluator, Result | None, str]


def write_diagnosis(
    directory: Path, report: Mapping[str, Any], drawn: Drawn | None, warn: Callable[[str], None]
) -> list[Path]:
    """Write ``diagnosis.json``, and ``diagnosis.png`` if there is a reason to mark.

    Parameters
    ----------
    report : mapping
        Content of ``diagnosis.json``: the output of ``pathgene diagnose --json``.
    drawn : tuple or None
        Contents of the picture. None for a problem without costs, which has no evaluator and
        therefore no picture.
    warn : callable
        Receives a sentence if there is no picture.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the directory cannot be written to.
    """
    written, drawing = [directory / "diagnosis.json"], directory / "diagnosis.png"
    with writing_into(directory):
        # A picture of an earlier run would be misleading.
        replace_files(directory, {written[0].name: json_bytes(report)}, gone=[drawing.name])
    reason = report["reason"]
    if reason is None or drawn is None:
        return written
    if write_picture(drawing, lambda: _reason_scene(*drawn, reason), warn):
        written.append(drawing)
    return written


# Meaning of each code that is no limit of the aircraft, ahead of the sentence with the figures.
_MEANINGS = {
    "start": "The start violates a limit",
    "goal": "The goal violates a limit",
    "closed": "The way is closed at every altitude",
    "ceiling": "The ceiling closes the way",
    "heading": "A fixed heading leaves no path",
    "joint": "The legs do not join",
    "not-found": "No path was found",
}


def _verdict(reason: Mapping[str, Any]) -> str:
    """Return a reason in words, and whether it holds for every path."""
    holds = "proven for every path" if reason["proven"] else "as far as the search sees"
    # Loads the kernels.
    from pathgene.host.evaluation.aircraft_limits import limit_named

    limit = limit_named(reason["code"])
    return f"{limit.meaning if limit else _MEANINGS[reason['code']]}, {holds}"


def _reason_scene(
    evaluator: Evaluator, result: Result | None, place: str, reason: Mapping[str, Any]
) -> Scene:
    """Return the content of a reason's picture."""
    from pathgene.host.report.picture import Scene

    verdict = _verdict(reason)
    if result is not None:
        verdict = f"{verdict}; the path is the best that was found"
        return Scene(
            evaluator, result.path, result.evaluation, result.history, place, verdict, reason
        )
    path = np.array([evaluator.problem.start, evaluator.problem.goal])
    verdict = f"{verdict}; nothing was searched, and the path is the straight line"
    return Scene(evaluator, path, evaluator.evaluate(path), [], place, verdict, reason)
