"""How many cores there are for this process."""

import os


__all__ = ["available_cores"]


def available_cores() -> int:
    """Cores that this process may use, 1 or more."""
    # Not on every system; os.process_cpu_count is of Python 3.13.
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
