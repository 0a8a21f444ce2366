"""The files of a checked mission."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host.files.output import json_bytes, writing_into
from pathgene.host.files.replacement import replace_files
from pathgene.host.mission.foreign.check import MissionCheck
from pathgene.host.report.write import write_figure


if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["write_check"]


def write_check(
    directory: Path,
    check: MissionCheck,
    report: Mapping[str, Any],
    name: str,
    warn: Callable[[str], None],
    page: bytes | None = None,
) -> list[Path]:
    """Write ``check.json``, ``check.png`` and perhaps ``check.html``, and return the files.

    Parameters
    ----------
    report : mapping
        Content of ``check.json``: the output of ``pathgene check --json``.
    name : str
        Name of the mission.
    warn : callable
        Receives a sentence if there is no picture.
    page : bytes, optional
        Content of ``check.html``.

    Raises
    ------
    InputError
        If the directory cannot be written to.
    """
    contents = {"check.json": json_bytes(report)} | ({} if page is None else {"check.html": page})
    drawing = directory / "check.png"
    with writing_into(directory):
        # A picture or a page of an earlier check would be misleading.
        replace_files(directory, contents, gone=[drawing.name, "check.html"])
    written = [directory / each for each in contents]

    def figure() -> Figure:
        from pathgene.host.mission.foreign.picture import draw

        return draw(check, name)

    if write_figure(drawing, figure, warn):
        written.append(drawing)
    return written
