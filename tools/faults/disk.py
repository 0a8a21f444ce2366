"""A disk that fails or is slow at a chosen call, or at which the process is killed."""

from __future__ import annotations

import errno
import io
import os
import random
import time
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from pathgene.host.files.disk import Disk
from tools.faults.platter import TEARS_LAST, Platter


if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


#: Not an error number: the call takes a long time but succeeds.
SLOW = 0
# Seconds of a slow call, and of each call if all later ones are slow too.
_SLOW_S, _ALWAYS_SLOW_S = 0.05, 0.002

# The errors of a full disk.
_FULL = frozenset({errno.ENOSPC, errno.EDQUOT})


class Killed(BaseException):
    """The end of a process by SIGKILL or a loss of power: nothing is written after it."""


class FaultyDisk(Disk):
    """A real disk that counts its calls, from 1, and fails at one of them.

    Each method of :class:`pathgene.host.files.disk.Disk` is a call, and so is each write that a
    file passes on to the system. A write that fails is torn: part of its data, drawn from the seed,
    reaches the disk; for some seeds, all but the last byte. As in the kernel, a partial write is
    not an error; the call after it fails. A sync does not wait for the real disk, but the
    ``platter`` notes it.

    Parameters
    ----------
    at : int, optional
        Number of the call that fails; None only counts. A full disk fails at the first call from
        there on that needs space; renaming and removing still work.
    error : int
        Number of the error, a constant of :mod:`errno`, or :data:`SLOW`; a full disk by default.
    lasting : bool
        Every later call also fails or is slow.
    calls : int
        Number of calls after which a lasting fault is over; 0 for none.
    kill : bool
        Raise :class:`Killed` instead, at this and every later call.
    seed : int
        Seed of the lengths of torn writes.
    platter : Platter, optional
        Notes the bytes and names that survive a loss of power.

    Attributes
    ----------
    calls : list of str
        The calls made, with the names of their files.
    failed, slowed : bool
        True once a call has failed or the process is killed; true once a call was slow.
    refused : list of str
        The calls that failed with an error, as in ``calls``.
    """

    def __init__(
        self,
        at: int | None = None,
        *,
        error: int = errno.ENOSPC,
        lasting: bool = False,
        kill: bool = False,
        calls: int = 0,
        seed: int = 0,
        platter: Platter | None = None,
    ) -> None:
        self.calls: list[str] = []
        self.refused: list[str] = []
        self._platter = platter
        self._at, self._error, self._lasting, self._kill = at, error, lasting, kill
        self._calls = calls
        self._random = random.Random(seed)
        self._tears_last = random.Random(f"{seed} torn").random() < TEARS_LAST
        self._owed = False
        self.failed = self.slowed = False

    def create(self, path: Path) -> BinaryIO:
        """Open a new file."""
        self._call("create", path)
        file = io.BufferedWriter(_File(self, path, "xb"))
        if self._platter:
            self._platter.enter(path)
        return file

    def append(self, path: Path) -> BinaryIO:
        """Open a file for reading and for writing at its end."""
        self._call("append", path)
        file = io.BufferedRandom(_File(self, path, "a+b"))
        if self._platter:
            self._platter.enter(path)
        return file

    def sync(self, file: BinaryIO) -> None:
        """Flush a file."""
        file.flush()
        path = Path(str(file.name))
        self._call("sync", path)
        if self._platter:
            self._platter.sync(path)

    def sync_directory(self, path: Path) -> None:
        """Count the call."""
        self._call("sync_directory", path)
        if self._platter:
            self._platter.sync_names(path)

    def link(self, source: Path, target: Path) -> None:
        """Give a file a second name."""
        self._call("link", source)
        super().link(source, target)
        if self._platter:
            self._platter.link(source, target)

    def rename(self, source: Path, target: Path) -> None:
        """Rename a file."""
        self._call("rename", target, needs_space=False)
        if self._platter:
            self._platter.move(source, target)
        super().rename(source, target)

    def unlink(self, path: Path) -> None:
        """Remove a file."""
        self._call("unlink", path, needs_space=False)
        if self._platter:
            self._platter.remove(path)
        super().unlink(path)

    def make_directory(self, path: Path) -> None:
        """Make a folder."""
        self._call("make_directory", path)
        super().make_directory(path)

    def torn(self, path: Path, size: int) -> int:
        """Count a write of ``size`` bytes; return how many of them reach the disk.

        Raises
        ------
        OSError, Killed
            If none does.
        """
        is_slow = self._error == SLOW and not self._kill
        if not (self.failed or self._owed or is_slow) and self._is_due(needs_space=True):
            share = self._random.randrange(size) if size else 0
            if self._tears_last:
                share = size - 1
            if share > 0:
                self._owed = True  # The next call fails.
                self.calls.append(f"write {path.name}")
                return share
        self._call("write", path)
        return size

    def _call(self, name: str, path: Path, *, needs_space: bool = True) -> None:
        """Count a call, and fail if it is due."""
        is_due = self._owed or self._is_due(needs_space=needs_space)
        self._owed = False
        self.calls.append(f"{name} {path.name}")
        if not is_due:
            return
        if self._error == SLOW and not self._kill:
            self.slowed = True
            time.sleep(_ALWAYS_SLOW_S if self._lasting else _SLOW_S)
            return
        self.failed = True
        if self._kill:
            raise Killed
        self.refused.append(self.calls[-1])
        raise OSError(self._error, os.strerror(self._error), str(path))

    def _is_due(self, *, needs_space: bool) -> bool:
        """Return whether the next call fails."""
        if self._at is None or len(self.calls) + 1 < self._at:
            return False
        if self._kill:
            return True
        if self._calls and len(self.refused) >= self._calls:
            return False
        is_needed = needs_space or self._error not in _FULL
        return is_needed and (self._lasting or not (self.failed or self.slowed))


class _File(io.FileIO):
    """A file whose writes are calls of a disk."""

    def __init__(self, disk: FaultyDisk, path: Path, mode: str) -> None:
        super().__init__(path, mode)
        self._disk = disk

    def write(self, data: ReadableBuffer, /) -> int:
        """Write a part of ``data``, or fail; return the number of bytes."""
        view = memoryview(data).cast("B")
        size = self._disk.torn(Path(str(self.name)), len(view))
        return super().write(view[:size])
