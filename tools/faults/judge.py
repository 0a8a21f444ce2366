"""Runs a case and converts the outcome to a verdict."""

from __future__ import annotations

import contextlib
import signal
import traceback
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from tools.faults.case import Case, DiskExtent, Extent
from tools.faults.line import HangError


#: Real seconds after which a session counts as hanging, whatever the virtual time.
_LIMIT_S = 600


class DifferentError(Exception):
    """Something differs from a session without faults; the message says what."""


@dataclass
class Verdict:
    """Outcome of a case, and the promise that it broke, if any."""

    #: The broken promise; empty if none was broken.
    violation: str = ""
    #: How the session ended: ``done``, or the name of an error, and whether it was resumed.
    outcome: str = "done"
    faults: Counter[str] = field(default_factory=Counter)


@contextlib.contextmanager
def _limited(seconds: int) -> Iterator[None]:
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


class Judge(ABC):
    """Judges cases of some sessions."""

    @abstractmethod
    def extent(self, session: str, work: int) -> Extent | DiskExtent:
        """Return how long a session is without faults."""

    @abstractmethod
    def run(self, case: Case, verdict: Verdict) -> None:
        """Run a case and note its events.

        Raises
        ------
        DifferentError, HangError
            If a promise is broken, as it also is by any other exception.
        """

    def judge(self, case: Case) -> Verdict:
        """Run a case; return its verdict."""
        verdict = Verdict()
        try:
            with _limited(_LIMIT_S):
                self.run(case, verdict)
        except HangError as error:
            verdict.violation = f"hangs: {error}"
        except DifferentError as error:
            verdict.violation = str(error)
        except Exception as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            verdict.violation = (
                f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
            )
        return verdict
