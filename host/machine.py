"""The machine on which the process runs: its cores and its memory."""

from __future__ import annotations

import ctypes
import os


__all__ = ["available_cores", "keep_memory"]


# Options of the GNU C library's mallopt, and their values. Arrays below 32 MiB, the highest
# threshold allowed, do not get their own mapping, and the process keeps up to a GiB of free memory.
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
_LARGEST, _KEPT = 32 << 20, 1 << 30


def keep_memory() -> None:
    """Let the process keep up to a GiB of freed memory.

    An array of a map has over a thousand pages. Requesting them again from the kernel costs a
    replan several milliseconds. This has no effect with C libraries other than GNU's.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_MMAP_THRESHOLD, _LARGEST)
        mallopt(_TRIM_THRESHOLD, _KEPT)


def available_cores() -> int:
    """Return the number of cores that this process may use, 1 or more."""
    # Some systems lack it; os.process_cpu_count exists only since Python 3.13.
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
