"""Plans in the folder of the desk: saved as a whole, listed, and read again."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.files.output import prepare_directory
from pathgene.host.formats.registry import FORMATS, check_formats, files
from pathgene.host.mission.autopilot.hand_over import choices_of
from pathgene.host.mission.drawn import mission_of_plan
from pathgene.host.mission.ending import ending_of, with_end
from pathgene.host.mission.export import exported_with_room
from pathgene.host.mission.problem_file import problem_text
from pathgene.host.planning import Plan
from pathgene.host.report.run_files import FLIGHT, PICTURE, SUMMARY
from pathgene.host.report.write import scene, write_picture, write_report
from pathgene.host.web.page import page_of


__all__ = ["PROBLEM", "draw_picture", "files_of", "save", "saved_plans"]

#: The problem file of a saved plan.
PROBLEM = "problem.toml"

# Formats that need no place on Earth, and all formats; every run has path.geojson.
_ALL = tuple(row for row in FORMATS if row.file and row.name != "geojson")
_ANYWHERE = tuple(row.name for row in _ALL if not row.placed)


def save(plan: Plan, values: Mapping[str, Any], folder: Path) -> list[str]:
    """Write the files of a plan except its picture, all or none; return notes on their gaps.

    Parameters
    ----------
    values : mapping
        The values of its problem, for its problem file.
    folder : Path
        The folder of the plan; created if missing.

    Raises
    ------
    InputError
        If they cannot be written.
    """
    notes: list[str] = []
    problem, path = plan.evaluator.problem, plan.path
    formats = tuple(row.name for row in _ALL)
    try:
        check_formats(formats, problem.terrain)
    except InputError as error:
        notes.append(str(error))
        formats = _ANYWHERE
    ending = ending_of(values, problem)
    wanted = choices_of(values, problem)
    others, missing = exported_with_room(
        problem,
        path,
        formats,
        notes.append,
        feasible=plan.evaluation.feasible,
        page=lambda: page_of(plan.evaluator, path, plan.summary, wanted),
        wanted=wanted,
    )
    notes += [] if missing is None else [missing]
    others[PROBLEM] = problem_text(values, folder, PROBLEM).encode()
    prepare_directory(folder)
    write_report(
        folder,
        plan.evaluator,
        plan.result,
        with_end(plan.summary, ending),
        notes.append,
        picture=False,
        others=others,
    )
    return notes


def draw_picture(plan: Plan, values: Mapping[str, Any], folder: Path) -> None:
    """Draw ``path.png`` next to the files of a saved plan; a failure affects nothing else."""
    write_picture(
        folder / PICTURE,
        lambda: scene(
            plan.evaluator,
            plan.result,
            plan.summary,
            mission_of_plan(plan, choices_of(values, plan.evaluator.problem)),
        ),
        lambda sentence: None,
    )


def saved_plans(directory: Path) -> list[str]:
    """Return the names of the saved plans in the folder of the desk, the latest first."""
    with contextlib.suppress(OSError):
        return sorted((file.parent.name for file in directory.glob(f"*/{SUMMARY}")), reverse=True)
    return []


def files_of(folder: Path) -> list[str]:
    """Return the names of the files of a saved plan that a browser may fetch."""
    names = (*files().values(), PROBLEM, SUMMARY, PICTURE, *FLIGHT)
    return [name for name in names if (folder / name).is_file()]
