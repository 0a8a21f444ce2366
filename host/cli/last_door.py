"""The final check of a finished path, before it is exported or uploaded to an autopilot."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from pathgene.host.cli.output import note_compiling
from pathgene.host.errors import JobError


if TYPE_CHECKING:
    from pathgene.host.mission.ending import Ending
    from pathgene.host.report.read import Run


__all__ = ["check_path", "ending_for"]


def check_path(run: Run, consequence: str, remedy: str) -> None:
    """Refuse a run whose path breaks a limit or misses a via point, unless its summary admits it.

    The path is checked again, because the waypoints in the file may have been edited.

    Parameters
    ----------
    consequence, remedy : str
        Ends of the sentence.

    Raises
    ------
    JobError
        If the path must not be flown and the summary does not say that it is infeasible.
    """
    from pathgene.host.checking import path_fault

    if run.feasible is False:
        return
    note_compiling(as_paper=run.problem.as_paper)
    found = path_fault(run)
    if found is None:
        return
    text = found[0].lower() + found[1:].removesuffix(".")
    said = ", although the summary calls it feasible" if run.feasible else ""
    raise JobError(f"{run.file}: {text}{said}; {consequence}, {remedy}.")


def ending_for(args: argparse.Namespace, run: Run) -> Ending:
    """Return the end of a mission by the options of a command, or else as it was planned.

    Raises
    ------
    InputError
        If the options contradict each other, or the summary states a bad end.
    """
    from pathgene.host.mission.ending import ending_of, summary_ending

    stated = ending_of(vars(args), run.problem)
    return summary_ending(run.file, run.summary) if stated is None else stated
