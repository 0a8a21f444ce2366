"""The files of a diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.aircraft_limits import limit_named
from pathgene.host.files.output import json_bytes, writing_into
from pathgene.host.files.replacement import replace_files
from pathgene.host.planners.base import Result
from pathgene.host.report.write import write_picture


if TYPE_CHECKING:
    from pathgene.host.report.picture import Scene


__all__ = ["Drawn", "write_diagnosis"]

#: The evaluator of the problem or of the reported leg; the search that found no feasible path,
#: whose best path is drawn, or None to draw the straight line; and terrain and leg, the title of
#: the picture.
Drawn = tuple[Evaluator, Result | None, str]


def write_diagnosis(
    directory: Path,
    report: Mapping[str, Any],
    drawn: Drawn | None,
    warn: Callable[[str], None],
) -> list[Path]:
    """Write ``diagnosis.json``, and ``diagnosis.png`` if there is a reason to mark.

    Parameters
    ----------
    directory : Path
        An existing folder.
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
    if write_picture(drawing, lambda: _scene(*drawn, reason), warn):
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
    limit = limit_named(reason["code"])
    return f"{limit.meaning if limit else _MEANINGS[reason['code']]}, {holds}"


def _scene(
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
