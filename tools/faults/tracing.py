"""A signal at a chosen line of the product's code, and a count of its executed lines."""

from __future__ import annotations

import contextlib
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any
from unittest import mock

from pathgene import host
from pathgene.host.interrupts import caught
from tools.faults.judge import DifferentError


#: The signals that ``docs/reliability.md`` promises to heed; not the product's own list.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)

#: Seconds by which the time of day is set back.
_SET_BACK_S = 3600.0

# The name in frames: through the link in pathgene/.
_HOST = Path(host.__file__).parent


def signal_of(at: int) -> signal.Signals:
    """Return the signal that is sent at a line: Ctrl-C and similar signals in rotation."""
    return SIGNALS[at % len(SIGNALS)]


@contextlib.contextmanager
def signalled(at: int | None, packages: tuple[str, ...]) -> Iterator[list[signal.Signals]]:
    """Send this process a signal at the ``at``-th line of ``packages`` executed in the block.

    The product's own handlers receive it. The list has the signal once it has been sent. None sends
    nothing. In a third of the cases, the time of day is set back by an hour after the signal; a
    second signal follows, and must have an effect too.

    Raises
    ------
    DifferentError
        If the product leaves one of the signals at its default effect, or ignores the second one.
    """
    sent: list[signal.Signals] = []
    if at is None:
        with _handlers_kept():
            yield sent
        return
    left = iter(range(at, -1, -1))

    def count() -> None:
        if next(left, None) == 0:
            sent.append(signal_of(at))
            signal.raise_signal(sent[0])

    # A background process may have been started with some of them ignored.
    before = {number: signal.signal(number, signal.SIG_DFL) for number in SIGNALS}
    try:
        with _handlers_kept(), caught():
            for number in SIGNALS:
                if signal.getsignal(number) is signal.SIG_DFL:
                    raise DifferentError(f"{number.name} is not handled")
            try:
                with _traced(count, packages):
                    yield sent
            finally:
                if sent:
                    _send_again(sent[0], _SET_BACK_S if at % 3 == 0 else 0.0)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _send_again(number: signal.Signals, set_back_s: float) -> None:
    """Check that a signal a second later has an effect, although the time of day is set back."""
    later_s, day_s = time.monotonic() + 1, time.time() + 1 - set_back_s
    with (
        mock.patch.object(time, "monotonic", return_value=later_s),
        mock.patch.object(time, "time", return_value=day_s),
        contextlib.suppress(KeyboardInterrupt),
    ):
        signal.raise_signal(number)
        raise DifferentError(f"a second {number.name} had no effect")


@contextlib.contextmanager
def _handlers_kept() -> Iterator[None]:
    """Check that the handlers of the signals are the same after the block as before."""
    before = {number: signal.getsignal(number) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            if signal.getsignal(number) is not handler:
                raise DifferentError(f"{number.name} keeps another handler")


@contextlib.contextmanager
def counted_lines(packages: tuple[str, ...]) -> Iterator[list[int]]:
    """Count the lines executed in the block; afterwards the list has their number."""
    counted = [0]

    def count() -> None:
        counted[0] += 1

    with _traced(count, packages):
        yield counted


@contextlib.contextmanager
def _traced(on_line: Callable[[], None], packages: tuple[str, ...]) -> Iterator[None]:
    folders = tuple(f"{_HOST / name}/" for name in packages)

    def trace(frame: FrameType, event: str, _argument: Any) -> Any:
        if event == "call" and not frame.f_code.co_filename.startswith(folders):
            return None
        if event == "line":
            on_line()
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield
    finally:
        sys.settrace(before)
