"""Paths as CSV with the header ``x,y,z``, and missions with columns of degrees."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.files.output import reading
from pathgene.host.formats.content import Content
from pathgene.host.formats.mission_items import AMSL, TERRAIN, MissionFile, line_file
from pathgene.host.inputs import read_text
from pathgene.host.numeric import parse
from pathgene.host.terrain import Terrain


__all__ = ["holds_mission", "mission", "read_csv", "read_path"]

_HEADER = ["x", "y", "z"]
# Names of columns, without case, blanks and the unit m.
_LATITUDES = ("lat", "latitude")
_LONGITUDES = ("lon", "lng", "long", "longitude")
_HEIGHTS = {
    **dict.fromkeys(("alt", "altitude", "alt_amsl", "altitude_amsl", "amsl", "ele"), AMSL),
    **dict.fromkeys(("agl", "alt_agl", "altitude_agl", "height_agl"), TERRAIN),
}


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


def holds_mission(content: Content) -> bool:
    """Return whether the first line of a text names a latitude and a longitude."""
    names = _names(content)
    return any(name in names for name in _LATITUDES) and any(name in names for name in _LONGITUDES)


def mission(content: Content) -> MissionFile:
    """Return the rows as points of a line; other columns are ignored.

    Raises
    ------
    InputError
        If there is no column of heights in metres, or a row is bad.
    """
    names = _names(content)
    if len(_first_line(content).split(",")) < len(names):
        raise InputError("its cells must be separated by commas, with decimal points in numbers.")
    lat = next(names.index(name) for name in _LATITUDES if name in names)
    lon = next(names.index(name) for name in _LONGITUDES if name in names)
    heights = [name for name in names if name in _HEIGHTS]
    for kind in (_LATITUDES, _LONGITUDES):
        same = [name for name in names if name in kind]
        if len(same) > 1:
            raise InputError(f"its columns {' and '.join(same)} mean the same; keep one.")
    if len(heights) != 1:
        raise InputError(
            f"its columns are {', '.join(names)}; give one of heights in metres, named alt (above "
            "mean sea level) or agl (above the ground)."
        )
    columns = (lat, lon, names.index(heights[0]))
    points = []
    try:
        reader = csv.reader(io.StringIO(content.text, newline=""))
        next(reader)
        for row in reader:
            if not any(cell.strip() for cell in row):
                continue
            # Decimal commas make more cells.
            if any(cell.strip() for cell in row[len(names) :]):
                raise InputError(
                    f"line {reader.line_num} has {len(row)} cells, and the header has "
                    f"{len(names)}; write numbers with decimal points."
                )
            points.append(_degrees(reader.line_num, row, columns))
    except csv.Error:
        raise InputError("it is not CSV.") from None
    if len(points) < 2:
        raise InputError("a line needs two rows or more.")
    return line_file("rows of CSV", points, _HEIGHTS[heights[0]])


def _degrees(line: int, row: list[str], columns: tuple[int, ...]) -> tuple[float, float, float]:
    try:
        lat, lon, height = (parse(row[at]) for at in columns)
    except (ValueError, IndexError):
        raise InputError(
            f"line {line} must have numbers for latitude, longitude and height, not "
            f"{','.join(row)!r}."
        ) from None
    return lat, lon, height


def _names(content: Content) -> list[str]:
    """Return the names of the columns, lower case, without a unit of metres."""
    first = re.split("[,;\t]", _first_line(content))
    cells = (" ".join(cell.strip().strip('"').split()).lower() for cell in first)
    return [re.sub(r"[ _]*[(\[]?m[)\]]?$|[ _]+metres$", "", cell) for cell in cells]


def _first_line(content: Content) -> str:
    return content.text.lstrip("\ufeff").partition("\n")[0]
