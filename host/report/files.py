"""Files that are whole or not there: each is written beside its place, then renamed into it."""

from __future__ import annotations

import contextlib
import json
import os
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from host.errors import InputError


__all__ = ["prepare_directory", "replacing", "write_json"]


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a binary file that takes the place of ``path`` when the block ends without an error."""
    partial = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with partial.open("xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def write_json(path: Path, value: Any) -> None:
    """Write ``value``, whose numbers must be finite, as JSON with a final newline."""
    text = json.dumps(value, indent=1, allow_nan=False)
    with replacing(path) as file:
        file.write(f"{text}\n".encode())


def prepare_directory(directory: Path) -> None:
    """Make ``directory`` and make sure that files can be put into it.

    Raises
    ------
    InputError
        If that is impossible.
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
        trial = directory / f".writable.{secrets.token_hex(4)}"
        trial.touch()
        trial.unlink()
    except OSError as error:
        raise InputError(f"Cannot write to the directory {str(directory)!r} "
                         f"({error.strerror or error}); give another with --out.") from None
