"""Files that a user gives: only regular files are opened, and texts of limited size are read.

JSON and TOML are parsed here, so that any error in them is a ValueError.
"""

from __future__ import annotations

import errno
import json
import os
import re
import stat
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError


__all__ = [
    "MOST_TEXT_BYTES",
    "MOST_TOML_BYTES",
    "exists",
    "opened",
    "parse_json",
    "parse_toml",
    "read_bytes",
    "read_text",
    "require_regular",
]

#: Maximum size of a text file in bytes: a problem, an aircraft, zones, a path or a summary.
MOST_TEXT_BYTES = 64_000_000
#: Maximum size of a text in TOML, which tomllib reads at some megabytes a second.
MOST_TOML_BYTES = 16_000_000
# A dotted key of TOML with this many parts is refused; no table here is that deep.
_KEY_PARTS = 20
_KEY_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+"""
# A key begins a line, a table or an array of tables, or follows in an inline table.
_LONG_KEY = re.compile(
    rf"(?:^|[{{,\[])[ \t]*+(?:{_KEY_PART}\.[ \t]*+){{{_KEY_PARTS - 1}}}{_KEY_PART}", re.MULTILINE
)


def exists(path: str | Path) -> bool:
    """Return whether there is a file or folder; False for an impossible name."""
    try:
        return Path(path).exists()
    except (OSError, ValueError):
        return False


def require_regular(path: Path) -> None:
    """Check that ``path`` is a regular file, so that reading it ends and does not block.

    Raises
    ------
    InputError
        If it is a FIFO, a socket or a device.
    OSError
        If there is no such file, it is a directory, or the system refuses.
    """
    try:
        mode = path.stat().st_mode
    except ValueError:
        # A NUL or half a surrogate pair, which a name in a JSON or TOML file may contain.
        raise OSError(errno.EINVAL, "No file has such a name") from None
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        raise InputError(
            f"{path}: must be a regular file, not a pipe or a device; copy it into one."
        )


@contextmanager
def opened(path: Path) -> Iterator[BufferedReader]:
    """Open a regular file for reading; raises the errors of :func:`require_regular`."""
    require_regular(path)
    with path.open("rb") as file:
        yield file


def read_text(path: Path, encoding: str = "utf-8") -> str:
    """Return the text of a regular file.

    Raises
    ------
    InputError
        If it is not a regular file, or has more than :data:`MOST_TEXT_BYTES`.
    OSError
        If the system refuses.
    UnicodeDecodeError
        If it is not text in this encoding.
    """
    return read_bytes(path).decode(encoding)


def read_bytes(path: Path) -> bytes:
    """Return the content of a regular file; raises as :func:`read_text`."""
    with opened(path) as file:
        content = file.read(MOST_TEXT_BYTES + 1)
    if len(content) > MOST_TEXT_BYTES:
        raise InputError(
            f"{path}: has more than {MOST_TEXT_BYTES // 1_000_000} MB, too much for a text; give "
            "a smaller file."
        )
    return content


def parse_json(text: str) -> Any:
    """Return the content of a text in JSON.

    Raises
    ------
    ValueError
        If it is not JSON, or is nested too deeply.
    """
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("lists or objects are nested too deeply") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Return the content of a text in TOML.

    Raises
    ------
    ValueError
        If it is not TOML, is nested too deeply, has more than 16 MB, or has an integer of more than
        64 bits, which TOML does not require of its readers.
    """
    # Notepad writes a byte order mark.
    text = text.removeprefix("\ufeff")
    if len(text) > MOST_TOML_BYTES:
        most = MOST_TOML_BYTES // 1_000_000
        raise ValueError(f"it has more than {most} MB; put zones into a file of their own")
    # The time of tomllib grows with the square of their number.
    if _LONG_KEY.search(text):
        raise ValueError(f"a key has {_KEY_PARTS} parts or more")
    try:
        document = tomllib.loads(text)
    except RecursionError:
        raise ValueError("tables or arrays are nested too deeply") from None
    values: list[Any] = [document]
    while values:
        value = values.pop()
        if isinstance(value, dict):
            values += value.values()
        elif isinstance(value, list):
            values += value
        elif isinstance(value, int) and not -(1 << 63) <= value < 1 << 63:
            raise ValueError("an integer has more than 64 bits")
    return document
