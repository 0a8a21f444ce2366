"""Reduction of a case to the faults that are needed to fail."""

from __future__ import annotations

from collections.abc import Callable

from tools.faults.case import Case


__all__ = ["shrunk"]


def shrunk(case: Case, fails: Callable[[Case], bool]) -> Case:
    """Return a case with a subset of the faults of ``case``, each of which is needed to fail.

    It leaves out halves, then quarters and so on, then single faults, until none can be removed.

    Parameters
    ----------
    case : Case
        A case that fails.
    fails : callable
        Runs a case; returns True if it fails.
    """
    faults = case.faults
    size = max(len(faults) // 2, 1)
    while faults:
        at, has_shrunk = 0, False
        while at < len(faults):
            fewer = faults[:at] + faults[at + size :]
            if fails(case.with_faults(fewer)):
                faults, has_shrunk = fewer, True
            else:
                at += size
        if size == 1 and not has_shrunk:
            break
        size = max(size // 2, 1)
    return case.with_faults(faults)
