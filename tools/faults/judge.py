"""Runs a case and converts the outcome to a verdict."""

from __future__ import annotations

import traceback
from abc import ABC, abstractmethod
from pathlib import Path

from tools.faults.case import Case, DiskExtent, Extent
from tools.faults.verdict import DifferentError, HangError, Verdict, limited


__all__ = ["Judge"]

#: Real seconds after which a session counts as hanging, whatever the virtual time.
_LIMIT_S = 600


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
            with limited(_LIMIT_S):
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
