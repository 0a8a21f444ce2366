"""Several files of a folder replaced together: all or none."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import re
import secrets
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from pathgene.host import interrupts
from pathgene.host.files.disk import current, sync_names
from pathgene.host.files.special import is_special, write_through


__all__ = ["TRIAL", "beside", "hidden_copies", "replace_files"]

#: Name of the file that tries whether a folder takes files.
TRIAL = "writable"

# Longest wait for another writer of the same folder, which takes moments.
_PATIENCE_S = 10.0
_POLL_S = 0.02


def replace_files(
    directory: Path, contents: Mapping[str, bytes], *, gone: Iterable[str] = ()
) -> None:
    """Put files into a folder and remove obsolete ones: all, or nothing has changed.

    The files are written next to their places and synced, then renamed into them, the last of
    ``contents`` last. A failure undoes earlier renames and removals. A special file
    stays: its content is written to it before anything is renamed. Signals wait for the end.

    A process that is killed between two renames leaves older and newer files side by side, and
    hidden ones, which the next call that writes the same names removes. It keeps the only copy of
    a file until it has succeeded.

    Parameters
    ----------
    contents : mapping
        Content of each file by its name.
    gone : iterable of str
        Names of the files to remove. One that is missing, special or a folder is left alone.

    Raises
    ------
    OSError
        If the system refuses. If it also refuses to put a file back, the error says so.
    """
    removed = [name for name in gone if name not in contents]
    with interrupts.held(), _locked(directory) as is_alone:
        left = _left(directory, (*contents, *removed, TRIAL)) if is_alone else {}
        _remove(file for file, place in left.items() if os.path.lexists(place))
        change = _Change(directory)
        try:
            change.stage(contents)
            change.apply(removed)
            _remove(left)
        except BaseException as error:
            if change.undo() or not isinstance(error, OSError):
                raise
            raise OSError(
                error.errno,
                f"{error.strerror or error}, and not all older files could be put back",
            ) from error
        finally:
            change.clear()


def beside(place: Path) -> Path:
    """Return a new hidden name in the folder of ``place``."""
    return place.with_name(f".{place.name}.{secrets.token_hex(4)}")


class _Change:
    """The steps of a replacement, and how to undo them."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._staged: dict[Path, Path] = {}
        self._hidden: list[Path] = []
        # The older file of each place that has changed; None if there was none.
        self._older: dict[Path, Path | None] = {}

    def stage(self, contents: Mapping[str, bytes]) -> None:
        """Write new files next to their places, and write special files directly."""
        special = []
        for name, content in contents.items():
            place = self._directory / name
            if is_special(place):
                special.append((place, content))
                continue
            if _is_directory(place):
                raise IsADirectoryError(errno.EISDIR, f"{name} is a directory")
            self._staged[place] = self._beside(place)
            with current().create(self._staged[place]) as file:
                file.write(content)
                current().sync(file)
        for place, content in special:
            write_through(place, content)

    def apply(self, removed: Iterable[str]) -> None:
        """Rename the new files into their places, the last one after everything has been done."""
        staged = list(self._staged.items())
        for place, file in staged[:-1]:
            older = self._keep(place)
            current().rename(file, place)
            self._older[place] = older
        places = [self._directory / name for name in removed]
        obsolete = [
            place
            for place in places
            if os.path.lexists(place) and not (_is_directory(place) or is_special(place))
        ]
        if obsolete:
            # After a loss of power, a missing file must not be the only trace of the change:
            # nobody would notice it.
            sync_names(self._directory)
        for place in obsolete:
            self._move(place, self._beside(place))
        for place, file in staged[-1:]:
            current().rename(file, place)  # Need not be undone: nothing after it can fail.
        sync_names(self._directory)

    def undo(self) -> bool:
        """Put the older files back; return whether all are."""
        is_whole = True
        for place, older in reversed(self._older.items()):
            try:
                if older is not None:
                    current().rename(older, place)
                else:
                    current().unlink(place)
                sync_names(self._directory)  # Step by step, as in apply().
            except OSError:
                is_whole = False
                if older is not None:
                    self._hidden.remove(older)  # The only copy stays.
        return is_whole

    def clear(self) -> None:
        """Remove all hidden files."""
        _remove(self._hidden)

    def _keep(self, place: Path) -> Path | None:
        """Give the file at ``place`` a hidden name, and return it; None if there is no file."""
        if not os.path.lexists(place):
            return None
        older = self._beside(place)
        try:
            current().link(place, older)  # As well, so that the place is never empty.
        except OSError:
            self._move(place, older)  # A file system without links.
        return older

    def _move(self, place: Path, older: Path) -> None:
        """Take the file away from its place."""
        current().rename(place, older)
        self._older[place] = older

    def _beside(self, place: Path) -> Path:
        self._hidden.append(hidden := beside(place))
        return hidden


def _is_directory(place: Path) -> bool:
    return place.is_dir() and not place.is_symlink()


def hidden_copies(place: Path) -> list[Path]:
    """Return the hidden files that a replacement of ``place`` has left next to it."""
    return list(_left(place.parent, [place.name]))


def _left(directory: Path, names: Iterable[str]) -> dict[Path, Path]:
    """Return the place of each hidden file that earlier writers of ``names`` left."""
    left = re.compile(rf"\.({'|'.join(map(re.escape, names))})\.[0-9a-f]{{8}}")
    with contextlib.suppress(OSError):
        found = [(file, left.fullmatch(file.name)) for file in directory.iterdir()]
        return {file: directory / name[1] for file, name in found if name}
    return {}


def _remove(files: Iterable[Path]) -> None:
    """Remove the files that exist, as far as the disk allows."""
    for file in filter(os.path.lexists, files):
        with contextlib.suppress(OSError):
            current().unlink(file)


@contextlib.contextmanager
def _locked(directory: Path) -> Iterator[bool]:
    """Lock a folder in the block; yield False if another writer does not end, or locks fail."""
    try:
        descriptor = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        yield False
        return
    try:
        yield _lock(descriptor)
    finally:
        os.close(descriptor)


def _lock(descriptor: int) -> bool:
    deadline = time.monotonic() + _PATIENCE_S
    while time.monotonic() < deadline:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            time.sleep(_POLL_S)
        except OSError:
            return False
        else:
            return True
    return False
