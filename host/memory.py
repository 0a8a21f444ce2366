"""Memory of the process: freed pages are kept, so that nothing waits for the kernel's."""

from __future__ import annotations

import ctypes


__all__ = ["keep_memory"]

# Options of the GNU C library's mallopt, and values: arrays below 32 MiB, the most it allows, are
# not mapped on their own, and a GiB of free memory stays with the process.
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
_LARGEST, _KEPT = 32 << 20, 1 << 30


def keep_memory() -> None:
    """Have the process keep up to a GiB of memory that is freed.

    An array of a map is over a thousand pages. Where each comes anew, it takes a replan several
    milliseconds. It does nothing with another C library than GNU's.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_MMAP_THRESHOLD, _LARGEST)
        mallopt(_TRIM_THRESHOLD, _KEPT)
