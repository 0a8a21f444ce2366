"""Kinds of values: read from the command line and from TOML, and written as TOML.

A few lines here write TOML, because a template needs comments and no package keeps them.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats.classes import forbidding
from pathgene.host.formats.limits import height_of
from pathgene.host.numeric import as_number, numbers, parse


__all__ = [
    "BOOLEAN",
    "CELL",
    "CLASSES",
    "GEO_POINT",
    "GEO_POINTS",
    "HEIGHT",
    "INTEGER",
    "MOMENT",
    "NUMBER",
    "PATH",
    "POINT",
    "POINTS",
    "RING",
    "RINGS",
    "TERRAIN",
    "TEXT",
    "VOIDS",
    "WATER_LEVEL",
    "Kind",
    "cell_sides",
    "choice",
    "moment_of",
    "separated",
    "to_toml",
    "vector",
]


# Years of a departure; dates that end their calendar cannot be counted on from.
_YEARS = range(1900, 2200)
_NONE = "none"


@dataclass(frozen=True)
class Kind:
    """The kind of a value.

    Parameters
    ----------
    name : str
        Description of a valid value, which ends the sentence "must be ...".
    read : callable
        Converts a TOML value, given the folder of the file; raises ValueError if it has the wrong
        type.
    write : callable
        Converts a value to TOML, given the folder of the file.
    parse : callable
        Converts a text of the command line; raises ValueError or
        :class:`argparse.ArgumentTypeError`.
    metavar : str
        Placeholder of the value in the help of a command; empty to use the name of the option.
    """

    name: str
    read: Callable[[Any, Path], Any]
    write: Callable[[Any, Path], Any] = lambda value, _: value
    parse: Callable[[str], Any] = str
    choices: tuple[str, ...] = ()
    metavar: str = ""


def separated(names: str) -> Callable[[str], tuple[float, ...]]:
    """Return a parser of comma-separated numbers, one for each of the comma-separated ``names``."""

    def convert(text: str) -> tuple[float, ...]:
        parts = text.split(",")
        try:
            values = tuple(map(parse, parts))
        except ValueError:
            values = ()
        if len(values) != len(names.split(",")):
            raise argparse.ArgumentTypeError(f"must be finite numbers {names}, not {text!r}")
        return values

    return convert


def cell_sides(text: str) -> tuple[float, float]:
    """Convert ``DX`` or ``DX,DY`` to the two sides of a cell."""
    dx, *dy = separated("DX,DY" if "," in text else "DX")(text)
    return dx, dy[0] if dy else dx


def _integer(value: Any, _: Path) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError
    return value


def _boolean(value: Any, _: Path) -> bool:
    if not isinstance(value, bool):
        raise ValueError
    return value


def _text(value: Any, _: Path) -> str:
    if not isinstance(value, str):
        raise ValueError
    return value


def _list(value: Any) -> Sequence[Any]:
    if not isinstance(value, list | tuple):
        raise ValueError
    return value


def _ring(value: Any) -> list[list[float]]:
    return [list(numbers(corner, 2)) for corner in _list(value)]


def _cell(value: Any, _: Path) -> tuple[float, ...]:
    return numbers(value, 2) if isinstance(value, list | tuple) else (as_number(value),) * 2


def _water_level(value: Any, _: Path) -> float | str:
    return _NONE if value == _NONE else as_number(value)


def _water_level_of(text: str) -> float | str:
    try:
        return _NONE if text == _NONE else parse(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"must be a height in metres or {_NONE}, not {text!r}"
        ) from None


def _voids(value: Any, _: Path) -> tuple[float, ...] | str:
    if value == _NONE:
        return _NONE
    if not isinstance(value, list | tuple):
        return (as_number(value),)
    if not value:
        raise ValueError
    return tuple(map(as_number, value))


def _voids_of(text: str) -> tuple[float, ...] | str:
    try:
        return _NONE if text == _NONE else tuple(map(parse, text.split(",")))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"must be numbers of the file, as in -9999,0, or {_NONE}, not {text!r}"
        ) from None


def _height(value: Any, _: Path) -> float | str:
    """Return a number of metres, or a text such as ``120 m AGL``."""
    if not isinstance(value, str):
        return as_number(value)
    try:
        return parse(value)
    except ValueError:
        pass
    try:
        height_of(value, "height")
    except InputError:
        raise ValueError from None
    return value


def _classes(value: Any, folder: Path) -> str:
    text = _text(value, folder)
    forbidding(text)
    return text


def _moment(value: Any, folder: Path) -> str:
    text = _text(value, folder)
    moment_of(text)
    return text


def moment_of(text: str) -> datetime:
    """Return the moment of a departure.

    Raises
    ------
    InputError
        If it is not a date and time with a time zone.
    """
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        moment = None
    if moment is None or moment.tzinfo is None or moment.year not in _YEARS:
        raise InputError(
            f"The departure must be a date and time with a time zone, as in "
            f"2026-05-01T09:00+02:00 or 2026-05-01T07:00Z, from 1900 to 2199, "
            f"not {text!r} (--departure)."
        )
    return moment


def _path(value: Any, folder: Path) -> str:
    if not value:
        raise ValueError
    return str(folder / _text(value, folder))


def _named_path(text: str) -> str:
    if not text:
        raise argparse.ArgumentTypeError("must name a file or folder, not ''")
    return text


def _relative(value: Any, folder: Path) -> str:
    """Return a path relative to the folder of the file."""
    return os.path.relpath(value, folder)


def _is_embedded(value: Any) -> bool:
    # Loads numpy; the help of a command must not wait for it.
    from pathgene.host.terrain.embedded import names

    return value in names()


def _terrain(value: Any, folder: Path) -> str:
    return str(value) if _is_embedded(value) else _path(value, folder)


def _written_terrain(value: Any, folder: Path) -> str:
    return str(value) if _is_embedded(value) else _relative(value, folder)


def _point(names: str) -> Kind:
    return Kind(
        "a list of three numbers",
        lambda value, _: numbers(value, 3),
        parse=separated(names),
        metavar=names,
    )


def _points(names: str) -> Kind:
    """Return the kind of a list of points; an option is repeated and gives one point each time."""
    return Kind(
        "a list of points, each a list of three numbers",
        lambda value, _: [numbers(point, 3) for point in _list(value)],
        parse=separated(names),
        metavar=names,
    )


BOOLEAN = Kind("true or false", _boolean)
INTEGER = Kind("a whole number", _integer, parse=int, metavar="N")
NUMBER = Kind("a number", lambda value, _: as_number(value), parse=float)
HEIGHT = Kind("a number of metres, or a height above the ground such as '120 m AGL'", _height)
TEXT = Kind("a text", _text)
WATER_LEVEL = Kind(f"a number or {_NONE}", _water_level, parse=_water_level_of, metavar="M|none")
VOIDS = Kind(
    f"a number, a list of numbers or {_NONE}", _voids, parse=_voids_of, metavar="V[,V]|none"
)
#: A bad text is refused with the sentence of its reader.
CLASSES = Kind("a list of classes of airspace", _classes, parse=str)
MOMENT = Kind("a date and time with a time zone", _moment, parse=str)
PATH = Kind("the path of a file", _path, _relative, _named_path)
TERRAIN = Kind("the path of a file or a name", _terrain, _written_terrain)
CELL = Kind("a number or a list of two", _cell, parse=cell_sides, metavar="DX[,DY]")
POINT, GEO_POINT = _point("X,Y,Z"), _point("LAT,LON,ALT")
POINTS, GEO_POINTS = _points("X,Y,Z"), _points("LAT,LON,ALT")
RING = Kind("a list of corners, each a list of two numbers", lambda value, _: _ring(value))
RINGS = Kind(
    "a list of rings, each a list of corners",
    lambda value, _: [_ring(ring) for ring in _list(value)],
)


def vector(names: str) -> Kind:
    """Return the kind of a list of numbers, one for each of the comma-separated ``names``."""
    length = len(names.split(","))
    return Kind(
        f"a list of {length} numbers",
        lambda value, _: numbers(value, length),
        parse=separated(names),
        metavar=names,
    )


def choice(values: Sequence[str], current: Callable[[str], str] = str) -> Kind:
    """Return the kind of a text that is one of ``values``; ``current`` replaces old names."""

    def read(value: Any, _: Path) -> str:
        word = current(value) if isinstance(value, str) else value
        if word not in values:
            raise ValueError
        return str(word)

    return Kind(f"one of {', '.join(values)}", read, parse=current, choices=tuple(values))


def to_toml(value: Any) -> str:
    """Return a value as TOML on one line.

    Raises
    ------
    InputError
        If TOML has no such value.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, str):
        # JSON escapes like TOML, except for the last control character.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(to_toml, value))}]"
    if isinstance(value, Mapping):
        items = ", ".join(f"{_key(name)} = {to_toml(item)}" for name, item in value.items())
        return f"{{ {items} }}"
    raise InputError(f"A problem file cannot hold {value!r}.")


def _key(name: str) -> str:
    return name if name.replace("_", "").isalnum() and name.isascii() else json.dumps(name)
