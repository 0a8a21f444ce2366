"""Output files: each is written completely or not at all, and errors are sentences."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from pathgene.host.errors import InputError
from pathgene.host.files.disk import current
from pathgene.host.files.replacement import TRIAL, beside, replace_files
from pathgene.host.files.special import is_special, write_through


__all__ = [
    "json_bytes",
    "output_file",
    "prepare_directory",
    "prepare_file",
    "reading",
    "replacing",
    "write_json",
    "writing_into",
]


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Collect the content of ``path``, and put it there when the block ends without an error.

    A special file at ``path`` stays, and the content is written to it.

    Raises
    ------
    OSError
        If the system refuses; the older file is still there then.
    """
    content = io.BytesIO()
    yield content
    if is_special(path):
        write_through(path, content.getvalue())
    else:
        replace_files(path.parent, {path.name: content.getvalue()})


@contextlib.contextmanager
def output_file(path: Path) -> Iterator[BinaryIO]:
    """Open the file that the user chose with ``--out``; see :func:`replacing`.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    try:
        with replacing(path) as file:
            yield file
    except OSError as error:
        raise InputError(
            f"Cannot write to {str(path)!r} ({error.strerror or error}); give another file (--out)."
        ) from None


def json_bytes(value: Any) -> bytes:
    """Return ``value``, whose numbers must be finite, as JSON with a final newline."""
    return f"{json.dumps(value, indent=1, allow_nan=False)}\n".encode()


def write_json(path: Path, value: Any) -> None:
    """Write ``value`` as :func:`json_bytes` gives it; see :func:`replacing`."""
    with replacing(path) as file:
        file.write(json_bytes(value))


def prepare_file(path: Path) -> None:
    """Check, before the work for it, that :func:`output_file` can put a file at ``path``.

    Raises
    ------
    InputError
        If that is impossible.
    """
    if path.is_dir():
        raise InputError(f"{str(path)!r} is a directory; give the name of a file.")
    if not is_special(path):
        prepare_directory(path.parent)


def prepare_directory(directory: Path) -> None:
    """Make ``directory`` and check that it takes files.

    Raises
    ------
    InputError
        If that is impossible.
    """
    with writing_into(directory):
        current().make_directory(directory)
        trial = beside(directory / TRIAL)
        with current().create(trial):
            pass
        with contextlib.suppress(FileNotFoundError):  # Another process cleared up here.
            current().unlink(trial)


@contextlib.contextmanager
def reading(what: str, file: Path) -> Iterator[None]:
    """Read ``file`` in the block; ``what`` is its content in a word, for the sentence.

    Raises
    ------
    InputError
        If the system refuses.
    """
    try:
        yield
    except OSError as error:
        raise InputError(
            f"Cannot read the {what} {str(file)!r} ({error.strerror or error})."
        ) from None


@contextlib.contextmanager
def writing_into(directory: Path) -> Iterator[None]:
    """Write files into ``directory`` in the block.

    Raises
    ------
    InputError
        If the system refuses.
    """
    try:
        yield
    except OSError as error:
        raise InputError(
            f"Cannot write to the directory {str(directory)!r} "
            f"({error.strerror or error}); give another (--out)."
        ) from None
