"""Errors the command line turns into one sentence and an exit status."""

__all__ = ["InputError", "JobError", "PathgeneError"]


class PathgeneError(Exception):
    """An error whose message is one sentence for the user; no traceback is shown."""

    exit_status = 1


class InputError(PathgeneError):
    """Bad input or usage: the sentence says what is wrong and how to mend it. Exit status 2."""

    exit_status = 2


class JobError(PathgeneError):
    """The job itself failed: no feasible path, board lost. Exit status 1."""

    exit_status = 1
