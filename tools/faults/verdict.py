"""Verdict on a case."""

from __future__ import annotations

import contextlib
import signal
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from types import FrameType


__all__ = ["DifferentError", "HangError", "Verdict", "limited"]


class DifferentError(Exception):
    """Something differs from a session without faults; the message says what."""


class HangError(BaseException):
    """The host waits although it should have given up, or works forever."""


@dataclass
class Verdict:
    """Outcome of a case, and the promise that it broke, if any."""

    #: The broken promise; empty if none was broken.
    violation: str = ""
    #: How the session ended: ``done``, or the name of an error, and whether it was resumed.
    outcome: str = "done"
    #: The faults that happened, by name.
    faults: Counter[str] = field(default_factory=Counter)


@contextlib.contextmanager
def limited(seconds: int) -> Iterator[None]:
    """Raise :class:`HangError` if the block takes longer on this machine."""

    def end(_number: int, _frame: FrameType | None) -> None:
        raise HangError(f"no end after {seconds} s of this machine")

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
