"""Reading of runs from their ``summary.json``, for commands that work on a finished plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.files.output import reading
from pathgene.host.inputs import exists, opened, parse_json, read_text
from pathgene.host.numeric import as_number, numbers, rows
from pathgene.host.problem.aircraft import DEFAULT, Aircraft
from pathgene.host.problem.aircraft import load as load_aircraft
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.way import WayProblem
from pathgene.host.problem.zones import Zone, zone_from_dict
from pathgene.host.remarks import Reading
from pathgene.host.report.reading import sentences
from pathgene.host.report.run_files import GRID, verify
from pathgene.host.terrain import Terrain, embedded, load
from pathgene.host.terrain.datum import ELLIPSOID
from pathgene.host.terrain.origin import at_origin
from pathgene.host.terrain.stated import Stated


__all__ = [
    "Run",
    "find_summary",
    "problem_of_path",
    "read_run",
    "summary_aircraft",
    "summary_path",
    "summary_rules",
    "summary_terrain",
    "summary_terrain_reading",
    "summary_way",
    "summary_wind_and_step",
    "summary_zones",
    "summary_zones_reading",
]

_UNKNOWN_PROBLEM = (
    "the summary does not say how its path was evaluated; give --terrain and the other options."
)


@dataclass(frozen=True, eq=False)
class Run:
    """A finished plan.

    Parameters
    ----------
    problem : Problem
        The problem as it was planned; start and goal are the ends of ``path``.
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    """

    problem: Problem
    path: NDArray[np.float64]
    summary: dict[str, Any]
    file: Path

    @property
    def feasible(self) -> bool | None:
        """The verdict on the path; None if the summary has none."""
        stated = self.summary.get("feasible")
        return stated if isinstance(stated, bool) else None


def read_run(file: Path, *, origin: tuple[float, float] | None = None) -> Run:
    """Return the problem, the path and the content of a ``summary.json``.

    The terrain is ``terrain.npz`` next to the file if there is one, otherwise the terrain that the
    summary names.

    Parameters
    ----------
    origin : tuple of float, optional
        Latitude and longitude of the south-west node, for a terrain without a place on Earth.

    Raises
    ------
    InputError
        If the file is not a summary, does not say how its path was evaluated or has a bad value, or
        if a file next to it belongs to another run.
    """
    summary = find_summary(file)
    if summary is None:
        with reading("summary", file), opened(file):
            pass
        raise InputError(
            f"{file}: not a summary of a plan; give the summary.json that pathgene plan wrote."
        )
    verify(file, summary)
    path = summary_path(file, summary)
    wind, ds_m = summary_wind_and_step(file, summary)
    terrain = summary_terrain(file, summary)
    problem = problem_of_path(
        terrain if origin is None else at_origin(terrain, *origin),
        path,
        summary_way(file, summary),
        aircraft=summary_aircraft(file, summary) or load_aircraft(DEFAULT),
        zones=summary_zones(file, summary),
        zones_reading=summary_zones_reading(file, summary),
        wind=wind,
        ds_m=ds_m,
        **summary_rules(file, summary),
    )
    return Run(problem, path, summary, file)


def problem_of_path(
    terrain: Terrain, path: NDArray[np.float64], between: Sequence[Point], **options: Any
) -> Problem:
    """Return the problem of a path from its first point to its last.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres.
    between : sequence of (float, float, float)
        Points of a mission between its start and its end; none for a single leg.
    **options
        Options of :class:`Problem`.
    """
    (x, y, z), (end_x, end_y, end_z) = path[0].tolist(), path[-1].tolist()
    if between:
        return WayProblem(terrain, ((x, y, z), *between, (end_x, end_y, end_z)), **options)
    return Problem(terrain, (x, y, z), (end_x, end_y, end_z), **options)


def find_summary(file: Path) -> dict[str, Any] | None:
    """Return the content of ``file`` if it is a summary, otherwise None."""
    if file.suffix.lower() == ".csv":
        return None
    try:
        document = parse_json(read_text(file))
    except (OSError, ValueError):
        return None
    is_summary = isinstance(document, dict) and "waypoints" in document
    return document if is_summary else None


def summary_terrain(
    file: Path,
    summary: dict[str, Any],
    source: str | None = None,
    *,
    cell: tuple[float, float] | None = None,
    fill_voids: bool = False,
    max_cells: int | None = None,
    stated_by_user: Stated | None = None,
) -> Terrain:
    """Return the terrain of a run, with its place on Earth if the summary states one.

    Parameters
    ----------
    file : Path
        The summary; ``terrain.npz`` next to it is preferred to the source named in it.
    source : str, optional
        File or name of another terrain to take instead.
    cell, fill_voids, max_cells, stated_by_user
        As for :func:`pathgene.host.terrain.load`; by default as the summary states them.

    Raises
    ------
    InputError
        If the summary does not name its terrain, or the terrain cannot be loaded.
    """
    try:
        stated = summary["terrain"]
        grid = file.with_name(GRID)
        is_grid = source is None and exists(grid)
        is_own = source is None
        if source is None:
            source = str(grid) if is_grid else str(stated["source"])
        if not is_grid:
            fill_voids = fill_voids or bool(stated["fill_voids"])
        if cell is None and stated["cell_m"] and Path(source).suffix == ".npy":
            east, north = numbers(stated["cell_m"], 2)
            cell = east, north
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{file}: {_UNKNOWN_PROBLEM}") from None
    if is_own and stated_by_user in (None, Stated()):
        # A grid has its final heights; their datum was accepted when it was made.
        stated_by_user = _accepted(summary) if is_grid else Stated.of(stated)
    try:
        terrain = load(
            source, cell=cell, fill_voids=fill_voids, max_cells=max_cells, stated=stated_by_user
        )
    except InputError as error:
        if not is_own or is_grid:
            raise
        if GRID in (summary.get("files") or ()):
            raise InputError(
                f"{grid}, the terrain of the run, is missing, and the file that it was made from "
                f"cannot be read; put {GRID} back, or plan again. {error}"
            ) from None
        raise InputError(
            f"{file}: the terrain of the run cannot be read; put it back at {source}, or plan "
            f"again. {error}"
        ) from None
    return _placed(file, terrain, stated) if is_own else terrain


def summary_terrain_reading(file: Path, summary: dict[str, Any]) -> Reading | None:
    """Return the report on the terrain of a run; None in a summary of an earlier version.

    Raises
    ------
    InputError
        If it is no such report.
    """
    try:
        read = summary.get("read")
        if read is None:
            return None
        reading = Reading.of(read["terrain"])
        # Every command says it, so it must have all that its sentences name.
        list(sentences({"terrain": reading.to_dict(), "zones": {}}))
        return reading
    except (AttributeError, IndexError, KeyError, TypeError, ValueError):
        raise InputError(
            f"{file}: read must have a table terrain with the facts of the terrain and the remarks "
            "on it."
        ) from None


def _accepted(summary: dict[str, Any]) -> Stated | None:
    """Return the statement that accepts the datum of a run's grid; None if it needs none."""
    try:
        datum = summary["read"]["terrain"]["heights"]["datum"]
    except (KeyError, TypeError):
        return None
    return Stated(heights="ellipsoidal") if datum == ELLIPSOID else None


