"""Standard output and standard error, which may be closed, full, stalled or without a reader."""

from __future__ import annotations

import contextlib
import os
import select
import stat
import sys
from collections.abc import Callable, Iterator
from typing import Any, TextIO, cast

from pathgene.host.errors import PathgeneError
from pathgene.host.files.special import write_patiently


__all__ = ["OutputError", "guarded"]


# Maximum wait for a reader of standard error that does not read.
_PATIENCE_S = 1.0


class OutputError(PathgeneError):
    """Standard output cannot be written; the message is empty if its reader has gone."""


class _Guarded:
    """A stream that discards all output after its first error.

    Parameters
    ----------
    stream : TextIO
        The wrapped stream, which handles everything except writing.
    tell : callable
        Called with the first error.
    """

    def __init__(self, stream: TextIO, tell: Callable[[OSError], None]) -> None:
        self._stream = stream
        self._tell = tell
        self._lost = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write ``text``, or discard it after an error."""
        if not self._lost:
            try:
                self._stream.write(text)
            except UnicodeEncodeError:
                # A name of a file whose bytes are not of this encoding.
                encoding = self._stream.encoding
                self._stream.write(text.encode(encoding, "backslashreplace").decode(encoding))
            except OSError as error:
                self._give_up(error)
        return len(text)

    def flush(self) -> None:
        """Flush the stream."""
        if not self._lost:
            try:
                self._stream.flush()
            except OSError as error:
                self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        self._lost = True
        # The rest of the buffer must not fail again at exit.
        with contextlib.suppress(OSError):
            null = os.open(os.devnull, os.O_WRONLY)
            try:
                os.dup2(null, self._stream.fileno())
            finally:
                os.close(null)
        self._tell(error)


class _Patient:
    """A pipe or a terminal, written without waiting for a reader that does not read.

    A text waits up to a second for room. If there is none, the rest of it is lost, and all further
    texts are lost immediately until there is room again.

    Parameters
    ----------
    stream : TextIO
        The wrapped stream, which handles everything except writing.
    number : int
        A descriptor of the stream in non-blocking mode.
    """

    def __init__(self, stream: TextIO, number: int) -> None:
        self._stream = stream
        self._number = number
        self._room = select.poll()
        self._room.register(number, select.POLLOUT)
        self._stalled = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write ``text``, or as much of it as there is room for."""
        if not self._stalled or self._room.poll(0):
            content = text.encode("utf-8", "backslashreplace")
            self._stalled = not write_patiently(self._number, content, _PATIENCE_S)
        return len(text)

    def flush(self) -> None:
        """Nothing is buffered."""


@contextlib.contextmanager
def _patient(stream: TextIO) -> Iterator[TextIO]:
    """Return ``stream``, wrapped if it may have a reader so that writing does not wait for it."""
    own = None
    # Not a stream of the system, or a stream of another user.
    with contextlib.suppress(OSError):
        number = stream.fileno()
        if stat.S_ISFIFO(os.fstat(number).st_mode) or os.isatty(number):
            stream.flush()
            # The file is opened again, because other processes share the mode of the descriptor.
            flags = os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
            own = os.open(f"/proc/self/fd/{number}", flags)
    if own is None:
        yield stream
        return
    try:
        yield cast(TextIO, _Patient(stream, own))
    finally:
        os.close(own)


@contextlib.contextmanager
def guarded() -> Iterator[None]:
    """Ignore errors of standard error in the block; report the first of standard output.

    Raises
    ------
    OutputError
        From the first ``write`` or ``flush`` of standard output that fails.
    """
    _occupy_descriptors()
    before = sys.stdout, sys.stderr
    stdout = before[0] or os.fdopen(1, "w", closefd=False)
    stderr = before[1] or os.fdopen(2, "w", closefd=False)
    sys.stdout = cast(TextIO, _Guarded(stdout, _refuse))
    with _patient(stderr) as patient:
        sys.stderr = cast(TextIO, _Guarded(patient, lambda error: None))
        try:
            yield
        finally:
            with contextlib.suppress(OutputError):  # Too late: the exit status is already decided.
                sys.stdout.flush()
            sys.stderr.flush()
            sys.stdout, sys.stderr = before


def _occupy_descriptors() -> None:
    """Reopen closed standard streams, so that no other file gets their descriptors.

    A closed standard output is opened for reading only, so that writing to it still fails.
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
