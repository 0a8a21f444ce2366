"""Files of a planned path for ground stations, viewers and browsers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator
from pathgene.host.files.output import json_bytes, prepare_directory, writing_into
from pathgene.host.files.replacement import replace_files
from pathgene.host.formats.registry import check_formats, files, needs_flight_plan, write
from pathgene.host.mission.autopilot.ends import NoRoomError
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.hand_over import USUAL, HandOver
from pathgene.host.mission.autopilot.late import LateClimbError
from pathgene.host.problem.problem import Problem
from pathgene.host.report.read import Run
from pathgene.host.report.run_files import digests
from pathgene.host.report.summary import finite
from pathgene.host.report.track import track_of


__all__ = ["export", "exported", "exported_with_room"]


def exported(
    problem: Problem,
    path: NDArray[np.float64],
    formats: Sequence[str],
    note: Callable[[str], None],
    *,
    feasible: bool | None = None,
    page: Callable[[], str] | None = None,
    wanted: HandOver = USUAL,
) -> dict[str, bytes]:
    """Return the files of a path in some formats: contents by file name.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    formats : sequence of str
        Names of formats of :data:`pathgene.host.formats.registry.FORMATS`.
    note : callable
        Receives a sentence about each fact that a file cannot express.
    feasible : bool, optional
        The verdict on the path, which ``path.plan`` states.
    page : callable, optional
        Makes ``path.html``; ``html`` among the formats needs it.
    wanted : HandOver
        The user's choices about the flight plan.

    Raises
    ------
    InputError
        If the terrain has no place on Earth and a format needs one.
    LateClimbError, NoRoomError
        If a format needs a flight plan, and the path climbs too late for an autopilot or the end of
        the mission has no room.
    """
    check_formats(formats, problem.terrain)
    curve = Evaluator(problem).track(path)
    flight = None
    if needs_flight_plan(formats):
        flight = flight_plan(problem, curve, feasible=feasible, wanted=wanted)
        for sentence in flight.notes:
            note(sentence)
    return write(track_of(problem, path, curve, flight=flight, page=page), formats)


def exported_with_room(
    problem: Problem,
    path: NDArray[np.float64],
    formats: Sequence[str],
    note: Callable[[str], None],
    **options: Any,
) -> tuple[dict[str, bytes], str | None]:
    """Return the files of a path, without flight plans if it has none that can be flown.

    Parameters
    ----------
    problem, path, formats, note
        As for :func:`exported`.
    **options
        Further options of :func:`exported`.

    Returns
    -------
    dict of str to bytes
        Contents by file name.
    str or None
        The reason why flight plans are missing, a sentence that names their files.

    Raises
    ------
    InputError
        If the terrain has no place on Earth and a format needs one.
    """
    try:
        return exported(problem, path, formats, note, **options), None
    except (LateClimbError, NoRoomError) as error:
        names = [name for name in formats if needs_flight_plan([name])]
        others = [name for name in formats if name not in names]
        listed = " and ".join(files()[name] for name in names)
        are = "are" if len(names) > 1 else "is"
        sentence = f"{str(error).rstrip('.')}; {listed} {are} not written."
        return exported(problem, path, others, note, **options), sentence


def export(
    run: Run,
    formats: Sequence[str],
    directory: Path,
    note: Callable[[str], None],
    *,
    page: Callable[[], str] | None = None,
    wanted: HandOver = USUAL,
) -> list[Path]:
    """Write the path of a finished run in some formats: all files or none.

    If they are written to the run's own folder, its summary gets the new digests.

    Parameters
    ----------
    formats : sequence of str
        Names of formats of :data:`pathgene.host.formats.registry.FORMATS`.
    note : callable
        Receives a sentence about each fact that a file cannot express.
    page : callable, optional
        As for :func:`exported`.
    wanted : HandOver
        The user's choices about the flight plan.

    Returns
    -------
    list of Path
        The files written, without the summary.

    Raises
    ------
    InputError
        If the terrain has no place on Earth and a format needs one, or the directory cannot be
        written to.
    LateClimbError, NoRoomError
        If a format needs a flight plan, and the path climbs too late for an autopilot or the end of
        the mission has no room.
    """
    contents = exported(
        run.problem, run.path, formats, note, feasible=run.feasible, page=page, wanted=wanted
    )
    written = [directory / name for name in contents]
    prepare_directory(directory)
    with writing_into(directory):
        stated = run.summary.get("files")
        if stated is not None and directory.samefile(run.file.parent):
            whole = {**run.summary, "files": {**stated, **digests(contents)}}
            contents[run.file.name] = json_bytes(finite(whole))
        replace_files(directory, contents)
    return written
