"""Atomic output files: each is written beside its place, then renamed into it.

Devices, FIFOs and open descriptors such as ``/dev/stdout`` are written to and never replaced.
"""

from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import secrets
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from host import interrupts
from host.errors import InputError


__all__ = [
    "is_special",
    "output_file",
    "prepare_directory",
    "prepare_file",
    "reading",
    "remove",
    "replacing",
    "write_json",
    "writing_into",
]

# Most symbolic links followed, as in Linux.
_MOST_LINKS = 40


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a binary file that replaces ``path`` when the block ends without an error.

    A special file at ``path`` stays: the content of the block is written to it at once.
    """
    if is_special(path):
        content = io.BytesIO()
        yield content
        _write_through(path, content.getbuffer())
        return
    with interrupts.held(), _renamed_into(path) as file:
        yield file


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


def remove(path: Path) -> None:
    """Remove the file at ``path`` if there is one; a special file or a directory stays."""
    if not is_special(path):
        with contextlib.suppress(OSError):
            path.unlink()


def is_special(path: Path) -> bool:
    """Return whether ``path`` is, or links to, a device, a FIFO, a socket or an open descriptor."""
    if _descriptor(path) is not None:
        return True
    try:
        mode = path.stat().st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def _descriptor(path: Path) -> int | None:
    """Return the descriptor of this process that ``path`` is, as ``/dev/stdout`` is."""
    own = Path(f"/proc/{os.getpid()}/fd")
    for _ in range(_MOST_LINKS):
        if path.name.isdecimal() and Path(os.path.realpath(path.parent)) == own:
            return int(path.name)
        try:
            path = path.parent / path.readlink()
        except OSError:
            return None
    return None


def _write_through(path: Path, content: memoryview) -> None:
    """Write ``content`` to the special file ``path``."""
    number = _descriptor(path)
    if number is None and path.is_block_device():
        raise OSError(errno.ENOTSUP, "it is a block device, which may hold a file system")
    # The descriptor itself: its file, opened again, would begin at position 0.
    with os.fdopen(os.open(path, os.O_WRONLY) if number is None else os.dup(number), "wb") as file:
        file.write(content)


@contextlib.contextmanager
def _renamed_into(path: Path) -> Iterator[BinaryIO]:
    """Open a file that is renamed to ``path`` at the end of the block, or removed on an error."""
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
        directory.mkdir(parents=True, exist_ok=True)
        trial = directory / f".writable.{secrets.token_hex(4)}"
        trial.touch()
        trial.unlink()


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
