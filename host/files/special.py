"""Devices, FIFOs and open descriptors, which are written to and never replaced."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path


__all__ = ["is_special", "write_through"]

# Most symbolic links followed, as in Linux.
_MOST_LINKS = 40


def is_special(path: Path) -> bool:
    """Return whether ``path`` is, or links to, a device, a FIFO, a socket or an open descriptor."""
    if _descriptor(path) is not None:
        return True
    try:
        mode = path.stat().st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def write_through(path: Path, content: bytes) -> None:
    """Write ``content`` to the special file ``path``.

    Raises
    ------
    OSError
        If that fails, or the file is a block device.
    """
    number = _descriptor(path)
    if number is None and path.is_block_device():
        raise OSError(errno.ENOTSUP, "it is a block device, which may hold a file system")
    # The descriptor itself: its file, opened again, would begin at position 0.
    with os.fdopen(os.open(path, os.O_WRONLY) if number is None else os.dup(number), "wb") as file:
        file.write(content)


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
