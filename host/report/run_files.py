"""The data files of a run, and their digests in its ``summary.json``."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.files.output import reading
from pathgene.host.files.replacement import hidden_copies
from pathgene.host.formats.registry import files


__all__ = ["DATA", "FLIGHT", "GRID", "PATH", "PICTURE", "SUMMARY", "digests", "verify"]

SUMMARY, GRID, PATH, PICTURE = "summary.json", "terrain.npz", "path.geojson", "path.png"
#: Data files that a run may have in addition to its summary.
DATA = tuple(dict.fromkeys((GRID, PATH, *files().values())))
#: Files of a flight of the run, which ``pathgene fly`` writes next to it; the last belongs to a
#: flight with replans.
FLIGHT = ("flight.json", "flight.png", "flight.gif")


def digests(contents: Mapping[str, bytes]) -> dict[str, str]:
    """Return the SHA-256 of each content, in hexadecimal, by its name: ``files`` of a summary."""
    return {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}


def verify(file: Path, summary: Mapping[str, Any]) -> None:
    """Refuse a summary if a data file next to it does not belong to its run.

    A missing file is not an error, unless it is still there under a hidden name: the run is read
    without it, or the reader reports it. A summary without the member ``files`` is from an earlier
    version and says nothing about files.

    Raises
    ------
    InputError
        If a file next to the summary was altered, belongs to another run, or is hidden, or
        ``files`` is not a table of digests.
    """
    if "files" not in summary:
        return
    stated = summary["files"]
    if not isinstance(stated, dict) or not all(
        isinstance(digest, str) and Path(name).name == name for name, digest in stated.items()
    ):
        raise InputError(f"{file}: files must be a table of the SHA-256 of each file by its name.")
    for name in dict.fromkeys((*DATA, *stated)):
        beside = file.with_name(name)
        if beside.is_file() and stated.get(name) != _digest(beside):
            raise InputError(
                f"{beside} is not the file that the run of {file} wrote, but altered or of another "
                "run; remove it, or plan again."
            )
        if name in stated and not os.path.lexists(beside):
            _refuse_hidden(beside, stated[name])


def _refuse_hidden(missing: Path, digest: str) -> None:
    """Refuse a missing file if a hidden one next to it, left by a replacement, has its content."""
    for hidden in hidden_copies(missing):
        if hidden.is_file() and _digest(hidden) == digest:
            raise InputError(
                f"{missing} is missing, because a later run could not be written; it is kept as "
                f"{hidden.name!r}: rename that to {missing.name!r}, or plan again."
            )


def _digest(file: Path) -> str:
    with reading("file", file), file.open("rb") as opened:
        return hashlib.file_digest(opened, "sha256").hexdigest()
