"""Values of a problem file: read from what TOML gives, and written as TOML.

Writing takes these few lines and no package: a template needs comments, which those that write TOML
do not keep.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.numeric import as_number, numbers
from pathgene.host.terrain.embedded import names as terrain_names


__all__ = [
    "BOOLEAN",
    "CELL",
    "INTEGER",
    "NUMBER",
    "PATH",
    "POINT",
    "POINTS",
    "RING",
    "RINGS",
    "TERRAIN",
    "TEXT",
    "Kind",
    "choice",
    "to_toml",
    "vector",
]


@dataclass(frozen=True)
class Kind:
    """The kind of a value.

    Parameters
    ----------
    name : str
        What the value must be, in words.
    read : callable
        Returns the value of what TOML gives and the folder of the file; raises ValueError for what
        is no such value.
    write : callable
        Returns the inverse: what TOML takes, of a value and the folder of the file.
    choices : tuple of str
        All values, where they are few.
    """

    name: str
    read: Callable[[Any, Path], Any]
    write: Callable[[Any, Path], Any] = lambda value, _: value
    choices: tuple[str, ...] = ()


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


def _path(value: Any, folder: Path) -> str:
    return str(folder / _text(value, folder))


def _relative(value: Any, folder: Path) -> str:
    """Return a path as seen from the folder of the file."""
    return os.path.relpath(value, folder)


def _terrain(value: Any, folder: Path) -> str:
    return value if value in terrain_names() else _path(value, folder)


def _written_terrain(value: Any, folder: Path) -> str:
    return value if value in terrain_names() else _relative(value, folder)


BOOLEAN = Kind("true or false", _boolean)
INTEGER = Kind("a whole number", _integer)
NUMBER = Kind("a number", lambda value, _: as_number(value))
TEXT = Kind("a text", _text)
PATH = Kind("the path of a file", _path, _relative)
TERRAIN = Kind("the path of a file or a name", _terrain, _written_terrain)
CELL = Kind("a number or a list of two", _cell)
POINT = Kind("a list of three numbers", lambda value, _: numbers(value, 3))
POINTS = Kind(
    "a list of points, each a list of three numbers",
    lambda value, _: [numbers(point, 3) for point in _list(value)],
)
RING = Kind("a list of corners, each a list of two numbers", lambda value, _: _ring(value))
RINGS = Kind(
    "a list of rings, each a list of corners",
    lambda value, _: [_ring(ring) for ring in _list(value)],
)


def vector(length: int) -> Kind:
    """Return the kind of a list of ``length`` numbers."""
    return Kind(f"a list of {length} numbers", lambda value, _: numbers(value, length))


def choice(values: Sequence[str], current: Callable[[str], str] = str) -> Kind:
    """Return the kind of a text that is one of ``values``; ``current`` replaces old names."""

    def read(value: Any, _: Path) -> str:
        word = current(value) if isinstance(value, str) else value
        if word not in values:
            raise ValueError
        return str(word)

    return Kind(f"one of {', '.join(values)}", read, choices=tuple(values))


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
        # JSON escapes as TOML does, but for the last control character.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(to_toml, value))}]"
    if isinstance(value, Mapping):
        items = ", ".join(f"{_key(name)} = {to_toml(item)}" for name, item in value.items())
        return f"{{ {items} }}"
    raise InputError(f"A problem file cannot hold {value!r}.")


def _key(name: str) -> str:
    return name if name.replace("_", "").isalnum() and name.isascii() else json.dumps(name)
