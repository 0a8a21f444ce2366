"""Early end of a search by a signal."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from typing import TYPE_CHECKING

from pathgene.host import interrupts


if TYPE_CHECKING:
    from pathgene.host.planners.base import Stop

__all__ = ["ending"]

# Maximum wait after Ctrl-C for the end of a generation, because a board may hang.
_GRACE_S = 1.0


@contextlib.contextmanager
def ending(stop: Stop) -> Iterator[None]:
    """Let the first signal in the block request ``stop``; end a search that does not respond.

    A second signal ends the search immediately. Once the search has stopped, its results are
    written, and further signals have no effect.
    """

    def request() -> None:
        if stop.requested and not stop.heeded:
            raise KeyboardInterrupt
        stop.request()
        signal.setitimer(signal.ITIMER_REAL, _GRACE_S)

    def hurry(_signal: int, _frame: object) -> None:
        if not stop.heeded:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, hurry)
    try:
        with interrupts.instead(request):
            yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
