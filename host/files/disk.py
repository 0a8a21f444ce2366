"""The disk that all output goes to, which a test can exchange for one that fails."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO


__all__ = ["Disk", "current", "sync_names", "using"]


class Disk:
    """The calls that change files and folders; each raises OSError as the system does."""

    def create(self, path: Path) -> BinaryIO:
        """Open a new file for writing; FileExistsError if there is one."""
        return path.open("xb")

    def append(self, path: Path) -> BinaryIO:
        """Open a file, made if missing, for reading and for writing at its end."""
        return path.open("a+b")

    def sync(self, file: BinaryIO) -> None:
        """Flush a file that is open for writing, and wait until the disk has its content."""
        file.flush()
        os.fsync(file.fileno())

    def sync_directory(self, path: Path) -> None:
        """Wait until the disk has the names in a folder."""
        descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)

    def link(self, source: Path, target: Path) -> None:
        """Give the file, or the symbolic link, ``source`` the second name ``target``."""
        os.link(source, target, follow_symlinks=False)

    def rename(self, source: Path, target: Path) -> None:
        """Rename a file or a folder; a file at ``target`` is replaced."""
        source.rename(target)

    def unlink(self, path: Path) -> None:
        """Remove a file."""
        path.unlink()

    def make_directory(self, path: Path) -> None:
        """Make a folder and its parents, unless it exists."""
        path.mkdir(parents=True, exist_ok=True)


_current = Disk()


def current() -> Disk:
    """Return the disk that files are written to now."""
    return _current


def sync_names(directory: Path) -> None:
    """Wait until the disk has the names in a folder, if its file system can tell."""
    with contextlib.suppress(OSError):
        current().sync_directory(directory)


@contextlib.contextmanager
def using(disk: Disk) -> Iterator[None]:
    """Write all files to ``disk`` in the block, from all threads of this process."""
    global _current
    before, _current = _current, disk
    try:
        yield
    finally:
        _current = before
