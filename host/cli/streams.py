"""Standard output and error that may be closed, full, or read by nobody any more."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable, Iterator
from typing import Any, TextIO, cast

from host.errors import PathgeneError


__all__ = ["OutputError", "guarded"]


class OutputError(PathgeneError):
    """Standard output cannot be written to; the message is empty where its reader has left."""


class _Guarded:
    """A stream that is given up, and its file descriptor discarded, at its first error.

    Parameters
    ----------
    stream : TextIO
        What to write to; all but writing is left to it.
    tell : callable
        Is told of that error.
    """

    def __init__(self, stream: TextIO, tell: Callable[[OSError], None]) -> None:
        self._stream = stream
        self._tell = tell
        self._lost = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write ``text``, or discard it if the stream is given up."""
        if not self._lost:
            try:
                self._stream.write(text)
            except OSError as error:
                self._give_up(error)
        return len(text)

    def flush(self) -> None:
        """Pass on what is buffered."""
        if not self._lost:
            try:
                self._stream.flush()
            except OSError as error:
                self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        self._lost = True
        # What is still buffered must not fail again at exit.
        with contextlib.suppress(OSError):
            null = os.open(os.devnull, os.O_WRONLY)
            try:
                os.dup2(null, self._stream.fileno())
            finally:
                os.close(null)
        self._tell(error)


@contextlib.contextmanager
def guarded() -> Iterator[None]:
    """Let no error of standard error end the block, and one of standard output say what it is.

    Raises
    ------
    OutputError
        From ``write`` and ``flush`` of standard output, the first time that one fails.
    """
    _occupy_descriptors()
    before = sys.stdout, sys.stderr
    stdout = before[0] or os.fdopen(1, "w", closefd=False)
    stderr = before[1] or os.fdopen(2, "w", closefd=False)
    sys.stdout = cast(TextIO, _Guarded(stdout, _refuse))
    sys.stderr = cast(TextIO, _Guarded(stderr, lambda error: None))
    try:
        yield
    finally:
        with contextlib.suppress(OutputError):  # Too late: the exit status is chosen.
            sys.stdout.flush()
        sys.stderr.flush()
        sys.stdout, sys.stderr = before


def _occupy_descriptors() -> None:
    """Open the standard streams that are closed, so that no other file gets their numbers.

    Standard output stays one that nothing can be written to.
    """
    for number, flags in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            null = os.open(os.devnull, flags)
            if null != number:
                os.dup2(null, number)
                os.close(null)
            os.set_inheritable(number, True)


def _refuse(error: OSError) -> None:
    if isinstance(error, BrokenPipeError):
        raise OutputError("") from None
    raise OutputError(f"Cannot write to standard output ({error.strerror or error}).") from None