def summary_path(file: Path, summary: dict[str, Any]) -> NDArray[np.float64]:
    """Return the waypoints of a summary, (n, 3) float64 metres.

    Raises
    ------
    InputError
        If they are not at least two lists of three numbers.
    """
    try:
        path = rows(summary["waypoints"], 3)
    except ValueError:
        path = np.empty(0)
    if len(path) < 2:
        raise InputError(f"{file}: waypoints must be two or more lists of three numbers.")
    return path


def summary_way(file: Path, summary: dict[str, Any]) -> tuple[Point, ...]:
    """Return the points of a mission between its start and its end; none for a single leg.

    Raises
    ------
    InputError
        If the legs do not state where they begin.
    """
    try:
        points = [numbers(leg["from"], 3) for leg in summary.get("legs") or ()][1:]
    except (KeyError, TypeError, ValueError):
        raise InputError(
            f"{file}: every leg must be a table with three numbers under from."
        ) from None
    return tuple((x, y, z) for x, y, z in points)


def summary_aircraft(file: Path, summary: dict[str, Any]) -> Aircraft | None:
    """Return the aircraft of a summary, or None if it states none.

    Raises
    ------
    InputError
        If one of its values is bad.
    """
    if "uav" not in summary:
        return None
    if not isinstance(summary["uav"], dict):
        raise InputError(f"{file}: uav must be a table of the aircraft's values.")
    return Aircraft.from_dict(summary["uav"], str(file))


