"""Errors that the command line reports as one sentence and an exit status."""

from __future__ import annotations

from typing import Any


__all__ = ["InputError", "JobError", "NoPathError", "PathgeneError"]


class PathgeneError(Exception):
    """An error whose message is one sentence for the user; no traceback is shown."""

    exit_status = 1


class InputError(PathgeneError):
    """Bad input or usage; the sentence names the error and a remedy. Exit status 2."""

    exit_status = 2


class JobError(PathgeneError):
    """A job that failed: no feasible path, or a lost board. Exit status 1."""

    exit_status = 1


class NoPathError(JobError):
    """A problem that is not searched, because no planner can find a path for it.

    Parameters
    ----------
    leg : int or None
        The leg of a mission without a path, from 1; None for a single leg.
    """

    def __init__(self, sentence: str, reason: Any, leg: int | None = None) -> None:
        super().__init__(sentence)
        self.reason, self.leg = reason, leg
