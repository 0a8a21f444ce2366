"""Errors that the command line reports as one sentence and an exit status."""

__all__ = ["InputError", "JobError", "PathgeneError"]


class PathgeneError(Exception):
    """An error whose message is one sentence for the user; no traceback is shown."""

    exit_status = 1


class InputError(PathgeneError):
    """Bad input or usage; the sentence names the error and a remedy. Exit status 2."""

    exit_status = 2


class JobError(PathgeneError):
    """A job that failed: no feasible path, or a lost board. Exit status 1."""

    exit_status = 1
