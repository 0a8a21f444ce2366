"""The number of cores that this process may use."""

import os


__all__ = ["available_cores"]


def available_cores() -> int:
    """Return the number of cores that this process may use, 1 or more."""
    # Some systems lack it; os.process_cpu_count is new in Python 3.13.
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
