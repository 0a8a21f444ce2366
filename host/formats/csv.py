"""Paths as CSV with the header ``x,y,z``."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.files.output import reading
from pathgene.host.inputs import read_text
from pathgene.host.numeric import parse
from pathgene.host.terrain import Terrain


__all__ = ["read_csv", "read_path"]

_HEADER = ["x", "y", "z"]


def read_path(file: Path, _terrain: Terrain) -> NDArray[np.float64]:
    """Return the waypoints in a file, local metres; see :func:`read_csv`."""
    return read_csv(file)


def read_csv(file: Path) -> NDArray[np.float64]:
    """Return the rows of a path, (n, 3) float64 metres; blank lines are skipped.

    Raises
    ------
    InputError
        If the file cannot be read, has a wrong header, a row that is not three finite numbers, or
        fewer than two rows; the sentence names the line.
    """
    try:
        with reading("path", file):
            reader = csv.reader(io.StringIO(read_text(file, "utf-8-sig"), newline=""))
            rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if row]
    except (UnicodeDecodeError, csv.Error):
        raise InputError(f"{file}: not a CSV file; give one with the header x,y,z.") from None
    if not rows or rows[0][1] != _HEADER:
        raise InputError(f"{file}: the first line must be the header x,y,z.")
    points = [_point(file, number, row) for number, row in rows[1:]]
    if len(points) < 2:
        raise InputError(
            f"{file}: a path needs two rows or more, the start first and the goal last."
        )
    return np.array(points, dtype=np.float64)


def _point(file: Path, number: int, row: list[str]) -> list[float]:
    try:
        point = [parse(cell) for cell in row]
    except ValueError:
        point = []
    if len(point) != 3:
        raise InputError(
            f"{file}, line {number}: must be three finite numbers x,y,z, not {','.join(row)!r}."
        )
    return point
