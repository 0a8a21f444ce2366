"""Devices, FIFOs and open descriptors, which are written to and never replaced."""

from __future__ import annotations

import contextlib
import errno
import os
import select
import stat
import time
from pathlib import Path

from pathgene.host.numeric import whole


__all__ = ["is_special", "write_patiently", "write_through"]

# Maximum number of symbolic links followed, as in Linux.
_MOST_LINKS = 40
# The system numbers them by an int.
_MOST_DESCRIPTORS = 2**31 - 1
# Seconds after which an idle reader is given up: signals may be waiting for the end.
_PATIENCE_S = 10.0
_POLL_S = 0.02


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

    An open descriptor of this process waits for its reader, as standard output does.

    Raises
    ------
    OSError
        If that fails, the file is a block device or a FIFO that nobody reads, or its reader takes
        nothing for 10 s.
    """
    number = _descriptor(path)
    if number is not None:
        # The descriptor itself: its file, opened again, would begin at position 0.
        with os.fdopen(os.dup(number), "wb") as file:
            file.write(content)
        return
    if path.is_block_device():
        raise OSError(errno.ENOTSUP, "it is a block device, which may hold a file system")
    number = _opened(path)
    try:
        if not write_patiently(number, content, _PATIENCE_S):
            raise OSError(
                errno.ETIMEDOUT,
                f"the reader of {path.name} has taken nothing for {_PATIENCE_S:g} s",
            )
    finally:
        os.close(number)


def write_patiently(number: int, content: bytes, patience_s: float) -> bool:
    """Write to a pipe, a terminal or a device; return whether all of it was taken.

    Parameters
    ----------
    patience_s : float
        Longest wait for room, in seconds, after which the rest is not written.

    Raises
    ------
    OSError
        If the reader has left, or the system refuses.
    """
    room = select.poll()
    room.register(number, select.POLLOUT)
    deadline = time.monotonic() + patience_s
    left = memoryview(content)
    while left and room.poll(1000 * max(0.0, deadline - time.monotonic())):
        try:
            left = left[os.write(number, left) :]
        except BlockingIOError:  # Another writer has taken the room.
            if time.monotonic() > deadline:
                break
            time.sleep(_POLL_S)
        else:
            deadline = time.monotonic() + patience_s
    return not left


def _opened(path: Path) -> int:
    """Open a special file for writing, without waiting for a reader."""
    try:
        return os.open(path, os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY)
    except OSError as error:
        if error.errno == errno.ENXIO and path.is_fifo():
            raise OSError(errno.ENXIO, f"{path.name} is a pipe that nobody reads") from None
        raise


def _descriptor(path: Path) -> int | None:
    """Return the descriptor of this process that ``path`` is, as ``/dev/stdout`` is."""
    own = Path(f"/proc/{os.getpid()}/fd")
    for _ in range(_MOST_LINKS):
        with contextlib.suppress(ValueError):
            number = whole(path.name, _MOST_DESCRIPTORS)
            if Path(os.path.realpath(path.parent)) == own:
                return number
        try:
            path = path.parent / path.readlink()
        except OSError:
            return None
    return None
