"""Signals that request the end of a process, including Ctrl-C, all with the same effect."""

from __future__ import annotations

import _thread
import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType


__all__ = ["caught", "held", "instead", "kept_from_children", "status"]

#: Signals that request the end of a process.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)

# Signals that child processes do not receive. A pool ends its processes with SIGTERM.
_KEPT_FROM_CHILDREN = frozenset(SIGNALS) - {signal.SIGTERM}
# One request can arrive twice: `timeout` signals its command, then the group of its command.
_REPEAT_S = 0.1
# Time after which a lost interrupt is raised again: the callback that it ended has returned.
_AGAIN_S = 0.01


class _Received:
    """The signals since the process started to catch them."""

    first: int | None = None
    last: int = signal.SIGINT
    last_s = -1.0


def status(default: int = 128 + signal.SIGINT) -> int:
    """Return the exit status of an interrupted command: 128 + the number of the first signal.

    ``default`` is the status without a signal.
    """
    return default if _Received.first is None else 128 + _Received.first


@contextlib.contextmanager
def caught() -> Iterator[None]:
    """Raise :class:`KeyboardInterrupt` in the block at each signal that was not ignored.

    CPython drops an exception of a destructor or of a callback of a weak reference, which every
    import runs. An interrupt that is lost there is raised again.
    """
    if not _in_main_thread():
        yield
        return
    _Received.first, _Received.last_s = None, -1.0
    usual = (signal.SIG_DFL, signal.default_int_handler)
    ours = [number for number in SIGNALS if signal.getsignal(number) in usual]
    try:
        with _handled(ours, _raise), _raised_again_if_lost():
            yield
    finally:
        # CPython remembers an interrupt that leaves exec(), which creates dataclasses, and ends
        # `python -m` with SIGINT although the interrupt was caught. The next exec() clears that
        # memory.
        exec("")


@contextlib.contextmanager
def instead(action: Callable[[], None]) -> Iterator[None]:
    """Call ``action`` at each signal in the block instead of the usual handler."""

    def handle(number: int, _frame: FrameType | None) -> None:
        if _accepted(number):
            action()

    with _handled(_caught_signals(), handle):
        yield


@contextlib.contextmanager
def held() -> Iterator[None]:
    """Delay signals until the end of the block; processes started in it never receive Ctrl-C."""
    if not _in_main_thread():
        yield  # Signals interrupt only the main thread.
        return
    calls: list[tuple[int, FrameType | None]] = []
    handlers = {number: signal.getsignal(number) for number in _caught_signals()}
    try:
        # Another thread can still receive the signal.
        with (
            _handled(list(handlers), lambda *call: calls.append(call)),
            kept_from_children(),
        ):
            yield
    finally:
        if calls:
            handler = handlers[signal.Signals(calls[0][0])]
            if callable(handler):
                handler(*calls[0])


@contextlib.contextmanager
def kept_from_children() -> Iterator[None]:
    """Keep Ctrl-C from the processes that this thread starts in the block."""
    # They inherit the mask.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, _KEPT_FROM_CHILDREN)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


def _caught_signals() -> list[signal.Signals]:
    """Return the signals that Python handles: neither ignored nor left at the system's default."""
    return [number for number in SIGNALS if callable(signal.getsignal(number))]


@contextlib.contextmanager
def _handled(
    numbers: list[signal.Signals], handler: Callable[[int, FrameType | None], object]
) -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in numbers}
    try:
        for number in numbers:
            signal.signal(number, handler)
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous)


@contextlib.contextmanager
def _raised_again_if_lost() -> Iterator[None]:
    timers: list[threading.Timer] = []
    before = sys.unraisablehook

    def hook(lost: sys.UnraisableHookArgs) -> None:
        if not (issubclass(lost.exc_type, KeyboardInterrupt) and _in_main_thread()):
            before(lost)
            return
        _Received.last_s = -1.0  # No repetition of the lost one.
        timers.append(threading.Timer(_AGAIN_S, _thread.interrupt_main, (_Received.last,)))
        timers[-1].start()

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before
        for timer in timers:
            timer.cancel()


def _raise(number: int, _frame: FrameType | None) -> None:
    if _accepted(number):
        raise KeyboardInterrupt


def _accepted(number: int) -> bool:
    """Note a signal, unless it repeats the last one."""
    now_s = time.monotonic()
    if now_s - _Received.last_s < _REPEAT_S and _Received.first is not None:
        return False
    _Received.last, _Received.last_s = number, now_s
    if _Received.first is None:
        _Received.first = number
    return True
