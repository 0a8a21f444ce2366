"""The files of a comparison."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pathgene.host.files.output import json_bytes, writing_into
from pathgene.host.files.replacement import replace_files


__all__ = ["write_report"]


def write_report(
    directory: Path,
    report: Mapping[str, Any],
    warn: Callable[[str], None],
    *,
    picture: bool = True,
) -> list[Path]:
    """Write ``compare.json`` and, unless ``picture`` is false, ``compare.png``; return the paths.

    An error in the picture only causes a warning, because the numbers are still valid.

    Raises
    ------
    InputError
        If the directory cannot be written to.
    """
    numbers, drawing = directory / "compare.json", directory / "compare.png"
    with writing_into(directory):
        replace_files(directory, {numbers.name: json_bytes(report)}, gone=[drawing.name])
    if not picture:
        return [numbers]
    try:
        from pathgene.host.compare.picture import write

        write(report, drawing)
    except Exception as error:
        warn(f"There is no picture this time, drawing it failed: {type(error).__name__}: {error}.")
        return [numbers]
    return [numbers, drawing]