def summary_zones(file: Path, summary: dict[str, Any]) -> tuple[Zone, ...]:
    """Return the no-fly zones of a summary.

    Raises
    ------
    InputError
        If they are not a list of zones, or a zone is bad.
    """
    zones = summary.get("nofly", [])
    if not isinstance(zones, list):
        raise InputError(f"{file}: nofly must be a list of zones, not {zones!r}.")
    return tuple(zone_from_dict(zone) for zone in zones)


def summary_zones_reading(file: Path, summary: dict[str, Any]) -> Reading:
    """Return the report on the files of zones; it is empty in a summary of an earlier version.

    Raises
    ------
    InputError
        If it is no such report.
    """
    try:
        read = summary.get("read")
        return Reading({"files": []}) if read is None else Reading.of(read["zones"])
    except (KeyError, TypeError, ValueError):
        raise InputError(
            f"{file}: read must have a table zones with the remarks on the files of zones."
        ) from None


def summary_wind_and_step(file: Path, summary: dict[str, Any]) -> tuple[tuple[float, float], float]:
    """Return the wind, m/s east and north, and the sampling step in metres of a summary.

    Raises
    ------
    InputError
        If one is missing or not made of numbers.
    """
    try:
        east, north = numbers(summary["wind"], 2)
        ds_m = as_number(summary["ds_m"])
    except (KeyError, ValueError):
        raise InputError(f"{file}: {_UNKNOWN_PROBLEM}") from None
    return (east, north), ds_m


def summary_rules(file: Path, summary: dict[str, Any]) -> dict[str, Any]:
    """Return the rules and headings of a summary as keywords of :class:`Problem`.

    A summary without the key ``as_paper`` is of version 0.1, so its problem is ``as_paper``.

    Raises
    ------
    InputError
        If the rules are missing, or one is unknown or bad.
    """
    as_paper = summary.get("as_paper", True)
    if not isinstance(as_paper, bool):
        raise InputError(f"{file}: as_paper must be true or false, not {as_paper!r}.")
    if as_paper:
        return {"as_paper": True}
    try:
        rules = Rules(**summary["rules"])
    except (KeyError, TypeError):
        raise InputError(
            f"{file}: rules must be a table of the rules of safe flight, "
            f"not {summary.get('rules')!r}."
        ) from None
    headings = ("start_heading_deg", "goal_heading_deg")
    return {"rules": rules, **{name: summary.get(name) for name in headings}}


def _placed(file: Path, terrain: Terrain, stated: dict[str, Any]) -> Terrain:
    """Return the terrain with its name, and with the reference system of the summary if needed."""
    name, source = str(stated.get("name", terrain.name)), str(stated.get("source", terrain.source))
    named = {entry.name: entry.source for entry in embedded.describe()}
    terrain = replace(terrain, name=name, source=named.get(source, source))
    crs, origin = stated.get("crs"), stated.get("origin")
    if terrain.crs is not None or crs is None or origin is None:
        return terrain
    try:
        if not isinstance(crs, str):
            raise ValueError
        east, north = numbers(origin, 2)
    except ValueError:
        raise InputError(
            f"{file}: crs must be the name of a reference system and origin two numbers, "
            f"not {crs!r} and {origin!r}."
        ) from None
    from pathgene.host.terrain.geodesy import known_crs

    try:
        known_crs(crs)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
    return replace(terrain, crs=crs, origin=(east, north))
