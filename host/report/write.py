"""The files of a run."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from host.evaluation import Evaluator
from host.files.output import remove, replacing, write_json, writing_into
from host.planners.base import Result
from host.report.geojson import path_document


if TYPE_CHECKING:
    from host.report.picture import Scene


__all__ = ["scene", "write_grid", "write_picture", "write_report"]


def write_report(
    directory: Path,
    evaluator: Evaluator,
    result: Result,
    summary: Mapping[str, Any],
    warn: Callable[[str], None],
    *,
    picture: bool = True,
    grid: bool = True,
) -> list[Path]:
    """Write ``summary.json``, ``terrain.npz``, ``path.geojson`` and ``path.png``.

    The picture comes last, and an error in it is only a warning: the other files are kept.

    Parameters
    ----------
    directory : Path
        An existing folder.
    evaluator : Evaluator
        Holds the problem.
    result : Result
        Result of the run.
    summary : mapping
        Result of :func:`host.report.summary.summarise`.
    warn : callable
        Receives a sentence if there is no picture.
    picture : bool
        Draw ``path.png``; otherwise only remove the one of an earlier run, which would mislead.
    grid : bool
        Write ``terrain.npz``; otherwise remove the one of an earlier run, which ``check`` would
        take for the terrain of this one.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the directory cannot be written to.
    """
    terrain = evaluator.problem.terrain
    written = [directory / name for name in ("summary.json", "terrain.npz", "path.geojson")]
    with writing_into(directory):
        write_json(written[0], summary)
        if grid:
            write_grid(written[1], evaluator)
        else:
            remove(written.pop(1))
        document = path_document(
            result.path,
            evaluator.track(result.path),
            terrain,
            step_m=min(terrain.dx_m, terrain.dy_m),
            zones=evaluator.problem.zones,
            way=evaluator.problem.way,
        )
        write_json(written[-1], document)
    drawing = directory / "path.png"
    if not picture:
        remove(drawing)
    elif write_picture(drawing, lambda: scene(evaluator, result, summary), warn):
        written.append(drawing)
    return written


def write_picture(file: Path, made: Callable[[], Scene], warn: Callable[[str], None]) -> bool:
    """Draw a picture, and return whether it is there; an error in it is only a warning.

    Parameters
    ----------
    file : Path
        The PNG. After an error, the one of an earlier run is removed, which would mislead.
    made : callable
        Returns the scene.
    warn : callable
        Receives a sentence if there is no picture.
    """
    try:
        from host.report.picture import write

        write(made(), file)
    except Exception as error:
        remove(file)
        warn(f"There is no picture this time, drawing it failed: {type(error).__name__}: {error}.")
        return False
    return True


def write_grid(file: Path, evaluator: Evaluator) -> None:
    """Write the evaluated grid: elevation (NaN over voids), dx_m, dy_m, nofly and its place."""
    problem = evaluator.problem
    with replacing(file) as binary:
        problem.terrain.save_npz(binary, problem.nofly_raster)


def scene(evaluator: Evaluator, result: Result, summary: Mapping[str, Any]) -> Scene:
    """Return all that the picture of a run shows."""
    from host.report.picture import Scene

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
        # In a mission, the other legs are still the planner's.
        by = f"{by}, {'in part by' if summary.get('legs') else 'path by'} {summary['fallback']}"
    subtitle = (
        f"{verdict}, fitness {summary['fitness']:.4f}, {summary['length_m'] / 1000:.2f} km, "
        f"mean altitude {summary['mean_altitude_m']:,.0f} m, fuel {summary['fuel_N']:.3f} N "
        f"({summary['uav']['name']}); {summary['generations']} generations, seed "
        f"{summary['seed']}"
    )
    return f"{summary['terrain']['name']}, planned by {by}", subtitle
